# SPDX-License-Identifier: Apache-2.0
"""Piecewise constant jerk: phases of a move, their states, and sampling.

Lengths may be metres, millimetres or radians; everything else is in the same unit and seconds.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sim.motion.planner.scurve import Number, Samples

# Accelerations that are less, relative to the greatest change in one phase, are none.
NO_ACCELERATION = 1e-14


class State(NamedTuple, Generic[Number]):
    """Position [unit], speed [unit/s] and acceleration [unit/s2] at one instant."""

    position: Number
    speed: Number
    acceleration: Number

    def after(self: State[Any], time: Number, jerk: Number) -> State[Number]:
        """State `time` seconds later (earlier if negative) under constant jerk [unit/s3]."""
        p, v, a = self
        return State(
            p + time * (v + time * (a / 2 + time * jerk / 6)),
            v + time * (a + time * jerk / 2),
            a + time * jerk,
        )


@dataclass(frozen=True)
class Phase(Generic[Number]):
    """`duration` [s] of constant `jerk` [unit/s3] beginning in `start`."""

    duration: Number
    jerk: Number
    start: State[Number]

    @property
    def end(self) -> State[Number]:
        """State at the end of the phase, with this phase's acceleration."""
        return self.start.after(self.duration, self.jerk)

    @property
    def displacement(self) -> Number:
        """Length run in the phase."""
        return self.end.position - self.start.position


class Step(NamedTuple):
    """Duration [s] and jerk [unit/s3] of a phase whose place is not known yet."""

    duration: float
    jerk: float


def run(start: State[float], steps: Sequence[Step]) -> State[float]:
    """State after the steps."""
    for duration, jerk in steps:
        start = start.after(duration, jerk)
    return start


def sampled(at: Callable[[float], State[Any]], t: ArrayLike) -> Samples:
    """States at the times t [s], any shape, rounded to doubles once."""
    times = np.asarray(t, dtype=np.float64)
    states = np.array([at(float(time)) for time in times.ravel()], dtype=np.float64)
    return Samples(*np.moveaxis(states.reshape(*times.shape, 3), -1, 0))


class Profile:
    """Phases between two states that are both met exactly, whatever the rounding.

    The first half of the time is counted from the start, the second back from the end; where they
    meet they differ by the rounding of the arithmetic, see `mismatch`.
    """

    def __init__(self, start: State[float], steps: Sequence[Step], end: State[float]) -> None:
        self.start, self.end = start, end
        self.steps = tuple(step for step in steps if step.duration > 0.0)
        self.ends = [0.0]
        self._from_start = [start]
        for duration, jerk in self.steps:
            self.ends.append(self.ends[-1] + duration)
            self._from_start.append(self._settled(self._from_start[-1].after(duration, jerk)))
        self._to_end = [end]
        for duration, jerk in reversed(self.steps):
            self._to_end.append(self._settled(self._to_end[-1].after(-duration, jerk)))
        self._to_end.reverse()
        self.total_time = self.ends[-1]

    def _settled(self, state: State[float]) -> State[float]:
        """The state without an acceleration that is rounding: a long cruise would add it up."""
        greatest = max(abs(duration * jerk) for duration, jerk in self.steps)
        if abs(state.acceleration) <= NO_ACCELERATION * greatest:
            return state._replace(acceleration=0.0)
        return state

    @property
    def phases(self) -> list[Phase[float]]:
        """Phases with their states counted from the start."""
        return [
            Phase(duration, jerk, state)
            for (duration, jerk), state in zip(self.steps, self._from_start, strict=False)
        ]

    @property
    def mismatch(self) -> State[float]:
        """State reached from the start minus the requested end: rounding of position, speed, ..."""
        return State(*(x - y for x, y in zip(self._from_start[-1], self.end, strict=True)))

    def at(self, t: float) -> State[float]:
        """State at time t [s]; held at the start before 0, at the end after total_time."""
        if t <= 0.0 or not self.steps:
            return self.start
        if t >= self.total_time:
            return self.end
        index = min(bisect.bisect_right(self.ends, t) - 1, len(self.steps) - 1)
        if t <= self.total_time / 2:
            return self._from_start[index].after(t - self.ends[index], self.steps[index].jerk)
        return self._to_end[index + 1].after(t - self.ends[index + 1], self.steps[index].jerk)

    def sample(self, t: ArrayLike) -> Samples:
        """States at the times t [s], any shape."""
        return sampled(self.at, t)

    def extremes(self) -> tuple[float, float, float, float]:
        """Least and greatest speed, greatest |acceleration| and greatest |jerk| of all instants."""
        speeds = [self.start.speed, self.end.speed]
        acceleration = max(abs(self.start.acceleration), abs(self.end.acceleration))
        for phase in self.phases:
            speeds.append(phase.end.speed)
            acceleration = max(acceleration, abs(phase.end.acceleration))
            if phase.jerk:
                turn = -phase.start.acceleration / phase.jerk  # acceleration 0: speed extreme
                if 0.0 < turn < phase.duration:
                    speeds.append(phase.start.after(turn, phase.jerk).speed)
        jerk = max((abs(step.jerk) for step in self.steps), default=0.0)
        return min(speeds), max(speeds), acceleration, jerk
