# SPDX-License-Identifier: Apache-2.0
"""Profile velocity and profile torque of CiA 402; independent of us: Ruckig."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from ruckig import ControlInterface, InputParameter, Result, Ruckig, Trajectory

from tests.ethercat.drives import CSP, CSV, ENABLE, PP, PT, PV, QUICK_STOP, TICK, Drives
from tests.ethercat.host import AXES, AbortedError

REACHED, ZERO, LIMITED, SLIPPAGE = 0x0400, 0x1000, 0x0800, 0x2000
TURNS = AXES  # control cycles in which each axis may plan once


def pv_drives(acceleration: int, deceleration: int, jerk: int, axis: int = 0) -> Drives:
    drives = Drives(PV)
    for index, value in ((0x6083, acceleration), (0x6084, deceleration), (0x6065, 0xFFFFFFFF)):
        drives.put(index + 0x800 * axis, 0, value)
    drives.put(0x60A4 + 0x800 * axis, 1, jerk // 1000)
    drives.enable(axis)
    return drives


def change_of_ruckig(v: float, a: float, target: float, limits: tuple[int, int]) -> Trajectory:
    """Of speed, from (v, a), in 1e6 increments; limits: acceleration, jerk."""
    given = InputParameter(1)
    given.control_interface = ControlInterface.Velocity
    given.current_velocity, given.current_acceleration = [v * 1e-6], [a * 1e-6]
    given.target_velocity = [target * 1e-6]
    given.max_acceleration, given.max_jerk = [limits[0] * 1e-6], [limits[1] * 1e-6]
    found = Trajectory(1)
    assert Ruckig(1).calculate(given, found) in (Result.Working, Result.Finished)
    return found


@pytest.mark.parametrize(
    ("before", "after", "which"),
    [(0, 4_000_000, 0), (4_000_000, 500_000, 1), (0, -3_000_000, 0), (-3_000_000, 0, 1),
     (2_000_000, 2_010_000, 0)],
)  # fmt: skip
def test_profile_velocity__changes_as_ruckig_does_up_by_6083_down_by_6084(before, after, which):
    ramps, jerk = (100_000_000, 40_000_000), 5_000_000_000
    drives = pv_drives(*ramps, jerk)
    drives.follow(3000, velocity=before)
    assert drives.set_point()[1] == before
    start = drives.set_point()[0]
    wanted = change_of_ruckig(before, 0, after, (ramps[which], jerk))
    rows = drives.follow(round(wanted.duration / TICK) + 20, velocity=after)
    first = np.nonzero(rows[:, 1] != before)[0][0]
    assert first < TURNS
    rows, last = rows[first:], before
    start += first * before * TICK
    for n, row in enumerate(rows):
        place, speed, acceleration = (1e6 * x[0] for x in wanted.at_time((n + 1) * TICK))
        assert abs(row[1] - speed) <= 2e-7 * 4e6 + 1, n
        assert abs(row[2] - acceleration) <= 1e-5 * ramps[which] + 1, n
        assert abs(row[0] - start - place) <= 1.0, n
        assert abs(row[1] - last) <= ramps[which] * TICK * 1.0001 + 1
        last = row[1]
    assert rows[-1, 1] == after


def test_profile_velocity__random_targets_in_motion_end_where_ruckig_ends():
    rng = random.Random(5)
    ramp, jerk = 80_000_000, 2_000_000_000
    drives = pv_drives(ramp, ramp, jerk)
    for _ in range(40):
        target = rng.randrange(-5_000_000, 5_000_000)
        _, v, a = drives.set_point()
        rows = drives.follow(TURNS, velocity=target)
        first = np.nonzero(np.abs(np.diff([a, *rows[:, 2]])) > 1)[0]
        cycles = rng.randrange(10, 1200)
        rows = np.vstack([rows, drives.follow(cycles)])
        assert np.abs(np.diff(rows[:, 2])).max() <= jerk * TICK * 1.001
        assert np.abs(rows[:, 2]).max() <= ramp * 1.0001
        if a == 0:  # the start of the plan is known
            wanted = change_of_ruckig(v, a, target, (ramp, jerk))
            time = (len(rows) - first[0]) * TICK
            speed = 1e6 * wanted.at_time(time)[1][0]
            assert abs(rows[-1, 1] - speed) < 3
    rows = drives.follow(3000)
    assert rows[-1, 1] == target and rows[-1, 2] == 0


def test_profile_velocity__every_axis_gets_its_turn_within_half_a_millisecond():
    drives = Drives(PV)
    for n in range(AXES):
        drives.put(0x6065 + 0x800 * n, 0, 0xFFFFFFFF)
        drives.enable(n)
    for n in range(AXES):
        drives.set(n, velocity=1_000_000 * (n + 1))
    drives.outputs(drives.values)
    began = {}
    for cycle in range(2 * TURNS):
        drives.cycle()
        for n in range(AXES):
            if drives.command.axis[n].velocity:
                began.setdefault(n, cycle)
    assert set(began.values()) == set(range(TURNS))  # no two in one control cycle
    drives.follow(3000)
    assert [drives.command.axis[n].velocity for n in range(AXES)] == [
        1_000_000.0 * (n + 1) for n in range(AXES)
    ]


def test_profile_velocity__a_ramp_written_in_motion_takes_effect():
    drives = pv_drives(10_000_000, 10_000_000, 10_000_000_000)
    rows = drives.follow(500, velocity=4_000_000)
    assert abs(rows[:, 2].max() - 10_000_000) < 100
    drives.put(0x6083, 0, 60_000_000)
    rows = drives.follow(500)
    assert abs(rows[:, 2].max() - 60_000_000) < 600


def test_profile_velocity__target_reached_after_the_time_in_the_window():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    drives.put(0x606D, 0, 30_000)
    drives.put(0x606E, 0, 20)
    drives.set(velocity=3_000_000)
    entered = reached = None
    for n in range(2000):
        drives.step()
        inside = abs(drives.inputs()[0x606C, 0] - 3_000_000) <= 30_000
        if inside and entered is None:
            entered = n
        if drives.statusword() & REACHED:
            reached = n
            break
        assert reached is None
    assert reached - entered == 200  # 20 ms
    drives.step(velocity=2_900_000)
    assert not drives.statusword() & REACHED


def test_profile_velocity__speed_0_by_threshold_and_its_time():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    drives.put(0x606F, 0, 10_000)
    drives.put(0x6070, 0, 15)
    drives.follow(10)
    assert drives.statusword() & ZERO
    above = 0
    drives.set(velocity=1_000_000)
    while drives.statusword() & ZERO:
        drives.step()
        above += abs(drives.inputs()[0x606C, 0]) > 10_000
        assert above < 200
    assert above == 151  # the first cycle beyond 15 ms
    drives.follow(1000, velocity=0)
    assert drives.statusword() & (ZERO | REACHED) == ZERO | REACHED


def test_profile_velocity__following_error_is_not_shown_as_slippage():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    drives.put(0x6065, 0, 100)
    drives.put(0x6066, 0, 1000)
    drives.held.add(0)
    drives.follow(500, velocity=1_000_000)
    assert drives.inputs()[0x60F4, 0] > 100
    assert not drives.statusword() & SLIPPAGE
    drives.follow(10_000)
    assert drives.state() == "FAULT" and drives.inputs()[0x603F, 0] == 0x8611


@pytest.mark.parametrize("sign", [1, -1])
def test_profile_velocity__607F_bounds_the_speed_and_a_lower_one_is_reached_on_the_ramp(sign):
    drives = pv_drives(100_000_000, 50_000_000, 10_000_000_000)
    drives.put(0x607F, 0, 2_000_000)
    rows = drives.follow(1500, velocity=sign * 5_000_000)
    assert sign * rows[-1, 1] == np.abs(rows[:, 1]).max() == 2_000_000
    assert drives.statusword() & LIMITED and not drives.statusword() & REACHED
    drives.put(0x607F, 0, 500_000)
    rows = np.vstack([rows[-1:], drives.follow(1500)])
    assert np.abs(np.diff(rows[:, 1])).max() <= 50_000_000 * TICK * 1.001
    assert sign * rows[-1, 1] == 500_000
    drives.follow(1500, velocity=sign * 400_000)
    assert not drives.statusword() & LIMITED


def test_profile_velocity__rests_at_a_limit_of_607D_and_leaves_it_again():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    drives.put(0x607D, 2, 300_000)
    rows = drives.follow(6000, velocity=3_000_000)
    assert rows[:, 0].max() <= 300_000 and rows[-1, 0] >= 299_000 and rows[-1, 1] == 0
    assert np.abs(np.diff(rows[:, 1])).max() <= 4e8 * TICK * 1.01  # the quick stop deceleration
    assert drives.statusword() & LIMITED
    rows = drives.follow(1000, velocity=-1_000_000)
    assert rows[-1, 1] == -1_000_000 and not drives.statusword() & LIMITED


@pytest.mark.parametrize(("option", "ramp"), [(1, 30_000_000), (2, 200_000_000)])
def test_profile_velocity__halt_on_the_ramp_of_605D_and_on_from_there(option, ramp):
    drives = pv_drives(100_000_000, 30_000_000, 10_000_000_000)
    drives.put(0x605D, 0, option)
    drives.put(0x6085, 0, 200_000_000)
    drives.follow(1000, velocity=3_000_000)
    rows = drives.follow(1500, control=ENABLE | 0x100)
    assert abs(np.diff(rows[:, 1])[2:20].mean() + ramp * TICK) < 1
    assert rows[-1, 1] == 0 and drives.statusword() & (REACHED | ZERO) == REACHED | ZERO
    assert drives.state() == "OPERATION ENABLED"
    rows = drives.follow(1500, control=ENABLE)
    assert rows[-1, 1] == 3_000_000 and drives.statusword() & (REACHED | ZERO) == REACHED


def test_profile_velocity__quick_stop_and_change_of_mode_do_not_jump():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    drives.put(0x605A, 0, 6)
    rows = drives.follow(1000, velocity=3_000_000)
    rows = np.vstack([rows, drives.follow(500, control=QUICK_STOP)])
    assert drives.state() == "QUICK STOP ACTIVE" and rows[-1, 1] == 0
    rows = np.vstack([rows, drives.follow(800, control=ENABLE)])
    assert rows[-1, 1] == 3_000_000
    rows = np.vstack([rows, drives.follow(800, mode=PP)])
    assert rows[-1, 1] == 0
    assert np.abs(np.diff(rows[:, 1])).max() <= 4e8 * TICK * 1.01


def test_profile_position__brakes_with_6084():
    """Ruckig's directional limits: the least acceleration is the deceleration of a way up."""
    drives = Drives(PP)
    for index, value in ((0x6083, 100_000_000), (0x6084, 25_000_000), (0x6065, 0xFFFFFFFF)):
        drives.put(index, 0, value)
    drives.enable()
    given, found = InputParameter(1), Trajectory(1)
    given.target_position, given.max_velocity = [1.0], [5.0]
    given.max_acceleration, given.min_acceleration, given.max_jerk = [100.0], [-25.0], [10_000.0]
    assert Ruckig(1).calculate(given, found) in (Result.Working, Result.Finished)
    rows = drives.follow(
        round(found.duration / TICK) + 80, position=1_000_000, control=ENABLE | 0x10
    )
    first = np.nonzero(rows[:, 1])[0][0]
    speeds = [found.at_time((n + 1) * TICK)[1][0] * 1e6 for n in range(len(rows) - first)]
    assert np.abs(rows[first:, 1] - speeds).max() < 2e-4 * 5e6
    assert rows[-1, 0] == 1_000_000
    assert rows[:, 2].max() == pytest.approx(1e8, rel=1e-5)
    assert rows[:, 2].min() == pytest.approx(-2.5e7, rel=1e-5)


