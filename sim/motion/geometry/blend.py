# SPDX-License-Identifier: Apache-2.0
"""Blends between neighbouring curves of the five-axis path: quintic Bezier curves, many at a time.

Path space: (x, y, z, w alpha, w gamma) [m], w = `TABLE_RADIUS`, so a turn of the table counts as
the way of a point at that distance from its axis. All curves are measured by their length in it.

A blend leaves the first curve at a distance d before the joint and meets the second one at the same
distance after it, with equal point, direction and curvature at both ends, so the acceleration
along the path is continuous. Between two lines the control points p0 p1 p2 and p3 p4 p5 lie on
the lines at d, (1 - a) d and (1 - b) d from the corner; a and b, in `SHAPE`, are those that a
search found to give the least time of zigzags (lines of 15 and 1.5 mm, P of 0.02 to 0.2 mm) at
4.8 m/s2 and 1000 m/s3. Next to an arc p2 (p3) is moved by 5/4 k (a d)^2, which gives the Bezier
curve the curvature vector k there.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import FloatArray

TABLE_RADIUS = 0.1  # m per rad
SCALE = np.array([1.0, 1.0, 1.0, TABLE_RADIUS, TABLE_RADIUS])

# Angle between the curves [degree], a, b.
SHAPE = np.array(
    [
        (0, 0.410, 0.815),
        (15, 0.410, 0.815),
        (30, 0.406, 0.810),
        (45, 0.400, 0.799),
        (60, 0.397, 0.776),
        (75, 0.400, 0.737),
        (90, 0.390, 0.690),
        (105, 0.365, 0.635),
        (120, 0.326, 0.567),
        (135, 0.266, 0.476),
        (150, 0.197, 0.360),
        (165, 0.109, 0.211),
        (175, 0.039, 0.079),
    ]
)
NODES = 17  # parameters at which the length run is known, equally spaced
PARAMETERS = np.linspace(0.0, 1.0, NODES)
EXAMINED = np.linspace(0.0, 1.0, 33)  # parameters at which the derivatives are examined
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_GAUSS, _WEIGHTS = (_GAUSS + 1) / 2, _WEIGHTS / 2


def _power_matrix(degree: int) -> FloatArray:
    """Rows: coefficients of u^0, u^1, ... from the control points of a Bezier curve."""
    matrix = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for k in range(degree - i + 1):
            matrix[i + k, i] = comb(degree, i) * comb(degree - i, k) * (-1) ** k
    return matrix


_POWERS = _power_matrix(5)


def shape(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The numbers a and b for angles between the curves [rad]."""
    degree = np.degrees(angle)
    return np.interp(degree, SHAPE[:, 0], SHAPE[:, 1]), np.interp(degree, SHAPE[:, 0], SHAPE[:, 2])


def control_points(
    points: tuple[FloatArray, FloatArray],
    directions: tuple[FloatArray, FloatArray],
    bends: tuple[FloatArray, FloatArray],
    distance: FloatArray,
    angle: FloatArray,
) -> FloatArray:
    """(n, 6, 5) from both ends' points, unit directions and curvature vectors, each (n, 5) [m].

    distance (n,) of the ends from the joint, along the curves; angle (n,) at the joint [rad].
    """
    a, b = shape(angle)
    first, second = (a * distance)[:, None], (b * distance)[:, None]
    (p0, p5), (t0, t5), (k0, k5) = points, directions, bends
    bow = 1.25 * first**2
    return np.stack(
        [
            p0,
            p0 + first * t0,
            p0 + second * t0 + bow * k0,
            p5 - second * t5 + bow * k5,
            p5 - first * t5,
            p5,
        ],
        axis=1,
    )


