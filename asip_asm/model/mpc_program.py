# SPDX-License-Identifier: Apache-2.0
"""Program of a problem of model-predictive control: a fixed number of ADMM iterations in loops.

Of each boxed coordinate the data memory holds two words that the next tick begins with: w, which
the relaxed iterate is added to before it is limited, and h, the pull of the limit. An iteration is

    backward over the steps:  d = -S (B' p + r),  p <- q + F' p - K' r,  q = rho h - Q r
    forward over the steps:   u = d - K x,  x <- F x + B d
    of each boxed one:        t = alpha x + w,  v = limited t,  w <- t - alpha v,  h <- t - 2 v

The slot of step k holds what belongs to u_k and x_{k+1}. A slot before the first one takes what the
loops write for the measured state, which no result depends on. The r in Q r is the reference.

Inputs in a cone wait with their t until all steps have one. Then a loop of its own limits them,
some steps in a round, whose roots and quotients overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np

from asip_asm.machine import Machine
from asip_asm.model.law import Law, Port
from asip_asm.model.mpc_cone import TINY
from asip_asm.model.mpc_problem import Problem, half_width, riccati
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import Words
from asip_asm.model.read import ModelError

STEP, BACK, ITERATION, CONE = "step", "back", "iteration", "cone"
RESIDUALS = ("primal", "dual")
STEPS = 5
"""Steps of a round of projections onto the cone."""
SPLIT = 2
"""Sums of which that of an input is made: its limit waits for it."""


@dataclass(frozen=True)
class Slot:
    """Places of a step's words in the data memory, by coordinate; size: words of a step. d_ref: the
    part of d that the reference makes. t_u: of inputs in the cone.
    """

    w_x: dict[int, int]
    h_x: dict[int, int]
    w_u: dict[int, int]
    h_u: dict[int, int]
    d: list[int]
    d_ref: list[int]
    z: list[int]
    pull: list[int]
    t_u: dict[int, int]
    size: int


def slot_of(problem: Problem, pulls: bool = True) -> Slot:
    """Places of a step's words. pulls: whether h is one of them also outside the cone, and d all
    of it.
    """
    n, m, _ = problem.sizes
    states, inputs = problem.boxed()
    cone = [j for j in inputs if problem.cone and j in problem.cone.inputs]
    apart = m if not pulls and problem.reference != "none" else 0
    held = (states, inputs) if pulls else ([], cone)
    counts = [len(states), len(held[0]), len(inputs), len(held[1]), m, apart, m]
    counts += [n if problem.reference == "trajectory" else 0, len(cone)]
    ends = np.cumsum([0, *counts])
    fields = [list(range(a, b)) for a, b in zip(ends, ends[1:], strict=False)]
    names = (states, held[0], inputs, held[1])
    w_x, h_x, w_u, h_u = (
        dict(zip(some, one, strict=True)) for some, one in zip(names, fields, strict=False)
    )
    d, d_ref, z, pull, t_u = fields[4:]
    return Slot(
        w_x, h_x, w_u, h_u, d, d_ref, z, pull, dict(zip(cone, t_u, strict=True)), int(ends[-1])
    )


def signals(problem: Problem) -> list[Port]:
    """Signals of the program: the state, its reference, the first inputs and the residuals."""
    ports = [
        Port("input", name, "1", "measured state", vector="x", limits=(low, high))
        for name, low, high in zip(problem.states, *problem.start, strict=True)
    ]
    if problem.reference != "none":
        where = "reference" if problem.reference == "point" else "reference at the horizon's end"
        ports += [
            Port("input", f"{name}_ref", "1", where, vector="x_ref", limits=(low, high))
            for name, low, high in zip(problem.states, *problem.start, strict=True)
        ]
    for name, low, high in zip(problem.inputs, *problem.input_box, strict=True):
        limits = (low, high) if np.isfinite(low) and np.isfinite(high) else None
        ports.append(Port("output", name, "1", "input of the plant", vector="u", limits=limits))
    for name, meaning in (
        (
            "primal_residual",
            "largest distance of an iterate from its limited value, by half its box",
        ),
        ("dual_residual", "largest move of a limited value in the last iteration, by half its box"),
    ):
        ports.append(Port("output", name, "1", meaning))
    return ports


def mpc_law(problem: Problem) -> Law:
    """The problem as a law, for interpreter, bounds and proofs; it has no function of its own."""
    return Law(problem.title, None, signals(problem), rate=1 / problem.sample_time)  # type: ignore[arg-type]  # not evaluated: the plan is made from the problem


class Maker:
    """Makes the plan of a problem; parts of it are other ones in lanes."""

    def __init__(self, problem: Problem, machine: Machine, slot: Slot | None = None) -> None:
        self.problem, self.slot = problem, slot or slot_of(problem)
        self.gains = riccati(problem)
        ports = signals(problem)
        inputs = [port.name for port in ports if port.kind == "input"]
        outputs = {port.name: 0.0 for port in ports if port.kind == "output"}
        self.plan = Plan(problem.title, inputs, outputs, machine)
        n, m, steps = problem.sizes
        self.plan.spaces["slot"] = (steps + 1) * self.slot.size
        if problem.reference == "trajectory":
            self.plan.spaces["end_ref"] = n
        used, room = sum(self.plan.spaces.values()), machine.data_words
        if used > room:
            raise ModelError(
                f"{problem.path}: {problem.title}: {steps} steps of {n} states and {m} inputs take "
                f"{used} words of data memory, the core has {room}; shorten the horizon, or take "
                "limits off states that need none"
            )
        self.x, self.p, self.r = _names("state", n), _names("costate", n), _names("pull_u", m)
        self.measured = inputs[:n]
        self.wanted = inputs[n:]
        self.alpha = problem.relaxation
        self.later: list[tuple[str, float, str]] = []

    # ------------------------------------------------------------------ short hands
    def address(self, offset: int, before: int = 0) -> int:
        """Address of a word of the slot that the index names, or of one `before` it."""
        return (1 - before) * self.slot.size + offset

    def index(self, value: int) -> None:
        self.plan.op("iadd", value * self.slot.size, 0, to="i")

    def step(self, by: int) -> None:
        self.plan.op("iadd", "i", by * self.slot.size, to="i")

    def copy(self, source: str | float = 0.0, to: str = "") -> str:
        return self.plan.op("fsub", source, 0.0, to=to)

    # ------------------------------------------------------------------ parts
    def make(self) -> Plan:
        problem, plan = self.problem, self.plan
        self.references()
        self.index(problem.horizon - 1)
        self.gradients({}, self.end, 0, self.p, self.r)
        with plan.loop(ITERATION, problem.iterations - 1):
            plan.rewind()
            self.backward()
            self.forward(residuals=False)
            self.index(problem.horizon - 1)
            h_x = self.limit_states(0, False)
            self.limit_cone(residuals=False)
            self.gradients(h_x, self.end, 0, self.p, self.r)
        plan.rewind()
        self.clear()
        self.backward()
        self.forward(residuals=True)
        self.index(problem.horizon - 1)
        self.limit_states(0, True)
        self.limit_cone(residuals=True)
        for name, offset in zip(problem.inputs, self.slot.z, strict=True):
            plan.op("mov", plan.load("slot", self.slot.size + offset), to=name)
        self.finish_residuals()
        plan.finish()
        return plan

    def clear(self) -> None:
        """Largest residuals are found from zero on."""
        for name in RESIDUALS:
            self.plan.op("mov", 0.0, to=name)

    def finish_residuals(self) -> None:
        for name in RESIDUALS:
            self.plan.op("fsqrt", name, to=f"{name}_residual")

    def multiplied(self, matrix: np.ndarray, x: Sequence[str], into: Sequence[str]) -> list[str]:
        """A product that is computed once; with `into` written to these names, by `settle`."""
        return self.plan.product(Words(matrix), x, into=into)

    def pulls_of_states(self, before: int) -> dict[int, str]:
        """h of the boxed states of a step."""
        return self.loaded(self.slot.h_x, before)

    def pulls_of_inputs(self, before: int) -> dict[int, str]:
        return self.loaded(self.slot.h_u, before)

    def references(self) -> None:
        """-weight * reference: `end` of the last step, `pull` of the others."""
        problem, plan = self.problem, self.plan
        n, _, steps = problem.sizes
        self.pull: list[str] = []
        self.end: list[str] = []
        if problem.reference == "none":
            return
        plan.rewind()
        self.end = self.multiplied(-problem.terminal, self.wanted, _names("end", n))
        if problem.reference == "point":
            self.pull = self.multiplied(-problem.q, self.wanted, _names("pull", n))
            plan.settle()
            return
        plan.settle()
        # What a step had as its reference is that of the step before it, a tick later.
        self.index(0)
        with plan.loop("shift", steps - 1):
            moved = [plan.load("slot", self.address(o, -1), "i") for o in self.slot.pull]
            for name, offset in zip(moved, self.slot.pull, strict=True):
                plan.store(name, "slot", self.address(offset), "i")
            self.step(1)
        last = self.multiplied(-problem.q, [plan.load("end_ref", i) for i in range(n)], ())
        for name, offset in zip(last, self.slot.pull, strict=True):
            plan.store(name, "slot", (steps - 1) * self.slot.size + offset)
        for i, name in enumerate(self.wanted):
            plan.store(name, "end_ref", i)

    def gradients(
        self, h_x: dict[int, str], pull: list[str], before: int, q: list[str], r: list[str]
    ) -> tuple[list[str], list[str]]:
        """Gradients of a step's state and input, to the names of q and r if there are any."""
        rho_x, rho_u = self.problem.penalty
        n, m, _ = self.problem.sizes
        h_x = h_x or self.pulls_of_states(before)
        h_u = self.pulls_of_inputs(before)
        found_q = [
            self.gradient(h_x.get(i, ""), float(rho_x[i]), pull[i : i + 1], q[i] if q else "")
            for i in range(n)
        ]
        if r:
            return found_q, [
                self.gradient(h_u.get(j, ""), float(rho_u[j]), [], r[j]) for j in range(m)
            ]
        self.later = [(h_u.get(j, ""), float(rho_u[j]), self.r[j]) for j in range(m)]
        return found_q, []

    def gradient(self, h: str, rho: float, known: list[str], to: str) -> str:
        """rho h and a known pull, where there are any."""
        if h:
            return self.plan.op("fmadd" if known else "fmul", rho, h, *known, to=to)
        return known[0] if known and not to else self.copy(known[0] if known else 0.0, to)

    def loaded(self, offsets: dict[int, int], before: int) -> dict[int, str]:
        return {
            i: self.plan.load("slot", self.address(offset, before), "i")
            for i, offset in offsets.items()
        }

    def backward(self) -> None:
        """The index goes from the last step to the one before the first."""
        plan, gains, steps = self.plan, self.gains, self.problem.horizon
        with plan.loop(BACK, steps):
            pull = self.pull
            if self.slot.pull:
                pull = [plan.load("slot", self.address(o, 1), "i") for o in self.slot.pull]
            q, _ = self.gradients({}, pull, 1, [], [])
            d = plan.product(reversed_gains(-gains.s), self.r)
            d = plan.product(reversed_gains(-gains.sb), self.p, d, parts=SPLIT)
            q = plan.product(reversed_gains(-np.swapaxes(gains.k, 1, 2)), self.r, q)
            plan.product(reversed_gains(np.swapaxes(gains.f, 1, 2)), self.p, q, self.p)
            plan.settle()
            for h, rho, to in self.later:
                self.gradient(h, rho, [], to)
            for name, offset in zip(d, self.slot.d, strict=True):
                plan.store(name, "slot", self.address(offset), "i")
            self.step(-1)

    def forward(self, residuals: bool) -> None:
        """The index goes from the first step to one past the last."""
        plan, gains, (n, m, steps) = self.plan, self.gains, self.problem.sizes
        for name, to in zip(self.measured, self.x, strict=True):
            self.copy(name, to=to)
        self.index(0)
        b = np.broadcast_to(self.problem.b, (steps, n, m))
        with plan.loop(STEP, steps):
            d = [plan.load("slot", self.address(o), "i") for o in self.slot.d]
            w_u = self.loaded(self.slot.w_u, 0)
            h_u = self.loaded(self.slot.h_u, 0) if residuals else {}
            self.limit_states(1, residuals)
            start = plan.product(Words(b, (STEP,)), d)
            plan.product(Words(gains.f, (STEP,)), self.x, start, self.x)
            u = plan.product(Words(-gains.k, (STEP,)), self.x, d, parts=SPLIT)
            plan.settle()
            for j, value in enumerate(u):
                z = value
                if j in self.slot.t_u:
                    t = plan.op("fmadd", self.alpha, value, w_u[j])
                    plan.store(t, "slot", self.address(self.slot.t_u[j]), "i")
                elif j in w_u:
                    box = self.problem.input_box[:, j]
                    z, w, h = self.limit(value, w_u[j], box)
                    plan.store(w, "slot", self.address(self.slot.w_u[j]), "i")
                    plan.store(h, "slot", self.address(self.slot.h_u[j]), "i")
                    if residuals:
                        share = Words(np.full(steps, 1 / half_width(box[:, None])[0]), (STEP,))
                        self.residual(value, z, w_u[j], h_u[j], share)
                if residuals:
                    plan.store(z, "slot", self.address(self.slot.z[j]), "i")
            self.step(1)

    def limit_states(self, before: int, residuals: bool) -> dict[int, str]:
        """Limit the state that belongs to a slot; the new h. The measured one has no residual."""
        plan, slot, box = self.plan, self.slot, self.problem.state_box
        found = {}
        w_x = self.loaded(slot.w_x, before)
        h_x = self.loaded(slot.h_x, before) if residuals else {}
        for i, w_old in w_x.items():
            v, w, found[i] = self.limit(self.x[i], w_old, box[:, i])
            if residuals:
                share = np.full(self.problem.horizon, 1 / half_width(box[:, i : i + 1])[0])
                share[0] = 0.0
                words = Words(share, (STEP,)) if before else Words(share[1])
                self.residual(self.x[i], v, w_old, h_x[i], words)
            plan.store(w, "slot", self.address(slot.w_x[i], before), "i")
            plan.store(found[i], "slot", self.address(slot.h_x[i], before), "i")
        return found

    def limit(self, value: str, w: str, box: np.ndarray) -> tuple[str, str, str]:
        """Limited value, and what the slot holds of it for the next iteration."""
        t = self.plan.op("fmadd", self.alpha, value, w)
        v = self.limited(t, box)
        return v, *self.held(t, v)

    def held(self, t: str, v: str) -> tuple[str, str]:
        """w and h of the next iteration."""
        return self.plan.op("fnmsub", self.alpha, v, t), self.plan.op("fnmsub", 2.0, v, t)

    def limited(self, t: str, box: np.ndarray) -> str:
        low, high = (float(each) for each in box)
        if np.isinf(low):
            return self.plan.op("fmin", t, high)
        if np.isinf(high):
            return self.plan.op("fmax", t, low)
        return self.plan.op("fsat", t, low, high)

    def limit_cone(self, residuals: bool) -> None:
        """Limit the inputs in the cone of all steps; the index is that of the last step before and
        afterwards.
        """
        if not self.slot.t_u:
            return
        steps = self.problem.horizon
        rounds = -(-steps // STEPS)
        size = steps // rounds
        self.index(0)
        with self.plan.loop(CONE, rounds) if rounds > 1 else nullcontext():
            self.limit_some(size, residuals)
            self.step(size)
        self.limit_some(steps - rounds * size, residuals)
        self.index(steps - 1)

    def limit_some(self, count: int, residuals: bool) -> None:
        """Limit those of some steps from that of the index on."""
        plan, slot, box = self.plan, self.slot, self.problem.input_box
        steps = range(count)
        known = [self.loaded(slot.t_u, -k) for k in steps]
        old_w = [self.loaded(slot.w_u, -k) if residuals else {} for k in steps]
        old_h = [self.loaded(slot.h_u, -k) if residuals else {} for k in steps]
        value = [self.loaded(dict(enumerate(slot.z)), -k) if residuals else {} for k in steps]
        for k, t in enumerate(known):
            for j, v in self.projected(t).items():
                w, h = self.held(t[j], v)
                found = [(w, slot.w_u[j]), (h, slot.h_u[j])]
                if residuals:
                    share = 1 / float(half_width(box[:, j : j + 1])[0])
                    self.residual(value[k][j], v, old_w[k][j], old_h[k][j], share)
                    found.append((v, slot.z[j]))
                for word, offset in found:
                    plan.store(word, "slot", self.address(offset, -k), "i")

    def projected(self, t: dict[int, str]) -> dict[int, str]:
        """Inputs of a step projected onto the cone, as `Cone.limited` computes them."""
        plan, cone = self.plan, self.problem.cone
        assert cone is not None
        found: dict[int, str] = {}
        first, *others = cone.norm
        square = plan.op("fmul", t[first], t[first])
        for j in others:
            square = plan.op("fmadd", t[j], t[j], square)
        size, limit = plan.op("fsqrt", square), cone.limit
        radius: str | float = limit
        least: str | float = max(limit, TINY)
        if cone.axis is not None:
            axis = t[cone.axis]
            excess = plan.op("fsub", size, plan.op("fmadd", cone.slope, axis, limit))
            share = cone.share(self.problem.penalty[1])
            moved = plan.op("fmadd", share, plan.op("fmax", excess, 0.0), axis)
            found[cone.axis] = plan.op("fsat", moved, cone.low, cone.high)
            radius = plan.op("fmadd", cone.slope, found[cone.axis], limit)
            least = plan.op("fmax", radius, TINY)
        scale = plan.op("fdiv", radius, plan.op("fmax", size, least))
        for j in cone.norm:
            found[j] = plan.op("fmul", scale, t[j])
        return found

    def residual(self, value: str, v: str, w: str, h: str, share: Words | float) -> None:
        """Squares of the distance from the limited value, and of the limited value's move."""
        plan = self.plan
        before = plan.op("fsub", w, h)  # (2 - alpha) times the last limited value
        moved = plan.op("fnmsub", 1 / (2 - self.alpha), before, v)
        for name, each in zip(RESIDUALS, (plan.op("fsub", value, v), moved), strict=True):
            scaled = plan.op("fmul", share, each)
            plan.op("fmax", name, plan.op("fmul", scaled, scaled), to=name)


def _names(name: str, count: int) -> list[str]:
    return [f"{name}{i}" for i in range(count)]


def reversed_gains(values: np.ndarray) -> Words:
    """Gains (steps, ...) in the order of the loop from the last step to the first. After the last
    step there is no gain: what it would weigh is a state's alone.
    """
    return Words(values[::-1], (BACK,))
