# SPDX-License-Identifier: Apache-2.0
"""Short motion with reversals for the tests of the tracking programs."""

from __future__ import annotations

import numpy as np

from sim.robot import kinematics
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints


def _harmonic(t: np.ndarray, amplitude: float, hertz: float, phase: float) -> np.ndarray:
    """Position, velocity, acceleration (3, N) of a harmonic motion."""
    rate = 2.0 * np.pi * hertz
    angle = rate * t + phase
    return amplitude * np.stack((np.sin(angle), rate * np.cos(angle), -rate * rate * np.sin(angle)))


def reversing_path(robot: Robot, ticks: int) -> tuple[SetPoints, np.ndarray]:
    """60 mm circle at 2 m/min with a vertical 30 Hz shake of 0.25 mm, table at 12 and 5 Hz.

    The shake is faster than the circle: every leg reverses. Set-points are single floats held as
    doubles, so rounding of the inputs is no error of a program. Counts: the joint path minus
    following errors of up to 3 um and 0.08 mrad, rounded. A reversal boosts the integration for
    200 ticks, so 600 ticks show all its parts, with errors above and below the threshold.
    """
    t = np.arange(ticks) * robot.T_s
    circle = 2.0 / 60.0 / (2.0 * np.pi * 0.030)
    x = _harmonic(t, 0.030, circle, 0.4)
    y = _harmonic(t, 0.030, circle, 0.4 - np.pi / 2.0)
    z = _harmonic(t, 0.25e-3, 30.0, 0.2)
    z[0] += 0.6
    alpha = _harmonic(t, 5e-3, 12.0, 0.7)
    alpha[0] += 0.3
    gamma = _harmonic(t, 20e-3, 5.0, 1.2)
    tool, table = np.stack((x, y, z), axis=-1), np.stack((alpha, gamma), axis=-1)
    words = np.concatenate((*tool, *table), axis=1).astype(np.float32).astype(np.float64)
    path = SetPoints.from_words(words)
    joints = np.concatenate((kinematics.inverse(robot, path.position), path.table_position), 1)
    error = np.stack([np.sin(2.0 * np.pi * (22 + 7 * i) * t + i) for i in range(5)], axis=1)
    error *= np.array((3e-6, 3e-6, 3e-6, 8e-5, 8e-5))
    return path, np.rint((joints - error) / np.array(robot.resolution)).astype(np.int64)
