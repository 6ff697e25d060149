# SPDX-License-Identifier: Apache-2.0
"""Program of a problem of model-predictive control in lanes: products of matrices on vectors.

The iterations are those of `mpc_program`. Rows of a matrix with equal columns share a vector,
and a column that a vector does not have takes no cycle. The auxiliary slot bounds a step, so

- the data memory holds t alone of each boxed coordinate, from which v, w and h follow: one store
  and two loads of an iteration, instead of two stores and two loads. Of inputs in a cone it holds w
  and h, so that each is limited once;
- p and r are those of `mpc_program` divided by the penalty of their coordinate, with gains to
  match, so that h itself is the gradient;
- the sweep is linear in its gradients, so what the reference adds to d is found once in a tick, and
  an iteration loads m words of a step instead of n.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from asip_asm.machine import Machine
from asip_asm.model.mpc_problem import Problem, half_width
from asip_asm.model.mpc_program import BACK, RESIDUALS, STEP, Maker, _names, reversed_gains, slot_of
from asip_asm.model.plan import NEGLIGIBLE, Plan
from asip_asm.model.plan_items import PIPES, Operand, Vectors, Words

PARTS = 2
"""Sums of a row in a pipe."""
Rows = list[list[tuple[str, str, int]]]
"""Sums of each row, which are to be added: pipe, vector and lane."""


class LaneMaker(Maker):
    def __init__(self, problem: Problem, machine: Machine) -> None:
        super().__init__(problem, machine, slot_of(problem, pulls=False))
        self.lanes = 1 + machine.build.lanes
        self.plan.reorder = True
        self.plan.spaces["slot"] += self.slot.size  # where the first step of a sweep stores nothing
        self.load = [0] * len(PIPES)
        self.kept: list[tuple[str, int, int]] = []
        gains, (n, m, steps) = self.gains, problem.sizes
        self.weights, own_u = (np.where(rho > 0, rho, 1.0) for rho in problem.penalty)
        own, f, k = self.weights, np.swapaxes(gains.f, 1, 2), np.swapaxes(gains.k, 1, 2)
        self.to_p = np.concatenate((f * own, -k * own_u), 2) / own[:, None]
        self.to_d = np.concatenate((-gains.sb * own, -gains.s * own_u), 2)
        ones = np.broadcast_to(np.eye(m), (steps, m, m))
        self.to_u = Words(np.concatenate((-gains.k, ones), 2), (STEP,))
        b = np.broadcast_to(problem.b, (steps, n, m))
        self.to_x = Words(np.concatenate((gains.f, b), 2), (STEP,))
        # A name that `vout` writes belongs to one pipe: that which the backward sweep chooses.
        self.homes: dict[str, str] = {}
        self.placed(self.filled(reversed_gains(self.to_d)), True)
        for group, ((pipe, _),) in self.placed(self.filled(reversed_gains(self.to_p)), False):
            self.homes |= {self.p[row]: PIPES[pipe] for row in group}
        self.load = [0] * len(PIPES)

    # ------------------------------------------------------------------ addresses
    def index(self, value: int) -> None:
        """The index is that of the slot before: a step on comes before the stores of a round."""
        super().index(value - 1)

    def address(self, offset: int, before: int = 0) -> int:
        return super().address(offset, before - 1)

    def store_kept(self, step: int = 0) -> None:
        """Step to another slot, then store the pending words. Call it after all loads of the round,
        because loads and stores stay in order.
        """
        if step:
            self.step(step)
        for value, offset, before in self.kept:
            self.plan.store(value, "slot", self.address(offset, before + step), "i")
        self.kept.clear()

    # ------------------------------------------------------------------ products
    def sums(self, matrix: Words, x: Sequence[str], into: str = "") -> Rows:
        """Append the sums of the rows of matrix * x. into: both pipes have sums of every row, in
        vectors of this name, which `late` gives.
        """
        values, filled = matrix.values, self.filled(matrix)
        rows: Rows = [[] for _ in filled]
        for number, (group, shares) in enumerate(self.placed(filled, bool(into))):
            for pipe, mine in shares:
                pin = PIPES[pipe]
                ends: list[Operand] = []
                for part in range(PARTS):
                    total = ""
                    for j in mine[part::PARTS]:
                        taken = np.zeros((*values.shape[:-2], self.lanes))
                        taken[..., : len(group)] = values[..., group, j]
                        words = Vectors(taken, matrix.axes)
                        total = (
                            self.plan.vector("vfmadd", words, x[j], total, pipe=pin)
                            if total
                            else self.plan.vector("vfmul", words, x[j], pipe=pin)
                        )
                    ends += [total] if total else []
                to = f"{into}{number}{pin}" if into else ""
                if len(ends) == PARTS or into:
                    ends += [0.0] * PARTS
                    ends = [self.plan.vector("vmadd", ends[0], 1.0, ends[1], pipe=pin, to=to)]
                for lane, row in enumerate(group):
                    rows[row] += [(pin, str(name), lane) for name in ends]
        return rows

    def placed(
        self, filled: np.ndarray, split: bool
    ) -> list[tuple[list[int], list[tuple[int, list[int]]]]]:
        """Groups of rows, and the columns of a group that each of its pipes has: the pipe with less
        work so far, with `split` both.
        """
        found = []
        for group in groups(filled, self.lanes):
            columns = np.flatnonzero(filled[group].any(axis=0)).tolist()
            first = int(np.argmin(self.load))
            pipes = [first, 1 - first] if split else [first]
            shares = [(pipe, columns[n :: len(pipes)]) for n, pipe in enumerate(pipes)]
            for pipe, mine in shares:
                self.load[pipe] += len(mine) + min(len(mine), PARTS) - 1 + len(group)
            found.append((group, shares))
        return found

    @staticmethod
    def filled(matrix: Words) -> np.ndarray:
        """Whether an entry is other than zero in any iteration."""
        size = np.abs(matrix.values).reshape(-1, *matrix.values.shape[-2:]).max(axis=0)
        return size > NEGLIGIBLE * size.max(axis=1, keepdims=True)

    def late(self, matrix: Words, into: str) -> Rows:
        """The sums that `sums` makes in these vectors; append that they are zero."""
        filled = self.filled(matrix)
        rows: Rows = [[] for _ in filled]
        for number, group in enumerate(groups(filled, self.lanes)):
            for pin in PIPES:
                name, nothing = f"{into}{number}{pin}", Vectors(np.zeros(self.lanes))
                self.plan.vector("vfmul", nothing, 1.0, pipe=pin, to=name)
                for lane, row in enumerate(group):
                    rows[row].append((pin, name, lane))
        return rows

    def taken(
        self, rows: Rows, start: Sequence[str] = (),
        into: Sequence[str] = (),
    ) -> list[str]:  # fmt: skip
        """start + the sums, as numbers."""
        results = []
        for i, sums in enumerate(rows):
            value: Operand = start[i] if start and start[i] else 0.0
            name = into[i] if into else ""
            fits = bool(sums) and self.homes.get(name, sums[-1][0]) == sums[-1][0]
            for k, (pipe, vector, lane) in enumerate(sums):
                to = name if fits and k == len(sums) - 1 else ""
                value = self.plan.vector("vout", value, vector, pipe=pipe, lane=lane, to=to)
            if not sums or (name and not fits):
                value = self.copy(value if isinstance(value, str) else 0.0, name)
            results.append(str(value))
        return results

    def multiplied(self, matrix: np.ndarray, x: Sequence[str], into: Sequence[str]) -> list[str]:
        return self.taken(self.sums(Words(matrix), x), into=into)

    # ------------------------------------------------------------------ limits
    def pull_of(self, t: str, v: str, to: str = "") -> str:
        return self.plan.op("fnmsub", 2.0, v, t, to=to)

    def pulls_of_states(self, before: int, into: Sequence[str] = ()) -> dict[int, str]:
        """h of the limited states of a step; with `into` of all, a zero without a limit."""
        t, found = self.loaded(self.slot.w_x, before), {}
        for i in range(len(self.problem.states)):
            to = into[i] if into else ""
            if i in t:
                v = self.limited(t[i], self.problem.state_box[:, i])
                found[i] = self.pull_of(t[i], v, to)
            elif to:
                found[i] = self.copy(0.0, to)
        return found

    def pulls_of_inputs(self, before: int) -> dict[int, str]:
        """Those of a step's inputs, to the names that a sweep begins with."""
        alone = {j: o for j, o in self.slot.w_u.items() if j not in self.slot.h_u}
        t = self.loaded(alone, before)
        for j, name in enumerate(self.r):
            if j in self.slot.h_u:
                self.plan.load("slot", self.address(self.slot.h_u[j], before), "i", name)
            elif j in t:
                self.pull_of(t[j], self.limited(t[j], self.problem.input_box[:, j]), name)
            else:
                self.copy(0.0, name)
        return dict(enumerate(self.r))

    def gradients(
        self, h_x: dict[int, str], pull: list[str], before: int, q: list[str], r: list[str]
    ) -> tuple[list[str], list[str]]:
        """Pulls of the last step, to p and r; those of the limited state are there already."""
        if not h_x:
            self.pulls_of_states(before, self.p)
        else:
            for i, name in enumerate(self.p):
                if i not in h_x:
                    self.copy(0.0, name)
        self.pulls_of_inputs(before)
        return q, r

    def stepped(self, value: str, old: str, v: str, place: tuple[int, int]) -> str:
        """New t of a coordinate, to be stored at an offset of a slot, from the last one and its
        limited value.
        """
        w = self.plan.op("fnmsub", self.alpha, v, old)
        t = self.plan.op("fmadd", self.alpha, value, w)
        self.kept.append((t, *place))
        return t

    def residual_of(self, value: str, v: str, old: str, box: np.ndarray) -> None:
        """Squares of the distance from the limited value, and of the limited value's move."""
        plan, share = self.plan, 1 / float(half_width(box[:, None])[0])
        for name, (a, b) in zip(RESIDUALS, ((value, v), (v, old)), strict=True):
            scaled = plan.op("fmul", share, plan.op("fsub", a, b))
            plan.op("fmax", name, plan.op("fmul", scaled, scaled), to=name)

    def limit_states(self, before: int, residuals: bool) -> dict[int, str]:
        found, box = {}, self.problem.state_box
        known = self.loaded(self.slot.w_x, before)
        for i, offset in self.slot.w_x.items():
            old = self.limited(known[i], box[:, i])
            t = self.stepped(self.x[i], known[i], old, (offset, before))
            if residuals:
                self.residual_of(self.x[i], self.limited(t, box[:, i]), old, box[:, i])
            elif not before:
                found[i] = self.pull_of(t, self.limited(t, box[:, i]), self.p[i])
        if not before:
            self.store_kept()
        return found

    # ------------------------------------------------------------------ sweeps
    def references(self) -> None:
        """What the reference adds to d of each step: a sweep with its pulls alone, once in a tick.
        With a trajectory it moves them a step on: a tick later they are those of the step before.
        """
        self.end = []  # p has no reference in the iterations
        problem, plan, own = self.problem, self.plan, self.weights[:, None]
        n, _, steps = problem.sizes
        plan.rewind()
        self.d, self.u = self.late(reversed_gains(self.to_d), "d"), self.late(self.to_u, "u")
        if problem.reference == "none":
            return
        to_d, to_p = (reversed_gains(each[:, :, :n]) for each in (self.to_d, self.to_p))
        d = self.late(to_d, "r")
        self.multiplied(-problem.terminal / own, self.wanted, self.p)
        known = _names("pull", n)
        trajectory = problem.reference == "trajectory"
        wanted = [plan.load("end_ref", i) for i in range(n)] if trajectory else self.wanted
        self.multiplied(-problem.q / own, wanted, known)
        if trajectory:
            for i, name in enumerate(self.wanted):
                plan.store(name, "end_ref", i)
        self.index(steps - 1)
        with plan.loop(BACK, steps):
            self.load = [0] * len(PIPES)
            self.keep_inputs(d, self.slot.d_ref)
            self.sums(to_d, self.p, "r")
            p = self.sums(to_p, self.p)
            moved = [plan.load("slot", self.address(o, 1), "i") for o in self.slot.pull]
            for name, offset in zip(known if moved else (), self.slot.pull, strict=True):
                self.kept.append((name, offset, 1))
            self.taken(p, known, self.p)
            self.store_kept(-1)
            for name, to in zip(moved, known, strict=False):
                self.copy(name, to)
        self.keep_inputs(d, self.slot.d_ref)
        self.store_kept()

    def backward(self) -> None:
        plan, both = self.plan, [*self.p, *self.r]
        to_d, to_p = reversed_gains(self.to_d), reversed_gains(self.to_p)
        with plan.loop(BACK, self.problem.horizon):
            self.load = [0] * len(PIPES)
            self.keep_inputs(self.d, self.slot.d, self.slot.d_ref)
            self.sums(to_d, both, "d")
            p = self.sums(to_p, both)
            q = self.pulls_of_states(1)
            self.taken(p, [q.get(i, "") for i in range(len(self.p))], self.p)
            self.pulls_of_inputs(1)
            self.store_kept(-1)
        self.keep_inputs(self.d, self.slot.d, self.slot.d_ref)
        self.store_kept()

    def keep_inputs(self, d: Rows, offsets: Sequence[int], known: Sequence[int] = ()) -> None:
        """Keep d of the step before, whose sums have come late, to be stored after all loads.
        known: words to which they are added.
        """
        start = [self.plan.load("slot", self.address(o, -1), "i") for o in known]
        for name, offset in zip(self.taken(d, start), offsets, strict=True):
            self.kept.append((name, offset, -1))

    def forward(self, residuals: bool) -> None:
        plan, steps = self.plan, self.problem.horizon
        for name, to in zip(self.measured, self.x, strict=True):
            self.copy(name, to=to)
        self.index(0)
        if residuals:
            self.clear()
        with plan.loop(STEP, steps):
            d = [plan.load("slot", self.address(o), "i") for o in self.slot.d]
            self.load = [0] * len(PIPES)
            self.limit_inputs(1, residuals)
            self.sums(self.to_u, [*self.x, *d], "u")
            x = self.sums(self.to_x, [*self.x, *d])
            self.limit_states(1, residuals)
            self.taken(x, into=self.x)
            self.store_kept(1)
            if residuals:
                # The first step limits the measured state and inputs of none: no residuals.
                for name in RESIDUALS:
                    plan.op("sel", "counts", name, 0.0, to=name)
                plan.op("mov", 1.0, to="counts")
        self.index(steps - 1)
        self.limit_inputs(0, residuals)

    def limit_inputs(self, before: int, residuals: bool) -> None:
        """Limit the inputs of a step, whose sums are a step late, and note the words to store."""
        known = self.loaded(self.slot.w_u, before)
        for j, value in enumerate(self.taken(self.u)):
            z, box = value, self.problem.input_box[:, j]
            if j in self.slot.t_u:
                t = self.plan.op("fmadd", self.alpha, value, known[j])
                self.kept.append((t, self.slot.t_u[j], before))
            elif j in self.slot.w_u:
                old = self.limited(known[j], box)
                t = self.stepped(value, known[j], old, (self.slot.w_u[j], before))
                if residuals:
                    z = self.limited(t, box)
                    self.residual_of(value, z, old, box)
            if residuals:
                self.kept.append((z, self.slot.z[j], before))

    def clear(self) -> None:
        for name in (*RESIDUALS, "counts"):
            self.plan.op("mov", 0.0, to=name)


def mpc_plan(problem: Problem, machine: Machine) -> Plan:
    """The finished plan, in lanes where the core has them. Raises ModelError where the core has no
    room.
    """
    return (LaneMaker if machine.build.lanes else Maker)(problem, machine).make()


def groups(filled: np.ndarray, size: int) -> list[list[int]]:
    """Rows in groups of up to `size`, those together that have the same columns."""
    left = list(range(len(filled)))
    found = []
    while left:
        group = [max(left, key=lambda i: int(filled[i].sum()))]
        left.remove(group[0])
        while left and len(group) < size:
            have = filled[group].any(axis=0)
            near = min(left, key=lambda i: (int((filled[i] & ~have).sum()), -int(filled[i].sum())))
            group.append(near)
            left.remove(near)
        found.append(group)
    return found
