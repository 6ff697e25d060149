# SPDX-License-Identifier: Apache-2.0
"""S-curve speed profile with set acceleration and jerk times (seed 002, formulas (1)-(11)).

The profile is fixed by times, not by acceleration and jerk: the speed rises from v0 to its peak in
exactly tr, the first and last tm of that with constant jerk, and falls in mirror image. A path too
short for vm lowers the peak and keeps tr, so no equation above the first degree has to be solved.
Lengths may be metres or radians; speeds and accelerations are in the same unit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


class SCurveClass(Enum):
    """The seven classes of the seed's table 1; the value is the number of segments."""

    SEVEN_SEGMENT = 7
    SIX_SEGMENT = 6
    FIVE_SEGMENT = 5
    FOUR_SEGMENT = 4
    TRAPEZOID = 3
    TRIANGLE = 2
    CONSTANT = 1


class SCurveError(ValueError):
    """A parameter of a profile lies outside its limit; names the value and the limit."""


def _require(ok: bool, name: str, value: float, limit: str) -> None:
    if not (ok and math.isfinite(value)):
        raise SCurveError(f"S-curve parameter {name} = {value!r} is outside its limit: {limit}")


@dataclass(frozen=True)
class Samples:
    """Values of a profile along its path, one array each, of the shape of the time asked for."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


class SCurve:
    """One move of `length` that begins and ends at speed v0 and never exceeds vm.

    v0, vm [unit/s], tr total acceleration time [s], tm jerk time [s], length [unit].
    Raises SCurveError unless 0 <= v0 <= vm, vm > 0, tr > 0, 0 <= tm <= tr/2 and length > 0.
    The acceleration is continuous if tm > 0.
    """

    def __init__(self, v0: float, vm: float, tr: float, tm: float, length: float) -> None:
        _require(vm > 0.0, "vm", vm, "vm > 0")
        _require(0.0 <= v0 <= vm, "v0", v0, f"0 <= v0 <= vm = {vm!r}")
        _require(tr > 0.0, "tr", tr, "tr > 0")
        _require(0.0 <= tm <= tr / 2, "tm", tm, f"0 <= tm <= tr/2 = {tr / 2!r}")
        _require(length > 0.0, "length", length, "length > 0")
        self.v0, self.vm, self.tr, self.tm, self.length = v0, vm, tr, tm, length

        self.cruise_critical_length = (v0 + vm) * tr  # (4)
        self.acceleration_critical_length = 2 * v0 * tr  # (7)
        cruise_length = 0.0
        if length > self.cruise_critical_length:
            self.peak_speed = vm
            cruise_length = length - self.cruise_critical_length
            self.kind = self._by_tm(
                SCurveClass.TRAPEZOID, SCurveClass.SEVEN_SEGMENT, SCurveClass.FIVE_SEGMENT
            )
        elif length > self.acceleration_critical_length:
            self.peak_speed = max(v0, length / tr - v0)  # (8); max: rounding at the boundary
            self.kind = self._by_tm(
                SCurveClass.TRIANGLE, SCurveClass.SIX_SEGMENT, SCurveClass.FOUR_SEGMENT
            )
        else:
            self.peak_speed = v0  # (11)
            cruise_length = length
            self.kind = SCurveClass.CONSTANT
        moving = self.kind is not SCurveClass.CONSTANT

        rise = self.peak_speed - v0
        self.peak_acceleration = rise / (tr - tm) if moving else 0.0
        self.jerk = self.peak_acceleration / tm if moving and tm > 0.0 else 0.0
        t4 = cruise_length / self.peak_speed
        t1, t2 = (tm, max(0.0, tr - 2 * tm)) if moving else (0.0, 0.0)
        self.durations = (t1, t2, t1, t4, t1, t2, t1)
        self.total_time = 2 * tr + t4 if moving else t4

        am, vp = self.peak_acceleration, self.peak_speed
        s1 = v0 * t1 + am * t1 * t1 / 6  # (6)
        s2 = (v0 + vp) * t2 / 2
        s3 = vp * t1 - am * t1 * t1 / 6
        self.displacements = (s1, s2, s3, cruise_length, s3, s2, s1)

    def _by_tm(self, without: SCurveClass, between: SCurveClass, half: SCurveClass) -> SCurveClass:
        if self.tm == 0.0:
            return without
        return half if self.tm == self.tr / 2 else between

    def profile(self, t: ArrayLike) -> Samples:
        """Position from the start, velocity and acceleration at the times t [s], any shape.

        Before 0 the profile is held at its start, after total_time at its end (acceleration 0).
        The falling half is computed as the mirror image of the rising one, counted from the end,
        so the last position is exactly `length` and the last speed exactly v0.
        Where tm = 0 the acceleration steps; at the step it has the value of the later side in the
        rising half and of the earlier side in the falling half.
        """
        time = np.asarray(t, dtype=np.float64)
        falling = time > self.total_time / 2
        # The smaller of the times from the start and to the end: only phases 1-4 are evaluated.
        u = np.maximum(0.0, np.where(falling, self.total_time - time, time))
        position, velocity, acceleration = self._rising(u)
        inside = (time >= 0.0) & (time <= self.total_time)
        acceleration = np.where(inside, acceleration, 0.0)
        return Samples(
            position=np.where(falling, self.length - position, position),
            velocity=velocity,
            acceleration=np.where(falling, -acceleration, acceleration),
        )

    def _rising(self, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        t1, t2, t3, *_ = self.durations
        s1, s2, s3, *_ = self.displacements
        v0, vp, am, jerk = self.v0, self.peak_speed, self.peak_acceleration, self.jerk
        half_jerk_speed = am * t1 / 2  # speed won in phase 1, and again in phase 3
        end2 = t1 + t2
        # Phase 3 is counted back from its end, where the acceleration is zero.
        end3 = self.tr if self.kind is not SCurveClass.CONSTANT else 0.0
        d2, d3, d4 = u - t1, end3 - u, u - end3
        v1 = v0 + half_jerk_speed
        phases = [u < t1, u < end2, u < end3]
        position = np.select(
            phases,
            [
                v0 * u + jerk * u**3 / 6,
                s1 + v1 * d2 + am * d2 * d2 / 2,
                s1 + s2 + s3 - (vp * d3 - jerk * d3**3 / 6),
            ],
            s1 + s2 + s3 + vp * d4,
        )
        velocity = np.select(
            phases, [v0 + jerk * u * u / 2, v1 + am * d2, vp - jerk * d3 * d3 / 2], vp
        )
        acceleration = np.select(phases, [jerk * u, am, jerk * d3], 0.0)
        return position, velocity, acceleration
