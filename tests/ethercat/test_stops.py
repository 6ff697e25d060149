# SPDX-License-Identifier: Apache-2.0
"""Stops of an axis that is not where its set-point is: they start from the measured motion.

The machine is a mass with a limit of force and a loop of position and speed without an integral.
Nothing of it is in the application.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import pytest

from tests.bench.seed import SEED
from tests.ethercat.drives import (
    CSP,
    CST,
    CSV,
    ENABLE,
    PP,
    QUICK_STOP,
    SHUTDOWN,
    SWITCH_ON,
    TICK,
    Drives,
)

DECELERATION = 400_000_000  # increments/s2, object 6085
NOISE = 10_000  # increments/s: two of the last places of a position in a control cycle
FAULT = 0x5441


@dataclass
class Mass:
    """One axis in increments and seconds; `force` is the greatest acceleration."""

    force: float
    bandwidth: float
    position: float = 0.0
    speed: float = 0.0

    def step(self, axis) -> None:
        """A control cycle with this command."""
        wanted = 0.0
        if axis.power and axis.torque_only:
            wanted = axis.torque / 1000 * self.force
        elif axis.power:
            lag = axis.position + axis.fraction - self.position
            wanted = self.bandwidth**2 * lag + 2 * self.bandwidth * (axis.velocity - self.speed)
        wanted = max(-self.force, min(self.force, wanted))
        self.position += self.speed * TICK + wanted * TICK**2 / 2
        self.speed += wanted * TICK


class Moved(Drives):
    """The first axis is a mass."""

    def __init__(self, mode: int, mass: Mass) -> None:
        super().__init__(mode)
        self.mass = mass
        self.held.add(0)

    def cycle(self, count: int = 1) -> None:
        """The law has the set-point of a pass at the tick after it, as on the robot."""
        for _ in range(count):
            before = type(self.command.axis[0]).from_buffer_copy(self.command.axis[0])
            super().cycle()
            if hasattr(self, "mass"):
                self.mass.step(before)
                self.feedback.axis[0].position = round(self.mass.position)


def run_to_the_stop(drives: Moved, cycles: int = 20_000) -> tuple[list[float], float]:
    """Measured speeds from the present one on, and the distance, till power goes or it rests."""
    speeds, start = [drives.mass.speed], drives.mass.position
    for n in range(cycles):
        if n % 10 == 0:
            drives.outputs(drives.values)
        drives.cycle()
        speeds.append(drives.mass.speed)
        axis = drives.command.axis[0]
        if not axis.power or (n > 20 and axis.velocity == 0 and abs(drives.mass.speed) < NOISE):
            break
    return speeds, abs(drives.mass.position - start)


def situation(seed: int) -> tuple[float, float]:
    """One random stop: highest speed after it and speed at it, increments/s."""
    random = Random(seed)
    mode = random.choice((CSP, CSV, CST, PP))
    mass = Mass(force=random.uniform(4e8, 3e9), bandwidth=random.uniform(100.0, 900.0))
    drives = Moved(mode, mass)
    period = random.choice((1, 2, 5, 10, 40))
    drives.put(0x60C2, 1, period)
    drives.put(0x60C2, 2, -4)
    drives.put(0x10F1, 2, 0)
    drives.put(0x6065, 0, random.choice((20_000, 100_000, 0xFFFFFFFF)))
    drives.put(0x605A, 0, random.choice((1, 2, 5, 6)))
    drives.put(0x605B, 0, 1)
    drives.put(0x605E, 0, random.choice((1, 2)))
    drives.put(0x605D, 0, random.choice((1, 2)))
    drives.put(0x6083, 0, random.choice((100_000_000, 300_000_000)))
    mass.position = random.uniform(-5e6, 5e6)
    drives.feedback.axis[0].position = round(mass.position)
    drives.enable(position=round(mass.position) + random.randrange(-100_000, 100_000))
    size = random.choice((10_000, 300_000, 5_000_000))
    drives.set(
        position=round(mass.position) + random.randrange(-size, size),
        velocity=random.randrange(-20_000_000, 20_000_000),
        torque=random.randrange(-300, 300),
        control=ENABLE | (0x30 if mode == PP else 0),
    )
    for n in range(random.randrange(2, 400)):
        if n % period == 0:
            drives.outputs(drives.values)
        drives.cycle()
        if drives.state() != "OPERATION ENABLED":
            break
    else:
        kind = random.randrange(5)
        if kind == 0:
            drives.feedback.axis[0].fault = FAULT
        else:
            control = (QUICK_STOP, SHUTDOWN, SWITCH_ON, ENABLE | 0x100)[kind - 1]
            drives.set(control=control)
            drives.outputs(drives.values)
        drives.cycle()
    # The pass that found the fault gave the first set-point of the stop. Till the next tick the law
    # has the one before.
    at_stop = abs(mass.speed)
    drives.cycle()
    at_stop = max(at_stop, abs(mass.speed))
    speeds, _ = run_to_the_stop(drives)
    return max(map(abs, speeds)), at_stop


def check_situations(first: int, count: int) -> None:
    for seed in range(first, first + count):
        highest, before = situation(seed)
        assert highest <= before + NOISE, (
            f"situation({seed}): {highest:.0f} after, {before:.0f} before"
        )


def test_stops__no_random_one_accelerates():
    check_situations(SEED, 60)


@pytest.mark.full
def test_stops__ten_thousand_random_ones_do_not_accelerate():
    check_situations(SEED, 10_000)


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
