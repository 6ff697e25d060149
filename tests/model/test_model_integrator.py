# SPDX-License-Identifier: Apache-2.0
"""Non-linear integrator: every boundary of (29)-(35), step by step and vectorised."""

import numpy as np
import pytest

from sim.robot import float32, integrator

N_C = 200
LARGE, SMALL = 1.0, 1.0 - 2.0**-50  # the error as a share of e_c: at the threshold, below it


@pytest.mark.parametrize(
    ("ticks", "share", "phi_c"),
    [
        (0, LARGE, 1.0),  # t_c <= 0
        (1, LARGE, 5.0),
        (1, SMALL, 5.0),  # the first half does not look at the error
        (100, LARGE, 5.0),  # t_c = T_c / 2 belongs to the first half
        (100, SMALL, 5.0),
        (101, LARGE, 1.0 + 8.0 * (1.0 - 101 / 200)),
        (101, -LARGE, 1.0 + 8.0 * (1.0 - 101 / 200)),
        (101, SMALL, 1.0),
        (101, -SMALL, 1.0),
        (199, LARGE, 1.0 + 8.0 / 200),
        (199, SMALL, 1.0),
        (200, LARGE, 1.0),  # t_c = T_c ends the boost
        (201, LARGE, 1.0),
    ],
)
def test_boost__boundaries__follow_the_printed_cases(robot, ticks, share, phi_c):
    for e_c in robot.e_c:
        assert integrator.boost(robot, ticks, share * e_c, e_c) == pytest.approx(phi_c, rel=1e-14)
    errors = share * np.array((robot.e_c,))
    whole = integrator.boosts(robot, np.full((1, 5), ticks), errors)
    np.testing.assert_allclose(whole, np.full((1, 5), phi_c), rtol=1e-14)


def test_boost__single_precision_time__takes_the_same_cases_at_every_tick(robot):
    ticks = np.repeat(np.arange(N_C + 2)[:, None], 5, axis=1)
    c = float32.Constants(robot)
    for error in (np.full(ticks.shape, 1e-3), np.zeros(ticks.shape)):
        single = float32.boost(c, ticks, error.astype(np.float32))
        assert single.dtype == np.float32
        # 1 - t_c / T_c loses at most 2 roundings of a quotient up to 1, times 2 (xi_c - 1) = 8
        np.testing.assert_allclose(
            single, integrator.boosts(robot, ticks, error), rtol=0, atol=8 * 2 * 2.0**-24 + 2.0**-22
        )


def test_ticks__start_stop_and_reversal__count_from_zero_and_saturate(robot):
    velocity = np.concatenate(
        (np.zeros(3), np.full(3, 0.1), np.full(2, -0.1), np.zeros(N_C + 5), [1e-300])
    )
    want = [N_C] * 3 + [0, 1, 2, 0, 1] + [min(n, N_C) for n in range(N_C + 5)] + [0]
    sign = integrator.signs(velocity[:, None])
    assert integrator.ticks_since_reversal(sign, N_C)[:, 0].tolist() == want
    axis = integrator.Integrator(robot, 0)
    seen = []
    for v in velocity:
        axis.step(0.0, v)
        seen.append(axis.ticks)
    assert seen == want


def test_ticks__motion_in_the_first_tick__is_a_reversal(robot):
    sign = integrator.signs(np.array([[-0.1], [-0.1]]))
    assert sign[:, 0].tolist() == [-1, -1]
    assert integrator.ticks_since_reversal(sign, N_C)[:, 0].tolist() == [0, 1]


@pytest.mark.parametrize("axis", [0, 4])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_integrate__large_error__stops_at_the_bound_and_leaves_it_at_once(robot, axis, direction):
    bound = direction * robot.s_max[axis]
    error = bound / robot.T_s / 4.0  # the bound after four ticks
    single = integrator.Integrator(robot, axis)
    path = [single.step(e, 0.0) for e in [error] * 6 + [-error]]
    assert path[1] == pytest.approx(bound / 2, rel=1e-14)
    assert path[4:6] == [bound, bound]
    assert path[6] == pytest.approx(0.75 * bound, rel=1e-14)
    increments = np.zeros((7, 5))
    increments[:, axis] = np.array([error] * 6 + [-error]) * robot.T_s
    np.testing.assert_array_equal(integrator.integrate(increments, robot.s_max)[:, axis], path)
    narrow = float32.integrate(float32.Constants(robot), increments.astype(np.float32))
    assert narrow[5, axis] == np.float32(bound)


def test_step__random_path__equals_the_vectorised_evaluation(robot):
    rng = np.random.default_rng(5)
    error = rng.normal(0, 2e-6, (3000, 5))
    velocity = np.sign(np.sin(np.arange(3000)[:, None] / rng.uniform(20, 90, 5)).round(1))
    axes = [integrator.Integrator(robot, axis) for axis in range(5)]
    steps = np.array(
        [
            [a.step(*pair) for a, *pair in zip(axes, e, v, strict=True)]
            for e, v in zip(error.tolist(), velocity.tolist(), strict=True)
        ]
    )
    ticks = integrator.ticks_since_reversal(integrator.signs(velocity), robot.boost_ticks)
    phi = integrator.boosts(robot, ticks, error)
    assert set(np.unique(phi)) >= {1.0, 5.0} and np.any((phi > 1.0) & (phi < 5.0))
    np.testing.assert_array_equal(integrator.integrate(phi * error * robot.T_s, robot.s_max), steps)
