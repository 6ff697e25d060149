# SPDX-License-Identifier: Apache-2.0
"""Forces of the legs and along the axes of the device: x, y, z of the tool, tilt, rotation.

By virtual work a force f on the tool and forces F of the legs are equal if f = sum of w_j F_j, with
the legs' directions w_j of (24). A torque of an axis is in 0.1 % of the greatest one: of a leg's
F_max for x, y and z, of tau_max_4 and tau_max_5 for the table.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.robot.parameters import Robot
from sim.robot.records import Floats

PER_RATED = 1000.0  # 0.1 %
TOOL = 3


def directions(robot: Robot, tool: Floats) -> NDArray[np.float64]:
    """Columns (3, 3): unit vectors from the legs' start points to the tool (3,) [m]."""
    starts = np.array([(*leg, 0.0) for leg in robot.legs])
    legs = np.asarray(tool, float) - starts
    return (legs / np.linalg.norm(legs, axis=1, keepdims=True)).T


def along_axes(robot: Robot, tool: Floats, outputs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the five axes [N, N m], from the law's outputs (5,)."""
    return np.concatenate((directions(robot, tool) @ outputs[:TOOL], outputs[TOOL:]))


def with_torques(
    robot: Robot,
    tool: Floats,
    outputs: NDArray[np.float64],
    torques: NDArray[np.float64],
    alone: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """The law's outputs (5,) with torques [0.1 %] of the axes added, or in the law's place where
    `alone`; within the greatest forces."""
    if not torques.any() and not alone.any():
        return outputs
    own = np.where(alone, 0.0, along_axes(robot, tool, outputs))
    limits = np.array(robot.output_max)
    axes = own + torques / PER_RATED * limits
    legs = np.linalg.solve(directions(robot, tool), axes[:TOOL])
    return np.clip(np.concatenate((legs, axes[TOOL:])), -limits, limits)