# -------------------------------------------------------------------- profile torque


def pt_drives(slope: int = 10_000) -> Drives:
    drives = Drives(PT)
    drives.put(0x6087, 0, slope)
    drives.enable()
    return drives


def torques(drives: Drives, cycles: int, **values: int) -> list[int]:
    """Of each control cycle; the machine measures what it is told."""
    drives.set(**values)
    rows = []
    for _ in range(cycles):
        drives.outputs(drives.values)
        drives.cycle()
        assert drives.command.axis[0].torque_only
        rows.append(drives.command.axis[0].torque)
        drives.feedback.axis[0].torque = rows[-1]
    return rows


@pytest.mark.parametrize("target", [400, -250])
def test_profile_torque__goes_to_the_target_on_the_slope_then_it_is_reached(target):
    drives = pt_drives(slope=20_000)  # 2 (0.1 %) a control cycle
    ticks = abs(target) // 2
    rows = torques(drives, ticks - 1, torque=target)
    assert not drives.statusword() & REACHED
    rows += torques(drives, 20)
    sign = 1 if target > 0 else -1
    wanted = [sign * min(2 * (n + 1), abs(target)) for n in range(len(rows))]
    assert np.abs(np.array(rows) - wanted).max() <= 1 and rows[-1] == target
    assert drives.statusword() & REACHED