class Blends:
    """n blends by their control points (n, 6, 5) in path space [m].

    length (n,) [m]; nodes (n, NODES): length run at PARAMETERS.
    """

    def __init__(self, points: FloatArray) -> None:
        # Coefficients about the first point, so that small blends keep their digits far away.
        self.origin = points[:, 0]
        self.coefficients = np.einsum("ki,nid->nkd", _POWERS, points - points[:, :1])
        inner = (PARAMETERS[:-1, None] + _GAUSS / (NODES - 1)).ravel()
        speeds = self._speed(np.arange(len(points)).repeat(len(inner)), np.tile(inner, len(points)))
        parts = speeds.reshape(len(points), NODES - 1, -1) @ _WEIGHTS / (NODES - 1)
        self.nodes = np.concatenate([np.zeros((len(points), 1)), np.cumsum(parts, axis=1)], axis=1)
        self.length = self.nodes[:, -1]

    def __len__(self) -> int:
        return len(self.origin)

    def _derivatives(self, which: NDArray[np.int64], u: FloatArray, order: int) -> list[FloatArray]:
        """The curve (from its first point) and its derivatives by the parameter, each (m, 5)."""
        c = self.coefficients[which]
        results = []
        factors = np.ones(6)
        for k in range(order + 1):
            powers = np.zeros((len(u), 6))
            power = np.ones_like(u)
            for degree in range(k, 6):
                powers[:, degree] = factors[degree] * power
                power = power * u
            results.append(np.einsum("mk,mkd->md", powers, c))
            factors = factors * np.maximum(np.arange(6) - k, 0)
        return results

    def _speed(self, which: NDArray[np.int64], u: FloatArray) -> FloatArray:
        return np.linalg.norm(self._derivatives(which, u, 1)[1], axis=1)

    def at_parameters(
        self, which: NDArray[np.int64], u: FloatArray, order: int = 3
    ) -> list[FloatArray]:
        """Point and derivatives by the length, up to `order`, each (m, 5) in path space."""
        derivatives = self._derivatives(which, u, order)
        derivatives[0] = derivatives[0] + self.origin[which]
        return by_length(derivatives)

    def parameter(self, which: NDArray[np.int64], s: FloatArray) -> FloatArray:
        """Parameter at which the length s (m,) is run: Newton from the nodes, to rounding."""
        nodes = self.nodes[which]
        cell = np.clip((nodes <= s[:, None]).sum(axis=1) - 1, 0, NODES - 2)
        row = np.arange(len(s))
        low, high = nodes[row, cell], nodes[row, cell + 1]
        begin = PARAMETERS[cell]
        u = begin + (s - low) / np.maximum(high - low, 1e-300) / (NODES - 1)
        for _ in range(3):
            at = begin[:, None] + (u - begin)[:, None] * _GAUSS
            speeds = self._speed(which.repeat(len(_GAUSS)), at.ravel()).reshape(at.shape)
            run = low + (speeds @ _WEIGHTS) * (u - begin)
            u = np.clip(u - (run - s) / np.maximum(self._speed(which, u), 1e-300), 0.0, 1.0)
        return u

    def at(self, which: NDArray[np.int64], s: FloatArray, order: int = 2) -> list[FloatArray]:
        """Point and derivatives by the length at the lengths s (m,) of the blends `which` (m,)."""
        return self.at_parameters(which, self.parameter(which, s), order)


def by_length(derivatives: list[FloatArray]) -> list[FloatArray]:
    """Derivatives by the length from those by the parameter (chain rule)."""
    point, d1 = derivatives[:2]
    rate = 1.0 / np.maximum(np.linalg.norm(d1, axis=1), 1e-300)[:, None]  # du/ds
    results = [point, d1 * rate]
    if len(derivatives) > 2:
        d2 = derivatives[2]
        rate2 = -(rate**4) * np.sum(d1 * d2, axis=1, keepdims=True)
        results.append(d2 * rate**2 + d1 * rate2)
    if len(derivatives) > 3:
        d3 = derivatives[3]
        dot = np.sum(d1 * d2, axis=1, keepdims=True)
        slope = np.sum(d2 * d2 + d1 * d3, axis=1, keepdims=True)
        # d/ds of -rate^4 dot, with d rate/ds = rate2
        rate3 = -4 * rate**3 * rate2 * dot - rate**5 * slope
        results.append(d3 * rate**3 + 3 * d2 * rate * rate2 + d1 * rate3)
    return results
