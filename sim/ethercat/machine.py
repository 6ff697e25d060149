# SPDX-License-Identifier: Apache-2.0
"""The robot behind the device on the bus: its law on the ASIP, its plant, its encoders.

Words of a control tick (nios_sw/ethercat/ethercat_tick.h) go both ways. What the pass of tick k
gave is the law's set-point at tick k + 1; what the encoders say at tick k goes to pass k.
Until all axes have power the brakes hold the robot; they close again when one loses it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from asip_asm.assemble import assemble
from asip_asm.project import PACKAGES
from sim.coe.dictionary import Device
from sim.ethercat.device import INPUT_WORDS
from sim.model.kinematics import height2_of
from sim.model.parameters import Robot
from sim.model.plant import Plant
from sim.run.controller import AsipController

AXES = 5
PROGRAM = PACKAGES / "asip_asm/programs/tracking_optimised.s"
INCREMENT = 0x2011
POWER = 0x10000  # TICK_POWER
RATED = 1000.0  # 0.1 % of the greatest force


def increments(device: Device) -> NDArray[np.float64]:
    """Of the five axes (5,) [m, rad]."""
    entries = device.object(INCREMENT).entries[1:]
    return np.array([float(entry.default) for entry in entries])


@dataclass
class Record:
    """N control ticks with power: set-points (N, 15), exact tool (N, 3), table (N, 2)."""

    words: list[NDArray[np.float64]] = field(default_factory=list)
    tool: list[Sequence[float]] = field(default_factory=list)
    table: list[Sequence[float]] = field(default_factory=list)


class Machine:
    """The robot at rest at a pose (5,), brakes closed. `stopped`: it lost its power again."""

    def __init__(self, robot: Robot, device: Device, pose: Sequence[float]) -> None:
        self.robot = robot
        self.increments = increments(device)
        self.plant = Plant(robot, pose[:3], pose[3:])
        image = assemble(PROGRAM, configuration="fast", defines=robot.values())
        self._law = AsipController(image, intermediates=False)
        self._limits = np.array((*[robot.F_max] * 3, robot.tau_max_4, robot.tau_max_5))
        self._forces = np.zeros(AXES)
        self.record = Record()
        self.powered = self.stopped = False

    def measured(self) -> NDArray[np.uint32]:
        """Inputs of a tick: positions by the encoders (14), (15), torques, pose; no fault."""
        joints = [c * q for c, q in zip(self.plant.counts(), self.robot.resolution, strict=True)]
        x, y, z2 = height2_of(self.robot, *joints[:3])
        pose = np.array((x, y, math.sqrt(z2), *joints[3:]))
        words = np.zeros(INPUT_WORDS, np.uint32)
        words[:AXES] = np.rint(pose / self.increments).astype(np.int32).view(np.uint32)
        torques = np.rint(RATED * self._forces / self._limits).astype(np.int16)
        words[AXES : 2 * AXES] = torques.view(np.uint16)
        words[2 * AXES : 3 * AXES] = pose.astype(np.float32).view(np.uint32)
        return words

    def advance(self, outputs: NDArray[np.uint32]) -> None:
        """A control period with these outputs of the pass before. Raises ControllerFault."""
        wanted = outputs.copy()
        power = bool((wanted[4 * AXES : 5 * AXES] & POWER).all())
        words = self.set_points(wanted)
        if power and not self.powered:
            self._law.prime(words, self.plant.counts())
        self.stopped |= self.powered and not power
        self.powered = power
        if not power:
            self._forces = np.zeros(AXES)
            return
        self.record.words.append(words)
        self.record.tool.append(self.plant.tool)
        self.record.table.append(self.plant.table)
        result = self._law.step(words, self.plant.counts())
        self._forces = result.outputs[0].astype(np.float64)
        self.plant.step(self._forces.tolist())

    def set_points(self, outputs: NDArray[np.uint32]) -> NDArray[np.float64]:
        """The law's 15 set-points from the words of a pass: positions, velocities, accelerations
        of the tool, then of the table."""
        whole = outputs[:AXES].view(np.int32).astype(np.float64)
        fraction, velocity, acceleration = (
            outputs[AXES * n : AXES * (n + 1)].view(np.float32).astype(np.float64)
            for n in (1, 2, 3)
        )
        parts = [part * self.increments for part in (whole + fraction, velocity, acceleration)]
        return np.concatenate([part[:3] for part in parts] + [part[3:] for part in parts])
