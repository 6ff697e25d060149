# SPDX-License-Identifier: Apache-2.0
"""The drive cases of `drive.py` and the computed-torque law on the robot, in closed loop.

The plant has friction that no controller knows, and a payload error: a heavier platform than the
law's. Each leg gets a drive of its own: P position loop, I-P velocity loop for the leg's reduced
mass at the start, in every control period, with feed-forward of the leg's speed and acceleration.
Its integrator starts with the weight at the start. The table axes keep the computed-torque law in
all cases: their encoders of 18 bits are too coarse for a velocity loop of 160 Hz at 10 kHz.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.bench.cnc.position_loop import Case, Drive, DriveError
from sim.core import closed_loop
from sim.core.controller import LawController, LawTicks, one_tick
from sim.robot.parameters import Robot
from sim.robot.records import Counts, Floats, SetPoints
from sim.robot.tracking import Tracking, joint_path

COMPUTED_TORQUE = "computed torque"
PAYLOAD = 2.0  # kg, a fifth of the platform
LEAD_IN = 0.1  # s of rest before a stroke


def leg_drive(robot: Robot) -> Drive:
    """The drive of a leg, whose loops run once per control period."""
    return Drive(damping=math.sqrt(0.5), cycle=robot.T_s)


class DriveController:
    """Three leg drives with the feed-forward of a case; the law for the table."""

    def __init__(self, robot: Robot, case: Case, drive: Drive | None = None) -> None:
        drive = drive or leg_drive(robot)
        if drive.damping is None:
            raise DriveError("damping = None: the drives of the legs are of second order")
        self._damped = 2.0 * drive.damping * drive.natural
        self._robot, self._law, self._drive = robot, Tracking(robot), drive
        self._k1, self._k2 = case.gains(drive)
        self._mass: tuple[float, ...] = ()
        self._force: list[float] = []

    def prime(self, words: Floats, counts: Counts) -> None:
        """Take mass and weight at the start."""
        start = Tracking(self._robot).step(words, counts)
        self._mass, self._force = tuple(start.mass[:3]), list(start.gravity[:3])

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick."""
        law, robot, drive = self._law.step(words, counts), self._robot, self._drive
        rigid, damped = drive.natural**2, self._damped
        output = list(law.output)
        for leg in range(3):
            word = drive.kp * law.e[leg] + self._k1 * law.velocity_d[leg]
            word += self._k2 * law.acceleration_d[leg]
            speed = law.velocity[leg]
            self._force[leg] += self._mass[leg] * rigid * (word - speed) * robot.T_s
            force = self._force[leg] - self._mass[leg] * damped * speed
            output[leg] = min(max(force, -robot.F_max), robot.F_max)
        return one_tick(output)


@dataclass(frozen=True)
class RobotRun:
    """Leg errors over time (N, 3) [m], forces (N, 3) [N], and the largest errors."""

    leg_error: NDArray[np.float64]
    force: NDArray[np.float64]
    tracking: closed_loop.Tracking


def stroke(robot: Robot, path: SetPoints, first: int, last: int) -> SetPoints:
    """Ticks first .. last - 1 of a path, which rests there, after LEAD_IN at rest."""
    words = path.words()[first:last].copy()
    rest = np.repeat(words[:1], round(LEAD_IN / robot.T_s), axis=0)
    rest[:, 3:9] = rest[:, 11:] = 0.0  # speeds and accelerations of tool and table
    return SetPoints.from_words(np.concatenate((rest, words)))


def simulate(
    robot: Robot,
    path: SetPoints,
    case: Case | None,
    payload: float = PAYLOAD,
    progress: Callable[[int], None] = lambda ticks: None,
) -> RobotRun:
    """A path from rest under a drive case, None: the computed-torque law. payload: error [kg]."""
    plant = dataclasses.replace(robot, m_p=robot.m_p + payload)
    controller: closed_loop.Controller
    controller = LawController(robot) if case is None else DriveController(robot, case)
    recording = closed_loop.run(plant, path, controller, progress)
    desired = joint_path(robot, path)[0]
    return RobotRun(
        leg_error=(desired - recording.joints)[:, :3],
        force=recording.ticks.outputs[:, :3].astype(np.float64),
        tracking=closed_loop.tracking_error(robot, path, desired, recording),
    )
