# SPDX-License-Identifier: Apache-2.0
"""Kinematics of the parallel manipulator and of the tilt-rotary table in double precision.

Arrays have the shape (..., 3) for tool positions in m, velocities in m/s, accelerations in m/s^2
and the same of the legs, (..., 2) for table angles (tilt, rotation) in rad; results keep the
leading shape. The functions ending in `_of` take and return separate components, either numpy
arrays or Python floats, with the matching `sqrt`; one tick of the law uses them without numpy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.robot.parameters import Robot

Array = NDArray[np.float64]
Component = Any  # a float or an array of float64


class WorkspaceError(ValueError):
    """A tool position lies outside the workspace, or leg lengths that meet in no point."""


def _where(index: tuple[int, ...]) -> str:
    if not index:
        return ""
    return f" at tick {index[0]}" if len(index) == 1 else f" at index {index}"


def split(values: ArrayLike) -> tuple[Array, Array, Array]:
    """The three components of (..., 3), each (...). Raises ValueError for another shape."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape[-1:] != (3,):
        raise ValueError(f"array has the shape {array.shape}, must be (..., 3)")
    return array[..., 0], array[..., 1], array[..., 2]


def check_workspace(robot: Robot, position: ArrayLike) -> None:
    """Raise WorkspaceError for the first tool position (..., 3) outside the workspace.

    The limits belong to the workspace. The text names coordinate, value, limits and tick index.
    """
    position = np.asarray(position, dtype=np.float64)
    low = np.array((-robot.x_max, -robot.y_max, robot.z_min))
    high = np.array((robot.x_max, robot.y_max, robot.z_max))
    inside = (position >= low) & (position <= high)  # False for NaN
    if not inside.all():
        *index, axis = (int(entry) for entry in np.argwhere(~inside)[0])
        raise WorkspaceError(
            f"{'xyz'[axis]} = {position[(*index, axis)]:.9g} m{_where(tuple(index))}: "
            f"must be within {low[axis]:.9g} .. {high[axis]:.9g} m"
        )


def lengths_of(robot: Robot, x: Component, y: Component, z: Component, sqrt: Callable) -> tuple:
    """Leg lengths of (7)."""
    return tuple(sqrt((x - xp) ** 2 + (y - yp) ** 2 + z * z) for xp, yp in robot.legs)


def velocities_of(robot: Robot, position: tuple, velocity: tuple, lengths: tuple) -> tuple:
    """Leg velocities: (8) with the factors 2 and 1/2 cancelled."""
    x, y, z = position
    vx, vy, vz = velocity
    return tuple(
        ((x - xp) * vx + (y - yp) * vy + z * vz) / length
        for (xp, yp), length in zip(robot.legs, lengths, strict=True)
    )


def accelerations_of(
    robot: Robot,
    position: tuple,
    velocity: tuple,
    acceleration: tuple,
    lengths: tuple,
    leg_velocities: tuple,
) -> tuple:
    """Leg accelerations: (9)-(11) as (v.v + r.a - v_i^2) / l_i."""
    x, y, z = position
    vx, vy, vz = velocity
    ax, ay, az = acceleration
    speed2 = vx * vx + vy * vy + vz * vz
    return tuple(
        (speed2 + (x - xp) * ax + (y - yp) * ay + z * az - speed * speed) / length
        for (xp, yp), length, speed in zip(robot.legs, lengths, leg_velocities, strict=True)
    )


def height2_of(robot: Robot, l1: Component, l2: Component, l3: Component) -> tuple:
    """Tool x and y of (14) and the square of z, the radicand of (15)."""
    q1, q2, q3 = l1 * l1, l2 * l2, l3 * l3
    x = -math.sqrt(3.0) * (q2 - q3) / (6.0 * robot.R)
    y = -(2.0 * q1 - q2 - q3) / (6.0 * robot.R)
    return x, y, q1 - x * x - (y - robot.R) ** 2


def inverse(robot: Robot, position: ArrayLike) -> Array:
    """Leg lengths (..., 3) in m for tool positions (..., 3) in m, (7)."""
    return np.stack(lengths_of(robot, *split(position), np.sqrt), axis=-1)


def inverse_velocity(robot: Robot, position: ArrayLike, velocity: ArrayLike) -> Array:
    """Leg velocities (..., 3) in m/s, (8)."""
    point = split(position)
    lengths = lengths_of(robot, *point, np.sqrt)
    return np.stack(velocities_of(robot, point, split(velocity), lengths), axis=-1)


def inverse_acceleration(
    robot: Robot, position: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike
) -> Array:
    """Leg accelerations (..., 3) in m/s^2, (9)-(11)."""
    point, speed = split(position), split(velocity)
    lengths = lengths_of(robot, *point, np.sqrt)
    leg_speeds = velocities_of(robot, point, speed, lengths)
    return np.stack(
        accelerations_of(robot, point, speed, split(acceleration), lengths, leg_speeds), axis=-1
    )


def forward(robot: Robot, lengths: ArrayLike) -> Array:
    """Tool positions (..., 3) in m for leg lengths (..., 3) in m, (14)-(15), z >= 0.

    Raises WorkspaceError where the three lengths meet in no point.
    """
    x, y, z2 = height2_of(robot, *split(lengths))
    reached = z2 >= 0.0  # False for NaN
    if not np.all(reached):
        index = tuple(int(entry) for entry in np.argwhere(~np.atleast_1d(reached))[0])
        legs = np.asarray(lengths, dtype=np.float64).reshape(*np.shape(np.atleast_1d(z2)), 3)[index]
        raise WorkspaceError(
            f"legs {legs[0]:.9g}, {legs[1]:.9g}, {legs[2]:.9g} m"
            f"{_where(index if np.ndim(z2) else ())}: meet in no point, "
            f"z^2 = {np.atleast_1d(z2)[index]:.9g} m^2 must be >= 0"
        )
    return np.stack((x, y, np.sqrt(z2)), axis=-1)


def table_forward(robot: Robot, theta: ArrayLike) -> tuple[Array, Array]:
    """Centre of the table surface (..., 3) in m, orientation (alpha, beta, gamma) in rad, (17)."""
    theta = np.asarray(theta, dtype=np.float64)
    tilt, rotation = theta[..., 0], theta[..., 1]
    zero = np.zeros_like(tilt)
    point = np.stack((zero, -robot.h * np.sin(tilt), robot.h * np.cos(tilt)), axis=-1)
    return point, np.stack((tilt, zero, rotation), axis=-1)
