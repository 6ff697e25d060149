# SPDX-License-Identifier: Apache-2.0
"""How the look-ahead planner runs moves."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.motion.geometry.curves import check_positive
from sim.motion.lookahead.limits import MachineLimits
from sim.robot.parameters import Robot

OF_ROBOT = object.__new__(MachineLimits)
"""In place of limits: those of the robot."""
DEPTH = 256  # moves looked at together, and least depth of the look-ahead


@dataclass(frozen=True)
class LookaheadSettings:
    """How moves are run: machine limits (None: those of the robot), rapid rate [m/s] (None: that

    of the tool's limit), depth (moves), robot. only_blends: every corner that P lets round is
    a blend, also where a turn or a stop would be faster; for the figures of blends.
    """

    limits: MachineLimits = OF_ROBOT
    rapid: float | None = None
    depth: int = DEPTH
    robot: Robot = field(default_factory=Robot.load)
    only_blends: bool = False

    @property
    def period(self) -> float:
        """Control period of the robot, that of the set-points [s]."""
        return self.robot.T_s

    def __post_init__(self) -> None:
        if self.limits is OF_ROBOT:
            object.__setattr__(self, "limits", MachineLimits.of(self.robot))
        if self.rapid is not None:
            check_positive(rapid=self.rapid)
        if self.depth < 2:
            raise ValueError(f"depth = {self.depth!r} is outside its limit: depth >= 2")
