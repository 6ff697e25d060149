# SPDX-License-Identifier: Apache-2.0
"""Torque modes of CiA 402: the limit of their speed, and the demanded values (606B, 6074).

The axis moves as the test says while it has the torque alone, and follows its set-point while the
law holds it. That the law holds a robot: test_torque.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.ethercat.drives import CSP, CST, CSV, PT, TICK, Drives

MOST = 1_000_000  # increments/s
LIMITED = 0x0800
VELOCITY_DEMAND, TORQUE_DEMAND = 0x606B, 0x6074


def drives_with(mode: int, torque: int = 100, most: int = MOST) -> Drives:
    drives = Drives(mode)
    drives.put(0x607F, 0, most)
    drives.put(0x6087, 0, 10_000_000)
    drives.enable(torque=torque)
    return drives


class Load:
    """What moves the first axis while it has the torque alone; then it has the law's speed."""

    GAIN = 5000.0  # increments/s in a cycle

    def __init__(self, drives: Drives) -> None:
        self.drives, self.speed, self.part = drives, 0.0, 0.0

    def run(self, speed: float, cycles: int) -> int:
        """Towards this speed; cycles in which the law did not hold the axis."""
        alone = 0
        for _ in range(cycles):
            axis = self.drives.command.axis[0]
            if axis.torque_only:
                away = speed - self.speed
                self.speed += max(-self.GAIN, min(self.GAIN, away))
                way = self.speed * TICK + self.part
                self.drives.feedback.axis[0].position += round(way)
                self.part = way - round(way)
                alone += 1
            else:
                self.speed = axis.velocity
            self.drives.step()
        return alone


@pytest.mark.parametrize("mode", [CST, PT])
@pytest.mark.parametrize("sign", [1, -1])
def test_axis_that_reaches_the_limit__is_held_there_by_the_law(mode, sign):
    drives = drives_with(mode, 100 * sign)
    # 200 cycles to the limit; the speed of the tick that has the law's first set-point counts.
    assert 197 <= Load(drives).run(2 * MOST * sign, 250) <= 201
    drives.feedback.axis[0].torque = 30 * sign
    drives.cycle(50)
    axis = drives.command.axis[0]
    assert (axis.velocity, axis.acceleration, axis.torque) == (MOST * sign, 0.0, 0)
    assert not axis.torque_only and drives.statusword() & LIMITED
    assert drives.get(VELOCITY_DEMAND) == MOST * sign
    assert drives.get(TORQUE_DEMAND) == 30 * sign
    before = axis.position
    drives.cycle(10)
    assert drives.command.axis[0].position - before == MOST * sign // 1000


def test_axis_below_the_limit__has_its_torque():
    drives = drives_with(CST)
    load = Load(drives)
    load.run(0.9 * MOST, 300)
    assert load.run(0.97 * MOST, 300) == 300
    assert drives.command.axis[0].torque == 100 and not drives.statusword() & LIMITED
    assert load.run(1.02 * MOST, 100) < 50


def test_motor_speed__limits_too():
    drives = drives_with(CST, most=2_000_000_000)
    drives.put(0x6080, 0, 600)  # 1/min, of 100 000 increments
    load = Load(drives)
    load.run(0.9 * MOST, 300)
    assert load.run(0.97 * MOST, 300) == 300
    assert load.run(1.02 * MOST, 100) < 50


def held(torque: int = 50) -> tuple[Drives, Load]:
    """An axis that the law holds at the limit with this torque."""
    drives = drives_with(CST)
    load = Load(drives)
    load.run(2 * MOST, 220)
    drives.feedback.axis[0].torque = torque
    load.run(MOST, 100)
    assert not drives.command.axis[0].torque_only
    return drives, load


def test_load_that_needs_more_torque__gets_the_target_and_no_more():
    drives, load = held()
    drives.feedback.axis[0].torque = 250
    assert load.run(MOST, 40) > 20
    assert drives.command.axis[0].torque_only and drives.command.axis[0].torque == 100
    # At the limit the target moves it, until it was slower or faster.
    drives.feedback.axis[0].torque = 100
    assert load.run(MOST, 200) == 200
    load.run(0.9 * MOST, 200)
    assert load.run(1.02 * MOST, 200) < 100


def test_load_that_drives_the_axis_on_after_the_law_gave_it_back__is_held():
    drives, load = held()
    drives.feedback.axis[0].torque = 250
    load.run(MOST, 40)
    assert drives.command.axis[0].torque_only
    drives.feedback.axis[0].torque = 50
    assert load.run(1.05 * MOST, 200) < 100


@pytest.mark.parametrize("torque", [20, -100])
def test_target_below_what_the_law_needs__acts_at_once(torque):
    drives, _ = held()
    drives.step(torque=torque)
    axis = drives.command.axis[0]
    assert axis.torque_only and axis.torque == torque


def test_raised_limit__gives_the_torque_and_a_lowered_one_brakes():
    drives, load = held()
    drives.put(0x607F, 0, 2 * MOST)
    drives.step()
    assert drives.command.axis[0].torque_only
    drives.put(0x6085, 0, 20_000_000)
    drives.put(0x607F, 0, MOST // 2)
    load.run(MOST, 1)
    assert not drives.command.axis[0].torque_only
    speeds = drives.follow(300)[:, 1]
    assert np.abs(np.diff(speeds)).max() == pytest.approx(2000, abs=1)
    assert 200 < np.argmin(speeds) < 260 and speeds[-1] == MOST // 2


def test_change_of_mode__goes_on_from_the_speed_that_is_held():
    drives, _ = held()
    velocities = drives.follow(3, mode=CSV, velocity=MOST)[:, 1]
    assert velocities == pytest.approx(MOST, rel=1e-3)
    drives.step(mode=CST)
    assert drives.command.axis[0].torque_only or drives.set_point()[1] == MOST


def test_demanded_values__of_a_mode_with_a_set_point_and_of_a_torque_mode():
    drives = Drives(CSV)
    drives.enable()
    drives.feedback.axis[0].torque = -17
    drives.follow(100, velocity=300_000)
    assert drives.get(VELOCITY_DEMAND) == 300_000 == drives.set_point()[1]
    assert drives.get(TORQUE_DEMAND) == -17
    drives.put(0x6072, 0, 40)
    drives.step(mode=CST, torque=90)
    assert drives.get(TORQUE_DEMAND) == 40
    assert drives.get(VELOCITY_DEMAND) == drives.get(0x606C)
    drives.step(mode=CSP, position=0, control=0)
    drives.cycle(10)
    assert drives.get(VELOCITY_DEMAND) == 0
