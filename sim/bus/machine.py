# SPDX-License-Identifier: Apache-2.0
"""The robot that the device on the bus drives: its law on the ASIP, its plant, its encoders.

Words of a control tick (nios_sw/ethercat/ethercat_tick.h) go both ways. What the pass of tick k
gave is the law's set-point at tick k + 1; what the encoders say at tick k goes to pass k.
Until all axes have power the brakes hold the robot; they close again when one loses it.

A torque adds to the law's force along its axis. An axis in torque-only has the torque alone: the
law gets its measured place and speed as set-point, so that it has no error there, its integrator
stays where it is, and the other axes are followed as before. Back from torque-only the integrator
goes on from there. Without gravity of the law, z and tilt fall at torque 0, as such drives do.
A gain that comes as a setting goes into the law's words before the next tick.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from asip_asm.assemble import assemble
from asip_asm.project import ROOT
from sim.bus.coe.dictionary import Device
from sim.bus.device import INPUT_WORDS
from sim.bus.forces import PER_RATED, along_axes, with_torques
from sim.bus.gains import GainError, Gains
from sim.bus.switches import Switches
from sim.core.controller import AsipController
from sim.robot.kinematics import height2_of
from sim.robot.parameters import Robot
from sim.robot.plant import Plant

AXES = 5
PROGRAM = ROOT / "asip_asm/programs/tracking_optimised.s"
INCREMENT = 0x2011
POWER, TORQUE_ONLY = 0x10000, 0x20000  # TICK_POWER, TICK_TORQUE_ONLY
FLAGS = slice(4 * AXES, 5 * AXES)
INDEX = slice(3 * AXES + 2, 4 * AXES + 2)  # positions
SWITCHES = 8  # TICK_SWITCHES
SETTING = slice(5 * AXES + 1, 5 * AXES + 4)  # number, place, value


def increments(device: Device) -> NDArray[np.float64]:
    """Of the five axes (5,) [m, rad]."""
    entries = device.object(INCREMENT).entries[1:]
    return np.array([float(entry.default) for entry in entries])


class Machine:
    """The robot at rest at a pose (5,), brakes closed. `stopped`: it lost its power again.

    switches: of axes by their number; an axis without has none that is ever on, and no index.
    places: exact tool and table (5,) in each control tick with power;
    refused: gains that the law could not take, by what was wrong.
    """

    def __init__(
        self,
        robot: Robot,
        device: Device,
        pose: Sequence[float],
        switches: Mapping[int, Switches] | None = None,
    ) -> None:
        self.robot = robot
        self.switches = switches or {}
        self.increments = increments(device)
        self.plant = Plant(robot, pose[:3], pose[3:])
        image = assemble(PROGRAM, configuration="fast", defines=robot.values())
        self._law = AsipController(image, intermediates=False)
        self._gains = Gains(PROGRAM, image, robot.values())
        self._setting = 0  # number of the last one
        self._rated = np.array(robot.output_max)
        self._forces = np.zeros(AXES)
        self._pose = self._pose_before = self.pose()
        self.places: list[tuple[float, ...]] = []
        self.refused: list[str] = []
        self.powered = self.stopped = False

    def pose(self) -> NDArray[np.float64]:
        """Measured, (5,): tool by (14), (15) [m], table [rad]."""
        joints = [c * q for c, q in zip(self.plant.counts(), self.robot.resolution, strict=True)]
        x, y, z2 = height2_of(self.robot, *joints[:3])
        return np.array((x, y, math.sqrt(z2), *joints[3:]))

    def measured(self) -> NDArray[np.uint32]:
        """Inputs of a tick: positions by the encoders, torques along the axes, pose, switches and
        indices; no fault, no age of an edge."""
        pose = self.pose()
        words = np.zeros(INPUT_WORDS, np.uint32)
        words[:AXES] = np.rint(pose / self.increments).astype(np.int32).view(np.uint32)
        forces = along_axes(self.robot, pose[:3], self._forces)
        torques = np.rint(PER_RATED * forces / self._rated).astype(np.int16)
        words[AXES : 2 * AXES] = torques.view(np.uint16)
        words[2 * AXES : 3 * AXES] = pose.astype(np.float32).view(np.uint32)
        for n, switches in self.switches.items():
            position = int(words[:AXES].view(np.int32)[n])
            switches.move(position)
            words[3 * AXES] |= np.uint32(switches.word(position) << SWITCHES + 3 * n)
            words[3 * AXES + 1] |= np.uint32(switches.count << 6 * n)
            words[INDEX].view(np.int32)[n] = switches.index
        return words

    def advance(self, outputs: NDArray[np.uint32]) -> None:
        """A control period with these outputs of the pass before. Raises ControllerFault."""
        flags = outputs[FLAGS]
        power = bool((flags & POWER).all())
        self._take_setting(outputs[SETTING])
        alone = (flags & TORQUE_ONLY).astype(bool)
        self._pose_before, self._pose = self._pose, self.pose()
        words = self.set_points(outputs, alone)
        if power and not self.powered:
            self._law.prime(words, self.plant.counts())
        self.stopped |= self.powered and not power
        self.powered = power
        if not power:
            self._forces = np.zeros(AXES)
            return
        self.places.append((*self.plant.tool, *self.plant.table))
        result = self._law.step(words, self.plant.counts())
        law = result.outputs[0].astype(np.float64)
        torques = flags.astype(np.uint16).view(np.int16).astype(np.float64)
        self._forces = with_torques(self.robot, self._pose[:3], law, torques, alone)
        self.plant.step(self._forces.tolist())

    def _take_setting(self, words: NDArray[np.uint32]) -> None:
        """A changed gain to the law, once for each number."""
        number, place = int(words[0]), int(words[1])
        if number in (0, self._setting):
            return
        self._setting = number
        value = float(words[2:].view(np.float32)[0])
        try:
            changed = self._gains.change(place >> 8, place & 0xFF, value)
        except GainError as error:
            self.refused.append(str(error))
            return
        for index, word in changed.items():
            self._law.core.write(f"k{index}", word)

    def set_points(
        self, outputs: NDArray[np.uint32], alone: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """The law's 15 set-points from the words of a pass: positions, velocities, accelerations
        of the tool, then of the table. What is measured, for axes whose torque is `alone`."""
        whole = outputs[:AXES].view(np.int32).astype(np.float64)
        fraction, velocity, acceleration = (
            outputs[AXES * n : AXES * (n + 1)].view(np.float32).astype(np.float64)
            for n in (1, 2, 3)
        )
        parts = [part * self.increments for part in (whole + fraction, velocity, acceleration)]
        speed = (self._pose - self._pose_before) / self.robot.T_s
        measured = (self._pose, speed, np.zeros(AXES))
        parts = [np.where(alone, *pair) for pair in zip(measured, parts, strict=True)]
        return np.concatenate([part[:3] for part in parts] + [part[3:] for part in parts])
