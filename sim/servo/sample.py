# SPDX-License-Identifier: Apache-2.0
"""A piece of a path twice: every clock of the RTL chain, and with averaged inverters.

Both run the same start-up values, tracking program and plant, each in closed loop of its own.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.dual.moves import moves_of
from sim.dual.system import program
from sim.gcode.interpreter import parse_file
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.model.tracking import joint_path
from sim.run import closed_loop
from sim.run.controller import AsipController
from sim.run.nios import set_points
from sim.servo.averaged import AveragedPlant
from sim.servo.path import Chain, Run
from sim.servo.plant import Plant
from sim.trajectory.exact_stop import MotionSettings, generate

PATH = Path(__file__).resolve().parents[1] / "paths/reversals.ngc"


@dataclass(frozen=True)
class Sample:
    """Ticks of the path: error (N, 5) of the exact joints [m, rad] on RTL and averaged, the RTL's
    run; clocks simulated and processor time for them [s]; edges with both gates of a phase on."""

    error: NDArray[np.float64]
    averaged_error: NDArray[np.float64]
    run: Run
    clocks: int
    seconds: float
    shoot_through: int

    @property
    def difference(self) -> NDArray[np.float64]:
        """Largest distance of the joints, RTL against averaged, behind the first 50 ms (5,)."""
        return np.abs(self.error - self.averaged_error)[500:].max(axis=0, initial=0.0)


def sample(
    robot: Robot, drives: Drives, ticks: int, progress: Callable[[int], None] = lambda ticks: None
) -> Sample:
    """The first ticks of the path of reversals. Raises ControllerFault."""
    settings = MotionSettings(robot)
    trajectory = generate(parse_file(PATH), settings)
    path = set_points(trajectory, ticks)
    desired = joint_path(robot, path)[0]
    plant = Plant(robot, drives)
    chain = Chain(plant, path, moves_of(trajectory, settings))
    begin = time.process_time()
    chain.begin()
    before = chain.system.clocks
    run = chain.advance(ticks, progress)
    seconds = time.process_time() - begin
    machine = AveragedPlant(plant, chain.setting, chain.at, chain.angles, chain.zeros)
    controller = AsipController(program("tracking_optimised", "fast", robot), intermediates=False)
    other = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    return Sample(
        desired - run.joints,
        desired - other.joints,
        run,
        chain.system.clocks - before,
        seconds,
        chain.system.look().shoot_through,
    )
