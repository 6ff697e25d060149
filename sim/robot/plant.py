# SPDX-License-Identifier: Apache-2.0
"""Rigid-body plant of the robot with friction, integrated over control periods, and its encoders.

Tool: M_x a + (dM_x/dt) v - 1/2 grad(v' M_x v) = sum w_j (F_j - friction_j) - (0, 0, m_z g) with
M_x = m_p I + sum [m_s w_j w_j' + p_j (I - w_j w_j')] and p_j = J_j / l_j^2. Both velocity terms are
analytic: with u = |v|^2, s_j = w_j.v and p' = dp/dl their sum is
sum p'_j s_j v + w_j [(m_s - p_j)(u - s_j^2) / l_j - p'_j (u + s_j^2) / 2].
Table: two independent axes, (27). Friction is f tanh(v / v_0).

Forces are held over a period, which one classical Runge-Kutta step of T_s covers. Encoders read at
the end of the period, rounded to the nearest count (ties up), so that a reading is unbiased.
Plain Python floats: numpy is slower for systems of this size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from sim.robot.kinematics import lengths_of
from sim.robot.parameters import Robot

Vector = tuple[float, float, float]


def tool_acceleration(robot: Robot, place: Vector, speed: Vector, forces: Vector) -> Vector:
    """Acceleration of the tool in m/s^2 for leg forces in N; place in m, speed in m/s."""
    x, y, z = place
    vx, vy, vz = speed
    m_s, l_c = robot.m_s, robot.l_c
    friction, scale = robot.friction_legs, robot.friction_speed_legs
    u = vx * vx + vy * vy + vz * vz
    diagonal = m_z = robot.m_p
    xx = xy = xz = yy = yz = zz = 0.0  # sum of (m_s - p_j) w_j w_j'
    bx = by = bz = along = 0.0
    for (xp, yp), force in zip(robot.legs, forces, strict=True):
        rx, ry = x - xp, y - yp
        length = math.sqrt(rx * rx + ry * ry + z * z)
        wx, wy, wz = rx / length, ry / length, z / length
        s = wx * vx + wy * vy + wz * vz
        reach = length - l_c
        p = (robot.J_a + m_s * reach * reach) / (length * length)
        slope = 2.0 * (m_s * reach / length - p) / length  # dp/dl
        across = m_s - p
        diagonal += p
        m_z += (m_s * reach - robot.mr_c) / length
        ax, ay, az = across * wx, across * wy, across * wz
        xx += ax * wx
        xy += ax * wy
        xz += ax * wz
        yy += ay * wy
        yz += ay * wz
        zz += az * wz
        s2 = s * s
        push = force - friction * math.tanh(s / scale)
        push -= across * (u - s2) / length - 0.5 * slope * (u + s2)
        along += slope * s
        bx += push * wx
        by += push * wy
        bz += push * wz
    bx -= along * vx
    by -= along * vy
    bz -= along * vz + m_z * robot.g
    # M_x a = b by the adjugate of the symmetric matrix
    xx += diagonal
    yy += diagonal
    zz += diagonal
    axx, axy, axz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    ayy, ayz, azz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    scale = 1.0 / (xx * axx + xy * axy + xz * axz)
    return (
        (axx * bx + axy * by + axz * bz) * scale,
        (axy * bx + ayy * by + ayz * bz) * scale,
        (axz * bx + ayz * by + azz * bz) * scale,
    )


def table_acceleration(
    robot: Robot, theta: Sequence[float], omega: Sequence[float], torques: Sequence[float]
) -> tuple[float, float]:
    """Angular accelerations of tilt and rotation in rad/s^2 for torques in N m."""
    friction, scale = robot.friction_table, robot.friction_speed_table
    weight = robot.r_4 * robot.m_4 * robot.g * math.sin(theta[0])
    return (
        (torques[0] - weight - friction * math.tanh(omega[0] / scale)) / robot.J_44,
        (torques[1] - friction * math.tanh(omega[1] / scale)) / robot.J_55,
    )


class Plant:
    """The robot as the controller sees it: outputs in, encoder counts out."""

    def __init__(
        self,
        robot: Robot,
        tool: Sequence[float],
        table: Sequence[float] = (0.0, 0.0),
        steps: int = 1,
    ) -> None:
        """At rest with the tool at (x, y, z) in m and the table at (theta4, theta5) in rad.

        steps: Runge-Kutta steps per control period.
        """
        self._robot = robot
        self._steps = steps
        self._dt = robot.T_s / steps
        x, y, z = (float(value) for value in tool)
        theta4, theta5 = (float(value) for value in table)
        # x, y, z, theta4, theta5 and their rates
        self._q = (x, y, z, theta4, theta5)
        self._v = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def tool(self) -> Vector:
        """Tool position in m."""
        return self._q[:3]

    @property
    def tool_velocity(self) -> Vector:
        """Tool velocity in m/s."""
        return self._v[:3]

    @property
    def table(self) -> tuple[float, float]:
        """Table angles in rad."""
        return self._q[3:]

    @property
    def table_velocity(self) -> tuple[float, float]:
        """Table rates in rad/s."""
        return self._v[3:]

    @property
    def joints(self) -> tuple[float, ...]:
        """Exact l_1, l_2, l_3 in m, theta_4, theta_5 in rad."""
        return (*lengths_of(self._robot, *self._q[:3], math.sqrt), *self._q[3:])

    def counts(self) -> tuple[int, ...]:
        """Encoder counts of the five axes, each fits in 32 bits."""
        return tuple(
            math.floor(value / q + 0.5)
            for value, q in zip(self.joints, self._robot.resolution, strict=True)
        )

    def step(self, outputs: Sequence[float]) -> tuple[int, ...]:
        """Hold F_1..F_3 in N, tau_4, tau_5 in N m for one period; returns the counts at its end."""
        forces, torques = tuple(outputs[:3]), tuple(outputs[3:])
        for _ in range(self._steps):
            self._runge_kutta(forces, torques)
        return self.counts()

    def _rates(self, q: tuple, v: tuple, forces: tuple, torques: tuple) -> tuple:
        robot = self._robot
        return (
            *tool_acceleration(robot, q[:3], v[:3], forces),
            *table_acceleration(robot, q[3:], v[3:], torques),
        )

    def _runge_kutta(self, forces: tuple, torques: tuple) -> None:
        q, v, dt = self._q, self._v, self._dt
        half = 0.5 * dt
        a1 = self._rates(q, v, forces, torques)
        v2 = _moved(v, half, a1)
        a2 = self._rates(_moved(q, half, v), v2, forces, torques)
        v3 = _moved(v, half, a2)
        a3 = self._rates(_moved(q, half, v2), v3, forces, torques)
        v4 = _moved(v, dt, a3)
        a4 = self._rates(_moved(q, dt, v3), v4, forces, torques)
        self._q = _moved(q, dt / 6.0, _weighted(v, v2, v3, v4))
        self._v = _moved(v, dt / 6.0, _weighted(a1, a2, a3, a4))


def _moved(start: tuple, dt: float, rate: tuple) -> tuple:
    a, b, c, d, e = start
    ra, rb, rc, rd, re = rate
    return (a + dt * ra, b + dt * rb, c + dt * rc, d + dt * rd, e + dt * re)


def _weighted(k1: tuple, k2: tuple, k3: tuple, k4: tuple) -> tuple:
    return tuple(a + 2.0 * (b + c) + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
