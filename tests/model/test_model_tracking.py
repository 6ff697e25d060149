# SPDX-License-Identifier: Apache-2.0
"""Closed loop of the law and the plant, and the two evaluations of the law against each other."""

from dataclasses import fields, replace

import numpy as np
import pytest
from model_paths import circle

from sim.robot import errors, tracking
from sim.robot.kinematics import WorkspaceError
from sim.robot.plant import Plant
from sim.robot.records import OUTPUTS, TABLE_3, SetPoints

FEED = 2.0 / 60.0  # 2 m/min


def close_loop(robot, path):
    """Joints and tool at every sampling instant, counts, and what the law computed."""
    law, plant = tracking.Tracking(robot), Plant(robot, path.position[0], path.table_position[0])
    joints, tools, readings, ticks = [], [], [], []
    counts = plant.counts()
    for words in path.words().tolist():
        joints.append(plant.joints)
        tools.append(plant.tool)
        readings.append(counts)
        ticks.append(law.step(words, counts))
        counts = plant.step(ticks[-1].output)
    return np.array(joints), np.array(tools), np.array(readings), ticks


@pytest.fixture(scope="module")
def loop(robot):
    """Circle of 60 mm radius at 2 m/min with a start and stop of one second; the table turns."""
    path = circle(robot, 0.06, FEED, 1.0, (0.3, 1.0))
    return path, *close_loop(robot, path)


@pytest.mark.full
def test_closed_loop__circle__keeps_the_specified_accuracy(robot, loop):
    path, joints, tools, _, _ = loop
    wanted, _, _ = tracking.joint_path(robot, path)
    leg_error = np.abs(joints - wanted)[:, :3].max()
    table_error = np.abs(joints - wanted)[:, 3:].max()
    tool_error = np.linalg.norm(tools - path.position, axis=1).max()
    assert robot.encoder_legs / 2 < leg_error < 0.5e-6
    assert tool_error < 5e-6
    assert table_error < 50e-6


def test_closed_loop__circle__never_saturates(robot, loop):
    ticks = loop[-1]
    assert all(t.demand == t.output for t in ticks)
    assert all(abs(s) < high for t in ticks for s, high in zip(t.s_c, robot.s_max, strict=True))


def test_step__whole_circle__equals_the_vectorised_evaluation(robot, loop):
    path, _, _, counts, ticks = loop
    whole = tracking.run(robot, path, counts)
    steps = {f.name: np.array([getattr(t, f.name) for t in ticks]) for f in fields(whole)}
    for name in ("sign", "ticks", "position", "velocity"):
        np.testing.assert_array_equal(steps[name], getattr(whole, name), err_msg=name)
    # numpy sums in the same order as Python; squares and the sine may differ by a rounding
    scale = {"demand": 3000.0, "output": 3000.0, "gravity": 300.0, "mass": 40.0, "m_z": 30.0}
    for name in set(steps) - {"sign", "ticks"}:
        bound = 16 * 2.0**-52 * scale.get(name, 1.0)
        if name in ("demand", "output"):  # one rounding of l_d or v_d, through the gains
            bound += 40.0 * (max(robot.K_P) + max(robot.K_V)) * 2.0**-52
        np.testing.assert_allclose(
            steps[name], getattr(whole, name), rtol=0, atol=bound, err_msg=name
        )


def test_closed_loop__reversal_of_the_table__peaks_near_the_friction_step_of_the_linear_loop(robot):
    """Reversing friction is a step 2 f / J; 1/(s + w)^3 answers with at most 2 e^-2 / w^2 of it."""
    rate = 5.0
    phase = rate * np.arange(12_000) * robot.T_s  # reverses at pi
    cos, sin, none = np.cos(phase), np.sin(phase), np.zeros_like(phase)
    zero = np.zeros((len(phase), 3))
    turn = [0.2 * np.stack((none, u), axis=1) for u in (1.0 - cos, rate * sin, rate * rate * cos)]
    path = SetPoints(zero + (0.0, 0.0, 0.6), zero, zero, *turn)
    joints, _, _, _ = close_loop(robot, path)
    peak = np.abs(joints[:, 4] - path.table_position[:, 1]).max()
    step = 2.0 * robot.friction_table / robot.J_55
    bound = step * 2.0 * np.exp(-2.0) / (robot.K_V[4] / 3.0) ** 2
    assert 0.5 * bound < peak < bound + robot.encoder_table


