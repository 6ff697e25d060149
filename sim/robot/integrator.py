# SPDX-License-Identifier: Apache-2.0
"""Non-linear integrator of the tracking law (29)-(35), (37), in double precision.

The time since the last reversal or stop is an exact tick count n with t_c = n T_s: n = 0 in the
tick of the reversal. It saturates at N_c = T_c / T_s, where the boost is over, and starts there;
the sign before the first tick is 0, so a path that starts with motion starts with a reversal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.robot.parameters import Robot


def boost(robot: Robot, ticks: int, error: float, e_c: float) -> float:
    """phi_c of one axis, (30)-(32)."""
    end = robot.boost_ticks
    if ticks <= 0 or ticks >= end:
        return 1.0
    if 2 * ticks <= end:
        return robot.xi_c
    if abs(error) < e_c:
        return 1.0
    return 1.0 + 2.0 * (robot.xi_c - 1.0) * (1.0 - ticks * robot.T_s / robot.T_c)


class Integrator:
    """State of one axis: s_c, the last sign of the desired velocity, the ticks since it changed."""

    def __init__(self, robot: Robot, axis: int) -> None:
        self._robot = robot
        self._e_c, self._s_max = robot.e_c[axis], robot.s_max[axis]
        self.s_c = 0.0
        self.sign = 0
        self.ticks = robot.boost_ticks
        self.phi_c = 1.0

    def step(self, error: float, desired_velocity: float) -> float:
        """Advance by one tick; returns s_c in m s or rad s."""
        sign = int(desired_velocity > 0.0) - int(desired_velocity < 0.0)
        if sign != self.sign:
            self.sign, self.ticks = sign, 0
        elif self.ticks < self._robot.boost_ticks:
            self.ticks += 1
        self.phi_c = boost(self._robot, self.ticks, error, self._e_c)
        total = self.s_c + self.phi_c * error * self._robot.T_s
        self.s_c = min(max(total, -self._s_max), self._s_max)
        return self.s_c


def signs(desired_velocity: NDArray[np.floating]) -> NDArray[np.int8]:
    """s_g of (35), (37), same shape."""
    return np.sign(desired_velocity).astype(np.int8)


def ticks_since_reversal(sign: NDArray[np.int8], end: int) -> NDArray[np.int64]:
    """n of every tick and axis for signs (N, axes), saturated at `end` = N_c."""
    before = np.zeros_like(sign)
    before[1:] = sign[:-1]
    now = np.arange(len(sign))[:, None]
    last = np.maximum.accumulate(np.where(sign != before, now, -end - 1), axis=0)
    return np.minimum(now - last, end)


def boosts(robot: Robot, ticks: NDArray[np.int64], error: NDArray[np.float64]) -> NDArray:
    """phi_c (N, 5) for n (N, 5) and errors (N, 5), (30)-(32)."""
    end = robot.boost_ticks
    large = np.abs(error) >= np.array(robot.e_c)
    ramp = 1.0 + 2.0 * (robot.xi_c - 1.0) * (1.0 - ticks * robot.T_s / robot.T_c)
    return np.select(
        ((ticks <= 0) | (ticks >= end), 2 * ticks <= end, large), (1.0, robot.xi_c, ramp), 1.0
    )


def integrate(increments: NDArray[np.float64], s_max: tuple[float, ...]) -> NDArray[np.float64]:
    """s_c (N, axes) from phi_c e T_s (N, axes): the saturated sum (29), from 0."""
    result = np.empty_like(increments)
    for axis, high in enumerate(s_max):
        total, low, path = 0.0, -high, []
        for increment in increments[:, axis].tolist():
            total += increment
            if total > high:
                total = high
            elif total < low:
                total = low
            path.append(total)
        result[:, axis] = path
    return result