def test_profile_torque__6072_bounds_it_and_it_is_not_reached():
    drives = pt_drives(slope=1_000_000)
    drives.put(0x6072, 0, 300)
    rows = torques(drives, 30, torque=500)
    assert rows[-1] == 300 == max(rows)
    assert drives.statusword() & (LIMITED | REACHED) == LIMITED
    drives.put(0x6072, 0, 600)
    assert torques(drives, 3)[-1] == 500
    assert drives.statusword() & (LIMITED | REACHED) == REACHED


def test_profile_torque__begins_with_the_measured_torque():
    drives = Drives(CSP)
    drives.put(0x6087, 0, 10_000)
    drives.enable()
    drives.feedback.axis[0].torque = 150
    drives.step()
    rows = torques(drives, 10, mode=PT, torque=0)
    assert rows[0] == 149 and rows[-1] == 140


def test_profile_torque__offsets_of_the_cyclic_modes_do_not_add():
    drives = pt_drives(slope=1_000_000)
    assert torques(drives, 20, torque=100, torque_offset=70)[-1] == 100
    drives = Drives(PV)
    drives.enable(velocity=1_000_000, velocity_offset=500_000)
    assert drives.follow(1000)[-1, 1] == 1_000_000


def test_profile_torque__halt_brakes_the_axis_and_takes_it_up_again():
    drives = pt_drives(slope=1_000_000)
    torques(drives, 20, torque=100)
    drives.put(0x6065, 0, 50)  # less than the way of a cycle: no following error without set-point
    drives.put(0x6066, 0, 0)
    drives.held.add(0)
    for n in range(200):
        drives.feedback.axis[0].position = 100 * n
        drives.step()
    assert drives.state() == "OPERATION ENABLED" and drives.inputs()[0x60F4, 0] == 0
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.held.clear()
    drives.feedback.axis[0].position += 100
    speeds = drives.follow(200, control=ENABLE | 0x100)[:, 1]
    assert not drives.command.axis[0].torque_only
    assert 900_000 < speeds[0] <= 1_000_000 and speeds[-1] == 0
    assert drives.statusword() & REACHED
    assert torques(drives, 30, control=ENABLE)[-1] == 100


