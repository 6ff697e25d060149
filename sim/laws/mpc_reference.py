# SPDX-License-Identifier: Apache-2.0
"""Model-predictive control in double precision: the solver's iterations, and the true optimum.

The reference has one unknown for each input and state of the horizon, takes its primal step by
inverting the optimality system of all of them, and keeps v and lambda as Boyd and others (2011)
write ADMM. The program has Riccati gains and other variables. The optimum is that of DAQP (Arnstrom
and others, IEEE TAC 2022), an active-set solver, on the problem in the inputs alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from asip_asm.model.mpc_problem import Problem, drawn, half_width

Matrix = NDArray[np.float64]
SEED = 20261127
STATES = 10_000


class Reference:
    """The solver for many runs at once; `tick` is one solve, warm from the last one."""

    def __init__(self, problem: Problem, runs: int) -> None:
        self.problem = problem
        n, m, steps = problem.sizes
        self.inputs = steps * m
        boxes = [np.tile(problem.input_box, steps), np.tile(problem.state_box, steps)]
        self.low, self.high = np.hstack(boxes)
        self.half = np.hstack([half_width(box) for box in boxes])
        self.boxed = np.isfinite(self.low) | np.isfinite(self.high)
        rho_x, rho_u = problem.penalty
        self.rho = np.hstack((np.tile(rho_u, steps), np.tile(rho_x, steps)))
        weights = [problem.q] * (steps - 1) + [problem.terminal]
        self.weight = block_diag(*weights)
        hessian = block_diag(*[problem.r] * steps, *weights) + np.diag(self.rho)
        rows = np.zeros((steps * n, len(self.rho)))
        for k in range(steps):
            at = slice(k * n, (k + 1) * n)
            rows[at, k * m : (k + 1) * m] = -problem.b
            rows[at, self.inputs + k * n : self.inputs + (k + 1) * n] = np.eye(n)
            if k:
                rows[at, self.inputs + (k - 1) * n : self.inputs + k * n] = -problem.a
        zero = np.zeros((steps * n,) * 2)
        self.inverse = np.linalg.inv(np.block([[hessian, rows.T], [rows, zero]]))
        self.v = np.zeros((runs, len(self.rho)))
        self.multiplier = np.zeros_like(self.v)
        self.window = np.zeros((runs, steps, n))
        self.pulls: list[tuple[Matrix, Matrix]] = []

    def tick(self, x: Matrix, wanted: Matrix | None = None) -> dict[str, Matrix]:
        """Inputs u (runs, m), residuals primal and dual (runs,), planned inputs (runs, steps m) of
        measured states x (runs, n) and their references.
        """
        problem, (n, m, steps) = self.problem, self.problem.sizes
        alpha, size = problem.relaxation, len(self.rho)
        if wanted is not None:
            self.window = np.roll(self.window, -1, axis=1)
            self.window[:, -1] = wanted
            if problem.reference == "point":
                self.window[:] = wanted[:, None]
        pull = self.window.reshape(len(x), -1) @ self.weight
        right = np.zeros((len(x), size + steps * n))
        right[:, size : size + n] = x @ problem.a.T
        y = before = self.v
        self.pulls = []  # largest |multiplier - v| of states and inputs before each iteration
        for _ in range(problem.iterations):
            most = np.abs(self.multiplier - self.v).max(axis=0) * self.boxed
            self.pulls.append((most[self.inputs :], most[: self.inputs]))
            right[:, :size] = self.rho * (self.v - self.multiplier)
            right[:, self.inputs : size] += pull
            y = (right @ self.inverse.T)[:, :size]
            before = self.v
            relaxed = alpha * y + (1 - alpha) * self.v
            total = relaxed + self.multiplier
            self.v = np.where(self.boxed, np.clip(total, self.low, self.high), y)
            self.multiplier = np.where(self.boxed, total - self.v, 0.0)
        plan = self.v[:, : self.inputs]

        def largest(move: Matrix) -> Matrix:
            return np.max(np.abs(move) / self.half * self.boxed, axis=1)

        return {
            "u": plan[:, :m], "plan": plan, "primal": largest(y - self.v),
            "dual": largest(self.v - before),
        }  # fmt: skip


@dataclass(frozen=True)
class Distance:
    """Distance of the plan after the fixed iterations, from zero, from the optimum: its cost above
    the optimum's as a share of it, and its states beyond their box by its width, each for
    every initial state that has an optimum. infeasible: states that have none.
    """

    excess: Matrix
    violation: Matrix
    infeasible: int
    first: Matrix = field(repr=False)

    def lines(self) -> list[str]:
        """Text for people."""
        count = len(self.excess)
        none = f"; {self.infeasible} more have no plan within the boxes" if self.infeasible else ""
        rows = [f"distance from the optimum (DAQP), {count} initial states{none}:"]
        for name, values in (
            ("cost above it", self.excess),
            ("state beyond its box, by the width", self.violation),
        ):
            median, far, most = np.quantile(values, (0.5, 0.99, 1.0))
            rows.append(f"  {name}: median {median:.2g}, 99 % {far:.2g}, largest {most:.2g}")
        return rows


def distance(problem: Problem, count: int = STATES, seed: int = SEED) -> Distance:
    """Distance from the optimum over drawn initial states, reference zero. Raises ImportError
    without daqp.
    """
    import daqp

    n, m, steps = problem.sizes
    x0 = drawn(problem, count, seed)
    plans = Reference(problem, count).tick(x0)["plan"]
    free, forced = np.zeros((steps, n, n)), np.zeros((steps, n, steps, m))
    state = np.eye(n)
    for k in range(steps):
        state = problem.a @ state
        free[k] = state
        if k:
            forced[k] = np.einsum("ij,jkl->ikl", problem.a, forced[k - 1])
        forced[k, :, k] += problem.b
    response, held = forced.reshape(steps * n, -1), free.reshape(steps * n, n)
    weight = block_diag(*[problem.q] * (steps - 1), problem.terminal)
    effort = block_diag(*[problem.r] * steps)
    hessian = response.T @ weight @ response + effort
    hessian = (hessian + hessian.T) / 2
    large = 1e30
    low, high = (np.nan_to_num(np.tile(end, steps), posinf=large, neginf=-large)
                 for end in problem.state_box)  # fmt: skip
    ends = [np.nan_to_num(np.tile(end, steps), posinf=large, neginf=-large)
            for end in problem.input_box]  # fmt: skip
    boxed = np.tile(np.isfinite(problem.state_box).any(axis=0), steps)
    rows = np.ascontiguousarray(response[boxed])
    sense = np.zeros(steps * m + len(rows), dtype=np.int32)
    width = np.tile(2 * half_width(problem.state_box), steps)

    def cost(x: Matrix, u: Matrix) -> float:
        states = held @ x + response @ u
        return float(states @ weight @ states + u @ effort @ u) / 2

    excess, violation, first, infeasible = [], [], [], 0
    for x, plan in zip(x0, plans, strict=True):
        base = held @ x
        upper = np.hstack((ends[1], (high - base)[boxed]))
        lower = np.hstack((ends[0], (low - base)[boxed]))
        linear = response.T @ weight @ base
        best, _, flag, _ = daqp.solve(hessian, linear, rows, upper, lower, sense)
        if flag < 1:
            infeasible += 1
            continue
        least = cost(x, best)
        excess.append((cost(x, plan) - least) / max(least, 1e-12))
        states = base + response @ plan
        beyond = np.maximum(low - states, states - high) / width
        violation.append(max(0.0, float(beyond[boxed].max(initial=0.0))))
        first.append(plan[:m] - best[:m])
    return Distance(np.array(excess), np.array(violation), infeasible, np.array(first))
