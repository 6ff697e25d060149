# SPDX-License-Identifier: Apache-2.0
"""Segments of the look-ahead planner: a line, an arc, or a part of the curve of a run of lines."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sim.motion.geometry.blend import SCALE
from sim.motion.geometry.curves import Arc, FloatArray
from sim.motion.geometry.smoothed import Smoothed


@dataclass(eq=False)
class Segment:
    """A move in path space [m]."""

    line: int
    move: int  # its number in the stream
    start: FloatArray
    end: FloatArray
    length: float
    feed: float  # [m/s] of path space
    tool_feed: float  # [m/s] of the tool; inf for a move of the table alone
    tolerance: float  # [m]
    merge: float  # [m]
    inner: bool
    direction: FloatArray = field(default_factory=lambda: np.zeros(5))  # direction of a line
    curve: Arc | Smoothed | None = None  # curve of an arc or of a run of lines
    ratio: float = 1.0  # length in path space per length of the curve
    off: float = 0.0  # greatest distance of corners that were joined into this line [m]

    @property
    def first_move(self) -> int:
        """Number of the first move that it is of; `move` is the last one."""
        return self.curve.moves[0] if isinstance(self.curve, Smoothed) else self.move

    @property
    def count(self) -> int:
        """Moves that it is of."""
        return len(self.curve.moves) if isinstance(self.curve, Smoothed) else 1

    @property
    def cell(self) -> float:
        """Greatest length that is examined together [m]."""
        return 2 * self.curve.width if isinstance(self.curve, Smoothed) else math.inf

    def room(self, at_end: bool) -> float:
        """Greatest distance of a blend from an end: half the segment and half the move there [m].

        So a blend is near its own moves only.
        """
        if not isinstance(self.curve, Smoothed):
            return self.length / 2
        ends = self.curve.ends
        return min(self.length, float(ends[-1] - ends[-2] if at_end else ends[1])) / 2

    @property
    def allowed(self) -> float:
        """Greatest distance from the programmed path: P, or Q where that is greater [m]."""
        return max(self.tolerance, self.merge)

    @property
    def rounding(self) -> float:
        """Greatest distance of blends from its ends [m]: P, less what joining has used."""
        return min(self.tolerance, self.allowed - self.off)

    def at(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Point, first and second derivative by the length, (n, 5), in path space."""
        if self.curve is None:
            zero = np.zeros((len(s), 5))
            return self.start + s[:, None] * self.direction, zero + self.direction, zero
        point, first, second = self.curve.evaluate(s / self.ratio)
        return point * SCALE, first * SCALE / self.ratio, second * SCALE / self.ratio**2

    def third(self, s: FloatArray) -> FloatArray:
        """Third derivative by the length, (n, 5), in path space."""
        if self.curve is None:
            return np.zeros((len(s), 5))
        return self.curve.third(s / self.ratio) * SCALE / self.ratio**3
