# SPDX-License-Identifier: Apache-2.0
"""Set-points of any path as streams of phase records: one per axis, for the motion front-end.

Between set-points a period apart, a joint (leg or table axis, in steps) runs the cubic that has its
position and speed at both ends: constant jerk, so it is one record. Where the speed changes sign
the cubic is cut at the nearest tick, because a record has one direction.

What the hardware does with a record is known to the last bit: each tick adds a whole rate [1/16 Hz]
to a phase, and a step is due whenever that passes a modulus (velocity_control, pulse_generator). So
the encoder keeps count and phase of each axis exactly, and every record aims from where the
hardware will be to where the joint should be: errors do not add up, whatever the length.

A step represents the place where it is half done; count and phase together are a place too:
count +- (phase - 1/2). At a change of direction the phase is centred (flag FIRST), which moves that
place by half a step at most. The axis waits there while the joint has not yet come so far back.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import FloatArray, check_positive
from sim.motion.lookahead.planner import Setpoints
from sim.motion.planner.pulse_records import PulseRecordError
from sim.robot.kinematics import inverse, inverse_velocity
from sim.robot.parameters import Robot
from sim.rtl.phase_record import (
    DIRECTION,
    FIRST,
    FRACTION,
    HIGHEST_RATE,
    LAST,
    SLOPE_LIMIT,
    UNITS_PER_PULSE,
    Record,
)

AXES = ("leg 1", "leg 2", "leg 3", "tilt", "rotation")
TICKS_PER_SECOND = 1_000_000
SHORTEST = 4  # ticks of a part between two changes of direction
HALF = UNITS_PER_PULSE // 2


@dataclass(frozen=True)
class Steps:
    """Steps per m of a leg and per rad of a table axis; set-points between records' ends."""

    leg: float = 1e6
    table: float = 1000 * 180 / math.pi
    every: int = 10

    def __post_init__(self) -> None:
        check_positive(PulseRecordError, **vars(self))
        if self.every != int(self.every):
            raise PulseRecordError(f"every = {self.every!r} is not a whole number of set-points")

    @property
    def scale(self) -> FloatArray:
        """Steps per unit of the five joints."""
        return np.array([self.leg] * 3 + [self.table] * 2)


def joints(robot: Robot, points: Setpoints, steps: Steps) -> tuple[FloatArray, FloatArray]:
    """Places (n, 5) in steps and speeds (n, 5) in steps/s of legs and table at set-points."""
    tool, speed = points.position[:, :3], points.velocity[:, :3]
    place = np.hstack([inverse(robot, tool), points.position[:, 3:]])
    rate = np.hstack([inverse_velocity(robot, tool, speed), points.velocity[:, 3:]])
    return place * steps.scale, rate * steps.scale


