# SPDX-License-Identifier: Apache-2.0
"""Model-predictive control in double precision: the solver's iterations, and the true optimum.

The reference has one unknown for each input and state of the horizon, takes its primal step by
inverting the optimality system of all of them, and keeps v and lambda as Boyd and others (2011)
write ADMM. The program has Riccati gains and other variables. The optimum is that of DAQP (Arnstrom
and others, IEEE TAC 2022), an active-set solver, on the problem in the inputs alone. With a cone it
is that of Clarabel (Goulart and Chen, arXiv 2405.12762), an interior-point solver.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse import csc_matrix

from asip_asm.model.mpc_cone import Cone
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
            self.v = np.where(self.boxed, self._limited(total), y)
            self.multiplier = np.where(self.boxed, total - self.v, 0.0)
        plan = self.v[:, : self.inputs]

        def largest(move: Matrix) -> Matrix:
            return np.max(np.abs(move) / self.half * self.boxed, axis=1)

        return {
            "u": plan[:, :m], "plan": plan, "primal": largest(y - self.v),
            "dual": largest(self.v - before),
        }  # fmt: skip

    def _limited(self, total: Matrix) -> Matrix:
        """Nearest values within all limits."""
        found = np.clip(total, self.low, self.high)
        cone, (_, m, steps) = self.problem.cone, self.problem.sizes
        if cone:
            inputs = total[:, : self.inputs].reshape(-1, steps, m)
            held = found[:, : self.inputs].reshape(-1, steps, m).copy()
            held[..., list(cone.inputs)] = project(inputs, cone, self.problem.penalty[1])
            found[:, : self.inputs] = held.reshape(len(total), -1)
        return found


def project(u: Matrix, cone: Cone, rho: Matrix) -> Matrix:
    """Nearest inputs (..., cone's) within the cone and the box of its axis, of inputs (..., m).

    Norm and axis are found in their plane, scaled to equal penalties. An inner point stays. Others
    go to the nearest point of the cone's edge, or of the faces at the two ends of the axis.
    """
    norm = u[..., list(cone.norm)]
    size = np.linalg.norm(norm, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        away = np.where(size[..., None] > 0, norm / size[..., None], 0.0)
    if cone.axis is None:
        return away * np.minimum(size, cone.limit)[..., None]
    axis = u[..., cone.axis]
    heavy = np.sqrt(rho[[cone.norm[0], cone.axis]])
    point = np.stack((size, axis), axis=-1)
    corners = np.array([[cone.limit + cone.slope * z, z] for z in (cone.low, cone.high)])
    edge = (corners[1] - corners[0]) * heavy
    along = ((point - corners[0]) * heavy @ edge / (edge @ edge)).clip(0, 1)
    places = [corners[0] + along[..., None] * (corners[1] - corners[0])]
    places += [
        np.stack((np.clip(size, 0, corner[0]), np.full_like(size, corner[1])), axis=-1)
        for corner in corners
    ]
    inside = (axis >= cone.low) & (axis <= cone.high) & (size <= cone.limit + cone.slope * axis)
    far = np.stack([(((place - point) * heavy) ** 2).sum(axis=-1) for place in places])
    best = np.take_along_axis(np.stack(places), far.argmin(axis=0)[None, ..., None], axis=0)[0]
    best = np.where(inside[..., None], point, best)
    return np.concatenate((away * best[..., :1], best[..., 1:]), axis=-1)


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
    solver: str = "DAQP"

    def lines(self) -> list[str]:
        """Text for people."""
        count = len(self.excess)
        none = f"; {self.infeasible} more have no plan within the limits" if self.infeasible else ""
        rows = [f"distance from the optimum ({self.solver}), {count} initial states{none}:"]
        for name, values in (
            ("cost above it", self.excess),
            ("state beyond its box, by the width", self.violation),
        ):
            median, far, most = np.quantile(values, (0.5, 0.99, 1.0))
            rows.append(f"  {name}: median {median:.2g}, 99 % {far:.2g}, largest {most:.2g}")
        return rows


def distance(problem: Problem, count: int = STATES, seed: int = SEED) -> Distance:
    """Distance from the optimum over drawn initial states, reference zero. Raises ImportError
    without daqp, or with a cone without clarabel.
    """
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
    low, high = (np.tile(end, steps) for end in problem.state_box)
    boxed = np.tile(np.isfinite(problem.state_box).any(axis=0), steps)
    rows = np.ascontiguousarray(response[boxed])
    solver = _with_cone(problem, hessian, rows) if problem.cone else _boxes(problem, hessian, rows)
    width = np.tile(2 * half_width(problem.state_box), steps)

    def cost(x: Matrix, u: Matrix) -> float:
        states = held @ x + response @ u
        return float(states @ weight @ states + u @ effort @ u) / 2

    excess, violation, first, infeasible = [], [], [], 0
    for x, plan in zip(x0, plans, strict=True):
        base = held @ x
        linear = response.T @ weight @ base
        best = solver(linear, (low - base)[boxed], (high - base)[boxed])
        if best is None:
            infeasible += 1
            continue
        least = cost(x, best)
        excess.append((cost(x, plan) - least) / max(least, 1e-12))
        states = base + response @ plan
        beyond = np.maximum(low - states, states - high)[boxed] / width[boxed]
        violation.append(max(0.0, float(beyond.max(initial=0.0))))
        first.append(plan[:m] - best[:m])
    name = "Clarabel" if problem.cone else "DAQP"
    return Distance(np.array(excess), np.array(violation), infeasible, np.array(first), name)


Solver = Callable[[Matrix, Matrix, Matrix], Matrix | None]
"""Best inputs (steps * m,) of a linear cost and limits of the boxed states; None without any."""


def _boxes(problem: Problem, hessian: Matrix, rows: Matrix) -> Solver:
    import daqp

    steps, large = problem.horizon, 1e30
    low, high = (np.tile(end, steps) for end in problem.input_box)
    sense = np.zeros(len(low) + len(rows), dtype=np.int32)

    def finite(*ends: Matrix) -> Matrix:
        return np.nan_to_num(np.hstack(ends), posinf=large, neginf=-large)

    def solve(linear: Matrix, least: Matrix, most: Matrix) -> Matrix | None:
        upper, lower = finite(high, most), finite(low, least)
        best, _, flag, _ = daqp.solve(hessian, linear, rows, upper, lower, sense)
        return best if flag >= 1 else None

    return solve


def _with_cone(problem: Problem, hessian: Matrix, rows: Matrix) -> Solver:
    """Clarabel states A x + s = b, s in nonnegative numbers and cones (t, v), |v| <= t."""
    import clarabel

    cone, (_, m, steps) = problem.cone, problem.sizes
    assert cone is not None
    size = steps * m
    low, high = (np.tile(end, steps) for end in problem.input_box)
    norm = np.tile([j in cone.norm for j in range(m)], steps)
    has_high, has_low = np.isfinite(high) & ~norm, np.isfinite(low) & ~norm
    one = np.eye(size)
    parts = []
    for k in range(steps):
        part = np.zeros((1 + len(cone.norm), size))
        if cone.axis is not None:
            part[0, k * m + cone.axis] = -cone.slope
        for row, j in enumerate(cone.norm, 1):
            part[row, k * m + j] = -1.0
        parts.append(part)
    linear_rows = np.vstack((one[has_high], -one[has_low], rows, -rows))
    known = np.hstack((high[has_high], -low[has_low]))
    radius = np.tile([cone.limit, *[0.0] * len(cone.norm)], steps)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    upper = csc_matrix(np.triu(hessian))

    def solve(linear: Matrix, least: Matrix, most: Matrix) -> Matrix | None:
        limits = np.hstack((known, most, -least))
        kept = np.isfinite(limits)
        left = csc_matrix(np.vstack((linear_rows[kept], *parts)))
        cones = [clarabel.NonnegativeConeT(int(kept.sum()))]
        cones += [clarabel.SecondOrderConeT(1 + len(cone.norm)) for _ in range(steps)]
        right = np.hstack((limits[kept], radius))
        made = clarabel.DefaultSolver(upper, linear, left, right, cones, settings).solve()
        return np.array(made.x) if str(made.status) == "Solved" else None

    return solve