def test_law__one_tick_by_hand__follows_the_equations(robot):
    law = tracking.Tracking(robot)
    words = (0.0, 0.0, 0.6, 0.0, 0.0, 0.01, 0.0, 0.0, 0.5, 0.2, 0.1, 0.3, -0.4, 1.0, -2.0)
    length = np.hypot(0.5, 0.6)
    counts = [round(length / 0.25e-6)] * 3 + [8000, 4000]
    law.step(words, counts)
    counts[0] -= 3
    tick = law.step(words, counts)
    measured = np.array(counts) * robot.resolution
    z = 0.6
    v_d, omega = 0.01 * z / length, (0.3, -0.4)
    a_d = (0.01**2 + z * 0.5 - v_d**2) / length
    np.testing.assert_allclose(tick.velocity, (-3 * 0.25e-6 / 1e-4, 0, 0, 0, 0), atol=1e-10)
    np.testing.assert_allclose(tick.velocity_d, (v_d, v_d, v_d, *omega), rtol=1e-14)
    np.testing.assert_allclose(tick.acceleration_d, (a_d, a_d, a_d, 1.0, -2.0), rtol=1e-14)
    e = np.array((length, length, length, 0.2, 0.1)) - measured
    np.testing.assert_allclose(tick.e, e, rtol=0, atol=4e-16)
    assert tick.ticks == (1,) * 5 and tick.sign == (1, 1, 1, 1, -1)
    first = e + np.array((-3 * 0.25e-6, 0, 0, 0, 0))  # before the first leg moved, phi_c = 1
    s_c = np.clip((first + 5.0 * e) * 1e-4, -np.array(robot.s_max), robot.s_max)
    np.testing.assert_allclose(tick.s_c, s_c, rtol=1e-9)
    pid = np.array(robot.K_P) * e + np.array(robot.K_V) * tick.e_v + np.array(robot.K_I) * s_c
    assert tick.mass[3:] == (1.6, 0.9)
    force = np.array(tick.mass) * (np.array(tick.acceleration_d) + pid) + tick.gravity
    np.testing.assert_allclose(tick.demand, force, rtol=1e-9)
    assert tick.gravity[3] == pytest.approx(8.829 * np.sin(8000 * robot.encoder_table), rel=1e-14)


def test_step__legs_that_meet_nowhere__are_named(robot):
    words = (0.0, 0.0, 0.6) + (0.0,) * 12
    with pytest.raises(WorkspaceError, match=r"^legs 0\.1, 0\.1, 0\.1 m: meet in no point"):
        tracking.Tracking(robot).step(words, (400_000, 400_000, 400_000, 0, 0))


def test_run__legs_that_meet_nowhere__name_the_tick(robot, loop):
    path, _, _, counts, _ = loop
    short = SetPoints.from_words(path.words()[:5])
    broken = counts[:5].copy()
    broken[3] = 400_000
    with pytest.raises(WorkspaceError, match=r"legs 0\.1, 0\.1, 0\.1 m at tick 3: meet"):
        tracking.run(robot, short, broken)


def test_setpoints__words__come_back(loop):
    path = loop[0]
    words = path.words()
    assert words.shape == (len(path), 15)
    np.testing.assert_array_equal(words[5, 9:11], path.table_position[5])
    for name, values in vars(SetPoints.from_words(words)).items():
        np.testing.assert_array_equal(values, getattr(path, name))


def test_setpoints__wrong_shape__is_named():
    three, two = np.zeros((4, 3)), np.zeros((4, 2))
    with pytest.raises(
        ValueError, match=r"table_velocity has the shape \(4, 3\), must be \(4, 2\)"
    ):
        SetPoints(three, three, three, two, three, two)


def test_max_abs_error__one_changed_value__is_found_in_its_row(robot, loop):
    path, _, _, counts, _ = loop
    whole = tracking.run(robot, SetPoints.from_words(path.words()[:50]), counts[:50])
    assert set(errors.max_abs_error(whole, whole).values()) == {0.0}
    for field, names in (
        ("position_d", TABLE_3[:5]),
        ("velocity_d", TABLE_3[5:10]),
        ("acceleration_d", TABLE_3[10:]),
        ("output", OUTPUTS),
    ):
        for axis, name in enumerate(names):
            changed = getattr(whole, field).copy()
            changed[17, axis] -= 0.25
            found = errors.max_abs_error(whole, replace(whole, **{field: changed}))
            assert found.pop(name) == pytest.approx(0.25)
            assert set(found.values()) == {0.0}


def test_max_abs_error__nan__is_not_hidden(robot, loop):
    path, _, _, counts, _ = loop
    whole = tracking.run(robot, SetPoints.from_words(path.words()[:5]), counts[:5])
    output = whole.output.copy()
    output[2, 1] = np.nan
    assert np.isnan(errors.max_abs_error(whole, replace(whole, output=output))["F2"])


def test_max_abs_error__other_tick_count__is_refused(robot, loop):
    path, _, _, counts, _ = loop
    words = path.words()
    short, whole = (
        tracking.run(robot, SetPoints.from_words(words[:n]), counts[:n]) for n in (4, 5)
    )
    with pytest.raises(ValueError, match=r"result has the shape \(4, 5\), the reference \(5, 5\)"):
        errors.max_abs_error(whole, short)


def test_row__unknown_name__is_refused(loop):
    with pytest.raises(KeyError, match="l9"):
        loop[-1][0].row("l9")
