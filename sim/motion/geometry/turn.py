# SPDX-License-Identifier: Apache-2.0
"""Turns: corners that the tool passes on the shortest curve that a window of averaging makes.

The motion along the path comes to rest in the corner with the deceleration A and leaves it with the
acceleration A at once. Averaged over the window T as a vector, it is

    q(t) = corner - h (1 - t / T)^3 u1 + h (t / T)^3 u2,    h = A T^2 / 6,    t = 0 .. T

with the directions u1 and u2 before and after. Its acceleration goes evenly from -A u1 to A u2,
so the jerk is A (u1 + u2) / T. Compared with a stop, which rests for T, a turn saves that time.
The averaged speed counts the length s = h (2 x^3 + 1.5 x) with x = t / T - 1/2, from -h to h. This
gives the curve as a function of s. The nearest point to the corner is h / 8 (u2 - u1) away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.motion.geometry.curves import FloatArray


@dataclass(frozen=True, eq=False)
class Turn:
    """The curve at a corner (5,) in path space [m], between unit directions; half [m]: h."""

    corner: FloatArray
    before: FloatArray
    after: FloatArray
    half: float

    @property
    def end(self) -> FloatArray:
        """Its last point."""
        return self.corner + self.half * self.after

    @property
    def apex(self) -> float:
        """Distance from the corner to the curve [m]."""
        return float(np.linalg.norm(self.after - self.before)) * self.half / 8

    def at(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Point and two derivatives by s (n,) in 0 .. 2 h, each (n, 5)."""
        h = self.half
        wanted = s / h - 1.0
        x = wanted / 2
        for _ in range(5):  # Newton; the slope is 1.5 at least, so it goes to rounding
            x = x - (2 * x**3 + 1.5 * x - wanted) / (6 * x * x + 1.5)
        x = np.clip(x, -0.5, 0.5)[:, None]
        left, done = 0.5 - x, 0.5 + x
        point = self.corner + h * (done**3 * self.after - left**3 * self.before)
        rate = 6 * x * x + 1.5
        first = 3 * (left**2 * self.before + done**2 * self.after) / rate
        second = (6 * (done * self.after - left * self.before) - 12 * x * first) / (h * rate**2)
        return point, first, second
