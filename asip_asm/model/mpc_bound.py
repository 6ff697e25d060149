# SPDX-License-Identifier: Apache-2.0
"""Bound on what roundings do to a plan: program against the same iterations in exact arithmetic.

With t the relaxed iterate of all boxed coordinates, an iteration is t <- T(t), the relaxed operator
of Douglas and Rachford, which never spreads two points in the norm |t|^2 = sum rho_i t_i^2
(Eckstein and Bertsekas 1992, theorem 6; relaxation below 2). So the roundings of the iterations add
up there:

    |t - t exact| <= sum over the iterations of |roundings of one|,

and an input's limited value is as near. Roundings of an iteration are a running error analysis of
its recursions (Higham, chapter 3) with the largest values that t can take:
|t| <= iterations * |T(0)|, and T(0) is linear in the measured state and its reference. A program in
lanes computes p and d of h and of the reference apart. Its bound is the same, as the sizes of both
add up to those here. Its p is divided by penalties, which changes no relative error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.mpc_problem import Problem, riccati

Real = NDArray[np.float64]
UNIT = 2.0**-24


def input_bounds(problem: Problem, pulls: Sequence[tuple[Real, Real]] = ()) -> Real:
    """Largest distance of each input (m,) of a first tick, memories as loaded, from that of exact
    arithmetic: for every measured state and reference within `start`, or for those of which `pulls`
    holds the largest |h| of states (steps * n,) and inputs (steps * m,) before each iteration.
    """
    return _Bound(problem).inputs(pulls)


class _Bound:
    """Arrays of a sweep are (steps * n,) for states, (steps * m,) for inputs."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.gains = problem, riccati(problem)
        n, m, steps = problem.sizes
        self.rho = [np.tile(rho, steps) for rho in problem.penalty]
        boxes = (problem.state_box, problem.input_box)
        zeros = [np.where(np.isfinite(box).any(0), np.maximum(box[0], -box[1]), 0) for box in boxes]
        self.away = [np.tile(np.maximum(zero, 0), steps) for zero in zeros]
        ends = [np.where(np.isfinite(box), np.abs(box), 0).max(axis=0) for box in boxes]
        self.limit = [np.tile(end, steps) for end in ends]
        self.start = np.abs(problem.start).max(axis=0)
        wanted = self.start if problem.reference != "none" else np.zeros(n)
        pulls = [np.abs(problem.q) @ wanted] * (steps - 1) + [np.abs(problem.terminal) @ wanted]
        self.pull = np.hstack(pulls)
        self.gamma = (n + m + 8) * UNIT
        self._responses()

    def _responses(self) -> None:
        """What each input of a sweep, and an error of each result, adds to x, u, p and d."""
        n, m, steps = self.problem.sizes
        gains, b = self.gains, self.problem.b
        ends = np.cumsum([0, n, steps * n, steps * m, steps * m, steps * n, steps * m])
        self.parts = [slice(i, j) for i, j in zip(ends, ends[1:], strict=False)]
        unit = np.eye(ends[-1])
        x0, q, r, d_own, x_own, u_own = (unit[part] for part in self.parts)

        def of(values: Real, k: int, size: int) -> Real:
            return values[k * size : (k + 1) * size]

        p, d = [np.zeros((n, ends[-1]))] * steps, [np.zeros((m, ends[-1]))] * steps
        for k in range(steps - 1, -1, -1):
            p[k] = of(q, k, n)  # of the state after step k
            if k + 1 < steps:
                f, gain = gains.f[k + 1], gains.k[k + 1]
                p[k] = p[k] + f.T @ p[k + 1] - gain.T @ of(r, k + 1, m)
            d[k] = of(d_own, k, m) - gains.sb[k] @ p[k] - gains.s[k] @ of(r, k, m)
        x, states, inputs = x0, [], []
        for k in range(steps):
            inputs.append(of(u_own, k, m) + d[k] - gains.k[k] @ x)
            x = of(x_own, k, n) + gains.f[k] @ x + b @ d[k]
            states.append(x)
        self.response = [np.abs(np.vstack(each)) for each in (states, inputs, p, d)]

    def inputs(self, pulls: Sequence[tuple[Real, Real]]) -> Real:
        """The bound of each input."""
        problem = self.problem
        _, m, _ = problem.sizes
        alpha, slack = problem.relaxation, 1 + 1e-3
        x, u, _, _ = self.sweep([2 * each for each in self.away])
        held = zip((x, u), self.away, strict=True)
        step = self.norm([slack * (alpha * each + 2 * away) for each, away in held])
        total, e_u, last = 0.0, np.zeros(1), np.zeros_like(u)
        for iteration in range(problem.iterations):
            t = [iteration * step * self.by_norm(rho) for rho in self.rho]
            h = [each + 2 * away for each, away in zip(t, self.away, strict=True)]
            if pulls:
                h = [slack * each + total * self.by_norm(rho)
                     for each, rho in zip(pulls[iteration], self.rho, strict=True)]  # fmt: skip
            x, u, e_x, e_u = self.sweep(h)
            # Stored are h, and w = h + (2 - alpha) v, with |v| <= max(|h|, |limit|); both are
            # rounded, and so is t.
            # A projection onto a cone is rounded: h has twice its error, w alpha times, and h
            # reaches t by alpha.
            cone = [np.zeros_like(x), 3 * alpha * self.cone_errors(h[1])]
            total += self.norm(
                [alpha * error + UNIT * (alpha * size + 4 * pull + 2 * np.maximum(pull, limit))
                 + slack * projected
                 for size, error, pull, limit, projected
                 in zip((x, u), (e_x, e_u), h, self.limit, cone, strict=True)]
            )  # fmt: skip
            last = alpha * u + h[1]
        bound = total * self.by_norm(self.rho[1]) + slack * self.cone_errors(last)
        moved = [total * np.sqrt(rho) for rho in self.rho]
        free = e_u + self.through(1, moved[0], moved[1])
        return np.where(self.rho[1] > 0, bound, free)[:m]

    def cone_errors(self, h: Real) -> Real:
        """Largest errors of projected inputs (steps * m,), by sizes of h = t - 2 v; |v| has a
        limit.
        """
        cone, (_, m, _) = self.problem.cone, self.problem.sizes
        if not cone:
            return np.zeros_like(h)
        size = (h + 2 * self.limit[1]).reshape(-1, m)
        return cone.roundings(size, self.problem.penalty[1]).ravel()

    def sweep(self, h: list[Real]) -> tuple[Real, Real, Real, Real]:
        """Largest states and inputs of a sweep with pulls up to h, and their largest errors."""
        n, m, steps = self.problem.sizes
        gains, gamma, b = self.gains, self.gamma, np.abs(self.problem.b)
        q, r = self.rho[0] * h[0] + self.pull, self.rho[1] * h[1]
        x, u, p, d = (self.through(k, q, r, self.start) for k in range(4))
        e_p, e_d, e_x, e_u = q.copy(), np.zeros_like(d), np.zeros_like(x), np.zeros_like(u)
        before = self.start
        for k in range(steps):
            state, force = slice(k * n, (k + 1) * n), slice(k * m, (k + 1) * m)
            if k + 1 < steps:
                after, next_ = slice(state.stop, state.stop + n), slice(force.stop, force.stop + m)
                e_p[state] += np.abs(gains.f[k + 1].T) @ p[after]
                e_p[state] += np.abs(gains.k[k + 1].T) @ r[next_]
            e_d[force] = np.abs(gains.sb[k]) @ p[state] + 2 * np.abs(gains.s[k]) @ r[force]
            e_u[force] = d[force] + np.abs(gains.k[k]) @ before
            e_x[state] = b @ d[force] + np.abs(gains.f[k]) @ before
            before = x[state]
        # The pull of an input is rounded too: its error goes through S here and K' below.
        errors = [gamma * each for each in (e_p, r, e_d, e_x, e_u)]
        found = [
            sum(self.response[k][:, part] @ error
                for part, error in zip(self.parts[1:], errors, strict=True))
            for k in range(2)
        ]  # fmt: skip
        return x, u, found[0], found[1]

    def through(self, k: int, q: Real, r: Real, x0: Real | None = None) -> Real:
        """Largest result k (x, u, p, d) of pulls and a measured state of these sizes."""
        response = self.response[k]
        result = response[:, self.parts[1]] @ q + response[:, self.parts[2]] @ r
        return result if x0 is None else result + response[:, self.parts[0]] @ x0

    def norm(self, t: list[Real]) -> float:
        return float(
            np.sqrt(sum((rho * each**2).sum() for rho, each in zip(self.rho, t, strict=True)))
        )

    @staticmethod
    def by_norm(rho: Real) -> Real:
        """Largest coordinate of a vector whose norm is 1; 0 without limits."""
        return np.where(rho > 0, 1 / np.sqrt(np.where(rho > 0, rho, 1.0)), 0.0)
