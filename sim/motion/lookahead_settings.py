# SPDX-License-Identifier: Apache-2.0
"""How the look-ahead planner runs moves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sim.model.parameters import Robot
from sim.motion.lookahead_limits import MachineLimits

DEPTH = 256  # moves looked at together, and least depth of the look-ahead


@dataclass(frozen=True)
class LookaheadSettings:
    """How moves are run: period of the set-points [s], machine limits, rapid rate [m/s] (None: that

    of the tool's limit), depth (moves), robot.
    """

    period: float = 100e-6
    limits: MachineLimits = field(default_factory=MachineLimits)
    rapid: float | None = None
    depth: int = DEPTH
    robot: Robot = field(default_factory=Robot.load)

    def __post_init__(self) -> None:
        for name in ("period", "rapid"):
            value = getattr(self, name)
            if value is not None and not (value > 0.0 and math.isfinite(value)):
                raise ValueError(f"{name} = {value!r} is outside its limit: {name} > 0")
        if self.depth < 2:
            raise ValueError(f"depth = {self.depth!r} is outside its limit: depth >= 2")
