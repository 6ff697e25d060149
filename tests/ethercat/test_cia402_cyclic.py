# SPDX-License-Identifier: Apache-2.0
"""Cyclic modes of CiA 402; independent of us: scipy's polynomials for the interpolation."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from scipy.interpolate import BPoly

from tests.ethercat.drives import (
    CSP,
    CST,
    CSV,
    ENABLE,
    HOMING,
    PP,
    SHUTDOWN,
    SWITCH_ON,
    TICK,
    Drives,
)
from tests.ethercat.host import AbortedError


def master_path(count: int) -> np.ndarray:
    """Targets of a smooth path that starts and ends at rest, whole increments."""
    t = np.arange(count) / count
    return np.rint(2e6 * np.sin(math.pi * t) ** 4 * np.cos(7 * t)).astype(int)


def run_csp(drives: Drives, targets: np.ndarray, period: int) -> np.ndarray:
    """Position, velocity and acceleration of the set-point in each control cycle."""
    return np.vstack([drives.follow(period, period, position=int(t)) for t in targets])


@pytest.mark.parametrize("period", [10, 20, 5, 1])
def test_csp__runs_the_quintic_of_scipy_and_its_acceleration_is_continuous(period):
    drives = Drives()
    drives.put(0x60C2, 1, period)
    drives.put(0x60C2, 2, -4)
    check_quintic(drives, period)


def check_quintic(drives: Drives, period: int) -> None:
    """A path in CSP, a target in each `period`-th control cycle, against scipy's quintic."""
    tick = drives.CYCLE_NS * 1e-9
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x607F, 0, 2_000_000_000)  # the fastest path of this test
    drives.enable()
    drives.follow(10)
    drives.step(control=0)
    drives.enable()
    drives.cycle(period - 1)
    targets = master_path(200)
    rows = run_csp(drives, targets, period)
    h = period * tick
    p = np.concatenate([np.zeros(4), targets])
    v = (p[2:] - p[:-2]) / (2 * h)
    a = (p[2:] - 2 * p[1:-1] + p[:-2]) / h**2
    knots = h * np.arange(1, len(p) - 1)
    curve = BPoly.from_derivatives(knots, np.column_stack([p[1:-1], v, a]))
    # A target that comes at tick k is reached 2.5 periods later; the tick is set at its end.
    ticks = np.arange(len(rows))
    half = 0.5 * h
    times = 4 * h + (ticks + 1) * tick - 2 * h - half
    use = (times > knots[0]) & (times < knots[-1])
    for order, bound in ((0, 0.2), (1, 100.0), (2, 3e5)):
        wanted = curve.derivative(order)(times[use]) if order else curve(times[use])
        scale = np.abs(wanted).max()
        error = np.abs(rows[use, order] - wanted).max()
        assert error < max(bound * (10 / period) ** order * 0.1, 2e-6 * scale), (
            order,
            error,
            scale,
        )
    # Continuous: no step of the acceleration beyond what the jerk of the quintic gives in a tick.
    jerk = np.abs(np.diff(p, 3)).max() / h**3
    assert np.abs(np.diff(rows[:, 2])).max() <= 9.1 * jerk * tick


def test_csp__a_late_and_a_lost_target_do_not_stop_the_motion():
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    speeds = []
    rng = random.Random(3)
    arrivals = {10 * k + rng.randrange(-2, 3): k for k in range(1, 400) if k % 50}
    for tick in range(4000):
        if tick in arrivals:
            drives.set(position=1000 * arrivals[tick])
            drives.outputs(drives.values)
        drives.cycle()
        speeds.append(drives.command.axis[0].velocity)
    steady = np.array(speeds[200:]) * 1e-3
    assert steady.min() > 990 and steady.max() < 1010  # increments a period
    assert drives.get(0x1C32, 11) >= 7


class LateDrives(Drives):
    """Outputs come after the control cycle has read the event of their sync manager."""

    def write(self, address: int, data: bytes) -> bool:
        if address != 0x1200:
            return super().write(address, data)
        self.library.double_write_late(address, bytes(data), len(data))
        return True


