# SPDX-License-Identifier: Apache-2.0
"""Poses that a program may ask for, where it starts, and the number grid of its set-points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.moves import Pose
from sim.robot.parameters import Robot

# Spacing of binary32 between 0.5 and 1 [m], where the tool's height and the legs' bases are.
GRID = 2.0**-24

# A position outside the workspace by less is on its border: half a step of the grid [m].
WORKSPACE_ROUNDING = GRID / 2

# The same of an angle of the table, as a share of its limit: a set-point of binary32 is rounded.
ANGLE_ROUNDING = 2.0**-23

NAMES = ("x", "y", "z", "A", "C")
_SHOWN = (*(("mm", 1e3),) * 3, *(("degree", 180 / math.pi),) * 2)


@cache
def default_robot() -> Robot:
    """The robot of `sim/robot.toml`."""
    return Robot.load()


def start_of(robot: Robot) -> Pose:
    """The pose [mm, degree] in which a program starts."""
    x, y, z, tilt, turn = robot.start
    return (x * 1e3, y * 1e3, z * 1e3, math.degrees(tilt), math.degrees(turn))


def pivot_of(robot: Robot) -> tuple[float, float, float]:
    """Where the axes of the table cross [mm]: its surface, h above, has the start's height."""
    return (0.0, 0.0, robot.z_start * 1e3 - robot.h * 1e3)


@dataclass(frozen=True)
class Workspace:
    """Poses accepted: bounds of x, y, z [m], of tilt and rotation [rad], all included."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @classmethod
    def of(cls, robot: Robot) -> Workspace:
        """The workspace of a robot's parameters."""
        return cls(
            (-robot.x_max, -robot.y_max, robot.z_min, robot.tilt_min, robot.rotation_min),
            (robot.x_max, robot.y_max, robot.z_max, robot.tilt_max, robot.rotation_max),
        )

    def outside(self, poses: NDArray[np.float64]) -> tuple[int, int] | None:
        """Row and axis of the first value of poses (n, 5) beyond its bound, if there is one."""
        lower, upper = np.array(self.lower), np.array(self.upper)
        rounding = np.full(5, WORKSPACE_ROUNDING)
        rounding[3:] = ANGLE_ROUNDING * np.maximum(-lower, upper)[3:]
        inside = (poses >= lower - rounding) & (poses <= upper + rounding)  # False for NaN
        if inside.all():
            return None
        row, axis = (int(index) for index in np.argwhere(~inside)[0])
        return row, axis


def shown(axis: int, value: float, form: str = "g") -> str:
    """A position with its unit, as a program has it."""
    unit, scale = _SHOWN[axis]
    return f"{value * scale:{form}} {unit}"
