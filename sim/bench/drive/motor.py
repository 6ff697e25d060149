# SPDX-License-Identifier: Apache-2.0
"""A motor between switching edges: the exact solution of the circuit, edge by edge.

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

from sim.robot.drives import Motor

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


def space_vector(a: float, b: float, c: float) -> tuple[float, float]:
    """(alpha, beta) of three terminal voltages, their mean apart."""
    return (2 * a - b - c) / 3, (b - c) / SQRT3
