# SPDX-License-Identifier: Apache-2.0
"""Kinematics against the printed formulas, derivatives of (7) at 40 digits, and their inverse."""

import mpmath as mp
import numpy as np
import pytest
from model_paths import workspace_points

from sim.robot import kinematics
from sim.robot.kinematics import WorkspaceError

SEED = 7


@pytest.fixture(autouse=True)
def forty_digits():
    with mp.workdps(40):
        yield


def printed_length(robot, leg, x, y, z):
    """(4)-(7) in mpmath."""
    angle = mp.radians((90, 330, 210)[leg])
    radius = mp.mpf(robot.R)
    return mp.sqrt((x - radius * mp.cos(angle)) ** 2 + (y - radius * mp.sin(angle)) ** 2 + z * z)


def motions(robot):
    points = workspace_points(robot, 40, SEED)
    rng = np.random.default_rng(SEED + 1)
    return points, rng.normal(0, 0.05, points.shape), rng.normal(0, 2.0, points.shape)


def test_inverse__whole_workspace__equals_the_printed_formula(robot):
    points = workspace_points(robot, 40, SEED)
    want = [[float(printed_length(robot, i, *map(mp.mpf, p))) for i in range(3)] for p in points]
    np.testing.assert_allclose(kinematics.inverse(robot, points), want, rtol=4e-16)


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives__whole_workspace__equal_those_of_the_length_along_a_parabola(robot, order):
    points, speeds, changes = motions(robot)
    want = np.empty_like(points)
    for row, (p, v, a) in enumerate(zip(points, speeds, changes, strict=True)):
        p, v, a = ([mp.mpf(float(u)) for u in w] for w in (p, v, a))
        for leg in range(3):

            def along(t, leg=leg, p=p, v=v, a=a):
                return printed_length(
                    robot, leg, *(q + t * (u + t * w / 2) for q, u, w in zip(p, v, a, strict=True))
                )

            want[row, leg] = mp.diff(along, 0, order)
    if order == 1:
        got = kinematics.inverse_velocity(robot, points, speeds)
    else:
        got = kinematics.inverse_acceleration(robot, points, speeds, changes)
    # a few roundings of terms not larger than |v| or |a| + |v|^2 / l
    np.testing.assert_allclose(got, want, rtol=0, atol=8 * 2.0**-53 * (0.2 if order == 1 else 6.0))


def test_forward__of_inverse__returns_the_tool(robot):
    points = workspace_points(robot, 1000, SEED)
    back = kinematics.forward(robot, kinematics.inverse(robot, points))
    np.testing.assert_allclose(back, points, rtol=0, atol=2e-15)


def test_shapes__leading_dimensions__are_kept(robot):
    points = workspace_points(robot, 4, SEED).reshape(2, 6, 3)
    lengths = kinematics.inverse(robot, points)
    assert lengths.shape == (2, 6, 3)
    np.testing.assert_array_equal(kinematics.inverse(robot, points[1, 2]), lengths[1, 2])
    np.testing.assert_array_equal(
        kinematics.forward(robot, lengths[1, 2]), kinematics.forward(robot, lengths)[1, 2]
    )


def test_inverse__two_coordinates__names_the_shape(robot):
    with pytest.raises(ValueError, match=r"shape \(5, 2\), must be \(\.\.\., 3\)"):
        kinematics.inverse(robot, np.zeros((5, 2)))


def test_table__forward__is_the_centre_of_the_surface(robot):
    theta = np.array(((0.0, 1.0), (np.pi / 2, -2.0), (-np.pi / 6, 0.25)))
    point, orientation = kinematics.table_forward(robot, theta)
    root = np.sqrt(0.75)
    want = robot.h * np.array(((0, 0, 1.0), (0, -1.0, 0), (0, 0.5, root)))
    np.testing.assert_allclose(point, want, atol=1e-17)
    np.testing.assert_array_equal(orientation, [(t, 0.0, r) for t, r in theta])


def test_workspace__limits__belong_to_it(robot):
    kinematics.check_workspace(robot, workspace_points(robot, 100, SEED))


@pytest.mark.parametrize(
    ("position", "text"),
    [
        ((0.2, 0.0, 0.6), "x = 0.2 m: must be within -0.15 .. 0.15 m"),
        ((0.0, -0.151, 0.6), "y = -0.151 m: must be within -0.15 .. 0.15 m"),
        ((0.0, 0.0, 0.76), "z = 0.76 m: must be within 0.45 .. 0.75 m"),
        ((0.0, float("nan"), 0.6), "y = nan m: must be within -0.15 .. 0.15 m"),
        (
            [(0.0, 0.0, 0.6)] * 5 + [(0.0, 0.0, 0.4), (1.0, 0.0, 0.6)],
            "z = 0.4 m at tick 5: must be within 0.45 .. 0.75 m",
        ),
        (
            [[(0.0, 0.0, 0.6), (0.0, 0.0, 0.4)]],
            "z = 0.4 m at index (0, 1): must be within 0.45 .. 0.75 m",
        ),
    ],
)
def test_workspace__outside__names_value_limits_and_tick(robot, position, text):
    with pytest.raises(WorkspaceError) as caught:
        kinematics.check_workspace(robot, position)
    assert str(caught.value) == text


@pytest.mark.parametrize(
    ("lengths", "text"),
    [
        (
            (0.1, 0.1, 0.1),
            "legs 0.1, 0.1, 0.1 m: meet in no point, z^2 = -0.24 m^2 must be >= 0",
        ),
        (
            [(0.8, 0.8, 0.8), (0.1, 0.1, 0.1)],
            "legs 0.1, 0.1, 0.1 m at tick 1: meet in no point, z^2 = -0.24 m^2 must be >= 0",
        ),
    ],
)
def test_forward__legs_too_short__names_them_and_the_tick(robot, lengths, text):
    with pytest.raises(WorkspaceError) as caught:
        kinematics.forward(robot, lengths)
    assert str(caught.value) == text