def test_csp__outputs_after_the_read_of_the_event_come_in_each_cycle():
    """A fetch of the outputs before them would take them too, and the next cycle would find no
    event: half of them would be missed."""
    drives = LateDrives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x60C2, 1, 1)
    drives.put(0x60C2, 2, -4)
    drives.enable()
    missed = drives.get(0x1C32, 11)
    speeds = []
    for k in range(200):
        drives.step(position=100 * k)
        speeds.append(drives.command.axis[0].velocity)
    assert drives.get(0x1C32, 11) - missed <= 1
    assert np.allclose(speeds[10:], 1e6)


@pytest.mark.parametrize("every", [2, 3])
def test_csp__regular_losses_do_not_make_the_set_points_swing(every):
    """One of `every` targets of a sine comes. With n = every and D the sine's second difference,
    the target that comes bends the path by n^2 D, the next extrapolation by n (1 - n) D. Between
    the two, the acceleration of the quintic overshoots by 0.766 of their difference. A target
    that is off has no effect a turn later."""
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x607F, 0, 2_000_000_000)
    drives.put(0x10F1, 2, 0)
    drives.enable()
    period, amplitude, turn = 10, 2e6, 400
    accelerations = []
    for k in range(4 * turn):
        off = 5000 * (k == 2 * turn + 2 * every)
        drives.set(position=round(amplitude * (1 - math.cos(2 * math.pi * k / turn))) + off)
        if k < turn or k % every == 0:
            drives.outputs(drives.values)
        for _ in range(period):
            drives.cycle()
            accelerations.append(drives.command.axis[0].acceleration)
            assert not drives.statusword() & 0x0800 or k < 10
    bend = amplitude * (2 * math.pi / turn) ** 2
    found = np.abs(accelerations[3 * turn * period :]).max() * (period * TICK) ** 2
    assert found < bend * (every**2 + 0.766 * (2 * every**2 - every))


def test_csp__a_clock_that_runs_away_is_followed():
    """A master 1000 ppm fast: the phase does not slip over a target."""
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x10F1, 2, 0)
    drives.enable()
    speeds, arrival = [], 0.0
    for k in range(2000):
        drives.set(position=1000 * k)
        drives.outputs(drives.values)
        arrival += 10 * (1 - 1e-3)
        while len(speeds) < arrival:
            drives.cycle()
            speeds.append(drives.command.axis[0].velocity)
    steady = np.array(speeds[200:]) * 1e-3
    assert 990 < steady.min() and steady.max() < 1010


