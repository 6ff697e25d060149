# SPDX-License-Identifier: Apache-2.0
"""Laws that are products of matrices: an LQG controller and a learned policy's network.

The LQG law holds the end masses of a chain of six masses and springs still. Masses and springs are
drawn with a fixed seed, so that no two elements of its matrices are equal. The weights of the
policy are drawn too: they serve for cycles, bits and bounds, not for control.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from asip_asm.model.law import Law, Port

Matrix = NDArray[np.float64]
SEED = 20
MASSES, FORCES = 6, (0, 2, 3, 5)
"""Masses of the chain, and those on which an actuator pulls."""
PERIOD, FREQUENCY = 1e-3, 20.0  # s, Hz of a mass on its spring
POLICY = (12, 16, 16, 4)
"""Inputs, hidden neurons, and outputs of the policy."""


@dataclass(frozen=True)
class Lqg:
    """x+ = A x + B u, y = C x; u = -K x, and L weighs what was measured in the estimate."""

    a: Matrix
    b: Matrix
    c: Matrix
    k: Matrix
    l: Matrix  # noqa: E741


def lqg_gains(seed: int = SEED) -> Lqg:
    """Chain of masses with its controller and its Kalman predictor, in double precision."""
    rng = np.random.default_rng(seed)
    springs, masses = rng.uniform(0.5, 1.5, MASSES + 1), rng.uniform(0.5, 1.5, MASSES)
    stiffness = np.diag(springs[:-1] + springs[1:])
    stiffness -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    pull = stiffness / masses[:, None]
    speed, n = 2 * np.pi * FREQUENCY, 2 * MASSES
    whole = np.zeros((n + len(FORCES),) * 2)
    whole[:MASSES, MASSES:n] = speed * np.eye(MASSES)
    whole[MASSES:n, :n] = np.hstack((-speed * pull, -0.02 * speed * pull))
    for column, mass in enumerate(FORCES):
        whole[MASSES + mass, n + column] = speed / masses[mass]
    step = expm(PERIOD * whole)
    a, b, c = step[:n, :n], step[:n, n:], np.eye(MASSES, n)
    cost = solve_discrete_are(a, b, np.eye(n), np.eye(len(FORCES)))
    k = np.linalg.solve(b.T @ cost @ b + np.eye(len(FORCES)), b.T @ cost @ a)
    noise = 1e-4 * np.eye(MASSES)
    spread = solve_discrete_are(a.T, c.T, 1e-2 * np.eye(n), noise)
    return Lqg(a, b, c, k, a @ spread @ c.T @ np.linalg.inv(c @ spread @ c.T + noise))


def lqg(gains: Lqg | None = None) -> Law:
    """Four forces from six measured positions, with a Kalman predictor of twelve states."""
    made = gains or lqg_gains()
    y, x = ca.SX.sym("y", MASSES), ca.SX.sym("x", 2 * MASSES)
    u = -ca.DM(made.k) @ x
    # The measured positions are states themselves: no product is needed for C x.
    after = ca.DM(made.a) @ x + ca.DM(made.b) @ u + ca.DM(made.l) @ (y - x[:MASSES])
    function = ca.Function("lqg", [y, x], [u, after], ["y", "x"], ["u", "x_next"])
    ports = [
        *(Port("input", f"y{i}", vector="y", limits=(-1.0, 1.0)) for i in range(MASSES)),
        *(Port("state", f"x{i}", vector="x", limits=(-2.0, 2.0)) for i in range(2 * MASSES)),
        *(Port("output", f"u{i}", vector="u", limits=(-1.0, 1.0)) for i in range(len(FORCES))),
    ]
    return Law("lqg", function, ports, "LQG of a chain of six masses", 1 / PERIOD)


def policy(sizes: Sequence[int] = POLICY, seed: int = SEED) -> Law:
    """A network of dense layers, with tanh between them, and drawn weights."""
    rng = np.random.default_rng(seed)
    x = ca.SX.sym("x", sizes[0])
    values: ca.SX = x
    for layer, (n, m) in enumerate(zip(sizes, sizes[1:], strict=False)):
        weights, bias = rng.normal(size=(m, n)) / np.sqrt(n), 0.1 * rng.normal(size=m)
        values = ca.DM(weights) @ values + ca.DM(bias)
        values = ca.tanh(values) if layer < len(sizes) - 2 else values
    function = ca.Function("policy", [x], [values], ["x"], ["u"])
    ports = [Port("input", f"x{i}", vector="x", limits=(-1.0, 1.0)) for i in range(sizes[0])]
    ports += [Port("output", f"u{i}", vector="u", limits=(-5.0, 5.0)) for i in range(sizes[-1])]
    return Law("policy", function, ports, "network with drawn weights", 1000.0)