def test_supported_modes__are_those_that_6060_takes():
    """Bit m - 1 of 6502 is mode m (CiA 402-2), for the modes above 0."""
    drives = Drives()
    word = int(drives.get(0x6502))
    for mode in range(-1, 12):
        try:
            drives.put(0x6060, 0, mode)
            taken = True
        except AbortedError as error:
            assert error.code == 0x06090030
            taken = False
        assert taken == (mode == 0 or mode > 0 and bool(word >> mode - 1 & 1)), mode
    assert word == 0x3AD


# -------------------------------------------------------------------- scale and motor speed


def test_scale__is_that_of_2011_and_cannot_be_written():
    """User unit = increment * feed / (increments per revolution * gear) (CiA 402-2)."""
    drives = Drives()
    for n in range(AXES):
        at = 0x800 * n
        increments = drives.get(0x608F + at, 1) / drives.get(0x608F + at, 2)
        gear = drives.get(0x6091 + at, 1) / drives.get(0x6091 + at, 2)
        feed = drives.get(0x6092 + at, 1) / drives.get(0x6092 + at, 2)
        assert feed / (increments * gear) == 1  # positions are increments
        revolution = 1e-3 if n < 3 else 2 * math.pi
        assert increments * drives.get(0x2011, n + 1) == pytest.approx(revolution, rel=1e-7)
        for index in (0x608F, 0x6091, 0x6092):
            for subindex in (1, 2):
                with pytest.raises(AbortedError) as caught:
                    drives.put(index + at, subindex, 2)
                assert caught.value.code == 0x06010002


@pytest.mark.parametrize("mode", [PP, PV, CSP, CSV])
@pytest.mark.parametrize("axis", [0, 4])
def test_max_motor_speed__bounds_every_mode_with_set_points_beside_607F(mode, axis):
    drives = Drives(mode)
    at = 0x800 * axis
    revolution = 100_000 if axis == 0 else 62_831_853  # increments
    motor = 1200 if axis == 0 else 2  # 1/min: 2e6, 2.1e6 increments/s
    drives.put(0x6080 + at, 0, motor)
    drives.put(0x6065 + at, 0, 0xFFFFFFFF)
    for n in range(AXES):
        drives.enable(n)
    drives.set(axis, position=2_000_000, velocity=6_000_000, control=ENABLE | 0x10)
    speeds = []
    for tick in range(3000):
        if tick % 10 == 0:
            drives.outputs(drives.values)
        if tick == 1500:
            drives.put(0x607F + at, 0, 500_000)  # the lesser one, of targets from here on
            drives.set(axis, position=0, control=ENABLE)
        if tick == 1550:
            drives.set(axis, control=ENABLE | 0x30)
        drives.cycle()
        speeds.append(abs(drives.command.axis[axis].velocity))
    assert max(speeds[:1500]) == pytest.approx(motor * revolution / 60, rel=5e-3)
    assert max(speeds[2600:]) == pytest.approx(500_000, rel=5e-3)


def test_max_motor_speed__written_in_motion_takes_effect():
    drives = pv_drives(100_000_000, 100_000_000, 10_000_000_000)
    assert drives.follow(1000, velocity=3_000_000)[-1, 1] == 3_000_000
    drives.put(0x6080, 0, 600)  # 1/min, of 100 000 increments
    assert drives.follow(1000)[-1, 1] == 1_000_000
