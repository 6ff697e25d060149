# SPDX-License-Identifier: Apache-2.0
"""Planted faults of sensors, windings, bus voltage and encoders: each must be found in time.

The chain runs as RTL, every clock, with three current sensors an axis. A test bench turns all
motors, the host orders a share of the greatest forces, and each fault comes to all axes at once. A
fault is found in time if every axis trips while its current is below twice `i_max` and the speed
that its encoder loses is below a hundredth of the greatest speed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sim.bench.drive import start_up
from sim.bench.drive.averaged import at_joints, true_angles
from sim.bench.drive.chain import ChainRtl, GuardedChain
from sim.bench.drive.plant import AXES, Plant
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

SHARE = 0.5  # of the greatest force, ordered
MOST_CURRENT, MOST_SPEED = 2.0, 0.01  # shares of i_max and of the greatest speed
PARTS = (0.2, 0.4, 0.6, 0.8)  # of the greatest speeds: the bench accelerates in these steps
STEP = 100  # half periods of a step
LAST = 17_000  # half periods in which a fault must trip every axis: two indices of the table
MEAN = 1e-3  # least time of the mean of a lost speed [s]; position loops are slower
DRIFT = 1.0  # what a sensor that drifts shows too much [A]
LOST = 500  # an encoder loses one of so many counts


@dataclass(frozen=True)
class Fault:
    """What happens to a chain with these drives."""

    name: str
    plant: Callable[[ChainRtl, Drives], None]


def _drift(phase: int) -> Callable[[ChainRtl, Drives], None]:
    drift = DRIFT * np.eye(3)[phase]
    return lambda system, drives: system.sensors(drift=drift)


def _stuck(phase: int) -> Callable[[ChainRtl, Drives], None]:
    return lambda system, drives: system.sensors(stuck={phase: start_up.ALL})


def _open(phase: int) -> Callable[[ChainRtl, Drives], None]:
    return lambda system, drives: system.sensors(broken=start_up.ALL << AXES * phase)


def _volts(share: float) -> Callable[[ChainRtl, Drives], None]:
    return lambda system, drives: system.fault(share * drives.U_dc)


FAULTS = (
    *(Fault(f"sensor {'abc'[k]} shows no current", _stuck(k)) for k in range(3)),
    *(Fault(f"sensor {'abc'[k]} shows {DRIFT:g} A too much", _drift(k)) for k in range(3)),
    *(Fault(f"phase {'abc'[k]} is open", _open(k)) for k in range(3)),
    Fault("bus voltage too low", _volts(0.75)),
    Fault("bus voltage too high", _volts(1.2)),
    Fault("lines A and B touch", lambda s, drives: s.fault(drives.U_dc, touching=start_up.ALL)),
    Fault("counts are lost", lambda s, drives: s.slip(start_up.ALL, LOST)),
)


@dataclass(frozen=True)
class Outcome:
    """Greatest current as a share of i_max, greatest lost speed as a share of the greatest one, of
    any axis before it tripped; tripped: axes, as bits; halves: half periods until the last.

    The lost speed is what the counts have lost since the fault, divided by that time or by `MEAN`.
    """

    name: str
    current: float
    speed: float
    tripped: int
    halves: int

    @property
    def in_time(self) -> bool:
        """Every axis has tripped before the limits."""
        within = self.current < MOST_CURRENT and self.speed < MOST_SPEED
        return within and self.tripped == start_up.ALL


def turning(robot: Robot, drives: Drives) -> ChainRtl:
    """All guards on, motors at the last of `PARTS` of their greatest speeds, forces ordered."""
    plant, setting = Plant(robot, drives), Setting(robot.resolution)
    system = GuardedChain()
    counts = system.place(plant, robot.start)
    start_up.configure(system, drives, setting, counts)
    start_up.measure_offsets(system)
    start_up.guard(system, robot, drives, setting)
    start_up.write_angles(system, true_angles(plant, at_joints(plant, robot.start)))
    start_up.order(system, [0.0] * AXES)
    system.front("LINK", enable=1)
    system.clock(3 * HALF_PERIOD)
    system.front("MODE", **start_up.RUN)
    for part in PARTS:  # a jump of the speed would be one of the encoders' lines
        system.spin((part * greatest_speeds(robot)).tolist())
        system.clock(STEP * HALF_PERIOD)
    start_up.order(system, [SHARE * m.i_max * m.force_per_ampere for m in drives.motors])
    system.clock(STEP * HALF_PERIOD)
    status = system.status()
    if status["trip"]:
        raise start_up.StartUpError(f"before any fault, {start_up.told(status)}")
    return system


def greatest_speeds(robot: Robot) -> np.ndarray:
    """Speeds (5,) [m/s, rad/s]."""
    return np.array([robot.v_max_leg] * 3 + [robot.v_max_table] * 2)


def outcome(fault: Fault, robot: Robot, drives: Drives, last: int = LAST) -> Outcome:
    """One fault in a chain of its own; last: half periods in which it must trip."""
    system = turning(robot, drives)
    rated = np.array([motor.i_max for motor in drives.motors])
    joints, counted = system.look().joints, start_up.positions(system)
    fault.plant(system, drives)
    current, speed, trip, n = np.zeros(AXES), np.zeros(AXES), 0, 0
    while n < last and trip != start_up.ALL:
        system.clock(HALF_PERIOD)
        n += 1
        live = np.array([not trip >> axis & 1 for axis in range(AXES)])
        seen, trip = system.look(), system.status()["trip"]
        share = np.hypot(seen.i_d, seen.i_q) / rated
        current = np.where(live, np.maximum(current, share), current)
        moved = (start_up.positions(system) - counted) * np.array(robot.resolution)
        lost = np.abs(seen.joints - joints - moved) - 2 * np.array(robot.resolution)
        since = max(n * HALF_PERIOD * CLOCK, MEAN)
        rate = np.maximum(lost, 0) / since / greatest_speeds(robot)
        speed = np.where(live, np.maximum(speed, rate), speed)
    return Outcome(fault.name, float(current.max()), float(speed.max()), trip, n)


def campaign(
    robot: Robot,
    drives: Drives,
    report: Callable[[str], None],
    faults: Sequence[Fault] = FAULTS,
    last: int = LAST,
) -> list[Outcome]:
    """Every fault."""
    found = []
    for fault in faults:
        found.append(outcome(fault, robot, drives, last))
        each = found[-1]
        report(
            f"  {each.name}: tripped {each.tripped:05b} after {each.halves} half periods, "
            f"{each.current:.2f} of i_max, {each.speed:.2%} of the speed lost"
        )
    return found