@pytest.mark.parametrize("period_us", [100, 125, 150, 200, 250, 330, 1750])
def test_csp__a_period_that_is_no_multiple_of_the_control_is_served_exactly(period_us):
    drives = Drives()
    value, index = (period_us, -6) if period_us < 256 else (period_us // 10, -5)
    drives.put(0x60C2, 1, value)
    drives.put(0x60C2, 2, index)
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    speeds, k = [], 0
    for tick in range(6000):
        if tick * 100 >= k * period_us:
            drives.set(position=10 * period_us * k)  # 1e7 increments/s
            drives.outputs(drives.values)
            k += 1
        drives.cycle()
        speeds.append(drives.command.axis[0].velocity)
    steady = np.array(speeds[2000:])
    assert np.abs(steady / 1e7 - 1).max() < 3e-3  # steps of 1/512 follow the phase


def set_points(periods: dict[int, int]) -> dict[int, list[tuple[float, ...]]]:
    """Set-points of the axes with these periods in control cycles, each along a path of its own,
    with a frame each six cycles."""
    drives = Drives()
    for axis, period in periods.items():
        drives.put(0x60C2 + 0x800 * axis, 1, period)
        drives.put(0x60C2 + 0x800 * axis, 2, -4)
        drives.put(0x6065 + 0x800 * axis, 0, 0xFFFFFFFF)
    for control in (SHUTDOWN, SWITCH_ON, ENABLE):
        for axis in periods:
            drives.set(axis, control=control)
        drives.step()
    drives.cycle(5)
    rows: dict[int, list[tuple[float, ...]]] = {axis: [] for axis in periods}
    paths = {axis: random.Random(axis) for axis in periods}
    for cycle in range(400):
        if cycle % 6 == 0:
            for axis, path in paths.items():
                drives.set(axis, position=50 * cycle + path.randrange(100))
            drives.outputs(drives.values)
        drives.cycle()
        for axis in periods:
            found = drives.command.axis[axis]
            rows[axis].append((found.position, found.fraction, found.velocity, found.acceleration))
    return rows


def test_csp__axes_of_different_periods_run_as_each_alone():
    """The first two are at the same phase of their periods in every sixth cycle."""
    periods = {0: 6, 1: 2, 2: 6, 4: 9}
    together = set_points(periods)
    assert all(len(set(row)) > 300 for row in together.values())
    for axis, period in periods.items():
        assert together[axis] == set_points({axis: period})[axis], axis


def test_interpolation_period__shorter_than_the_control_is_refused():
    drives = Drives()
    for subindex, value in ((2, -6), (2, -5)):
        with pytest.raises(AbortedError, match="06090030"):
            drives.put(0x60C2, subindex, value)
    assert (drives.get(0x60C2, 1), drives.get(0x60C2, 2)) == (1, -3)
    drives.put(0x60C2, 1, 100)
    drives.put(0x60C2, 2, -6)
    with pytest.raises(AbortedError, match="06090030"):
        drives.put(0x60C2, 1, 99)
    assert (drives.get(0x60C2, 1), drives.get(0x60C2, 2)) == (100, -6)
    drives.put(0x60C2, 2, -1)
    drives.put(0x60C2, 1, 255)  # 25.5 s
    drives.follow(10)


def test_csp__offsets_are_feed_forward_and_limits_hold():
    drives = Drives()
    drives.put(0x607D, 1, -500)
    drives.put(0x607D, 2, 500)
    drives.enable()
    drives.follow(60, position=400, velocity_offset=12345, torque_offset=-77)
    axis = drives.command.axis[0]
    assert (axis.position, axis.velocity, axis.torque) == (400, 12345.0, -77)
    assert not drives.statusword() & 0x0800
    drives.follow(60, position=2000)
    assert drives.command.axis[0].position == 500
    assert drives.statusword() & 0x1800 == 0x1800


QUICK = 4e8  # increments/s2


def approaching(mode: int, speed: int, offset: int = 0) -> np.ndarray:
    """Set-points of an axis that runs to the upper limit of 607D, where it is at half a second;
    the last frame asks for the limit."""
    drives, limit = Drives(mode), speed // 2
    drives.put(0x607D, 1, -limit)
    drives.put(0x607D, 2, limit)
    drives.put(0x10F1, 2, 0)
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x60C2, 1, 4)
    drives.put(0x60B0, 0, offset)
    drives.enable()
    rows = []
    for k in range(1, 126):
        rows.append(drives.follow(40, 40, position=speed * k // 250, velocity=speed))
    for _ in range(800):  # no frame, the watchdog is not over
        drives.cycle()
        rows.append(np.array([drives.set_point()]))
    assert drives.state() == "OPERATION ENABLED" and drives.statusword() & 0x0800
    return np.vstack(rows)


@pytest.mark.parametrize("mode", [CSP, CSV])
@pytest.mark.parametrize("speed", [1_000_000, 10_000_000, 40_000_000])
def test_position_limit__holds_for_extrapolated_and_integrated_targets(mode, speed):
    x, v, _ = approaching(mode, speed).T
    assert x.max() <= speed // 2
    assert x[-1] > speed // 2 - 10 and v[-1] == 0
    ramp = np.diff(v)[1000:] / TICK  # it is at its speed then
    assert -QUICK * 1.05 < ramp.min() < -QUICK * 0.9


def test_position_limit__holds_with_a_position_offset():
    assert approaching(CSP, 1_000_000, offset=50_000)[:, 0].max() <= 500_000


def test_csp__a_step_is_limited_by_the_greatest_speed_and_the_ramp():
    drives = Drives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.put(0x10F1, 2, 0)
    drives.put(0x607F, 0, 5_000_000)
    drives.enable()
    x, v, a = drives.follow(4000, position=1_000_000).T
    assert np.abs(v).max() == 5e6 and np.abs(a).max() <= QUICK * 1.001
    assert np.abs(np.diff(x)).max() <= 5e6 * TICK * 1.001
    assert (x[-1], v[-1]) == (1_000_000, 0) and not drives.statusword() & 0x0800
    assert x.max() <= 1_000_100


def test_mode_12_and_10__homed_axis_stays_homed_and_a_stop_that_ended_is_reached():
    drives = Drives(HOMING)
    drives.enable()
    drives.step(20, control=0x1F)
    assert drives.statusword() & 0x1000
    drives.step(20, mode=CSP, control=0x0F)
    drives.step(20, mode=HOMING)
    assert drives.statusword() & 0x3400 == 0x1400
    drives.step(20, control=0x1F)  # once more
    assert drives.statusword() & 0x1000


@pytest.mark.parametrize("mode", [CSP, CSV, CST, PP, HOMING])
@pytest.mark.parametrize("control", [0x010F, 0x0002])
def test_stop_that_ended__shows_bit_10_in_every_mode(mode, control):
    drives = Drives(mode)
    drives.put(0x605A, 0, 6)
    drives.enable()
    if mode == CSV:
        drives.follow(200, velocity=4_000_000)
        assert not drives.statusword() & 0x0400
        drives.step(control=control)
        assert not drives.statusword() & 0x0400
    drives.follow(600, control=control)
    assert drives.statusword() & 0x0400
    assert drives.state() == ("OPERATION ENABLED" if control & 0x100 else "QUICK STOP ACTIVE")


def test_csv__integrates_the_target_with_continuous_acceleration():
    drives = Drives(CSV)
    drives.enable(velocity=0)
    rows = []
    for k in range(300):
        target = int(1e6 * math.sin(k / 40) ** 3)
        rows.append(drives.follow(10, velocity=target, velocity_offset=1000))
    x, v, a = np.vstack(rows).T
    assert np.abs(v[25:-25:10] - np.interp(np.arange(25, 2975, 10) - 25, np.arange(0, 3000, 10),
        [1e6 * math.sin(k / 40) ** 3 + 1000 for k in range(300)])).max() < 3e4  # fmt: skip
    assert np.abs(np.diff(x)[100:] / TICK - (v[101:] + v[100:-1]) / 2).max() < 30
    assert np.abs(np.diff(v)[100:] / TICK - (a[101:] + a[100:-1]) / 2).max() < 2e4
    assert np.abs(np.diff(a)[100:]).max() < 2e6


def test_cst__gives_torque_within_the_limit_and_no_position():
    drives = Drives(CST)
    drives.put(0x6072, 0, 400)
    drives.enable(torque=250, torque_offset=-50)
    axis = drives.command.axis[0]
    assert (axis.torque, axis.torque_only, axis.power) == (200, True, True)
    for torque, wanted in ((32767, 400), (-32768, -400)):
        drives.step(torque=torque)
        assert drives.command.axis[0].torque == wanted and drives.statusword() & 0x0800


def test_mode__is_shown_and_a_wrong_one_is_not_taken():
    drives = Drives()
    drives.enable()
    for mode in (CSV, CST, PP, HOMING, CSP, 0):
        drives.step(mode=mode)
        assert drives.inputs()[0x6061, 0] == mode
        drives.step(mode=7)
        assert drives.inputs()[0x6061, 0] == mode


def test_change_of_mode_in_motion__no_jump():
    drives = Drives(CSV)
    drives.enable(velocity=2_000_000)
    drives.follow(200)
    before = drives.command.axis[0]
    x, v = before.position + before.fraction, before.velocity
    drives.set(mode=CSP, position=round(x + 2_000_000 * 1.5e-3))  # the one before the first
    for _ in range(40):
        drives.step(10, position=drives.values[0x607A, 0] + 2000)
        axis = drives.command.axis[0]
        assert abs(axis.position + axis.fraction - x - v * 10 * TICK) < 600
        x, v = axis.position + axis.fraction, axis.velocity
        assert abs(v - 2_000_000) < 500_000
    drives.step(mode=PP)
    assert abs(drives.command.axis[0].velocity - v) <= 1e8 * TICK * 1.01
