# SPDX-License-Identifier: Apache-2.0
"""Lines that follow each other, as one curve: their path averaged over its length.

The average is that of three windows of width w in turn. A corner at u = 0 with the directions t0
and t1 then deviates by w (t1 - t0) times an even function of u / w, which is 13/64 in the corner
and 0 from 1.5 w on. Elsewhere the curve is the path itself. Point, direction, curvature and the
third derivative by the length of the path are continuous.

At an end that the curve shall meet, the path goes on as its reflection in that point, so the curve
ends in the point, without curvature. All curves are in path space (blend.py) [m].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.blend import SCALE, by_length
from sim.motion.geometry.curves import FloatArray

REACH = 1.5  # of a corner, in widths
PEAK = 13 / 64  # greatest deviation of a corner, in widths times change of direction
ROWS = 2048  # evaluated together
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_GAUSS, _WEIGHTS = (_GAUSS + 1) / 2, _WEIGHTS / 2


def weights(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Deviation by a corner, and its derivatives, at x = u / w; the first as if there were none.

    Their factors are w, 1, 1 / w and 1 / w^2.
    """
    size = np.minimum(np.abs(x), REACH)
    far = REACH - size
    near = size <= 0.5
    half = 0.5 - size
    deviation = np.where(
        near,
        1 / 24 + half / 8 + 0.375 * half**2 - (size**4 - 0.0625) / 12,
        far**4 / 24,
    )
    share = np.where(near, 1 / 6 + 0.75 * half + (size**3 - 0.125) / 3, far**3 / 6)
    density = np.where(near, 0.75 - size**2, far**2 / 2)
    slope = np.where(near, 2 * size, far)
    before = x < 0.0
    return (
        deviation,
        np.where(before, share, -share),
        density,
        np.where(before, slope, -slope),
    )


def within(
    corners: FloatArray, u: FloatArray, reach: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Numbers (m, k) of the corners within reach of the places u (m,), and which of them are."""
    low = np.searchsorted(corners, u - reach)
    counts = np.searchsorted(corners, u + reach, side="right") - low
    number = np.arange(int(counts.max(initial=0)))
    there = number < counts[:, None]
    return np.where(there, low[:, None] + number, 0), there


@dataclass(eq=False)
class Smoothed:
    """A part of the curve.

    places (n + 1,) [m]: along the path, from 0 on; points (n + 1, 5) of the path there, and the
    directions after them; corners (k,) ascending, also those about the part, with the
    changes of direction (k, 5); width [m]. lines, moves (n,): of the lines between the places.
    """

    places: FloatArray
    points: FloatArray
    directions: FloatArray
    corners: FloatArray
    changes: FloatArray
    width: float
    lines: list[int]
    moves: list[int]

    def __post_init__(self) -> None:
        ways = np.diff(self.places)
        counts = np.maximum(1, np.ceil(2 * ways / self.width).astype(np.int64))
        number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        steps = np.repeat(ways / counts, counts)
        begin = np.repeat(self.places[:-1], counts) + number * steps
        self._knots = np.append(begin, self.places[-1])
        speeds = self._speed((begin[:, None] + steps[:, None] * _GAUSS).ravel())
        parts = (speeds.reshape(len(steps), -1) @ _WEIGHTS) * steps
        self._lengths = np.concatenate([[0.0], np.cumsum(parts)])
        self.length = float(self._lengths[-1])
        self.ends = self._lengths[np.concatenate([[0], np.cumsum(counts)])]  # at the places

    def derivatives(self, u: FloatArray, order: int) -> list[FloatArray]:
        """Point and derivatives by the length of the path at u (m,), each (m, 5)."""
        if len(u) > ROWS:
            parts = [self.derivatives(u[k : k + ROWS], order) for k in range(0, len(u), ROWS)]
            return [np.concatenate(values) for values in zip(*parts, strict=True)]
        own = np.clip(np.searchsorted(self.places, u, side="right") - 1, 0, len(self.places) - 1)
        direction = self.directions[own]
        found = [self.points[own] + (u - self.places[own])[:, None] * direction, direction]
        found += [np.zeros_like(direction) for _ in range(order - 1)]
        reach, w = REACH * self.width, self.width
        index, there = within(self.corners, u, reach)
        if not index.size:
            return found[: order + 1]
        x = np.where(there, (u[:, None] - self.corners[index]) / w, REACH)  # no weight there
        changes = self.changes[index]
        factors = (w, 1.0, 1.0 / w, 1.0 / w**2)
        for k, weight in enumerate(weights(x)[: order + 1]):
            found[k] = found[k] + factors[k] * np.einsum("mk,mkd->md", weight, changes)
        return found[: order + 1]

    def _speed(self, u: FloatArray) -> FloatArray:
        return np.linalg.norm(self.derivatives(u, 1)[1], axis=1)

    def parameter(self, s: FloatArray) -> FloatArray:
        """Length of the path at which the length s (m,) of the curve is run, to rounding."""
        cell = np.clip(
            np.searchsorted(self._lengths, s, side="right") - 1, 0, len(self._lengths) - 2
        )
        low, begin = self._lengths[cell], self._knots[cell]
        width = self._knots[cell + 1] - begin
        u = begin + (s - low) / (self._lengths[cell + 1] - low) * width
        for _ in range(3):
            at = begin[:, None] + (u - begin)[:, None] * _GAUSS
            run = low + (self._speed(at.ravel()).reshape(at.shape) @ _WEIGHTS) * (u - begin)
            u = np.clip(u - (run - s) / self._speed(u), begin, begin + width)
        return u

    def at_parameters(self, u: FloatArray, order: int = 3) -> list[FloatArray]:
        """Point and derivatives by the length of the curve, each (m, 5), in path space."""
        return by_length(self.derivatives(u, order))

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """As of a curve (curves.py): point and two derivatives by the length, in m and rad."""
        point, first, second = (each / SCALE for each in self.at_parameters(self.parameter(s), 2))
        return point, first, second

    def third(self, s: FloatArray) -> FloatArray:
        """Third derivative by the length."""
        return self.at_parameters(self.parameter(s))[3] / SCALE

    def examined(
        self, begin: FloatArray, end: FloatArray, count: int
    ) -> tuple[NDArray[np.float64], ...]:
        """Point and three derivatives (n, count, 5) of parts between lengths (n,) of the curve."""
        first, last = self.parameter(begin), self.parameter(end)
        u = first[:, None] + (last - first)[:, None] * np.linspace(0.0, 1.0, count)
        values = self.at_parameters(u.ravel())
        return tuple(value.reshape(*u.shape, 5) for value in values)
