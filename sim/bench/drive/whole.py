# SPDX-License-Identifier: Apache-2.0
"""Whole paths on the averaged inverters, tracked by the laws with and without friction in them.

The laws run as C with the bits of their programs (`sim.laws.native`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.averaged import AveragedPlant
from sim.bench.drive.chain import ORDER_FILTER
from sim.bench.drive.friction_law import compiled
from sim.bench.drive.plant import AXES, Plant
from sim.bench.drive.response import NOISE
from sim.core import closed_loop
from sim.laws.drive.current_law import Setting
from sim.laws.native.controller import NativeController
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints
from sim.robot.tracking import joint_path

AFTER = 0.05  # of a reversal, in which its error is looked for [s]


class FrictionController(NativeController):
    """A law of `friction_law.KINDS` that believes in a share of the friction."""

    def __init__(self, robot: Robot, drives: Drives, kind: str, share: float = 1.0) -> None:
        super().__init__(compiled(robot, drives, kind, share))

    def estimates(self) -> list[float]:
        """Of the adaptive law, as a share of what it was made with."""
        return [float(self.states[f"share{n}"][0]) for n in range(AXES)]


@dataclass(frozen=True)
class Whole:
    """Errors (N, 5) of the exact joints [m, rad], (N,) of the tool [m]; largest of leg, tool, table
    after 50 ms, and of leg and table within `AFTER` of a reversal."""

    error: NDArray[np.float64]
    tool: NDArray[np.float64]
    tracking: closed_loop.Tracking
    reversal_leg: float
    reversal_table: float


def reversals(robot: Robot, path: SetPoints) -> NDArray[np.bool_]:
    """Ticks (N, 5) within `AFTER` of a change of sign of an axis' desired speed."""
    signs = np.sign(joint_path(robot, path)[1])
    near = np.zeros(signs.shape, dtype=bool)
    ticks = round(AFTER / robot.T_s)
    for n in range(AXES):
        moving = np.flatnonzero(signs[:, n])
        for tick in moving[1:][np.diff(signs[moving, n]) != 0]:
            near[tick : tick + ticks, n] = True
    near[: round(closed_loop.SETTLED_S / robot.T_s)] = False
    return near


def path_of(robot: Robot, ticks: int | None = None, file: Path = AGH) -> SetPoints:
    """Set-points of the A-G-H path or another."""
    return set_points(generate(parse_file(file, robot=robot), MotionSettings(robot)), ticks)


def whole(robot: Robot, drives: Drives, path: SetPoints, kind: str, share: float = 1.0) -> Whole:
    """A path with a friction law that believes in a share of the true friction."""
    setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    machine = AveragedPlant(Plant(robot, drives), setting, at, noise=NOISE)
    controller = FrictionController(robot, drives, kind, share)
    done = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    desired = joint_path(robot, path)[0]
    error, near = desired - done.joints, reversals(robot, path)
    at_reversals = np.where(near, np.abs(error), 0.0)
    return Whole(
        error,
        np.linalg.norm(done.tool - path.position, axis=1),
        closed_loop.tracking_error(robot, path, desired, done),
        float(at_reversals[:, :3].max()),
        float(at_reversals[:, 3:].max()),
    )
