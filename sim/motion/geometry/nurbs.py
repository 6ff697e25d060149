# SPDX-License-Identifier: Apache-2.0
"""Plane NURBS: exact points, and chords that miss the curve by no more than a tolerance.

L. Piegl and W. Tiller, The NURBS Book, 2nd edition: the knots are clamped and uniform, 0 (k
times), 1, 2, ..., n - k + 1 (k times) for n control points of order k (degree k - 1), as in
LinuxCNC's G5.2.
Points are blossoms of the curve in homogeneous coordinates (de Boor's algorithm); the blossoms of
one knot span at its ends are its Bezier points, which are halved until the curve, which lies in
their hull, is near enough to its chord (chapter 5.3).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from sim.motion.geometry.curves import FloatArray

MAX_CHORDS = 100_000
MAX_HALVES = 40  # most halvings of a span; then its chords are shorter than rounding


class TooManyChordsError(ValueError):
    """A curve needs more than MAX_CHORDS chords."""


class Nurbs:
    """points: (n, 2); weights: (n,), positive; order: 2 to n. Parameters run from 0 to `end`."""

    def __init__(self, points: Sequence[Sequence[float]], weights: Sequence[float], order: int):
        self.order = order
        weight = np.array(weights, float)[:, None]
        self.homogeneous = np.hstack([np.array(points, float) * weight, weight])
        self.end = len(weight) - order + 1
        inner = np.arange(1, self.end)
        self.knots = np.concatenate([np.zeros(order), inner, np.full(order, self.end)])

    def _blossom(self, span: int, arguments: Sequence[float]) -> FloatArray:
        """Homogeneous point (3,) of the span [span, span + 1] for order - 1 arguments."""
        points = self.homogeneous[span : span + self.order].copy()
        for level, u in enumerate(arguments, start=1):
            for j in range(self.order - 1, level - 1, -1):
                left, right = self.knots[span + j], self.knots[span + j + self.order - level]
                share = (u - left) / (right - left)
                points[j] = (1.0 - share) * points[j - 1] + share * points[j]
        return points[-1]

    def point(self, u: float) -> FloatArray:
        """Point (2,) of the curve at u."""
        span = min(int(u), self.end - 1)
        found = self._blossom(span, [u] * (self.order - 1))
        return found[:2] / found[2]

    def spans(self) -> Iterator[FloatArray]:
        """Bezier points (order, 3) of each knot span, homogeneous."""
        degree = self.order - 1
        for span in range(self.end):
            ends = [[span] * (degree - j) + [span + 1] * j for j in range(self.order)]
            yield np.array([self._blossom(span, arguments) for arguments in ends])

    def chords(self, tolerance: float) -> list[tuple[float, float]]:
        """Ends of chords that the curve leaves by at most the tolerance, without its start.

        Raises TooManyChordsError.
        """
        ends: list[tuple[float, float]] = []
        for bezier in self.spans():
            stack = [(bezier, 0)]
            while stack:
                curve, depth = stack.pop()
                plane = curve[:, :2] / curve[:, 2:]
                if depth == MAX_HALVES or _distance(plane) <= tolerance:
                    ends.append((float(plane[-1, 0]), float(plane[-1, 1])))
                    if len(ends) > MAX_CHORDS:
                        raise TooManyChordsError(f"more than {MAX_CHORDS} chords")
                else:
                    first, second = _halves(curve)
                    stack += [(second, depth + 1), (first, depth + 1)]
        return ends


def _halves(curve: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bezier points of both halves (de Casteljau)."""
    first, second = [curve[0]], [curve[-1]]
    while len(curve) > 1:
        curve = (curve[1:] + curve[:-1]) / 2
        first.append(curve[0])
        second.append(curve[-1])
    return np.array(first), np.array(second[::-1])


def _distance(points: FloatArray) -> float:
    """Greatest distance of points (n, 2) from the line between the first and the last one.

    Where they go back beyond an end of that line, it is the distance from that end.
    """
    start, way = points[0], points[-1] - points[0]
    off = points - start
    square = float(way @ way)
    share = np.clip(off @ way / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
    gaps = off - share[:, None] * way
    return float(np.sqrt(np.max(np.sum(gaps * gaps, axis=1))))
