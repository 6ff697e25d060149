# SPDX-License-Identifier: Apache-2.0
"""Consecutive ticks of a path; ways from rest to its planned motion, and back to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import FloatArray
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.exact_stop import on_number_grid

GENTLE = 0.5  # share of the limits that a transit uses


@dataclass(frozen=True, eq=False)
class Ticks:
    """Set-points of n consecutive ticks. Axes x, y, z, alpha, gamma; SI units.

    position, velocity, acceleration (n, 5) in m or rad and per s, per s^2; move (n,): number of
    the move under way, -1 where none is.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    move: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.position)

    def part(self, begin: int, end: int | None) -> Ticks:
        """The ticks begin to end - 1, None: to the last one."""
        return Ticks(*(getattr(self, name)[begin:end] for name in FIELDS))


FIELDS = ("position", "velocity", "acceleration", "move")


def joined(parts: Sequence[Ticks]) -> Ticks:
    """The parts as one, in an array of its own."""
    return Ticks(*(np.concatenate([getattr(part, name) for part in parts]) for name in FIELDS))


def at_rest(pose: FloatArray, ticks: int, number: int) -> Ticks:
    """A rest at a pose (5,)."""
    rest, zero = np.broadcast_to(pose, (ticks, 5)), np.broadcast_to(0.0, (ticks, 5))
    return Ticks(rest, zero, zero, np.broadcast_to(number, ticks))


def run_in(planned: Ticks, period: float) -> Ticks:
    """From rest at the first of 2 m + 1 ticks up to the motion of the last, which is left out.

    The path of the ticks is run in twice their time: the pace rises from 0 to 1 as
    3 x^2 - 2 x^3, so speed and acceleration are continuous at both ends.
    """
    count = 2 * (len(planned) - 1)
    x = np.arange(count) / count
    place = count * (x**3 - x**4 / 2)  # in ticks of the plan
    pace, change = 3 * x**2 - 2 * x**3, 6 * x * (1 - x) / (count * period)
    own = np.minimum(place.astype(np.int64), len(planned) - 2)
    u = (place - own)[:, None]
    q, v, a = planned.position, planned.velocity, planned.acceleration
    point = _between(q[own], q[own + 1], v[own] * period, v[own + 1] * period, u)
    speed = _between(v[own], v[own + 1], a[own] * period, a[own + 1] * period, u)
    rate = (1 - u) * a[own] + u * a[own + 1]
    return Ticks(
        on_number_grid(point),
        speed * pace[:, None],
        rate * pace[:, None] ** 2 + speed * change[:, None],
        np.full(count, -1),
    )


def run_out(planned: Ticks, period: float) -> Ticks:
    """As run_in, backwards: from the motion of the first tick, which is left out, to rest."""
    turned = Ticks(
        planned.position[::-1], -planned.velocity[::-1], planned.acceleration[::-1], planned.move
    )
    found = run_in(turned, period)
    at_end = at_rest(planned.position[-1], 1, -1)
    back = Ticks(
        found.position[:0:-1], -found.velocity[:0:-1], found.acceleration[:0:-1], found.move[1:]
    )
    return joined([back, at_end])


def _between(
    first: FloatArray, last: FloatArray, rise: FloatArray, rise_last: FloatArray, u: FloatArray
) -> FloatArray:
    """Cubic polynomials at u in 0..1, by their values and slopes at 0 and 1."""
    way = last - first
    return first + u * (
        rise + u * (3 * way - 2 * rise - rise_last + u * (rise + rise_last - 2 * way))
    )


def transit(start: FloatArray, end: FloatArray, limits: MachineLimits, period: float) -> Ticks:
    """A straight line (in five axes) from rest to rest, without its ends, of least jerk.

    The tool's way bounds that of each leg. It takes at most GENTLE of the limits.
    """
    way = end - start
    time = period
    for size, names in (
        (float(np.linalg.norm(way[:3])), ("tool", "leg")),
        (float(np.abs(way[3:]).max()), ("table",)),
    ):
        for bound in (getattr(limits, name) for name in names):
            time = max(
                time,
                1.875 * size / (GENTLE * bound.speed),
                math.sqrt(5.78 * size / (GENTLE * bound.acceleration)),
                math.cbrt(60 * size / (GENTLE * bound.jerk)),
            )
    count = math.ceil(time / period)
    x = (np.arange(1, count) / count)[:, None]
    total = count * period
    return Ticks(
        on_number_grid(start + way * x**3 * (10 - 15 * x + 6 * x**2)),
        way * 30 * x**2 * (1 - x) ** 2 / total,
        way * 60 * x * (1 - x) * (1 - 2 * x) / total**2,
        np.full(count - 1, -1),
    )
