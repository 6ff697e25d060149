# SPDX-License-Identifier: Apache-2.0
"""Speeds from the time between counts: the encoders' stamps, and the law's use of them.

At the instant of a count the position is exact: half a count from the number that is shown.
e_v is the way that desired speed and acceleration make between two counts, at least half a tick
apart, less the counts' own, over that time (the M/T method [T. Ohmae, T. Matsuda, K. Kamiyama,
M. Tachikawa, IEEE Trans. Ind. Electron. 29(3), 1982], on errors, so that a motion as desired is
none at any age; not on errors of position, which hold the rounding of the set-points). Without a
new count e_v stays, within q/age of what the desired speed would make of a machine at rest.

A stamp is that of rtl/drive/quadrature_time.sv: 2 age + 1 half clocks, negative if the count went
down, 0 before the first one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.interface import program_interface
from sim.robot.parameters import Robot
from sim.robot.plant import Plant

AXES = 5
MOST_AGE = 2**22 - 1  # clocks
LONG_AGO = float(2**23)  # half clocks
Floats = Sequence[float]


def clock_of(robot: Robot) -> float:
    """Clock of the decoders [Hz]."""
    return program_interface("tracking_stamps").names(robot.values())["stamp_clock"]


class Stamps:
    """What the law keeps of the five axes from tick to tick."""

    def __init__(self, robot: Robot) -> None:
        self._q, self._clock, self._period = robot.resolution, clock_of(robot), robot.T_s
        self._ticking = 2.0 * round(self._clock * robot.T_s)
        self.since = [LONG_AGO] * AXES
        self.place: list[float] | None = None
        self.ahead, self.slip, self.apart = ([0.0] * AXES for _ in range(3))

    def errors(
        self, counts: Sequence[int], stamps: Sequence[int], v_d: Floats, a_d: Floats
    ) -> tuple[float, ...]:
        """e_v of the five axes [m/s, rad/s] in a tick; stamps: half clocks; v_d, a_d: desired
        speeds and accelerations of the axes."""
        period = self._period
        place = self.place = self.place or [float(n) for n in counts]
        for n in range(AXES):
            age, way = abs(stamps[n]), (stamps[n] > 0) - (stamps[n] < 0)
            far = self.since[n] + self._ticking
            apart, young = far - age, age < self._ticking
            late = age / (2.0 * self._clock)
            if self.since[n] >= LONG_AGO:  # at the start, or nobody knows how long ago
                place[n] = counts[n] - way / 2
            run = self.ahead[n] + period * (v_d[n] - period * a_d[n] / 2)
            if way and young and apart >= self._ticking / 2:
                at, part = counts[n] - way / 2, late * (v_d[n] - late * a_d[n] / 2)
                moved = run - part - self._q[n] * (at - place[n])
                self.slip[n] = moved * (2.0 * self._clock / apart)
                place[n], self.ahead[n], self.since[n] = at, part, float(age)
                self.apart[n] = apart / (2.0 * self._clock)
            else:
                most = self._q[n] * 2.0 * self._clock / (1.0 if young else age)
                self.slip[n] = min(max(self.slip[n], v_d[n] - most), v_d[n] + most)
                self.ahead[n], self.since[n], self.apart[n] = run, min(far, LONG_AGO), 0.0
        return tuple(self.slip)


@dataclass(frozen=True)
class Stamped:
    """A recorded path, each (N, 5): e_v; time between the counts that it was taken at [s], 0 where
    it stayed; way desired since the last count."""

    slip: NDArray[np.float64]
    apart: NDArray[np.float64]
    ahead: NDArray[np.float64]


def slips(
    robot: Robot,
    counts: NDArray[np.integer],
    v_d: NDArray[np.float64],
    a_d: NDArray[np.float64],
) -> Stamped:
    """Over a recorded path from the start state. counts: with stamps (N, 10); others (N, 5)."""
    law = Stamps(robot)
    rows = []
    for seen, speed, change in zip(counts.tolist(), v_d.tolist(), a_d.tolist(), strict=True):
        rows.append(
            (
                law.errors(seen[:AXES], seen[AXES:], speed, change),
                *map(tuple, (law.apart, law.ahead)),
            )
        )
    return Stamped(*np.array(rows).reshape(len(counts), 3, AXES).transpose(1, 0, 2))


class StampedPlant(Plant):
    """The plant whose stamps follow the counts: `counts` and `step` give ten integers.

    Between two ticks an axis moves by the cubic through its positions and speeds at both.
    """

    def __init__(self, robot: Robot, tool: Floats, table: Floats = (0.0, 0.0)) -> None:
        super().__init__(robot, tool, table)
        self._clock = clock_of(robot)
        self._clocks = round(self._clock * robot.T_s)  # of a tick
        self._stamps = [0] * AXES
        self._ends = self._motion()

    def _motion(self) -> tuple[list[float], list[float]]:
        """Positions [counts] and speeds [counts a tick] of the axes."""
        robot, (x, y, z), (vx, vy, vz) = self._robot, self.tool, self.tool_velocity
        joints = self.joints
        speeds = [
            ((x - xp) * vx + (y - yp) * vy + z * vz) / length
            for (xp, yp), length in zip(robot.legs, joints, strict=False)
        ]
        scale = robot.resolution
        return (
            [p / q for p, q in zip(joints, scale, strict=True)],
            [
                v * robot.T_s / q
                for v, q in zip((*speeds, *self.table_velocity), scale, strict=True)
            ],
        )

    def counts(self) -> tuple[int, ...]:
        """Counts of the five axes, then their stamps."""
        return (*super().counts(), *self._stamps)

    def step(self, outputs: Floats) -> tuple[int, ...]:
        """As that of `Plant`."""
        super().step(outputs)
        before, self._ends = self._ends, self._motion()
        for n, ends in enumerate(zip(*before, *self._ends, strict=True)):
            self._stamps[n] = self._stamp(self._stamps[n], *ends)
        return self.counts()

    def _stamp(self, last: int, p0: float, v0: float, p1: float, v1: float) -> int:
        """Stamp after a tick from p0 [counts] with speed v0 [counts a tick] to p1 with v1."""
        found = last_crossing(p0, v0, p1, v1)
        if found is None:
            if not last:
                return 0
            age = min((abs(last) - 1) // 2 + self._clocks, MOST_AGE)
            return (2 * age + 1) * (1 if last > 0 else -1)
        time, way = found
        return way * (2 * int((1.0 - time) * self._clocks) + 1)


def last_crossing(p0: float, v0: float, p1: float, v1: float) -> tuple[float, int] | None:
    """Time in the tick, 0 .. 1, and direction of the last change of the count floor(p + 1/2) on the
    cubic from p0, v0 to p1, v1; None if there is none."""
    c3, c2 = 2.0 * (p0 - p1) + v0 + v1, 3.0 * (p1 - p0) - 2.0 * v0 - v1

    def at(t: float) -> float:
        return ((c3 * t + c2) * t + v0) * t + p0

    times = [0.0, *sorted(t for t in _roots(3.0 * c3, 2.0 * c2, v0) if 0.0 < t < 1.0), 1.0]
    values = [p0, *map(at, times[1:-1]), p1]
    for k in range(len(times) - 1, 0, -1):  # the cubic is monotone between these times
        first, last = (math.floor(values[i] + 0.5) for i in (k - 1, k))
        if first == last:
            continue
        way = 1 if last > first else -1
        level = last - 0.5 * way
        low, high = times[k - 1], times[k]
        for _ in range(40):
            middle = 0.5 * (low + high)
            if (at(middle) - level) * way < 0.0:
                low = middle
            else:
                high = middle
        return high, way
    return None


def _roots(a: float, b: float, c: float) -> list[float]:
    """Real roots of a t^2 + b t + c."""
    if abs(a) < 1e-12 * (abs(b) + abs(c)):
        return [-c / b] if b else []
    inside = b * b - 4.0 * a * c
    if inside <= 0.0:
        return []
    root = math.sqrt(inside)
    return [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
