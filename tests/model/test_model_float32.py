# SPDX-License-Identifier: Apache-2.0
"""Single-precision model: purity, operation counts of the print, error against double precision."""

from collections import Counter

import numpy as np
import pytest
from model_paths import circle, workspace_points

from sim.robot import errors, float32, kinematics, tracking
from sim.robot.records import SetPoints

SEED = 31


class Recorder(np.ndarray):
    """A float32 array that counts the operations made with it and refuses any other type."""

    counts: Counter = Counter()

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        assert method == "__call__"
        plain = [np.asarray(value) for value in inputs]
        assert all(value.dtype == np.float32 for value in plain), (ufunc, inputs)
        result = ufunc(*plain, **kwargs)
        assert result.dtype == np.float32, ufunc
        Recorder.counts[ufunc.__name__] += 1
        return result.view(Recorder)


def recorded(*values):
    return tuple(np.array([value], np.float32).view(Recorder) for value in values)


@pytest.fixture
def counts():
    Recorder.counts = Counter()
    return Recorder.counts


def test_inverse_kinematics__as_printed__takes_the_specified_operations(robot, counts):
    c = float32.Constants(robot)
    p, v, a = recorded(0.05, -0.02, 0.6), recorded(0.1, 0.2, 0.3), recorded(1.0, 2.0, 3.0)
    for leg in range(3):
        float32.length(c, leg, p)
        float32.velocity(c, leg, p, v)
        float32.acceleration(c, leg, p, v, a)
    sums = counts.pop("add") + counts.pop("subtract")
    assert (sums, counts) == (89, {"sqrt": 12, "divide": 9, "multiply": 123})


def test_measured_side__every_operation__stays_in_single_precision(robot, counts):
    c = float32.Constants(robot)
    legs = recorded(0.78, 0.8, 0.76)
    p = float32.forward(c, *legs)
    m_z = float32.carried_mass(c, legs)
    results = (*p, m_z, float32.reduced_mass(c, *legs), *float32.gravity(c, p, legs, m_z))
    assert all(isinstance(r, Recorder) and r.dtype == np.float32 for r in results)
    assert counts["sqrt"] == 1


def still(robot, points):
    zero3, zero2 = np.zeros_like(points), np.zeros((len(points), 2))
    path = SetPoints(points, zero3, zero3, zero2, zero2, zero2)
    lengths = kinematics.inverse(robot, points) / robot.encoder_legs
    return path, np.pad(np.rint(lengths), ((0, 0), (0, 2))).astype(np.int32)


def test_run__circle__is_single_precision_in_every_field(robot):
    path = circle(robot, 0.06, 2.0 / 60.0, 1.0, (0.3, 1.0))
    path = SetPoints.from_words(path.words()[::50])
    _, counts = still(robot, path.position)
    result = float32.run(robot, path, counts)
    for name, values in vars(result).items():
        if name not in ("sign", "ticks"):
            assert values.dtype == np.float32, name


def test_run__desired_motion__errs_by_a_few_roundings(robot):
    path = circle(robot, 0.06, 2.0 / 60.0, 1.0, (0.3, 1.0))
    path = SetPoints.from_words(path.words()[::10])
    _, counts = still(robot, path.position)
    found = errors.max_abs_error(
        tracking.run(robot, path, counts), float32.run(robot, path, counts)
    )
    half = 2.0**-25  # half a unit in the last place of 0.5 .. 1
    for leg in "123":
        # inputs, x_pi, three squares, two sums, root: 8 roundings of terms below 1 m
        assert half / 4 < found["l" + leg] < 8 * half
        # speeds below 0.034 m/s, accelerations below 0.1 m/s^2: 20 roundings of their terms
        assert 0 < found["v" + leg] < 20 * 0.034 * 2.0**-24
        assert 0 < found["a" + leg] < 20 * 0.1 * 2.0**-24
    assert 0 < found["theta4"] <= 0.5 * 2.0**-24 and 0 < found["theta5"] <= 2.0**-24


