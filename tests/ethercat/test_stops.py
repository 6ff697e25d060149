# SPDX-License-Identifier: Apache-2.0
"""Stops of an axis that is not where its set-point is: they start from the measured motion."""

from __future__ import annotations

import pytest

from tests.bench.seed import SEED
from tests.ethercat.drives import CSP, CSV, ENABLE, QUICK_STOP, SHUTDOWN, SWITCH_ON, TICK, Drives
from tests.ethercat.stops import (
    CAMPAIGN,
    HALT,
    INCREMENT,
    KINDS,
    MODES,
    NOISE,
    PERIODS,
    PROFILES,
    Mass,
    Moved,
    campaign,
    run_to_the_stop,
    situation,
)


def check_situations(count: int, cycle_ns: int = Drives.CYCLE_NS) -> None:
    """Each can be run again: `situation(seed)` of tests.ethercat.stops."""
    kinds, modes = set(), set()
    for seed, stop in campaign(SEED, count, cycle_ns):
        assert stop.ratio <= 1, f"situation({seed}, {cycle_ns}) accelerates: {stop}"
        assert not stop.too_far, f"situation({seed}, {cycle_ns}) goes too far: {stop}"
        kinds.add(stop.kind)
        modes.add(stop.mode)
    assert kinds >= {*KINDS, "following error"} and modes == {*MODES, *PROFILES}


def test_stops__no_random_one_accelerates_or_goes_too_far():
    check_situations(150)


def test_stops__of_a_control_cycle_of_62_5_us():
    check_situations(150, 62_500)


@pytest.mark.full
@pytest.mark.parametrize("cycle_ns", PERIODS)
def test_stops__ten_thousand_random_ones(cycle_ns):
    check_situations(CAMPAIGN, cycle_ns)


@pytest.mark.parametrize(
    "seed",
    [
        7145,  # the set-point brakes in the tick in which the stop begins
        8378,  # the set-point accelerates in that tick
        18005,  # counts report rest, but the axis follows a slow set-point
        20258,  # the axis crosses a set-point at rest
        27132,  # the pass of a halt finds a following error, whose ramp is gentler
    ],
)
def test_stops__found_ones_are_short(seed: int):
    stop = situation(seed)
    assert stop.ratio <= 1 and not stop.too_far, stop


def test_stop__of_a_set_point_that_the_machine_cannot_follow_does_not_accelerate():
    """The set-point is still near the axis and has thirty times the machine's acceleration."""
    drives = Moved(CSP, Mass(force=4e8, bandwidth=600.0))
    drives.enable(position=0)
    drives.follow(34)
    drives.follow(80)  # the interpolation drifts by a part of a cycle
    drives.set(position=-100_000)
    drives.outputs(drives.values)
    while drives.set_point()[2] == 0:
        drives.cycle()
    position, _, acceleration = drives.set_point()
    assert abs(position) < 1 and abs(acceleration) > 30 * drives.mass.force
    drives.set(control=QUICK_STOP)
    drives.outputs(drives.values)
    drives.cycle()
    before = abs(drives.mass.speed)
    speeds, way = run_to_the_stop(drives)
    assert before > 30_000 and max(map(abs, speeds)) <= before + NOISE
    assert way <= before**2 / (2 * drives.mass.force) + before * TICK + INCREMENT


def test_stop__at_rest_moves_by_an_increment_at_most():
    """The axis is 1.45 increments from its set-point, of which it can measure one."""
    drives = Moved(CSP, Mass(force=1e9, bandwidth=600.0))
    drives.enable(position=0)
    for _ in range(20):
        drives.mass.position, drives.mass.speed = 1.45, 0.0
        drives.cycle()
    drives.set(control=HALT)
    drives.outputs(drives.values)
    drives.cycle()
    start = drives.mass.position
    drives.cycle(300)
    assert 0.5 < abs(drives.mass.position - start) <= INCREMENT


def test_following_error__of_a_far_target_brakes_from_the_measured_speed():
    """Actual 5 mm, target 0, a cycle of 4 ms: the axis is slow when the error is found."""
    drives = Moved(CSP, Mass(force=2e8, bandwidth=300.0, position=500_000.0))
    drives.put(0x60C2, 1, 4)
    drives.feedback.axis[0].position = 500_000
    for control in (SHUTDOWN, SWITCH_ON, ENABLE):
        drives.set(control=control, position=0)
        drives.outputs(drives.values)
        drives.cycle()
    for n in range(2000):
        if n % 40 == 0:
            drives.outputs(drives.values)
        drives.cycle()
        if drives.state() != "OPERATION ENABLED":
            break
    assert drives.state() == "FAULT REACTION ACTIVE" and drives.inputs()[0x603F, 0] == 0x8611
    before = drives.mass.speed
    drives.cycle()  # the law has the first set-point of the stop at the tick after it
    before = max(abs(before), abs(drives.mass.speed))
    speeds, way = run_to_the_stop(drives)
    assert 100_000 < before < 10_000_000
    assert max(map(abs, speeds)) <= before + NOISE
    assert way <= 3 * (before**2 / (2 * drives.mass.force) + before * TICK)


def test_stop__keeps_torque_until_the_axis_itself_rests():
    """The set-point is at rest long before a weak machine is."""
    drives = Moved(CSV, Mass(force=1e8, bandwidth=200.0))
    drives.enable(velocity=4_000_000)
    drives.follow(1500)
    assert drives.mass.speed == pytest.approx(4e6, rel=0.01)
    drives.set(control=QUICK_STOP)
    for n in range(4000):
        if n % 10 == 0:
            drives.outputs(drives.values)
        drives.cycle()
        if not drives.command.axis[0].power:
            break
    assert drives.state() == "SWITCH ON DISABLED"
    assert abs(drives.mass.speed) < 100_000


def test_stop__of_an_axis_that_never_rests_ends_too():
    drives = Drives(CSV)
    drives.enable(velocity=0)
    drives.held.add(0)
    for n in range(3000):
        drives.feedback.axis[0].position = 100_000 * (n % 2)
        drives.set(control=QUICK_STOP)
        drives.outputs(drives.values)
        drives.cycle()
    assert drives.state() == "SWITCH ON DISABLED" and not drives.command.axis[0].power
