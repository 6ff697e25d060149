# SPDX-License-Identifier: Apache-2.0
"""Speeds from observers and from time stamps: what they estimate, the loop with them, figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from asip_asm.assemble import assemble
from sim.bench.drive.speed import delay, margin
from sim.bench.run.bounds import bounds
from sim.bench.run.random_robots import PROGRAMS
from sim.core import closed_loop
from sim.core.controller import LawController
from sim.core.iss import run_path
from sim.robot.errors import ripple
from sim.robot.observer import Observer, gains
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.records import OUTPUTS, SetPoints
from sim.robot.stamps import LONG_AGO, StampedPlant, Stamps, clock_of, last_crossing
from sim.robot.tracking import Tracking, run
from tests.asip.tracking_path import reversing_path

ROBOT = Robot.load()
PERIOD = ROBOT.T_s


def rest(ticks: int, step: float = 0.0) -> SetPoints:
    """Set-points at home; from the second tick on the tool is wanted `step` [m] higher."""
    words = np.zeros((ticks, 15))
    words[:, :3], words[:, 9:11] = ROBOT.start[:3], ROBOT.start[3:]
    words[1:, 2] += step
    return SetPoints.from_words(words)


@pytest.mark.parametrize("axis", [0, 3])
def test_gains__give_three_equal_poles(axis):
    gain = gains(ROBOT)[axis]
    correct = np.array([[gain.kept, 0, 0], [-gain.speed, 1, 0], [-gain.pull, 0, 1]])
    predict = np.array([[1, PERIOD, PERIOD**2 / 2], [0, 1, PERIOD], [0, 0, 1]])
    theta = gain.kept ** (1 / 3)
    f = (ROBOT.f_legs, ROBOT.f_table)[axis // 3]
    assert theta == pytest.approx(np.exp(-10 * 2 * np.pi * f * PERIOD), rel=1e-3)
    np.testing.assert_allclose(
        np.poly(correct @ predict), np.poly([theta] * 3), rtol=1e-9, atol=1e-12
    )


def test_observer__constant_pull__is_found_and_the_speed_with_it():
    """Counts of a body with 3 m/s^2 that nobody requested, without rounding."""
    observer = Observer(ROBOT)
    scale = np.array(ROBOT.resolution)
    for tick in range(400):
        before, now = (1.5 * (max(t, 0) * PERIOD) ** 2 for t in (tick - 1, tick))
        speeds = observer.correct((now - before) / scale)
        observer.predict([0.0] * 5)
    assert speeds[:3] == pytest.approx([3 * 399 * PERIOD] * 3, rel=1e-6)
    assert observer.pull[:3] == pytest.approx([3.0] * 3, rel=1e-6)


def test_observer__law_at_rest__has_no_speed():
    law = Tracking(ROBOT, "observer")
    plant = Plant(ROBOT, ROBOT.start[:3])
    counts = plant.counts()
    for words in rest(50).words():
        found = law.step(words.tolist(), counts)
    assert max(map(abs, found.velocity)) < 1e-3  # forces of half a count's error


def test_law__tick_by_tick__is_that_of_a_recorded_path():
    path, counts = reversing_path(ROBOT, 300)
    law = Tracking(ROBOT, "observer")
    ticks = [law.step(w, c) for w, c in zip(path.words().tolist(), counts.tolist(), strict=True)]
    whole = run(ROBOT, path, counts, "observer")
    for name in ("velocity", "output"):
        got = np.array([getattr(tick, name) for tick in ticks])
        np.testing.assert_allclose(got, getattr(whole, name), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("speed", ["", "observers", "Difference"])
def test_speed__unknown__is_refused(speed):
    for call in (
        lambda: Tracking(ROBOT, speed),
        lambda: run(ROBOT, *reversing_path(ROBOT, 2), speed),
    ):
        with pytest.raises(ValueError, match="must be one of difference, observer, stamps"):
            call()


def test_loop__output_at_its_limit__comes_back_as_with_differences():
    """3 mm at once: forces are at their limits for milliseconds; `pull` takes the difference."""
    path = rest(4000, 3e-3)
    most = {}
    for speed in ("difference", "observer"):
        done = closed_loop.run(ROBOT, path, LawController(ROBOT, speed), lambda _: None)
        at_limit = np.abs(done.ticks.outputs[:, :3]).max(axis=1) == ROBOT.F_max
        error = done.tool[:, 2] - path.position[:, 2]
        assert at_limit.sum() > 10 and np.abs(error[-1000:]).max() < 1e-6
        most[speed] = error[1:].max()
    assert most["observer"] <= 1.15 * most["difference"]


@pytest.mark.parametrize("share", [0.8, 1.2])
def test_loop__wrong_masses__ripples_no_more_and_follows(share):
    """The law believes in other masses than the plant has."""
    wrong = {name: share * getattr(ROBOT, name) for name in ("m_s", "m_p", "J_a", "mr_c")}
    path, _ = reversing_path(ROBOT, 3000)
    tools = {}
    for speed in ("difference", "observer"):
        law = LawController(replace(ROBOT, **wrong), speed)
        plant = Plant(ROBOT, tuple(path.position[0]), tuple(path.table_position[0]))
        done = closed_loop.run(ROBOT, path, law, lambda _: None, plant=plant)
        tool = np.linalg.norm(done.tool - path.position, axis=1)[1000:].max()
        tools[speed] = (tool, ripple(done.ticks.outputs, PERIOD)[:3].max())
    assert tools["observer"][0] <= 1.05 * tools["difference"][0]
    assert tools["observer"][1] <= 0.2 * tools["difference"][1]


def test_ripple__of_a_sine__is_its_root_mean_square_above_1_khz_alone():
    t = np.arange(20_000) * PERIOD
    wave = [np.sin(2 * np.pi * f * t) for f in (100.0, 900.0, 1100.0, 4000.0)]
    values = np.stack([*wave, 5.0 + t], axis=1)
    assert ripple(values, PERIOD) == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5, 0], abs=2e-3)
    assert ripple(values[:3], PERIOD).shape == (5,)


def test_delay__of_speeds_a_tick_old__is_a_tick():
    t = np.arange(4000) * PERIOD
    joints = np.zeros((4000, 5))
    joints[:, :3] = 0.02 * np.sin(2 * np.pi * 2.0 * t)[:, None]
    old = np.gradient(joints, PERIOD, axis=0)
    old[1:] = old[:-1].copy()
    acceleration = -((2 * np.pi * 2.0) ** 2) * joints
    assert delay(PERIOD, joints, old, acceleration) == pytest.approx(PERIOD, rel=1e-2)


def test_margin__of_differences__is_that_of_the_loop_in_continuous_time_less_its_delays():
    """3 w s^2 + 3 w^2 s + w^3 over s^3; hold and difference are late by half a period each, the
    difference where K_V counts."""
    w = 2 * np.pi * ROBOT.f_legs
    s = 1j * np.geomspace(0.1 * w, 10 * w, 100_000)
    loop = (3 * w * s**2 * np.exp(-s * PERIOD / 2) + 3 * w**2 * s + w**3) / s**3
    loop = loop * np.exp(-s * PERIOD / 2)
    last = np.flatnonzero(np.abs(loop) > 1)[-1]
    want = np.degrees(np.angle(-loop[last]))
    assert margin(ROBOT, 0, "difference") == pytest.approx(want, abs=1.0)
    assert 50 < margin(ROBOT, 0, "observer") < margin(ROBOT, 0, "difference")


def stamped(path: SetPoints) -> closed_loop.Recording:
    """The law with stamps in double precision over a path."""
    plant = StampedPlant(ROBOT, tuple(path.position[0]), tuple(path.table_position[0]))
    law = LawController(ROBOT, "stamps")
    return closed_loop.run(ROBOT, path, law, lambda _: None, plant=plant)


@pytest.mark.parametrize("seed", range(20))
def test_crossing__of_a_cubic__is_the_last_change_of_its_count(seed):
    """Against the count in each of 100 000 moments of the tick."""
    random = np.random.default_rng(seed)
    p0, v0, p1, v1 = random.uniform(-3, 3, 4) * (1 + 5 * (seed % 2))
    t = np.linspace(0, 1, 100_001)
    c3, c2 = 2 * (p0 - p1) + v0 + v1, 3 * (p1 - p0) - 2 * v0 - v1
    counts = np.floor(((c3 * t + c2) * t + v0) * t + p0 + 0.5)
    changes = np.flatnonzero(np.diff(counts))
    found = last_crossing(p0, v0, p1, v1)
    if len(changes) == 0:
        assert found is None
    else:
        last = changes[-1]
        assert found == (pytest.approx(t[last + 1], abs=2e-5), np.sign(np.diff(counts)[last]))


def test_stamps__of_the_plant__age_by_a_tick_without_a_count_and_begin_at_none():
    plant = StampedPlant(ROBOT, ROBOT.start[:3])
    assert plant.counts()[5:] == (0,) * 5
    ticking = 2 * round(clock_of(ROBOT) * PERIOD)
    assert plant._stamp(-7, 0.1, 0.0, 0.2, 0.0) == -7 - ticking
    assert plant._stamp(LONG_AGO - 1, 0.1, 0.0, 0.2, 0.0) == LONG_AGO - 1
    assert plant._stamp(0, 0.1, 0.0, 0.2, 0.0) == 0
    half = plant._stamp(0, 0.0, 1.0, 1.0, 1.0)  # crosses 1/2 in the middle
    assert half == pytest.approx(ticking / 2, abs=2) and half % 2 == 1


def test_stamps__constant_slip__is_measured_without_its_counts():
    """A leg that is 1 mm/s too slow, its counts 2.5 ticks apart: e_v is that at any time."""
    law, q, speed = Stamps(ROBOT), ROBOT.resolution[0], 1e-3
    clock = clock_of(ROBOT)
    seen = []
    for tick in range(1, 100):
        place = speed * tick * PERIOD  # an edge at each odd half of a count
        edge = (np.floor(place / q - 0.5) + 0.5) * q
        age = (place - edge) / speed
        stamp = 2 * int(age * clock) + 1 if edge > 0 else 0
        count = int(np.floor(place / q + 0.5))  # the desired leg moves twice as fast
        seen.append(law.errors([count] * 5, [stamp] * 5, [2 * speed] * 5, [0.0] * 5)[0])
    assert seen[10:] == pytest.approx([speed] * 89, rel=2e-3)


def test_program_with_stamps__keeps_its_bounds_and_says_what_double_precision_says():
    path, _ = reversing_path(ROBOT, 500)
    done = stamped(path)
    want = run(ROBOT, path, done.counts, "stamps")
    assert np.array_equal(want.output, done.ticks.outputs)
    source = PROGRAMS / "tracking_stamps.s"
    image = assemble(source, optimise=False, defines=ROBOT.values()).to_json()
    rows = run_path(image, ROBOT, path, done.counts).rows
    limit = bounds(ROBOT, path, want, True, done.counts).output
    for axis, name in enumerate(OUTPUTS):
        assert np.max(np.abs(rows[name] - want.output[:, axis]) / limit[:, axis]) <= 1.0, name


def test_set_points_of_binary32__make_no_more_ripple_with_stamps():
    """Their rounding is a part of a leg's error of position, and no speed."""
    path, _ = reversing_path(ROBOT, 2000)  # binary32 as it is
    noise = np.random.default_rng(1).uniform(-3e-8, 3e-8, (2000, 3))
    words = path.words()
    words[:, :3] += noise
    plain, noisy = (
        ripple(stamped(p).ticks.outputs, PERIOD)[:3] for p in (path, SetPoints.from_words(words))
    )
    assert noisy.max() <= plain.max() + 0.5


def test_loop_with_stamps__ripples_little_even_where_legs_reverse_all_the_time():
    path, _ = reversing_path(ROBOT, 3000)
    law = LawController(ROBOT)
    plain = closed_loop.run(ROBOT, path, law, lambda _: None)
    share = ripple(stamped(path).ticks.outputs, PERIOD) / ripple(plain.ticks.outputs, PERIOD)
    assert share.max() <= 0.25  # 30 Hz shakes reverse every leg each 17 ms
