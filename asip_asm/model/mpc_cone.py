# SPDX-License-Identifier: Apache-2.0
"""Second-order cone of inputs: |norm inputs| <= limit + slope * axis, cut by the box of the axis.

The projection onto a cone that a slab cuts takes two steps. The axis goes to its coordinate of the
projection onto the cone alone and is limited to the slab; then the norm is limited to the radius
there. That is exact: where the slab cuts, the nearest point lies in its face, and a face is a disc.
With e = |norm| - limit - slope * axis, an axis moves by e+ slope / (1 + slope^2) in the plane of
norm and axis (Boyd and Vandenberghe, Convex Optimization, section 8.1: projections). Both are
meant in the metric of the penalties.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
TINY = 2.0**-60
"""Least divisor. Below it a norm is limited to the radius within this distance, also where the
squares of its parts underflow.
"""
UNIT = 2.0**-24


@dataclass(frozen=True)
class Cone:
    """norm: inputs under the norm. axis: input on the right side, None for a ball of radius
    `limit`. low, high: of the axis, the apex counted. All numbers have the units of the inputs.
    """

    norm: tuple[int, ...]
    axis: int | None
    slope: float
    limit: float
    low: float = 0.0
    high: float = 0.0

    @property
    def inputs(self) -> tuple[int, ...]:
        """All inputs of the constraint."""
        return self.norm if self.axis is None else (*self.norm, self.axis)

    @property
    def radius(self) -> float:
        """Largest norm."""
        return self.limit + self.slope * self.high

    def share(self, rho: Real) -> float:
        """Part of the excess by which the axis moves, with penalties (m,) of the inputs."""
        if self.axis is None:
            return 0.0
        norm, axis = float(rho[self.norm[0]]), float(rho[self.axis])
        return self.slope * norm / (axis + self.slope**2 * norm)

    def limited(self, u: Real, rho: Real) -> Real:
        """Inputs (..., m) with those of the cone projected onto it."""
        found = u.copy()
        norm = list(self.norm)
        size = np.sqrt((u[..., norm] ** 2).sum(axis=-1))
        radius = np.full_like(size, self.limit)
        if self.axis is not None:
            excess = np.maximum(size - self.limit - self.slope * u[..., self.axis], 0.0)
            moved = u[..., self.axis] + self.share(rho) * excess
            found[..., self.axis] = np.clip(moved, self.low, self.high)
            radius = self.limit + self.slope * found[..., self.axis]
        scale = radius / np.maximum(np.maximum(size, radius), TINY)
        found[..., norm] = scale[..., None] * u[..., norm]
        return found

    def beyond(self, u: Real) -> Real:
        """Excess of the norm over its limit by the largest radius, of inputs (..., m); 0 inside."""
        size = np.sqrt((u[..., list(self.norm)] ** 2).sum(axis=-1))
        radius = self.limit + (0.0 if self.axis is None else self.slope * u[..., self.axis])
        return np.maximum(size - radius, 0.0) / self.radius

    def roundings(self, size: Real, rho: Real) -> Real:
        """Largest distance of a computed projection from the exact one, of each input (..., m),
        for inputs of these sizes: a running error analysis of the operations of the program.
        """
        error, parts = np.zeros_like(size), len(self.norm)
        norm = np.sqrt((size[..., list(self.norm)] ** 2).sum(axis=-1))
        limit = abs(self.limit)
        # The sum of squares has `parts` roundings, of which the root takes half, and its own.
        root = (parts / 2 + 1.01) * UNIT
        radius = 2 * UNIT * limit
        if self.axis is not None:
            axis, slope, share = size[..., self.axis], self.slope, self.share(rho)
            # A constant that is rounded, and the operation: three roundings of a product.
            right = limit + slope * axis
            excess = norm + right
            e_excess = root * norm + 3.1 * UNIT * right + UNIT * excess
            end = max(abs(self.low), abs(self.high))
            e_axis = share * e_excess + UNIT * (axis + 3.1 * share * excess + end)
            error[..., self.axis] = e_axis
            radius = slope * e_axis + 3.1 * UNIT * (limit + slope * end)
        # The divisor has the root's error, quotient and product one each.
        whole = radius + (root + 2.1 * UNIT) * self.radius + TINY
        error[..., list(self.norm)] = np.asarray(whole)[..., None]
        return error
