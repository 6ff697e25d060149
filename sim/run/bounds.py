# SPDX-License-Identifier: Apache-2.0
"""Error bounds of the tracking programs, derived from the roundings that they make.

First-order rounding analysis with the unit roundoff u = 2^-24, evaluated at every tick from the
reference's own quantities. The reference sees the same binary32 set-points and counts as the
program, so the bounds are about arithmetic alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.model.parameters import Robot
from sim.model.records import SetPoints, TrackingResult

U = 2.0**-24


@dataclass(frozen=True)
class Bounds:
    """Error bounds of one program (N, axes): position, velocity, acceleration, e, output."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    e: np.ndarray
    output: np.ndarray


def bounds(robot: Robot, path: SetPoints, reference: TrackingResult, optimised: bool) -> Bounds:
    """First-order bounds on the rounding errors of one program.

    Legs, with d = (x - x_pi, y - y_pi, z): each coordinate of d carries u|x_pi| of the constant and
    u|d| of the subtraction. Then (7) as printed: three products, two sums, root: l (2u + 4u), the
    optimised one rounds l once. (8): numerator 5u sum|d v| and from d 2u sum|d v|, root and
    quotient 7u|v|. (9)-(11): numerators 9u sum|terms|, quotients 12u|terms|.

    e as printed: errors of l_d, of the rounded l and of the resolution, u l each. e optimised:
    Q - Qh is below 2^-9, with five roundings of it and of the rest, so 5 2^-34/(2l); the Newton
    step leaves (6u)^2 l/2; for the table only e itself is rounded.

    v: constants and quotient 3u|v|; as printed also 2u|l|/T_s for the two rounded lengths.
    K_I s_c: the error of e, integrated with the boost, and three roundings per tick. Where
    abs(e) is closer to e_c than the bound of e, the ramp may be switched the other way. Where
    abs(v_d) is below its bound, its sign and so the start of the boost is in doubt for its length.
    Both integrators are within +-s_max.
    Masses 32u (m_p + 3 m_s), gravity 64u |G|: fewer than 32 operations, and z, the difference
    l^2/3 - R^2 - ..., doubles relative errors. Sums and products of (28): 6u of their parts.
    """
    legs = np.array(robot.legs)
    shift = np.concatenate((legs, np.zeros((3, 1))), axis=1)
    d = path.position[:, None, :] - shift  # (N, 3, 3)
    speed, change = path.velocity[:, None, :], path.acceleration[:, None, :]
    length = reference.position_d[:, :3]
    v, a = np.abs(reference.velocity_d), np.abs(reference.acceleration_d)
    moved = np.sum(np.abs(d * speed), axis=2)
    parts = 2 * np.sum(speed**2, axis=2) + np.sum(np.abs(d * change), axis=2)
    exact = np.zeros((len(path), 2))

    position = np.hstack((length * (1.01 * U if optimised else 6 * U), exact))
    velocity = np.hstack((7 * U * moved / length + 7 * U * v[:, :3], exact))
    acceleration = np.hstack((21 * U * parts / length + 12 * U * a[:, :3], exact))
    measured = np.abs(reference.position)
    if optimised:
        leg = 5 * 2.0**-34 / (2 * length) + 18 * U**2 * length
        e = np.hstack((leg, exact)) + 4 * U * np.abs(reference.e)
    else:
        e = position + 2 * U * measured + U * np.abs(reference.e)
    e_v = velocity + 3 * U * (np.abs(reference.velocity) + v)
    if not optimised:
        e_v = e_v + 2 * U * measured / robot.T_s

    k_p, k_v, k_i = (np.array(gain) for gain in (robot.K_P, robot.K_V, robot.K_I))
    ticks = np.arange(1, len(path) + 1)[:, None]
    s_c = np.cumsum(reference.phi_c * e * robot.T_s, axis=0) + 3 * U * ticks * robot.s_max
    s_c += 6 * U * np.cumsum(reference.phi_c * np.abs(reference.e) * robot.T_s, axis=0)
    n, end, size = reference.ticks, robot.boost_ticks, np.abs(reference.e)
    ramp = np.where((2 * n > end) & (n < end), 2.0 * (robot.xi_c - 1.0) * (1.0 - n / end), 0.0)
    unsure = np.abs(size - np.array(robot.e_c)) <= e
    s_c += np.cumsum(unsure * ramp * (size + e) * robot.T_s, axis=0)
    s_c += (
        np.cumsum(_after_doubt(velocity, v, end) * (robot.xi_c - 1.0) * (size + e), axis=0)
        * robot.T_s
    )
    s_c = np.minimum(s_c, 2.0 * np.array(robot.s_max))
    terms = a + k_p * np.abs(reference.e) + k_v * np.abs(reference.e_v)
    terms = terms + k_i * np.abs(reference.s_c)
    inner = acceleration + k_p * e + k_v * e_v + k_i * s_c + 6 * U * terms
    masses = np.hstack((np.full_like(length, 32 * U * (robot.m_p + 3 * robot.m_s)), exact))
    output = (reference.mass + masses) * inner + masses * terms
    output += 64 * U * np.abs(reference.gravity) + 2 * U * np.abs(reference.demand)
    return Bounds(position, velocity, acceleration, e, output)


def _after_doubt(velocity: NDArray, speed: NDArray, ticks: int) -> NDArray[np.bool_]:
    """Ticks (N, 5) within a boost's length after one whose sign of speed is in doubt."""
    doubt = (speed <= velocity) & (velocity > 0.0)
    last = np.where(doubt, np.arange(len(doubt))[:, None], -ticks - 1)
    return np.arange(len(doubt))[:, None] - np.maximum.accumulate(last, axis=0) <= ticks
