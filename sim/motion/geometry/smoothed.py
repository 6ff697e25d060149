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

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.blend import SCALE, by_length
from sim.motion.geometry.curves import FloatArray

REACH = 1.5  # reach of a corner, in widths
PEAK = 13 / 64  # greatest deviation of a corner, in widths times change of direction
SHORTEST_INTERVAL = 1e-6  # between knots, in widths; a knot nearer to the last one is left out
_GAUSS = (np.polynomial.legendre.leggauss(8)[0] + 1) / 2
# From values at the places of Gauss to the integral from 0, by the powers 1 to 8 of its end.
_INTEGRALS = np.linalg.inv(np.vander(_GAUSS, increasing=True)).T / np.arange(1, 9)
# By order k and power n: n! / (n - k)!
_FACTORS = [[math.perm(n, k) for n in range(5)] for k in range(4)]


def weights(x: FloatArray) -> tuple[FloatArray, ...]:
    """Deviation by a corner, and its four derivatives, at x = u / w; the first as if there were

    none. Their factors are w, 1, 1 / w, 1 / w^2 and 1 / w^3.
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
        np.where(near, -2.0, np.where(size < REACH, 1.0, 0.0)),
    )


def _run(powers: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (m,) of polynomials without a constant, (8, m) from the first power on, and slopes."""
    value, slope = powers[7], 8 * powers[7]
    for n in range(6, -1, -1):
        value = value * share + powers[n]
        slope = slope * share + (n + 1) * powers[n] if n else slope * share + powers[0]
    return value * share, slope


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
        self._compile()
        begin, width = self._knots[:-1], np.diff(self._knots)
        at = (begin[:, None] + width[:, None] * _GAUSS).ravel()
        speeds = np.linalg.norm(self._polynomials(at, 1, np.arange(len(width)))[1], axis=1)
        # The length from the start of an interval, by the powers of the share of it.
        self._runs = (speeds.reshape(len(width), -1) @ _INTEGRALS) * width[:, None]
        self._lengths = np.concatenate([[0.0], np.cumsum(self._runs.sum(axis=1))])
        self.length = float(self._lengths[-1])
        self.ends = self._length_at(self.places)

    def _compile(self) -> None:
        """The curve as polynomials of degree 4 about the middles of the intervals between knots."""
        w, end = self.width, float(self.places[-1])
        knots = (self.corners[:, None] + w * np.array([-1.5, -0.5, 0.5, 1.5])).ravel()
        knots = np.sort(knots[(knots > 0.0) & (knots < end)])
        far = np.diff(knots, prepend=0.0) > SHORTEST_INTERVAL * w
        knots = knots[far & (end - knots > SHORTEST_INTERVAL * w)]
        self._knots = np.concatenate([[0.0], knots, [end]])
        self._middles = (self._knots[:-1] + self._knots[1:]) / 2
        found = self.derivatives(self._middles, 4)
        factors = 1.0, 1.0, 0.5, 1 / 6, 1 / 24
        self._powers = np.stack([f * d for f, d in zip(factors, found, strict=True)], axis=1)

    def derivatives(self, u: FloatArray, order: int) -> list[FloatArray]:
        """Point and derivatives by the length of the path at u (m,), each (m, 5), from the corners.

        The fourth one is constant between knots.
        """
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
        factors = (w, 1.0, 1.0 / w, 1.0 / w**2, 1.0 / w**3)
        for k, weight in enumerate(weights(x)[: order + 1]):
            found[k] = found[k] + factors[k] * np.einsum("mk,mkd->md", weight, changes)
        return found[: order + 1]

    def _interval(self, u: FloatArray) -> NDArray[np.int64]:
        return np.clip(np.searchsorted(self._knots, u, side="right") - 1, 0, len(self._runs) - 1)

    def _polynomials(
        self, u: FloatArray, order: int, own: NDArray[np.int64] | None = None
    ) -> list[FloatArray]:
        """As `derivatives`; own: the interval of every place, or of as many after each other."""
        if own is None:
            own = self._interval(u)
        own = np.repeat(own, len(u) // len(own)) if len(own) < len(u) else own
        powers, d = self._powers[own], (u - self._middles[own])[:, None]
        found = []
        for k in range(order + 1):
            value = _FACTORS[k][4] * powers[:, 4]
            for n in range(3, k - 1, -1):
                value = value * d + _FACTORS[k][n] * powers[:, n]
            found.append(value)
        return found

    def _length_at(self, u: FloatArray) -> FloatArray:
        own = self._interval(u)
        share = (u - self._knots[own]) / (self._knots[own + 1] - self._knots[own])
        return self._lengths[own] + _run(self._runs[own].T, share)[0]

    def parameter(self, s: FloatArray) -> FloatArray:
        """Length of the path at which the length s (m,) of the curve is run, to rounding."""
        own = np.searchsorted(self._lengths, s, side="right") - 1
        own = np.clip(own, 0, len(self._runs) - 1)
        low, begin = self._lengths[own], self._knots[own]
        runs, wanted = self._runs[own].T, s - low
        share = wanted / (self._lengths[own + 1] - low)
        for _ in range(3):
            run, slope = _run(runs, share)
            share = np.clip(share - (run - wanted) / slope, 0.0, 1.0)
        return begin + share * (self._knots[own + 1] - begin)

    def at_parameters(self, u: FloatArray, order: int = 3) -> list[FloatArray]:
        """Point and derivatives by the length of the curve, each (m, 5), in path space."""
        return by_length(self._polynomials(u, order))

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
