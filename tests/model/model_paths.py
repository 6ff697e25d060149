# SPDX-License-Identifier: Apache-2.0
"""Motion for the tests of the model."""

from __future__ import annotations

import numpy as np

from sim.robot.parameters import Robot
from sim.robot.records import SetPoints


def travel(t: np.ndarray, distance: float, feed: float, ramp: float) -> tuple[np.ndarray, ...]:
    """Distance, speed, acceleration along a path: ramps of fifth order, constant feed between."""

    def one(since: np.ndarray) -> tuple[np.ndarray, ...]:
        u = np.clip(since / ramp, 0.0, 1.0)
        return (
            feed * (ramp * (2.5 * u**4 - 3.0 * u**5 + u**6) + np.maximum(since - ramp, 0.0)),
            feed * (10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5),
            feed * (30.0 * u**2 - 60.0 * u**3 + 30.0 * u**4) / ramp,
        )

    return tuple(a - b for a, b in zip(one(t), one(t - distance / feed), strict=True))


def circle(robot: Robot, radius: float, feed: float, ramp: float, table: tuple) -> SetPoints:
    """One horizontal circle about (0, 0, 0.6) m while the table turns by `table` in rad.

    radius in m, feed in m/s, ramp: time of the smooth start and stop in s.
    """
    distance = 2.0 * np.pi * radius
    ticks = round((distance / feed + ramp + 0.1) / robot.T_s)
    s, v, a = travel(np.arange(ticks) * robot.T_s, distance, feed, ramp)
    angle, rate, change = s / radius, v / radius, a / radius
    cos, sin, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    share = np.array(table) / (2.0 * np.pi)
    return SetPoints(
        position=np.stack((radius * cos, radius * sin, zero + 0.6), axis=1),
        velocity=np.stack((-v * sin, v * cos, zero), axis=1),
        acceleration=np.stack((-a * sin - v * rate * cos, a * cos - v * rate * sin, zero), axis=1),
        table_position=angle[:, None] * share,
        table_velocity=rate[:, None] * share,
        table_acceleration=change[:, None] * share,
    )


def workspace_points(robot: Robot, count: int, seed: int) -> np.ndarray:
    """Random tool positions (count, 3) in the workspace, its eight corners first."""
    low = np.array((-robot.x_max, -robot.y_max, robot.z_min))
    high = np.array((robot.x_max, robot.y_max, robot.z_max))
    corners = np.array(np.meshgrid(*np.stack((low, high), axis=1))).reshape(3, -1).T
    return np.concatenate((corners, np.random.default_rng(seed).uniform(low, high, (count, 3))))