class AxisEncoder:
    """Records of one axis, and what the hardware makes of them: count, phase, direction.

    name: for messages; start: place of the joint [steps] at which the count is 0.
    """

    def __init__(self, name: str, start: float) -> None:
        self.name, self.start = name, start
        self.count, self.phase, self.sign = 0, HALF, 1
        self._fresh = True

    @property
    def place(self) -> float:
        """Place [steps] from the start that count and phase represent."""
        return self.count + self.sign * (self.phase / UNITS_PER_PULSE - 0.5)

    def records(
        self, ticks: int, x0: float, v0: float, x1: float, v1: float, last: bool = False
    ) -> list[Record]:
        """Records of the cubic from x0, v0 to x1, v1 [steps, steps/tick] in `ticks`.

        The last one ends at the nearest whole step. Raises PulseRecordError.
        """
        x0, x1 = x0 - self.start, x1 - self.start
        if last:
            x1 = float(round(x1))
        way, t = x1 - x0, float(ticks)
        slope = 2 * (3 * way - (2 * v0 + v1) * t) / t**2
        jerk = 6 * ((v0 + v1) * t - 2 * way) / t**3
        found: list[Record] = []
        marks = self._turns(ticks, v0, slope, jerk)
        for begin, end in zip(marks[:-1], marks[1:], strict=True):
            speed, rise = v0 + begin * (slope + begin * jerk / 2), slope + begin * jerk
            place = x0 + end * (v0 + end * (slope / 2 + end * jerk / 6)) if end < ticks else x1
            found += self._part(end - begin, place, speed, rise, jerk)
        if last:
            found[-1] = replace(found[-1], flags=found[-1].flags | LAST)
        return found

    @staticmethod
    def _turns(ticks: int, v0: float, slope: float, jerk: float) -> list[int]:
        """Ticks 0 .. ticks at which the speed changes its sign, with both ends."""
        roots = np.roots([jerk / 2, slope, v0]) if jerk or slope else np.zeros(0)
        real = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-9 * abs(root))
        marks = [0]
        for root in real:
            if math.isfinite(root) and marks[-1] + SHORTEST <= root <= ticks - SHORTEST:
                marks.append(round(root))
        return [*marks, ticks]

    def _part(
        self, ticks: int, place: float, speed: float, slope: float, jerk: float
    ) -> list[Record]:
        """Records to `place` in `ticks`, all in one direction; speeds per tick at their start."""
        found: list[Record] = []
        middle = speed + ticks / 2 * (slope + ticks / 4 * jerk)
        sign = self.sign if middle == 0.0 else int(math.copysign(1, middle))
        flags = 0
        if sign != self.sign and (place - self.count) * sign > 0.0:
            # A tick at rest comes first, so that no step is due in the clock of the change.
            found.append(self._record(0, 1, 0, 0, 0))
            ticks, speed, slope = ticks - 1, speed + slope + jerk / 2, slope + jerk
            self.sign, self.phase, flags = sign, HALF, FIRST
        distance = (place - self.place) * self.sign
        if distance <= 0.0:
            return [*found, self._record(flags, ticks, 0, 0, 0)]
        return [*found, self._moving(flags, ticks, distance, self.sign * slope, self.sign * jerk)]

    def _moving(self, flags: int, ticks: int, distance: float, slope: float, jerk: float) -> Record:
        """A record of `distance` steps; its start speed is what reaches it."""
        unit = UNITS_PER_PULSE * FRACTION
        sums = ticks * (ticks - 1) / 2, (ticks - 1) * ticks * (ticks + 1) / 6
        speed = (distance - slope * sums[0] - jerk * sums[1]) / ticks
        end = speed + (ticks - 1) * (slope + ticks / 2 * jerk)
        if speed < 0.0 or end < 0.0:
            # Close to a change of direction: from rest, or to rest, at constant acceleration.
            slope, jerk = 2 * distance / (ticks * max(ticks - 1, 1)), 0.0
            speed, slope = (0.0, slope) if speed < 0.0 else (slope * (ticks - 1), -slope)
        top = max(speed, end) * TICKS_PER_SECOND
        if not top <= HIGHEST_RATE:
            raise PulseRecordError(
                f"{self.name}: {top:.6g} steps/s are more than {HIGHEST_RATE}; use fewer steps per "
                "unit or a lower speed"
            )
        slopes = round(slope * unit), round(jerk * unit)
        if max(map(abs, slopes)) >= SLOPE_LIMIT:
            raise PulseRecordError(
                f"{self.name}: acceleration {slope:.6g} steps/us2 or jerk {jerk:.6g} steps/us3 is "
                f"not below {SLOPE_LIMIT / unit:.6g}"
            )
        # Half a unit, because published rates are cut to whole ones.
        return self._record(flags, ticks, round(speed * unit) + FRACTION // 2, *slopes)

    def _record(self, flags: int, ticks: int, velocity: int, slope: int, jerk: int) -> Record:
        """The record, and what the hardware does in it."""
        if self._fresh:
            flags |= FIRST
            self._fresh = False
        if self.sign < 0:
            flags |= DIRECTION
        if velocity:
            i = np.arange(ticks, dtype=np.int64)
            rates = np.maximum(velocity + i * slope + i * (i + 1) // 2 * jerk, 0) >> 32
            steps, self.phase = divmod(self.phase + int(rates.sum()), UNITS_PER_PULSE)
            self.count += self.sign * steps
        return Record(flags, ticks, velocity, slope, jerk)


class PathEncoder:
    """Records of all axes from the set-points of a path, `period` [s] apart."""

    def __init__(self, robot: Robot, period: float, steps: Steps | None = None) -> None:
        self.robot, self.steps = robot, steps or Steps()
        self.ticks = round(period * TICKS_PER_SECOND) if math.isfinite(period) else 0
        if self.ticks < 1 or abs(self.ticks / TICKS_PER_SECOND - period) > 1e-9 * period:
            raise PulseRecordError(f"period = {period!r} s is not a whole number of microseconds")
        self.axes: list[AxisEncoder] = []

    def run(self, stream: Iterable[Setpoints]) -> Iterator[list[list[Record]]]:
        """Lists of records, one list per axis, for one period after the other."""
        every, held = self.steps.every, None
        for points in stream:
            x, v = joints(self.robot, points, self.steps)
            v = v / TICKS_PER_SECOND
            if held is not None:
                x, v = np.vstack([held[0], x]), np.vstack([held[1], v])
            if not self.axes:
                self.axes = [AxisEncoder(*axis) for axis in zip(AXES, x[0], strict=True)]
            whole = (len(x) - 2) // every  # one more set-point is left for the last record
            for k in range(whole):
                yield self._period(x, v, k * every, (k + 1) * every, last=False)
            held = x[whole * every :], v[whole * every :]
        if held is not None and len(held[0]) > 1:
            yield self._period(*held, 0, len(held[0]) - 1, last=True)

    def _period(
        self, x: FloatArray, v: FloatArray, first: int, end: int, last: bool
    ) -> list[list[Record]]:
        ticks = (end - first) * self.ticks
        return [
            axis.records(ticks, x[first, n], v[first, n], x[end, n], v[end, n], last)
            for n, axis in enumerate(self.axes)
        ]


def published(records: Sequence[Record]) -> tuple[NDArray[np.int64], FloatArray]:
    """Count and place [steps] that records represent after each of their ticks, from 0.

    By the headers of velocity_control and pulse_generator: for checks of the encoder without them.
    """
    count, phase = 0, HALF
    counts, places = [], []
    for record in records:
        sign = -1 if record.flags & DIRECTION else 1
        if record.flags & FIRST:
            phase = HALF
        rates = np.array([record.published(tick) for tick in range(record.count)])
        phases = phase + np.cumsum(rates)
        counts.append(count + sign * (phases // UNITS_PER_PULSE))
        places.append(counts[-1] + sign * (phases % UNITS_PER_PULSE / UNITS_PER_PULSE - 0.5))
        count, phase = int(counts[-1][-1]), int(phases[-1] % UNITS_PER_PULSE)
    return np.concatenate(counts), np.concatenate(places)
