# SPDX-License-Identifier: Apache-2.0
"""What limits the speed along a path: at every tick the quantity that is nearest its limit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import FloatArray
from sim.motion.lookahead.limits import MachineLimits
from sim.robot.kinematics import inverse_acceleration, inverse_velocity
from sim.robot.parameters import Robot

FEED = "programmed feed"
EXACT_STOP = "times of the S-curve (G61.1)"


class LimitMeter:
    """Reads the ticks of a path in their order, in parts of any size.

    names: the feed, then speed, acceleration and jerk of tool, legs and table axes.
    """

    def __init__(self, robot: Robot, limits: MachineLimits, period: float) -> None:
        self._robot, self._limits, self._period = robot, limits, period
        orders = ("speed", "acceleration", "jerk")[: 3 if limits.jerk_limited else 2]
        self.names = [FEED, *(f"{g} {order}" for g in ("tool", "leg", "table") for order in orders)]
        self._counts = np.zeros(len(self.names) + 1, dtype=np.int64)
        self._before: dict[str, FloatArray] = {}  # last acceleration of each group

    def see(
        self,
        ticks: tuple[FloatArray, FloatArray, FloatArray],
        feed: FloatArray,
        alone: NDArray[np.bool_],
        exact: NDArray[np.bool_],
    ) -> FloatArray:
        """Ratios (names, n) of n more ticks to the limits.

        ticks: position, velocity, acceleration; feed (n,): of the move under way, infinite for a
        rapid one; alone (n,): the table turns alone, so the feed is its; exact (n,): under G61.1.
        """
        position, velocity, acceleration = ticks
        tool, table = velocity[:, :3], velocity[:, 3:]
        legs = inverse_velocity(self._robot, position[:, :3], tool)
        leg_rate = inverse_acceleration(self._robot, position[:, :3], tool, acceleration[:, :3])
        ways = np.where(alone, np.linalg.norm(table, axis=1), np.linalg.norm(tool, axis=1))
        ratios = [ways / feed]
        groups: dict[str, tuple[Callable[..., FloatArray], FloatArray, FloatArray]] = {
            "tool": (np.linalg.norm, tool, acceleration[:, :3]),
            "leg": (np.max, np.abs(legs), np.abs(leg_rate)),
            "table": (np.max, np.abs(table), np.abs(acceleration[:, 3:])),
        }
        for group, (size, speed, rate) in groups.items():
            bound = getattr(self._limits, group)
            ratios += [size(speed, axis=1) / bound.speed, size(rate, axis=1) / bound.acceleration]
            if self._limits.jerk_limited:
                before = self._before.get(group, rate[:1])
                change = np.diff(rate, axis=0, prepend=before) / self._period
                ratios.append(size(np.abs(change), axis=1) / bound.jerk)
                self._before[group] = rate[-1:].copy()
        nearest = np.argmax(ratios, axis=0)
        nearest[exact] = len(self.names)
        moving = velocity.any(axis=1)
        self._counts += np.bincount(nearest[moving], minlength=len(self._counts))
        return np.array(ratios)

    def shares(self) -> dict[str, float]:
        """Share of the moving time that each limit bounds, largest first; the shares add up to 1.

        Under G61.1 the times of the S-curve bound a move. Elsewhere it is the greatest ratio of
        speed, acceleration or jerk of tool, legs or table axes to its limit, or of the speed to the
        feed.
        """
        total = int(self._counts.sum())
        names = [*self.names, EXACT_STOP]
        pairs = zip(names, self._counts.tolist(), strict=True)
        found = {name: count / total for name, count in pairs if count}
        return dict(sorted(found.items(), key=lambda entry: -entry[1]))
