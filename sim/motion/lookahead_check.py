# SPDX-License-Identifier: Apache-2.0
"""What a stream of set-points demands of tool, legs and table, by differences of its positions.

Nothing here knows how the set-points were made: the legs come from sim/model/kinematics.py, speeds,
accelerations and jerks are first, second and third differences over the period. A difference is an
average of the derivative, so a motion within its limits has its differences within them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.model.kinematics import inverse
from sim.model.parameters import Robot
from sim.motion.lookahead import Setpoints
from sim.motion.lookahead_limits import MachineLimits

FloatArray = NDArray[np.float64]
QUANTITIES = ("speed", "acceleration", "jerk")
GROUPS = ("tool", "leg", "table")


@dataclass
class Demand:
    """Greatest speed, acceleration and jerk of tool [m], legs [m] and table [rad], per s, s2, s3.

    lines: the line of the text where each occurs.
    """

    greatest: dict[tuple[str, str], float]
    lines: dict[tuple[str, str], int]
    ticks: int = 0

    def ratios(self, limits: MachineLimits) -> dict[tuple[str, str], float]:
        """Greatest values by their limits."""
        return {
            (group, quantity): value / getattr(getattr(limits, group), quantity)
            for (group, quantity), value in self.greatest.items()
        }


def demand(stream: Iterable[Setpoints], robot: Robot, period: float) -> Demand:
    """Greatest differences of a whole stream; period [s]. Rest is assumed before its first tick."""
    result = Demand({(g, q): 0.0 for g in GROUPS for q in QUANTITIES}, {}, 0)
    tail: FloatArray | None = None
    for points in stream:
        result.ticks += len(points)
        before = np.repeat(points.position[:1], 3, axis=0) if tail is None else tail
        q = np.concatenate([before, points.position])
        tail = q[-3:]
        legs = inverse(robot, q[:, :3])
        for group, values in (("tool", q[:, :3]), ("leg", legs), ("table", q[:, 3:])):
            for order, quantity in enumerate(QUANTITIES, start=1):
                change = np.diff(values, order, axis=0)[3 - order :] / period**order
                size = (
                    np.linalg.norm(change, axis=1)
                    if group == "tool"
                    else np.abs(change).max(axis=1)
                )
                worst = int(size.argmax())
                if not size[worst] <= result.greatest[group, quantity]:
                    result.greatest[group, quantity] = float(size[worst])
                    result.lines[group, quantity] = int(points.line[worst])
    return result
