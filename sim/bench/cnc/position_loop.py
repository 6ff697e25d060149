# SPDX-License-Identifier: Apache-2.0
"""Servo drive of the CNC paper: P position loop around a velocity loop, with feed-forward (1), (2).

Every cycle of 1 ms (one process data frame) the controller sends the velocity word
    w = kp e + K1 dx_d/dt + K2 d2x_d/dt2,    e = x_d - x,
and the drive interpolates linearly from the word before to this one during the next cycle, so a
word acts one cycle late on the mean. The velocity loop is of first order, or of second order with a
damping; both have the bandwidth as their -3 dB frequency. Between cycles the states are exact
(matrix exponential), so the step of the samples has no influence on them.

Stated in the paper: bandwidth 160 Hz, cycle 1 ms, 15 m/min, about 2.5 mm without feed-forward, so
kp = 0.25 / 0.0025. Not stated, chosen here: acceleration, jerk time and length of the test move,
the interpolation, the order of the loop, K1 and K2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from sim.motion.geometry.curves import FloatArray, check_positive
from sim.motion.planner.scurve import Samples, SCurve

SUBSTEPS = 10  # samples of a cycle


class DriveError(ValueError):
    """A parameter of a drive or a move lies outside its limit; names the value and the limit."""


@dataclass(frozen=True)
class Drive:
    """kp [1/s], bandwidth of the velocity loop [Hz], damping (None: first order), cycle [s]."""

    kp: float = 100.0
    bandwidth: float = 160.0
    damping: float | None = None
    cycle: float = 1e-3

    def __post_init__(self) -> None:
        check_positive(DriveError, kp=self.kp, bandwidth=self.bandwidth, cycle=self.cycle)
        if self.damping is not None:
            check_positive(DriveError, damping=self.damping)

    @property
    def natural(self) -> float:
        """Angular frequency of the loop's poles [rad/s]."""
        corner = 2.0 * math.pi * self.bandwidth
        if self.damping is None:
            return corner
        z = 1.0 - 2.0 * self.damping**2
        return corner / math.sqrt(z + math.sqrt(z * z + 1.0))

    @property
    def lag(self) -> float:
        """By how much the velocity follows the word late [s]: the loop's lag and one cycle."""
        return (1.0 if self.damping is None else 2.0 * self.damping) / self.natural + self.cycle

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """A (n, n) and B (n,) of d(x, v[, a])/dt = A (x, v[, a]) + B word."""
        w = self.natural
        if self.damping is None:
            return np.array([[0.0, 1.0], [0.0, -w]]), np.array([0.0, w])
        a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -w * w, -2.0 * self.damping * w]])
        return a, np.array([0.0, 0.0, w * w])

    def residual(self, acceleration: float, k1: float, k2: float, speed: float = 0.0) -> float:
        """Following error [m] at constant acceleration [m/s2], at the speed [m/s], all settled.

        The velocity is the word of `lag` before, so kp e = (1 - K1) v + a (lag - K2) - de/dt with
        de/dt = (1 - K1) a / kp. With K1 = 1 that is e = a (lag - K2) / kp.
        """
        late = speed - acceleration / self.kp
        return ((1.0 - k1) * late + acceleration * (self.lag - k2)) / self.kp


@dataclass(frozen=True)
class Case:
    """A feed-forward: K1 (1) and K2 [s], None: the lag of the drive."""

    name: str
    k1: float
    k2: float | None

    def gains(self, drive: Drive) -> tuple[float, float]:
        """K1 and K2 for a drive."""
        return self.k1, drive.lag if self.k2 is None else self.k2


CASES = (
    Case("no feed-forward", 0.0, 0.0),
    Case("velocity", 1.0, 0.0),
    Case("velocity and acceleration", 1.0, None),
)


