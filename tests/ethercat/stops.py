# SPDX-License-Identifier: Apache-2.0
"""Stops at random: an axis that is not where its set-point is, in any mode and at any cycle of the
master, stops by a fault, a command or the end of the frames.

The machine is a mass with a limit of force and a loop of position and speed without an integral.
Nothing of it is in the application.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from tests.ethercat.drives import (
    CSP,
    CST,
    CSV,
    ENABLE,
    HOMING,
    PP,
    PT,
    PV,
    QUICK_STOP,
    SHUTDOWN,
    SWITCH_ON,
    Drives,
)
from tests.ethercat.host import SAFEOP

NO_MODE = 0
MODES = (CSP, CSV, CST, PP, HOMING, NO_MODE)
PROFILES = (PV, PT)  # of each fifth situation
NOISE = 10_000  # increments/s: two of the last places of a position in a control cycle
INCREMENT = 1  # of the encoder: less than one cannot be measured
FAULT = 0x5441
FOLLOWING_ERROR = 0x8611
NOT_WATCHED = 0xFFFFFFFF  # window of the following error
HALT = ENABLE | 0x100
COMMANDS = {"quick stop": QUICK_STOP, "shutdown": SHUTDOWN, "disable": SWITCH_ON, "halt": HALT}
KINDS = ("fault", "frames end", "SAFEOP", *COMMANDS)
CAMPAIGN = 10_000
# Periods of the master in control cycles, by the length of these in ns.
PERIODS = {100_000: (1, 2, 5, 10, 40), 62_500: (2, 4, 8, 16, 40)}


@dataclass
class Mass:
    """One axis in increments and seconds; `force` is the greatest acceleration."""

    force: float
    bandwidth: float
    position: float = 0.0
    speed: float = 0.0

    def step(self, axis, tick: float) -> None:
        """A control cycle of so many seconds with this command."""
        wanted = 0.0
        if axis.power and axis.torque_only:
            wanted = axis.torque / 1000 * self.force
        elif axis.power:
            lag = axis.position + axis.fraction - self.position
            wanted = self.bandwidth**2 * lag + 2 * self.bandwidth * (axis.velocity - self.speed)
            wanted += axis.acceleration
        wanted = max(-self.force, min(self.force, wanted))
        self.position += self.speed * tick + wanted * tick**2 / 2
        self.speed += wanted * tick


class Moved(Drives):
    """The first axis is a mass."""

    def __init__(self, mode: int, mass: Mass, cycle_ns: int = Drives.CYCLE_NS) -> None:
        self.CYCLE_NS = cycle_ns
        super().__init__(mode)
        self.mass, self.sampled = mass, 0.0
        self.held.add(0)

    def cycle(self, count: int = 1) -> None:
        """The law has the set-point of a pass at the tick after it, as on the robot."""
        for _ in range(count):
            before = type(self.command.axis[0]).from_buffer_copy(self.command.axis[0])
            super().cycle()
            if hasattr(self, "mass"):
                self.sampled = self.mass.speed  # when the pass had its position
                self.mass.step(before, self.CYCLE_NS * 1e-9)
                self.feedback.axis[0].position = round(self.mass.position)


def run_to_the_stop(drives: Moved, period: int | None = 10) -> tuple[list[float], float]:
    """Measured speeds from the present one on, and the greatest distance from here, till power goes
    or it rests; a frame in each `period`-th cycle.
    """
    speeds, start, distance = [drives.mass.speed], drives.mass.position, 0.0
    for n in range(20_000):
        if period and n % period == 0:
            drives.outputs(drives.values)
        drives.cycle()
        speeds.append(drives.mass.speed)
        distance = max(distance, abs(drives.mass.position - start))
        axis = drives.command.axis[0]
        if not axis.power or (n > 20 and axis.velocity == 0 and abs(drives.mass.speed) < NOISE):
            break
    return speeds, distance


@dataclass(frozen=True)
class Stop:
    """What came of a stop: speeds in increments/s, distances in increments."""

    kind: str
    mode: int
    before: float  # the speed at the stop: the higher of its sample's and of a tick later
    highest: float  # after it
    distance: float
    shortest: float  # braking from `before`, and a tick

    @property
    def ratio(self) -> float:
        """Highest speed after the stop, noise aside, over the speed at the stop."""
        return max(0.0, self.highest - NOISE) / max(self.before, 1.0)

    @property
    def too_far(self) -> bool:
        return self.distance > self.shortest + INCREMENT


def situation(seed: int, cycle_ns: int = Drives.CYCLE_NS) -> Stop:
    """One random stop of a device with this control cycle."""
    random = Random(seed)
    mode = random.choice(MODES)
    if seed % 5 == 4:
        mode = PROFILES[seed // 5 % 2]
    mass = Mass(force=random.uniform(4e8, 3e9), bandwidth=random.uniform(100.0, 900.0))
    drives = Moved(mode if mode != HOMING else CSV, mass, cycle_ns)
    period = random.choice(PERIODS[cycle_ns])
    quick, fault, halt = random.choice((1, 2, 5, 6)), random.choice((1, 2)), random.choice((1, 2))
    profile = random.choice((100_000_000, 300_000_000))
    put_period(drives, period * cycle_ns)
    drives.put(0x10F1, 2, 2)
    window = random.choice((20_000, 100_000, NOT_WATCHED))
    drives.put(0x6065, 0, window)
    drives.put(0x605A, 0, quick)
    drives.put(0x605B, 0, 1)
    drives.put(0x605E, 0, fault)
    drives.put(0x605D, 0, halt)
    drives.put(0x6083, 0, profile)
    drives.put(0x6084, 0, profile)
    fast = drives.get(0x6085)
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
    kind = random.choice(KINDS)
    cycles = random.randrange(2, 400)
    turn = random.randrange(cycles)  # here the mode changes to homing
    for n in range(cycles):
        if mode == HOMING and n >= turn:
            drives.set(mode=HOMING)
        if n % period == 0:
            drives.outputs(drives.values)
        drives.cycle()
        if drives.command.axis[0].power and drives.state() != "OPERATION ENABLED":
            kind = "following error"
            break
    else:
        _begin(drives, kind, period)
        reacts = drives.state() == "FAULT REACTION ACTIVE"
        if reacts and kind not in ("fault", "frames end"):  # the same pass found it
            kind = "following error"
    # The pass that found the fault gave the first set-point of the stop; the law has it from the
    # tick after it on, which is now.
    before = max(abs(mass.speed), abs(drives.sampled))
    speeds, distance = run_to_the_stop(drives, None if kind == "frames end" else period)
    if kind == "following error":  # no other fault has taken its place
        assert window != NOT_WATCHED and drives.get(0x603F) == FOLLOWING_ERROR, seed
    ramp = {
        "quick stop": profile if quick in (1, 5) else fast,
        "SAFEOP": profile if quick in (1, 5) else fast,
        "halt": profile if halt == 1 else fast,
        "shutdown": profile,
        "disable": profile,
    }.get(kind, profile if fault == 1 else fast)
    brake = 2 * min(ramp, mass.force)
    return Stop(
        kind=kind,
        mode=mode,
        before=before,
        highest=max(map(abs, speeds)),
        distance=distance,
        shortest=before**2 / brake + before * cycle_ns * 1e-9,
    )


def _begin(drives: Moved, kind: str, period: int) -> None:
    """The stop, and the pass that begins it."""
    if kind == "frames end":  # the device falls to SAFEOP after three periods
        for _ in range(3 * period + 10):
            drives.cycle()
            if drives.state() != "OPERATION ENABLED":
                return
        raise AssertionError("the device did not notice the end of the frames")
    if kind == "fault":
        drives.feedback.axis[0].fault = FAULT
    elif kind == "SAFEOP":
        drives.ask(SAFEOP)
    else:
        drives.set(control=COMMANDS[kind])
        drives.outputs(drives.values)
    drives.cycle()


def put_period(drives: Drives, ns: int) -> None:
    """60C2: whole microseconds."""
    value, power = ns // 1000, -6
    while value > 255:
        value, power = value // 10, power + 1
    assert value * 10 ** (9 + power) == ns
    drives.put(0x60C2, 1, value)
    drives.put(0x60C2, 2, power)


def campaign(first: int, count: int, cycle_ns: int = Drives.CYCLE_NS) -> Iterator[tuple[int, Stop]]:
    """Seed and stop of `count` situations from a seed on."""
    for seed in range(first, first + count):
        yield seed, situation(seed, cycle_ns)
