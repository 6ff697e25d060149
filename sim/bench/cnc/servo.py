# SPDX-License-Identifier: Apache-2.0
"""Servo of the CNC paper in detail: inertia, PI speed loop, delay, friction, quantised encoders.

The speed regulator is g J (1 + 1/(Ti s)) with the delay D of computation, current loop and filters,
so its open loop is g (s + 1/Ti) e^(-D s) / s^2. g, Ti and D follow from what the paper measured:
bandwidth 160 Hz, gain margin 14 dB, phase margin 55 degrees. What the bandwidth is of, the paper
does not say, so there are three readings (READINGS). In the first the proportional part acts on the
measured speed alone (I-P), which gives the second-order loop of `drive.py` except for the delay; it
is the default, and the only one whose load step comes near the paper's. The two others are of a PI
regulator, and give a softer drive.
The regulator runs every D / 4: half a sample each for holding the torque and differencing the
encoder counts, and three samples of computation. The position loop is the one of `drive.py`.

Not stated, chosen here: the inertia (rotor of a 750 W motor, screw of 20 mm by 600 mm, 20 kg slide)
and Coulomb friction. Errors under load are in inverse proportion to the inertia.
Angles are in rad of the motor; the screw moves 5 mm per turn.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from sim.bench.cnc.position_loop import Drive, DriveError, FloatArray

TURN = 2.0 * math.pi
PITCH = 0.005  # m per turn
MOTOR_COUNTS = 1_280_000  # per turn
LOAD_COUNTS = 144_000
GAIN_MARGIN = 10.0 ** (14.0 / 20.0)
PHASE_MARGIN = math.radians(55.0)
LOAD_TORQUE = 1.8  # N m
READINGS = ("i-p", "crossover", "pi")
"""The bandwidth is: the -3 dB frequency with an I-P regulator; the crossover of the open loop; the