class ThereAndBack:
    """Out, a pause, and back, each an S-curve of the S-curve paper; `sample` gives the set-point.

    speed [m/s], acceleration [m/s2], jerk_time [s] (0: trapezoid), length [m], pause [s].
    """

    def __init__(
        self,
        speed: float = 0.25,
        acceleration: float = 5.0,
        jerk_time: float = 0.0,
        length: float = 0.25,
        pause: float = 0.2,
    ) -> None:
        values = {"speed": speed, "acceleration": acceleration, "length": length, "pause": pause}
        check_positive(DriveError, **values)
        if not 0.0 <= jerk_time <= speed / acceleration:
            raise DriveError(
                f"jerk_time = {jerk_time!r} is outside its limit: "
                f"0 <= jerk_time <= speed / acceleration = {speed / acceleration!r}"
            )
        rise = speed / acceleration + jerk_time  # (6): am = vm / (tr - tm)
        self.curve = SCurve(0.0, speed, rise, jerk_time, length)
        self.acceleration, self.jerk_time, self.pause = acceleration, jerk_time, pause
        self._back = self.curve.total_time + pause
        self.total_time = 2.0 * self.curve.total_time + 2.0 * pause

    def sample(self, t: ArrayLike) -> Samples:
        """Set-points at the times t [s]."""
        times = np.asarray(t, dtype=np.float64)
        out, back = self.curve.profile(times), self.curve.profile(times - self._back)
        return Samples(
            out.position - back.position,
            out.velocity - back.velocity,
            out.acceleration - back.acceleration,
        )


@dataclass(frozen=True)
class Response:
    """Samples: time [s], following error [m], velocity, acceleration and jerk of the drive."""

    t: FloatArray
    error: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray

    @property
    def peak_error(self) -> float:
        """Largest following error [m]."""
        return float(np.abs(self.error).max())

    @property
    def peak_jerk(self) -> float:
        """Largest jerk [m/s3]; current slope is proportional to it (see drive_servo)."""
        return float(np.abs(self.jerk).max())


def words_of(
    drive: Drive, move: ThereAndBack, k1: float, k2: float, cycles: int
) -> tuple[FloatArray, FloatArray]:
    """Set-points (cycles + 1,) and feed-forward part of the words (cycles + 1,) [m, m/s]."""
    desired = move.sample(np.arange(cycles + 1) * drive.cycle)
    return desired.position, k1 * desired.velocity + k2 * desired.acceleration


def simulate(drive: Drive, move: ThereAndBack, k1: float, k2: float) -> Response:
    """Run a move from rest; SUBSTEPS samples per cycle."""
    a, b = drive.matrices()
    n = len(b)
    # State, word and slope of the word: x' = A x + B w, w' = s, s' = 0.
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n], whole[:n, n], whole[n, n + 1] = a, b, 1.0
    step = drive.cycle / SUBSTEPS
    # Row block i: states after i + 1 samples.
    forward = np.stack([expm(whole * step * (i + 1)) for i in range(SUBSTEPS)])
    cycles = math.ceil(move.total_time / drive.cycle)
    desired, ahead = words_of(drive, move, k1, k2, cycles)
    state = np.zeros(n + 2)
    states = np.zeros((cycles * SUBSTEPS + 1, n + 2))
    for k in range(cycles):
        word = drive.kp * (desired[k] - state[0]) + ahead[k]
        # the slope reaches `word` at the end of the cycle
        state[n + 1] = (word - state[n]) / drive.cycle
        block = forward @ state
        states[k * SUBSTEPS + 1 : (k + 1) * SUBSTEPS + 1] = block
        state = block[-1].copy()
    t = np.arange(len(states), dtype=np.float64) * step
    acceleration = states[:, :n] @ a[1] + b[1] * states[:, n]
    return Response(
        t=t,
        error=move.sample(t).position - states[:, 0],
        velocity=states[:, 1],
        acceleration=acceleration,
        jerk=np.diff(acceleration, append=acceleration[-1]) / step,
    )


def greatest_acceleration(drive: Drive, error: float, k1: float = 1.0, k2: float = 0.0) -> float:
    """Greatest acceleration [m/s2], to a hundredth, at which a trapezoid keeps an error [m].

    Found by running moves; theory has (error kp / (lag - K2)) for K1 = 1.
    """
    low, high = 0.0, 100.0
    while high - low > 0.01:
        middle = (low + high) / 2
        kept = simulate(drive, ThereAndBack(acceleration=middle), k1, k2).peak_error < error
        low, high = (middle, high) if kept else (low, middle)
    return low


def tuned_k2(drive: Drive, move: ThereAndBack) -> float:
    """K2 [s] as it is tuned on a machine: from the error that K1 = 1 leaves while accelerating."""
    left = simulate(drive, move, 1.0, 0.0)
    end = move.curve.durations[0] + move.curve.durations[1]
    at = int(round(end / drive.cycle * SUBSTEPS))
    return float(left.error[at]) * drive.kp / move.acceleration
