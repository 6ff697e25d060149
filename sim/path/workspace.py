# SPDX-License-Identifier: Apache-2.0
"""Tool positions that a program may ask for, and the number grid of its set-points."""

from __future__ import annotations

from dataclasses import dataclass

from sim.model.parameters import Robot

# Spacing of binary32 between 0.5 and 1 [m], where the tool's height and the legs' bases are.
GRID = 2.0**-24

# A position outside the workspace by less is on its border: half a step of the grid [m].
WORKSPACE_ROUNDING = GRID / 2


@dataclass(frozen=True)
class Workspace:
    """Tool positions accepted: bounds of x, y, z [m], both included."""

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]

    @classmethod
    def of(cls, robot: Robot) -> Workspace:
        """The workspace of a robot's parameters."""
        return cls(
            (-robot.x_max, -robot.y_max, robot.z_min), (robot.x_max, robot.y_max, robot.z_max)
        )
