# SPDX-License-Identifier: Apache-2.0
"""Frequency response of the position loops: tracking law, friction in it, averaged inverters.

Tool height and both table angles follow a multisine around home, where every leg does the same.
Twice: `alone` with set-points whose speeds and accelerations are 0, which is the loop itself, and
`fed` with those of the motion, as a path has them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.averaged import AveragedPlant
from sim.bench.drive.chain import ORDER_FILTER
from sim.bench.drive.plant import Plant
from sim.bench.drive.response import NOISE
from sim.bench.drive.whole import FrictionController
from sim.core import closed_loop
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints
from sim.robot.tracking import joint_path

BASE = 2.0  # spacing of the multisine's lines [Hz]
LINES = np.unique(np.round(np.geomspace(1, 150, 30)).astype(int))  # multiples of BASE
SPEEDS = (1e-3, 5e-3, 5e-3)  # amplitude of every line, tool height [m/s], table angles [rad/s]
KIND = "feed-forward"  # of `friction_law`
SHOWN = (0, 3, 4)  # joints: a leg, tilt, rotation


@dataclass(frozen=True)
class PositionLoops:
    """Desired to actual joint at frequencies [Hz], (lines, 3): leg, tilt, rotation."""

    frequency: NDArray[np.float64]
    alone: NDArray[np.complex128]
    fed: NDArray[np.complex128]

    @property
    def bandwidth(self) -> list[float]:
        """Where the loop alone has fallen to -3 dB for good [Hz]; the last line if nowhere."""
        above = np.abs(self.alone) >= np.sqrt(0.5)
        last = [int(np.flatnonzero(column)[-1]) if column.any() else 0 for column in above.T]
        return [float(self.frequency[min(k + 1, len(above) - 1)]) for k in last]


def wobble(robot: Robot) -> SetPoints:
    """Two periods of the motion, which begins with its speed; phases by Schroeder."""
    ticks = 2 * round(1 / (BASE * robot.T_s))
    t, w = robot.T_s * np.arange(ticks), 2 * np.pi * BASE * LINES
    angles = np.outer(t, w) - np.pi * np.arange(len(LINES)) ** 2 / len(LINES)
    speed, acceleration = np.cos(angles).sum(axis=1), (-w * np.sin(angles)).sum(axis=1)
    place = (np.sin(angles) / w).sum(axis=1)
    place -= place[0]
    words = np.zeros((ticks, 15))
    words[:, 0:3], words[:, 9:11] = robot.start[:3], robot.start[3:]
    for at, size in zip((2, 9, 10), SPEEDS, strict=True):
        rate, second = (at + 3, at + 6) if at == 2 else (at + 2, at + 4)
        words[:, at] += size * place
        words[:, rate], words[:, second] = size * speed, size * acceleration
    return SetPoints.from_words(words.astype(np.float32))


def position_loops(robot: Robot, drives: Drives) -> PositionLoops:
    """Both responses. Raises ControllerFault."""
    path = wobble(robot)
    still = {
        name: np.zeros_like(rows)
        for name, rows in vars(path).items()
        if not name.endswith("position")
    }
    alone, fed = (_response(robot, drives, words) for words in (replace(path, **still), path))
    return PositionLoops(LINES * BASE, alone, fed)


def _response(robot: Robot, drives: Drives, path: SetPoints) -> NDArray[np.complex128]:
    """Of the second period."""
    setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
    machine = AveragedPlant(Plant(robot, drives), setting, robot.start, noise=NOISE)
    controller = FrictionController(robot, drives, KIND)
    run = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    desired, half = joint_path(robot, path)[0], len(path) // 2
    found, wanted = (np.fft.fft(joints[half:, SHOWN], axis=0) for joints in (run.joints, desired))
    return found[LINES] / wanted[LINES]