def test_run__poses_at_rest__masses_and_gravity_agree_with_double(robot):
    path, counts = still(robot, workspace_points(robot, 500, SEED))
    single, double = float32.run(robot, path, counts), tracking.run(robot, path, counts)
    # the cosine of two legs cancels l_i^2 + l_j^2 - 3 R^2: about ten roundings of terms near 2,
    # times the derivative 2 c m_s < 24 kg
    np.testing.assert_allclose(single.mass, double.mass, rtol=0, atol=10 * 24 * 2.0**-23)
    # z from (15) amplifies roundings of l^2 by l / z < 2; forces are below 300 N
    assert np.abs(double.gravity).max() < 300.0
    np.testing.assert_allclose(single.gravity, double.gravity, rtol=0, atol=40 * 300 * 2.0**-24)
    np.testing.assert_allclose(single.tool, double.tool, rtol=0, atol=10 * 2.0**-24)


def test_gravity__cramer_in_double_precision__solves_the_system(robot):
    """The same expressions on float64 are exact enough to expose a wrong cofactor."""
    path, counts = still(robot, workspace_points(robot, 50, SEED))
    want = tracking.run(robot, path, counts)
    c = float32.Constants(robot)
    got = float32.gravity(c, tuple(want.tool.T), tuple(want.position[:, :3].T), want.m_z)
    # only the constants are rounded
    np.testing.assert_allclose(np.stack(got, 1), want.gravity[:, :3], rtol=0, atol=300 * 2.0**-22)


def test_measured_velocity__two_rounded_lengths__has_the_step_of_the_float_spacing(robot):
    points = np.tile((0.0, 0.0, 0.6), (200, 1))
    path, counts = still(robot, points)
    counts[:, :3] += np.arange(200)[:, None] // 7
    single = float32.run(robot, path, counts).velocity[:, :3]
    double = tracking.run(robot, path, counts).velocity[:, :3]
    worst = np.abs(single - double).max()
    # both lengths within half a spacing (2^-24 m below 1 m) of counts times the rounded resolution
    assert 2e-4 < worst <= 2.0**-24 / robot.T_s * 1.01


def test_outputs__noisy_counts__differ_by_what_the_rounded_positions_allow(robot):
    path = circle(robot, 0.06, 2.0 / 60.0, 1.0, (0.6, 1.0))
    path = SetPoints.from_words(path.words()[60_000:60_300])
    _, counts = still(robot, path.position)
    counts[:, 3:] = np.rint(path.table_position / robot.encoder_table)
    counts += np.random.default_rng(SEED).integers(-2, 3, counts.shape, np.int32)
    counts += np.array((-40, 40, 40, -10, 10), np.int32)  # an error that the integrators see
    single, double = float32.run(robot, path, counts), tracking.run(robot, path, counts)
    # positions below 1: both lengths of v within half a spacing 2^-24, e within three halves; the
    # integrator sums 1.5 x 2^-24 five times faster over at most 300 ticks
    spacing, ticks = 2.0**-24, len(path)
    for axis, mass in enumerate((40.0, 40.0, 40.0, robot.J_44, robot.J_55)):
        gain = robot.K_V[axis] / robot.T_s + 1.5 * robot.K_P[axis]
        gain += 7.5 * ticks * robot.T_s * robot.K_I[axis]
        worst = np.abs(single.demand - double.demand)[:, axis].max()
        assert worst < 1.05 * mass * gain * spacing, axis
        assert np.ptp(double.demand[:, axis]) > 10 * worst, axis
    assert (
        np.abs(double.gravity[:, 3]).min() > 10 * np.abs(single.demand - double.demand)[:, 3].max()
    )


def test_outputs__far_from_the_path__are_saturated(robot):
    path, counts = still(robot, np.tile((0.0, 0.0, 0.6), (2, 1)))
    counts[1] += (200_000, -200_000, 0, 100_000, -100_000)
    for model in (float32, tracking):
        result = model.run(robot, path, counts)
        assert result.output[1].tolist() == [-3000.0, 3000.0, result.demand[1, 2], -250.0, 120.0]
        assert abs(result.demand[1, 2]) < 3000.0


@pytest.mark.parametrize("model", [float32, tracking])
@pytest.mark.parametrize(
    ("counts", "text"),
    [
        (np.zeros((3, 5), int), r"counts have the shape \(3, 5\), must be \(2, 5\)"),
        (np.zeros((2, 5)), "counts have the type float64, must be integers"),
        (np.full((2, 5), 2**31), "counts do not fit in 32 bits"),
    ],
)
def test_run__bad_counts__are_refused(robot, model, counts, text):
    path, _ = still(robot, np.tile((0.0, 0.0, 0.6), (2, 1)))
    with pytest.raises(ValueError, match=text):
        model.run(robot, path, counts)
