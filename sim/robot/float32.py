# SPDX-License-Identifier: Apache-2.0
"""Tracking law in single precision: the printed formulas compiled without contraction (the PC).

Every operation is one binary32 operation rounded to nearest even, in the order printed, from left
to right where the print leaves it open; nothing is shared between (7), (8) and (9)-(11):
- parameters and products of parameters alone (x_pi, 6R, 12R^2, 3R^2, r_4 m_4 g, ...) are evaluated
  in double precision and rounded once;
- Q^(3/2) is Q sqrt(Q), other powers are products;
- the system (24) is solved by Cramer's rule with the determinant expanded along its third row, so
  the cofactors C_i serve determinant and solution: G_i = (m_z g) C_i / det;
- lengths are float(count) times the resolution, v = (l(t) - l(t-1)) / T_s from two rounded lengths;
- the sine is the double-precision one rounded once.
The functions work on float32 arrays of any shape.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.robot.integrator import signs, ticks_since_reversal
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints, TrackingResult, checked_counts

Single = NDArray[np.float32]
f32 = np.float32

ZERO, QUARTER, HALF, ONE, TWO = (f32(value) for value in (0.0, 0.25, 0.5, 1.0, 2.0))


class Constants:
    """Parameters of one robot rounded to single precision; the names follow the formulas.

    Times of the boost are on the grid of ticks as the law computes it, n T_s in single precision:
    the boost has its phases at the same tick for every T_s and T_c.
    """

    def __init__(self, robot: Robot) -> None:
        self.xp = tuple(f32(xp) for xp, _ in robot.legs)
        self.yp = tuple(f32(yp) for _, yp in robot.legs)
        self.root3 = f32(math.sqrt(3.0))
        self.r = f32(robot.R)
        self.r6 = f32(6.0 * robot.R)
        self.rr12 = f32(12.0 * robot.R**2)
        self.rr3 = f32(3.0 * robot.R**2)
        self.m_s = f32(robot.m_s)
        self.m_p = f32(robot.m_p)
        self.j_a = f32(robot.J_a)
        self.l_c = f32(robot.l_c)
        self.mr_c = f32(robot.mr_c)
        self.g = f32(robot.g)
        self.table_inertia = (f32(robot.J_44), f32(robot.J_55))
        self.tilt_weight = f32(robot.r_4 * robot.m_4 * robot.g)
        self.t_s = f32(robot.T_s)
        self.t_c = f32(robot.boost_ticks) * f32(robot.T_s)
        self.half_t_c = f32(robot.boost_ticks // 2) * f32(robot.T_s)
        self.boost = f32(robot.xi_c - 1.0)
        self.ramp = f32(2.0 * (robot.xi_c - 1.0))
        self.resolution = np.array(robot.resolution, f32)
        self.k_p = np.array(robot.K_P, f32)
        self.k_v = np.array(robot.K_V, f32)
        self.k_i = np.array(robot.K_I, f32)
        self.s_max = np.array(robot.s_max, f32)
        self.e_c = np.array(robot.e_c, f32)
        self.output_max = np.array(robot.output_max, f32)

    def block(self) -> dict[str, Single]:
        """All of them by name as arrays (1,) or (n,): the parameter block of the programs in C."""
        return {name: np.atleast_1d(value) for name, value in vars(self).items()}


def offsets(c: Constants, leg: int, x: Single, y: Single) -> tuple[Single, Single]:
    """x - x_pi and y - y_pi; x_p1 = 0 is not subtracted, as in the print."""
    return (x if leg == 0 else x - c.xp[leg]), y - c.yp[leg]


def squared_length(c: Constants, leg: int, x: Single, y: Single, z: Single) -> Single:
    """Q_i."""
    dx, dy = offsets(c, leg, x, y)
    return dx * dx + dy * dy + z * z


def length(c: Constants, leg: int, p: tuple) -> Single:
    """l_i of (7)."""
    return np.sqrt(squared_length(c, leg, *p))


def numerator(c: Constants, leg: int, p: tuple, v: tuple) -> Single:
    """S_i, the numerator of (8)."""
    dx, dy = offsets(c, leg, p[0], p[1])
    return TWO * dx * v[0] + TWO * dy * v[1] + TWO * p[2] * v[2]


def velocity(c: Constants, leg: int, p: tuple, v: tuple) -> Single:
    """v_i of (8)."""
    return HALF * (numerator(c, leg, p, v) / length(c, leg, p))


def acceleration(c: Constants, leg: int, p: tuple, v: tuple, a: tuple) -> Single:
    """a_i of (9)-(11)."""
    s = numerator(c, leg, p, v)
    q = squared_length(c, leg, *p)
    first = -QUARTER * (s * s / (q * np.sqrt(q)))
    dx, dy = offsets(c, leg, p[0], p[1])
    second = (
        TWO * (v[0] * v[0])
        + TWO * dx * a[0]
        + TWO * (v[1] * v[1])
        + TWO * dy * a[1]
        + TWO * (v[2] * v[2])
        + TWO * p[2] * a[2]
    )
    return first + HALF * (second / np.sqrt(squared_length(c, leg, *p)))


def forward(c: Constants, l1: Single, l2: Single, l3: Single) -> tuple[Single, Single, Single]:
    """x, y of (14) and z of (15), each evaluated on its own."""
    x = -(c.root3 * (l2 * l2 - l3 * l3)) / c.r6
    y = -(TWO * (l1 * l1) - l2 * l2 - l3 * l3) / c.r6
    d = l2 * l2 - l3 * l3
    s = (TWO * (l1 * l1) - l2 * l2 - l3 * l3) / c.r6 + c.r
    return x, y, np.sqrt(l1 * l1 - d * d / c.rr12 - s * s)


def cosine2(c: Constants, first: Single, second: Single) -> Single:
    """c_ij^2."""
    cosine = (first * first + second * second - c.rr3) / (TWO * first * second)
    return cosine * cosine


def swung_mass(c: Constants, other: Single, c2: Single) -> Single:
    """m_j,ij of leg j = `other`."""
    reach = other - c.l_c
    return (c.j_a + c.m_s * (reach * reach)) * (ONE - c2) / (other * other)


def reduced_mass(c: Constants, i: Single, j: Single, k: Single) -> Single:
    """M_ii of (23) for the lengths of the leg itself and of the two others."""
    cij, cik = cosine2(c, i, j), cosine2(c, i, k)
    own = c.m_s + c.m_p + c.m_s * cij + c.m_s * cik
    return own + swung_mass(c, j, cij) + swung_mass(c, k, cik)


def carried_mass(c: Constants, legs: tuple) -> Single:
    """m_z of (25)."""
    shares: list[Single] = [(c.m_s * (leg - c.l_c) - c.mr_c) / leg for leg in legs]
    return sum(shares, start=np.asarray(c.m_p))


def gravity(c: Constants, p: tuple, legs: tuple, m_z: Single) -> tuple[Single, Single, Single]:
    """G_1, G_2, G_3: the system (24) by Cramer's rule."""
    w = []
    for leg, l_i in enumerate(legs):
        dx, dy = offsets(c, leg, p[0], p[1])
        w.append((dx / l_i, dy / l_i, p[2] / l_i))
    (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = w
    c1, c2, c3 = x2 * y3 - x3 * y2, x3 * y1 - x1 * y3, x1 * y2 - x2 * y1
    det = z1 * c1 + z2 * c2 + z3 * c3
    weight = m_z * c.g
    return weight * c1 / det, weight * c2 / det, weight * c3 / det


def sine(angle: Single) -> Single:
    """Sine, computed in double precision and rounded once."""
    return np.sin(angle.astype(np.float64)).astype(f32)


def boost(c: Constants, ticks: NDArray[np.int64], e: Single) -> Single:
    """phi_c of (30)-(32); ticks and e of shape (..., 5)."""
    t = ticks.astype(f32) * c.t_s
    phi_e = np.where(np.abs(e) >= c.e_c, ONE, ZERO)
    ramp = c.ramp * (ONE - t / c.t_c) * phi_e
    phi_t = np.select((t <= ZERO, t <= c.half_t_c, t < c.t_c), (ZERO, c.boost, ramp), ZERO)
    return phi_t + ONE


def integrate(c: Constants, increments: Single) -> Single:
    """s_c (N, 5) of (29) from phi_c e T_s, starting at 0."""
    result = np.empty_like(increments)
    total = np.zeros(5, f32)
    for tick, increment in enumerate(increments):
        total = np.minimum(np.maximum(total + increment, -c.s_max), c.s_max)
        result[tick] = total
    return result


def run(robot: Robot, path: SetPoints, counts: ArrayLike) -> TrackingResult:
    """The law over a recorded path from the start state; all real fields are float32 arrays.

    path: N ticks of set-points, rounded to single precision here; counts: (N, 5) integers of 32
    bits. Raises ValueError for counts of another shape or type. Legs that meet nowhere give NaN
    and numpy's warning.
    """
    c = Constants(robot)
    counts = checked_counts(counts, len(path))
    p, v, a = (
        tuple(np.asarray(values, f32).T)
        for values in (path.position, path.velocity, path.acceleration)
    )
    legs = range(3)
    position_d = _axes([length(c, i, p) for i in legs], path.table_position)
    velocity_d = _axes([velocity(c, i, p, v) for i in legs], path.table_velocity)
    acceleration_d = _axes([acceleration(c, i, p, v, a) for i in legs], path.table_acceleration)

    position = counts.astype(f32) * c.resolution
    measured_velocity = np.zeros_like(position)
    measured_velocity[1:] = (position[1:] - position[:-1]) / c.t_s
    measured = tuple(position[:, :3].T)
    tool = forward(c, *measured)

    e = position_d - position
    e_v = velocity_d - measured_velocity
    sign = signs(velocity_d)
    ticks = ticks_since_reversal(sign, robot.boost_ticks)
    phi_c = boost(c, ticks, e)
    s_c = integrate(c, phi_c * e * c.t_s)

    m_z = carried_mass(c, measured)
    l1, l2, l3 = measured
    mass = np.empty_like(position)
    mass[:, 0] = reduced_mass(c, l1, l2, l3)
    mass[:, 1] = reduced_mass(c, l2, l1, l3)
    mass[:, 2] = reduced_mass(c, l3, l1, l2)
    mass[:, 3:] = c.table_inertia
    weight = np.zeros_like(position)
    weight[:, :3] = np.stack(gravity(c, tool, measured, m_z), axis=-1)
    weight[:, 3] = c.tilt_weight * sine(position[:, 3])
    demand = mass * (acceleration_d + c.k_p * e + c.k_v * e_v + c.k_i * s_c) + weight
    return TrackingResult(
        position_d=position_d,
        velocity_d=velocity_d,
        acceleration_d=acceleration_d,
        position=position,
        velocity=measured_velocity,
        tool=np.stack(tool, axis=-1),
        e=e,
        e_v=e_v,
        sign=sign,
        ticks=ticks,
        phi_c=phi_c,
        s_c=s_c,
        m_z=m_z,
        mass=mass,
        gravity=weight,
        demand=demand,
        output=np.minimum(np.maximum(demand, -c.output_max), c.output_max),
    )


def _axes(legs: list[Single], table: ArrayLike) -> Single:
    return np.concatenate((np.stack(legs, axis=-1), np.asarray(table, f32)), axis=1)
