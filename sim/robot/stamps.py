# SPDX-License-Identifier: Apache-2.0
"""Speeds from the time between counts: the encoders' stamps, and the law's use of them.

At a count the place of an axis is exact, half a count beside the number that the decoder shows.
The error there is e + s q/2 - age (v_d - age a_d/2), s the direction of the count; e_v is the
difference of two such errors over the time between them, at least half a tick (the M/T method
[T. Ohmae, T. Matsuda, K. Kamiyama, M. Tachikawa, IEEE Trans. Ind. Electron. 29(3), 1982], on errors
instead of positions, so that a motion as desired is no error at any age). Without a new count e_v
stays, within q/age of what the desired speed would make of a machine at rest.

A stamp is that of rtl/drive/quadrature_time.sv: 2 age + 1 half clocks, negative if the count went
down, 0 before the first one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

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
        self._q, self._clock = robot.resolution, clock_of(robot)
        self._ticking = 2.0 * round(self._clock * robot.T_s)
        self.since = [LONG_AGO] * AXES
        self.place, self.slip = [0.0] * AXES, [0.0] * AXES

    def errors(
        self, stamps: Sequence[int], e: Floats, v_d: Floats, a_d: Floats
    ) -> tuple[float, ...]:
        """e_v of the five axes [m/s, rad/s] in a tick; stamps: half clocks; e, v_d, a_d: errors,
        desired speeds and accelerations of the axes."""
        for n in range(AXES):
            age, way = abs(stamps[n]), (stamps[n] > 0) - (stamps[n] < 0)
            far = self.since[n] + self._ticking
            apart, young = far - age, age < self._ticking
            late = age / (2.0 * self._clock)
            if way and young and apart >= self._ticking / 2:
                at = e[n] + way * self._q[n] / 2 - late * (v_d[n] - late * a_d[n] / 2)
                self.slip[n] = (at - self.place[n]) * (2.0 * self._clock / apart)
                self.place[n], self.since[n] = at, float(age)
            else:
                most = self._q[n] * 2.0 * self._clock / (1.0 if young else age)
                self.slip[n] = min(max(self.slip[n], v_d[n] - most), v_d[n] + most)
                self.since[n] = min(far, LONG_AGO)
        return tuple(self.slip)


def slips(
    robot: Robot,
    stamps: NDArray[np.integer],
    e: NDArray[np.float64],
    v_d: NDArray[np.float64],
    a_d: NDArray[np.float64],
) -> NDArray[np.float64]:
    """e_v (N, 5) over a recorded path from the start state; arguments (N, 5) as `Stamps.errors`."""
    law = Stamps(robot)
    rows = zip(stamps.tolist(), e.tolist(), v_d.tolist(), a_d.tolist(), strict=True)
    return np.array([law.errors(*row) for row in rows]).reshape(len(e), AXES)


class StampedPlant(Plant):
    """The plant with stamps behind the counts: `counts` and `step` give ten integers.

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
