# SPDX-License-Identifier: Apache-2.0
"""Inverter and motor between switching edges: the exact solution of the circuit, edge by edge.

Terminals are at constant voltages between two edges of the effective gates; in the stator's frame
the voltage is constant there, in the rotor's it turns back with the electrical speed. With constant
speed in the interval both are linear: the state (i_d, i_q, u_d, u_q, psi) follows a matrix
exponential [C. Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23, 1978].
Speeds are held from edge to edge (0.1 to 10 us); mechanics are integrated outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from sim.model.drives import Drives, Motor

SQRT3 = math.sqrt(3.0)


def rotor_voltage(alpha: float, beta: float, angle: float) -> tuple[float, float]:
    """(u_d, u_q) of a voltage in the stator's frame."""
    c, s = math.cos(angle), math.sin(angle)
    return alpha * c + beta * s, beta * c - alpha * s


def phase_currents(i_d: float, i_q: float, angle: float) -> tuple[float, float, float]:
    """Currents into the three terminals [A]."""
    c, s = math.cos(angle), math.sin(angle)
    alpha, beta = i_d * c - i_q * s, i_d * s + i_q * c
    b = (-alpha + SQRT3 * beta) / 2
    return alpha, b, -alpha - b


def circuit(motor: Motor, speed: float) -> NDArray[np.float64]:
    """Matrix of d/dt (i_d, i_q, u_d, u_q, psi), at an electrical speed [rad/s]."""
    r, l_d, l_q = motor.R, motor.L_d, motor.L_q
    return np.array(
        [
            [-r / l_d, speed * l_q / l_d, 1 / l_d, 0, 0],
            [-speed * l_d / l_q, -r / l_q, 0, 1 / l_q, -speed / l_q],
            [0, 0, 0, speed, 0],
            [0, 0, -speed, 0, 0],
            [0, 0, 0, 0, 0],
        ]
    )


@dataclass
class Windings:
    """Currents of one motor in rotor coordinates [A]."""

    motor: Motor
    i_d: float = 0.0
    i_q: float = 0.0

    def advance(self, alpha: float, beta: float, angle: float, speed: float, time: float) -> None:
        """Over `time` [s] of a constant voltage [V, stator's frame]; angle, speed: electrical, at
        the beginning."""
        u_d, u_q = rotor_voltage(alpha, beta, angle)
        state = np.array([self.i_d, self.i_q, u_d, u_q, self.motor.psi])
        self.i_d, self.i_q = (expm(circuit(self.motor, speed) * time) @ state)[:2]

    @property
    def force(self) -> float:
        """Without cogging [N or N m]."""
        return self.motor.force(self.i_d, self.i_q)


def cogging(motor: Motor, angle: float) -> float:
    """Force of the slots [N or N m], six periods an electrical turn."""
    return motor.cogging * math.sin(6 * angle)


class Leg:
    """One half bridge: delayed switches, and diodes that carry the current when both are off."""

    def __init__(self, drives: Drives) -> None:
        self.drives = drives

    def edges(self, gate: NDArray[np.bool_], time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Instants at which the switch of a gate, sampled at `time` [s], conducts or stops."""
        change = np.flatnonzero(np.diff(gate)) + 1
        delay = np.where(gate[change], self.drives.delay_on, self.drives.delay_off)
        return time[change] + delay

    def voltage(self, high: bool, low: bool, current: float) -> float:
        """Terminal against the bus's middle [V] with a current out of it [A].

        Without a switch the diode against the current's sign conducts; without current both are off
        and the terminal is taken at the middle.
        """
        half = self.drives.U_dc / 2
        drop = math.copysign(self.drives.drop, current) + self.drives.drop_resistance * current
        if current == 0.0:
            drop = 0.0
        if high or low:
            return (half if high else -half) - drop
        return -math.copysign(half, current) - drop if current else 0.0


def space_vector(a: float, b: float, c: float) -> tuple[float, float]:
    """(alpha, beta) of three terminal voltages, their mean apart."""
    return (2 * a - b - c) / 3, (b - c) / SQRT3


def mean_leg_voltage(drives: Drives, duty: float, current: float) -> float:
    """Mean over a carrier period [V]: the averaged inverter, dead time and drops included.

    Both gates are off for the dead time twice a period; the diode against the current adds to one
    side what the current's sign says.
    """
    lost = (drives.dead_time + drives.delay_on - drives.delay_off) * drives.f_pwm * drives.U_dc
    sign = math.copysign(1.0, current) if current else 0.0
    return (
        (duty - 0.5) * drives.U_dc
        - sign * (lost + drives.drop)
        - (drives.drop_resistance * current)
    )
