# SPDX-License-Identifier: Apache-2.0
"""S-curves with set ramp times (S-curve paper) in exact rational arithmetic, correctly rounded.

The formulas are those of scurve.py; here they are evaluated with fractions, and each result is
rounded once, when it is read. A move costs some 100 us, once; `SCurve` samples whole paths fast.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from numpy.typing import ArrayLike

from sim.motion.planner.phases import Phase, State, sampled
from sim.motion.planner.scurve import ClosedForms, Samples, SCurveError, closed_forms

Exact = int | float | str | Fraction
PHASE_NAMES = (
    "jerk up, accelerating",
    "constant acceleration",
    "jerk down, accelerating",
    "cruise",
    "jerk down, decelerating",
    "constant deceleration",
    "jerk up, decelerating",
)
JERK_SIGNS = (1, 0, -1, 0, -1, 0, 1)
ACCELERATION_SIGNS = (0, 1, 1, 0, 0, -1, -1)  # at the start of the phase


_HUGE_EXPONENT = re.compile(r"[eE][+-]?0*[1-9]\d{3}")


def exact(name: str, value: Exact) -> Fraction:
    """The number that a parameter means: texts as written ("0.15" is 3/20), floats as stored."""
    try:
        if isinstance(value, str) and _HUGE_EXPONENT.search(value):
            raise ValueError
        return Fraction(value)
    except (ValueError, OverflowError, ZeroDivisionError, TypeError):
        raise SCurveError(
            f"S-curve parameter {name} = {value!r} is not a finite number; expected a decimal "
            "number such as 0.15 or a fraction such as 3/20"
        ) from None


@dataclass(frozen=True)
class RampTimePlan:
    """One move with its seven phases, empty ones included. All values are exact fractions."""

    v0: Fraction
    vm: Fraction
    tr: Fraction
    tm: Fraction
    length: Fraction
    forms: ClosedForms[Fraction]
    phases: tuple[Phase[Fraction], ...]

    @property
    def total_time(self) -> Fraction:
        """Duration of the move [s]."""
        return self.forms.total_time

    def at(self, t: Exact) -> State[Fraction]:
        """Exact state at time t [s]; held before 0 and after total_time (acceleration 0).

        At a step of the acceleration (tm = 0) the value is that of the later phase.
        """
        left = exact("t", t)
        if left < 0:
            return State(Fraction(0), self.v0, Fraction(0))
        for phase in self.phases:
            if left < phase.duration:
                return phase.start.after(left, phase.jerk)
            left -= phase.duration
        return State(self.length, self.v0, Fraction(0))

    def sample(self, t: ArrayLike) -> Samples:
        """Correctly rounded states at the times t [s], any shape."""
        return sampled(self.at, t)


def ramp_time_plan(v0: Exact, vm: Exact, tr: Exact, tm: Exact, length: Exact) -> RampTimePlan:
    """Plan a move: start and end speed v0, greatest speed vm [unit/s], acceleration time tr, jerk

    time tm [s], length [unit]. Raises SCurveError naming the parameter and the limit it breaks:
    0 <= v0 <= vm, vm > 0, tr > 0, 0 <= tm <= tr/2, length > 0.
    """
    names = ("v0", "vm", "tr", "tm", "length")
    given = (v0, vm, tr, tm, length)
    start, most, rise, rounding, way = (exact(*pair) for pair in zip(names, given, strict=True))
    forms = closed_forms(start, most, rise, rounding, way)
    phases = tuple(_phases(start, forms))
    return RampTimePlan(start, most, rise, rounding, way, forms, phases)


def _phases(v0: Fraction, forms: ClosedForms[Fraction]) -> Iterator[Phase[Fraction]]:
    state = State(Fraction(0), v0, Fraction(0))
    for duration, jerk, sign in zip(forms.durations, JERK_SIGNS, ACCELERATION_SIGNS, strict=True):
        # Without a jerk phase the acceleration steps, so it is set, not carried on.
        start = State(state.position, state.speed, sign * forms.peak_acceleration)
        phase = Phase(duration, jerk * forms.jerk, start)
        yield phase
        state = phase.end
