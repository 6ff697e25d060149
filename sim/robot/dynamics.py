# SPDX-License-Identifier: Apache-2.0
"""Dynamics in the tracking law: reduced masses, gravity of the legs, table. Double precision.

Shapes as in `sim.robot.kinematics`. The functions ending in `_of` take and return separate
components, numpy arrays or Python floats.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sim.robot.kinematics import Array, Component, split
from sim.robot.parameters import Robot


def cosine2_of(robot: Robot, first: Component, second: Component) -> Component:
    """c_ij^2: squared cosine of the angle between two legs of the given lengths."""
    cosine = (first * first + second * second - 3.0 * robot.R**2) / (2.0 * first * second)
    return cosine * cosine


def rotary_mass_of(robot: Robot, length: Component) -> Component:
    """J_j / l_j^2 in kg: inertia of a leg about its base joint, seen at the tool joint."""
    return (robot.J_a + robot.m_s * (length - robot.l_c) ** 2) / (length * length)


def reduced_masses_of(robot: Robot, l1: Component, l2: Component, l3: Component) -> tuple:
    """M_11, M_22, M_33 of (23) in kg."""
    c12, c13, c23 = cosine2_of(robot, l1, l2), cosine2_of(robot, l1, l3), cosine2_of(robot, l2, l3)
    p1, p2, p3 = (rotary_mass_of(robot, length) for length in (l1, l2, l3))
    own, m_s = robot.m_s + robot.m_p, robot.m_s
    return (
        own + m_s * (c12 + c13) + p2 * (1.0 - c12) + p3 * (1.0 - c13),
        own + m_s * (c12 + c23) + p1 * (1.0 - c12) + p3 * (1.0 - c23),
        own + m_s * (c13 + c23) + p1 * (1.0 - c13) + p2 * (1.0 - c23),
    )


def carried_mass_of(robot: Robot, l1: Component, l2: Component, l3: Component) -> Component:
    """m_z of (25) in kg: what the legs carry at the tool axis."""
    return robot.m_p + sum(
        (robot.m_s * (length - robot.l_c) - robot.mr_c) / length for length in (l1, l2, l3)
    )


def gravity_of(robot: Robot, position: tuple, lengths: tuple, m_z: Component) -> tuple:
    """G_1, G_2, G_3 in N: closed form of the system (24)."""
    x, y, z = position
    across = 3.0**0.5 * x
    shares = (1.0 + 2.0 * y / robot.R, 1.0 + (across - y) / robot.R, 1.0 - (across + y) / robot.R)
    weight = m_z * robot.g / (3.0 * z)
    return tuple(length * weight * share for length, share in zip(lengths, shares, strict=True))


def reduced_masses(robot: Robot, lengths: ArrayLike) -> Array:
    """Reduced masses (..., 3) in kg for leg lengths (..., 3) in m, (23)."""
    return np.stack(reduced_masses_of(robot, *split(lengths)), axis=-1)


def carried_mass(robot: Robot, lengths: ArrayLike) -> Array:
    """m_z (...) in kg for leg lengths (..., 3) in m, (25)."""
    return np.asarray(carried_mass_of(robot, *split(lengths)))


def leg_directions(robot: Robot, position: ArrayLike, lengths: ArrayLike) -> Array:
    """Unit vectors (..., 3, 3) from the base to the tool; [..., i, :] is leg i."""
    position, lengths = np.asarray(position, np.float64), np.asarray(lengths, np.float64)
    starts = np.array([(xp, yp, 0.0) for xp, yp in robot.legs])
    return (position[..., None, :] - starts) / lengths[..., :, None]


def gravity_solve(robot: Robot, position: ArrayLike, lengths: ArrayLike) -> Array:
    """Gravity forces of the legs (..., 3) in N from the 3x3 system (24)."""
    columns = np.swapaxes(leg_directions(robot, position, lengths), -1, -2)
    load = np.zeros(columns.shape[:-1])
    load[..., 2] = carried_mass(robot, lengths) * robot.g
    return np.asarray(np.linalg.solve(columns, load[..., None])[..., 0], np.float64)


def gravity(robot: Robot, position: ArrayLike, lengths: ArrayLike) -> Array:
    """Gravity forces of the legs (..., 3) in N in closed form, equal to `gravity_solve`."""
    legs = split(lengths)
    return np.stack(
        gravity_of(robot, split(position), legs, carried_mass_of(robot, *legs)), axis=-1
    )


def table_gravity(robot: Robot, theta: ArrayLike) -> Array:
    """Gravity torques of the table (..., 2) in N m for angles (..., 2) in rad, (27)."""
    theta = np.asarray(theta, dtype=np.float64)
    tilt = robot.r_4 * robot.m_4 * robot.g * np.sin(theta[..., 0])
    return np.stack((tilt, np.zeros_like(tilt)), axis=-1)
