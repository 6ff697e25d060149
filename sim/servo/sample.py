# SPDX-License-Identifier: Apache-2.0
"""A piece of a path twice: every clock of the RTL chain, and with averaged inverters.

Both run the same start-up values, tracking program and plant, from the state that the alignment
leaves, each in closed loop of its own. Averaged inverters take the noise of the modulators: without
it a machine that sticks near a reversal may rest a count aside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.gcode.interpreter import parse_file
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.model.tracking import joint_path
from sim.run import closed_loop
from sim.run.controller import AsipController
from sim.run.nios import set_points
from sim.servo.averaged import AveragedPlant
from sim.servo.chain import ORDER_FILTER
from sim.servo.current_law import Setting
from sim.servo.plant import Plant
from sim.servo.recording import PATH, Recording, recordings, tracking_image
from sim.servo.response import NOISE
from sim.servo.whole import FrictionController, reversals
from sim.trajectory.exact_stop import MotionSettings, generate

SETTLED = 500  # ticks


@dataclass(frozen=True)
class Sample:
    """Ticks of the path of reversals: error (N, 5) of the exact joints [m, rad] on RTL and
    averaged, of the RTL's tool (N,) [m]; ticks (N, 5) near a reversal; the RTL's recording."""

    error: NDArray[np.float64]
    averaged_error: NDArray[np.float64]
    tool: NDArray[np.float64]
    near: NDArray[np.bool_]
    rtl: Recording

    @property
    def difference(self) -> NDArray[np.float64]:
        """Largest distance of the joints, RTL against averaged, behind the first 50 ms (5,)."""
        return np.abs(self.error - self.averaged_error)[SETTLED:].max(axis=0, initial=0.0)

    @property
    def largest(self) -> NDArray[np.float64]:
        """Of the errors behind the first 50 ms (5,)."""
        return np.abs(self.error)[SETTLED:].max(axis=0, initial=0.0)

    @property
    def at_reversals(self) -> NDArray[np.float64]:
        """Of the errors near a reversal (5,), 0 without one."""
        return np.where(self.near, np.abs(self.error), 0.0).max(axis=0)


def sample(robot: Robot, drives: Drives, kind: str, rtl: Recording) -> Sample:
    """A recording of a law of `KINDS` beside averaged inverters. Raises ControllerFault."""
    path = set_points(generate(parse_file(PATH), MotionSettings(robot)), len(rtl.joints))
    desired = joint_path(robot, path)[0]
    setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    machine = AveragedPlant(Plant(robot, drives), setting, at, rtl.angles, rtl.zeros, NOISE)
    machine.put(*rtl.first)
    controller = (
        AsipController(tracking_image(robot, drives, kind), intermediates=False)
        if kind == "none"
        else FrictionController(robot, drives, kind)
    )
    averaged = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    return Sample(
        desired - rtl.joints,
        desired - averaged.joints,
        np.linalg.norm(rtl.tool - path.position, axis=1),
        reversals(robot, path),
        rtl,
    )


def samples(
    robot: Robot, drives: Drives, ticks: int, kinds: Sequence[str], jobs: int = 2
) -> dict[str, Sample]:
    """A sample for each kind; recordings are kept. Raises ControllerFault, StartUpError."""
    found = recordings(robot, drives, ticks, kinds, jobs)
    return {kind: sample(robot, drives, kind, rtl) for kind, rtl in found.items()}
