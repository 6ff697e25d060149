# SPDX-License-Identifier: Apache-2.0
"""S-curve speed profile with set acceleration and jerk times (S-curve paper, (1)-(11)).

The profile is fixed by times, not by acceleration and jerk: the speed rises from v0 to its peak in
exactly tr, the first and last tm of that with constant jerk, and falls in mirror image. A path too
short for vm lowers the peak and leaves tr, so no equation above the first degree has to be solved.
Lengths may be metres or radians; speeds and accelerations are in the same unit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
Number = TypeVar("Number", float, Fraction)


class SCurveClass(Enum):
    """The seven classes of the paper's table 1; the value is the number of segments."""

    SEVEN_SEGMENT = 7
    SIX_SEGMENT = 6
    FIVE_SEGMENT = 5
    FOUR_SEGMENT = 4
    TRAPEZOID = 3
    TRIANGLE = 2
    CONSTANT = 1


# With and without a cruise, each for tm = 0, tm between, and tm = tr/2.
CRUISING = (SCurveClass.TRAPEZOID, SCurveClass.SEVEN_SEGMENT, SCurveClass.FIVE_SEGMENT)
PEAKED = (SCurveClass.TRIANGLE, SCurveClass.SIX_SEGMENT, SCurveClass.FOUR_SEGMENT)


class SCurveError(ValueError):
    """A parameter of a profile lies outside its limit; names the value and the limit."""


def require(ok: bool, name: str, value: Number, limit: str) -> None:
    """Raise SCurveError naming value and limit unless `ok` and the value is finite."""
    if not (ok and math.isfinite(value)):
        raise SCurveError(
            f"S-curve parameter {name} = {as_text(value)} is outside its limit: {limit}"
        )


def as_text(value: Number) -> str:
    """A number as people write it; a rational one as the nearest double."""
    return repr(float(value) if isinstance(value, Fraction) else value)


@dataclass(frozen=True)
class ClosedForms(Generic[Number]):
    """Formulas (1)-(11) evaluated: floats from floats, exact fractions from fractions.

    durations [s] and displacements [unit] of the seven phases, peak speed, acceleration and jerk;
    the jerk is 0 where no phase has one (trapezoid, triangle, constant speed).
    """

    kind: SCurveClass
    cruise_critical_length: Number
    acceleration_critical_length: Number
    peak_speed: Number
    peak_acceleration: Number
    jerk: Number
    durations: tuple[Number, ...]
    displacements: tuple[Number, ...]
    total_time: Number


def closed_forms(
    v0: Number, vm: Number, tr: Number, tm: Number, length: Number
) -> ClosedForms[Number]:
    """Class and phases of one move; see SCurve for the parameters and the errors."""
    require(vm > 0, "vm", vm, "vm > 0")
    require(0 <= v0 <= vm, "v0", v0, f"0 <= v0 <= vm = {as_text(vm)}")
    require(tr > 0, "tr", tr, "tr > 0")
    require(0 <= tm <= tr / 2, "tm", tm, f"0 <= tm <= tr/2 = {as_text(tr / 2)}")
    require(length > 0, "length", length, "length > 0")
    zero = 0 * length

    cruise_critical_length = (v0 + vm) * tr  # (4)
    acceleration_critical_length = 2 * v0 * tr  # (7)
    cruise_length = zero
    ramp = (tm > 0) + (tm == tr / 2)
    if length > cruise_critical_length:
        peak_speed = vm
        cruise_length = length - cruise_critical_length
        kind = CRUISING[ramp]
    elif length > acceleration_critical_length:
        peak_speed = max(v0, length / tr - v0)  # (8); max: rounding at the boundary
        kind = PEAKED[ramp]
    else:
        peak_speed = v0  # (11)
        cruise_length = length
        kind = SCurveClass.CONSTANT
    moving = kind is not SCurveClass.CONSTANT

    rise = peak_speed - v0
    am = rise / (tr - tm) if moving else zero
    t4 = cruise_length / peak_speed
    t1, t2 = (tm, max(zero, tr - 2 * tm)) if moving else (zero, zero)
    s1 = v0 * t1 + am * t1 * t1 / 6  # (6)
    s2 = (v0 + peak_speed) * t2 / 2
    s3 = peak_speed * t1 - am * t1 * t1 / 6
    return ClosedForms(
        kind=kind,
        cruise_critical_length=cruise_critical_length,
        acceleration_critical_length=acceleration_critical_length,
        peak_speed=peak_speed,
        peak_acceleration=am,
        jerk=am / tm if moving and tm > 0 else zero,
        durations=(t1, t2, t1, t4, t1, t2, t1),
        displacements=(s1, s2, s3, cruise_length, s3, s2, s1),
        total_time=2 * tr + t4 if moving else t4,
    )


@dataclass(frozen=True)
class Samples:
    """Values of a profile along its path, one array each, of the shape of the requested times."""

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
        forms = closed_forms(v0, vm, tr, tm, length)
        self.v0, self.vm, self.tr, self.tm, self.length = v0, vm, tr, tm, length
        self.kind = forms.kind
        self.cruise_critical_length = forms.cruise_critical_length
        self.acceleration_critical_length = forms.acceleration_critical_length
        self.peak_speed = forms.peak_speed
        self.peak_acceleration = forms.peak_acceleration
        self.jerk = forms.jerk
        self.durations = forms.durations
        self.displacements = forms.displacements
        self.total_time = forms.total_time

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