-3 dB frequency with a PI regulator."""
SUBSTEPS = 4  # of the mechanics, per sample of the regulator
COMPUTATION = 3  # samples


def _shape() -> tuple[float, float]:
    """Ti and D in units of 1/crossover for the two margins, crossover at s = j."""

    def ti_of(delay: float) -> float:
        return math.tan(PHASE_MARGIN + delay)  # phase: atan(Ti) - D - pi

    def margin(delay: float) -> float:
        ti = ti_of(delay)
        turn = brentq(lambda w: math.atan(w * ti) - delay * w, 1.01, math.pi / (2 * delay))
        size = math.hypot(1.0, 1.0 / ti)  # of j + 1/Ti: the gain makes it 1
        return turn * turn * size / math.hypot(turn, 1.0 / ti) - GAIN_MARGIN

    delay = brentq(margin, 0.05, math.pi / 2 - PHASE_MARGIN - 0.01)
    return ti_of(delay), delay


@dataclass(frozen=True)
class Servo:
    """Inertia [kg m2], Coulomb friction [N m], bandwidth [Hz] and its reading, and the drive."""

    inertia: float = 1.13e-4 + 7.4e-5 + 1.3e-5  # rotor, screw, slide
    friction: float = 0.05
    bandwidth: float = 160.0
    reading: str = READINGS[0]
    outer: Drive = Drive()

    def __post_init__(self) -> None:
        if not (self.inertia > 0.0 and self.bandwidth > 0.0 and self.friction >= 0.0):
            raise DriveError("a servo needs inertia > 0, bandwidth > 0, friction >= 0")
        if self.reading not in READINGS:
            raise DriveError(f"reading = {self.reading!r}; expected one of {', '.join(READINGS)}")

    @cached_property
    def regulator(self) -> tuple[float, float, float]:
        """g [1/s], Ti [s] and D [s]."""
        ti, delay = _shape()
        gain = 1.0 / math.hypot(1.0, 1.0 / ti)
        corner = 1.0
        if self.reading != "crossover":

            def below(w: float) -> float:
                s = 1j * w
                loop = gain * (s + 1.0 / ti) / (s * s) * cmath.exp(-delay * s)  # open
                forward = loop / (1.0 + s * ti) if self.reading == "i-p" else loop
                return abs(forward / (1.0 + loop)) - math.sqrt(0.5)

            corner = brentq(below, 0.1, 4.0)
        crossover = TURN * self.bandwidth / corner
        return gain * crossover, ti / crossover, delay / crossover


@dataclass(frozen=True)
class Run:
    """Samples of the regulator: time [s], angle [rad], torque [N m], counts of both encoders."""

    t: FloatArray
    angle: FloatArray
    torque: FloatArray
    motor: np.ndarray
    load: np.ndarray


def run(
    servo: Servo,
    duration: float,
    target: Callable[[float], int],
    load: Callable[[float], float],
    torque: float = 0.0,
) -> Run:
    """Hold or move to targets from rest at 0, without feed-forward.

    target: motor counts at a time [s]; load: torque on the motor [N m]; torque: of the regulator at
    the start, which is that of the load if it has settled. Position loop and regulator see the
    motor's encoder only. The load's encoder is on the same shaft; 0 is in the middle of its count.
    """
    gain, ti, delay = servo.regulator
    sample = delay / (COMPUTATION + 1)
    step = sample / SUBSTEPS
    k_v, k_i = gain * servo.inertia, gain * servo.inertia / ti
    share = 0.0 if servo.reading == "i-p" else 1.0  # of the word in the proportional part
    grip = servo.friction / servo.inertia * step
    count = TURN / MOTOR_COUNTS
    cycle = servo.outer.cycle
    angle = speed = 0.0
    seen = 0
    integral = torque
    waiting = [torque] * (COMPUTATION + 1)
    old = new = 0.0
    next_cycle, cycles = 0.0, 0
    rows = []
    for n in range(math.ceil(duration / sample)):
        t = n * sample
        now = math.floor(angle / count + 0.5)
        if t >= next_cycle:
            error = (target(t) - now) * count
            old, new = new, servo.outer.kp * error
            cycles += 1
            next_cycle = cycles * cycle
        word = new + (old - new) * min(1.0, max(0.0, (next_cycle - t) / cycle))
        measured = (now - seen) * count / sample
        seen = now
        integral += k_i * (word - measured) * sample
        waiting.append(k_v * (share * word - measured) + integral)
        acting = waiting.pop(0)
        rows.append((t, angle, acting, now, math.floor(angle * LOAD_COUNTS / TURN + 0.5)))
        change = (acting - load(t)) / servo.inertia * step
        for _ in range(SUBSTEPS):
            free = speed + change
            # Coulomb friction stops, it does not turn round
            moved = math.copysign(max(0.0, abs(free) - grip), free)
            angle += 0.5 * (speed + moved) * step
            speed = moved
    return Run(*(np.array(column) for column in zip(*rows, strict=True)))


def load_step(servo: Servo, load: float = LOAD_TORQUE) -> Run:
    """The paper's disturbance test: the target stays, the load comes at 20 ms [N m]."""
    return run(servo, 0.2, lambda t: 0, lambda t: load if t >= 0.02 else 0.0)


def transient(result: Run) -> float:
    """Largest deviation on the screw [m]."""
    return float(np.abs(result.angle).max()) / TURN * PITCH


# (start of the rest [s], load increments) of the positioning test
INCREMENTS = ((0.0, 0), (0.2, 1), (1.2, 0), (2.2, -1), (3.2, 0))
INCREMENTS_END = 4.2
SETTLED = 0.2  # before the end of each rest [s]


def increments(servo: Servo, load: float = 0.0) -> Run:
    """The paper's positioning test: +1 and -1 increment of 144 000, under a load [N m]."""

    def target(t: float) -> int:
        wanted = [value for start, value in INCREMENTS if start <= t][-1]
        return round(wanted * MOTOR_COUNTS / LOAD_COUNTS)

    return run(servo, INCREMENTS_END, target, lambda t: load, load)


@dataclass(frozen=True)
class Rest:
    """What the encoders read while a target of the positioning test is held.

    wanted: load increments; load: readings of the load's encoder; motor: least and greatest motor
    count relative to the target.
    """

    wanted: int
    load: tuple[int, ...]
    motor: tuple[int, int]


def rests(result: Run) -> list[Rest]:
    """The settled part of each target."""
    ends = [start for start, _ in INCREMENTS[1:]] + [INCREMENTS_END]
    found = []
    for (_, wanted), end in zip(INCREMENTS, ends, strict=True):
        part = (result.t >= end - SETTLED) & (result.t < end)
        motor = result.motor[part] - round(wanted * MOTOR_COUNTS / LOAD_COUNTS)
        load = tuple(int(x) for x in np.unique(result.load[part]))
        found.append(Rest(wanted, load, (int(motor.min()), int(motor.max()))))
    return found
