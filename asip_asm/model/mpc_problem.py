# SPDX-License-Identifier: Apache-2.0
"""Problems of model-predictive control: the file that states one, and the constants of its solver.

A problem is: over `horizon` steps of x+ = A x + B u minimise the sum of (x - r)' Q (x - r) / 2 and
u' R u / 2, the last state weighed with `terminal` in place of Q, each boxed state and input within
its limits, and some inputs within a second-order cone. docs/your_robot.md shows a file.

The solver is ADMM with over-relaxation (Boyd and others, 2011, sections 3.4.3 and 5.2), its primal
step a Riccati recursion as in TinyMPC (Nguyen and others, ICRA 2024), but with the gains of each
step, so any terminal cost is exact. All constants are made here in double precision.
"""

from __future__ import annotations

import itertools
import re
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, expm, solve_discrete_are

from asip_asm.diagnostics import closest
from asip_asm.model.mpc_cone import Cone
from asip_asm.model.read import ModelError
from asip_asm.source import is_reserved

Matrix = NDArray[np.float64]
REFERENCES = ("none", "point", "trajectory")
"""References: the origin; an input for the whole horizon; one for its end, used later."""
KEYS = (
    "title", "horizon", "iterations", "sample_time", "continuous", "A", "B", "Q", "R", "terminal",
    "reference", "states", "inputs", "state_box", "input_box", "input_cone", "start",
    "penalty", "relaxation",
)  # fmt: skip
SIZES = {"horizon": (2, 256), "iterations": (2, 1000), "states": (1, 32), "inputs": (1, 16)}
"""Least and most of each number; the memories of the core are checked where a program is made."""
CONE = ("norm", "axis", "slope", "limit")
RELAXATIONS = (1.0, 1.6)
STEPS = (1.0, 0.25)
"""Penalties tried, for limits of -1 and 1: decades around 1, then quarters of the best decade."""
SAMPLES, LONG, SEED = 100, 500, 38
SHARE = 0.9
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True)
class Problem:
    """A problem of n states and m inputs. boxes: (2, n) and (2, m), lower and upper limits, +-inf
    without one; the box of an input in the cone is that which the cone implies. start: (2, n) box
    of the initial states for which distances are stated. penalty: weights (n,) and (m,) of the
    constraints; relaxation: 1 for plain ADMM.
    """

    path: Path
    title: str
    horizon: int
    iterations: int
    sample_time: float
    a: Matrix
    b: Matrix
    q: Matrix
    r: Matrix
    terminal: Matrix
    reference: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    state_box: Matrix
    input_box: Matrix
    start: Matrix
    penalty: tuple[Matrix, Matrix]
    relaxation: float
    cone: Cone | None = None

    @property
    def sizes(self) -> tuple[int, int, int]:
        """States, inputs, steps."""
        return len(self.states), len(self.inputs), self.horizon

    def boxed(self) -> tuple[list[int], list[int]]:
        """States and inputs that have a limit."""
        boxes = (self.state_box, self.input_box)
        found = [np.flatnonzero(np.isfinite(box).any(axis=0)).tolist() for box in boxes]
        return found[0], found[1]

    def limited_inputs(self, u: Matrix) -> Matrix:
        """Nearest inputs within their limits, of inputs (..., m)."""
        found = np.clip(u, *self.input_box)
        if self.cone:
            inputs = list(self.cone.inputs)
            found[..., inputs] = self.cone.limited(u, self.penalty[1])[..., inputs]
        return found


@dataclass(frozen=True)
class Gains:
    """Of each step k: u = d - K x, x+ = F x + B d (F = A - B K); backward
    p = q + F' p+ - K' r and d = -S (B' p+ + r); arrays begin with the step's axis.
    """

    k: Matrix
    f: Matrix
    s: Matrix
    sb: Matrix


def riccati(problem: Problem) -> Gains:
    """Gains of the problem with its penalties as weights."""
    a, b = problem.a, problem.b
    rho_x, rho_u = problem.penalty
    q, r = problem.q + np.diag(rho_x), problem.r + np.diag(rho_u)
    p = problem.terminal + np.diag(rho_x)
    found = []
    for _ in range(problem.horizon):
        s = np.linalg.inv(r + b.T @ p @ b)
        k = s @ b.T @ p @ a
        f = a - b @ k
        found.append((k, f, s, s @ b.T))
        p = q + a.T @ p @ f
        p = (p + p.T) / 2
    return Gains(*(np.stack(parts[::-1]) for parts in zip(*found, strict=True)))


class _File:
    """A problem file under the checks; errors name file, line, cause and cure."""

    def __init__(self, path: Path) -> None:
        self.path, self.text = path, path.read_text(encoding="utf-8")
        try:
            self.values: dict[str, Any] = tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as error:
            raise ModelError(f"{path}: error: {error}; write the problem as TOML") from None
        for key in self.values:
            if key not in KEYS:
                near = closest(key, KEYS) or f"keys are {', '.join(KEYS)}"
                self.fail(key, f"unknown key '{key}'; {near}")

    def fail(self, key: str, text: str) -> NoReturn:
        lines = enumerate(self.text.splitlines(), 1)
        table = rf"\s*\[?{re.escape(key)}\s*[\]=]"
        line = next((f"{n}:" for n, row in lines if re.match(table, row)), "")
        raise ModelError(f"{self.path}:{line} error: {text}")

    def get(self, key: str, kind: type | tuple[type, ...], default: Any = None) -> Any:
        value = self.values.get(key, default)
        if value is None:
            self.fail(key, f"no '{key}'; every problem states it")
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            self.fail(key, f"'{key}' is {value!r}; see the example in docs/your_robot.md")
        return value

    def whole(self, key: str) -> int:
        value, (low, high) = self.get(key, int), SIZES[key]
        if not low <= value <= high:
            self.fail(key, f"{key} = {value}; it is {low} to {high}")
        return value

    def positive(self, key: str, default: float | None = None) -> float:
        value = float(self.get(key, (int, float), default))
        if not 0 < value < np.inf:
            self.fail(key, f"{key} = {value}; it is above 0")
        return value

    def names(self, key: str) -> tuple[str, ...]:
        found = tuple(self.get(key, list))
        low, high = SIZES[key]
        if not low <= len(found) <= high:
            self.fail(key, f"{len(found)} {key}; there are {low} to {high}")
        for name in found:
            if not isinstance(name, str) or not _NAME.fullmatch(name) or is_reserved(name):
                self.fail(key, f"{name!r} cannot name a signal; take letters, digits and '_'")
            if found.count(name) > 1:
                self.fail(key, f"'{name}' appears twice; rename one")
        return found

    def matrix(self, key: str, rows: int, columns: int, value: Any = None) -> Matrix:
        given = self.get(key, (list, str)) if value is None else value
        try:
            found = np.array(given, float)
        except (ValueError, TypeError):
            self.fail(key, f"'{key}' is no matrix of numbers; give {rows} rows of {columns}")
        if found.shape != (rows, columns):
            shape = " by ".join(map(str, found.shape))
            self.fail(key, f"'{key}' is {shape}; with {self.counts()} it is {rows} by {columns}")
        if not np.isfinite(found).all():
            self.fail(key, f"'{key}' has an entry that is not finite; give numbers")
        return found

    def counts(self) -> str:
        states, inputs = self.values["states"], self.values["inputs"]
        return f"{len(states)} states and {len(inputs)} inputs"

    def weight(self, key: str, size: int, definite: bool, value: Any = None) -> Matrix:
        """A symmetric weight, given whole or by its diagonal."""
        given = self.get(key, list) if value is None else value
        if given and not isinstance(given[0], list):
            given = np.diag(self.matrix(key, 1, size, [given])[0]).tolist()
        found = self.matrix(key, size, size, given)
        if not np.allclose(found, found.T):
            self.fail(key, f"'{key}' is not symmetric; give (M + M') / 2")
        least = np.linalg.eigvalsh(found).min()
        if least < -1e-12 * np.abs(found).max(initial=0) or (definite and least <= 0):
            what = "positive definite" if definite else "positive semidefinite"
            self.fail(key, f"'{key}' has the eigenvalue {least:.3g}; it must be {what}")
        return (found + found.T) / 2

    def box(self, key: str, names: tuple[str, ...], infinite: bool) -> Matrix:
        """Limits (2, size) of a table {low = [...], high = [...]}."""
        table = self.get(key, dict, {} if infinite else None)
        for name in table:
            if name not in ("low", "high"):
                self.fail(key, f"unknown key '{key}.{name}'; a box has low and high")
        size, rows = len(names), []
        for end, sign in (("low", -1), ("high", 1)):
            given = table.get(end, [sign * np.inf] * size if infinite else None)
            try:
                row = np.array(given, float)
            except (ValueError, TypeError):
                row = np.empty(0)
            if row.shape != (size,) or np.isnan(row).any():
                self.fail(key, f"'{key}.{end}' needs {size} numbers, one for each of "
                          f"{', '.join(names)}")  # fmt: skip
            rows.append(row)
        found = np.stack(rows)
        for name, low, high in zip(names, *found, strict=True):
            if not low < high:
                self.fail(key, f"the box of '{name}' is {low:g} to {high:g}; low is below high")
        if not infinite and not np.isfinite(found).all():
            self.fail(key, f"'{key}' is not finite; give the range of the initial states")
        return found


def load_problem(path: Path) -> Problem:
    """The problem of a file. Raises ModelError, OSError."""
    file = _File(path)
    states, inputs = file.names("states"), file.names("inputs")
    both = set(states) & set(inputs)
    if both:
        file.fail("inputs", f"'{both.pop()}' is a state and an input; rename one")
    n, m = len(states), len(inputs)
    a, b = file.matrix("A", n, n), file.matrix("B", n, m)
    sample_time = file.positive("sample_time")
    if file.get("continuous", bool, False):
        whole = expm(sample_time * np.block([[a, b], [np.zeros((m, n + m))]]))
        a, b = whole[:n, :n], whole[:n, n:]
    q, r = file.weight("Q", n, False), file.weight("R", m, True)
    reference = file.get("reference", str, REFERENCES[0])
    if reference not in REFERENCES:
        file.fail("reference", f"reference = '{reference}'; it is {', '.join(REFERENCES)}")
    state_box, input_box = file.box("state_box", states, True), file.box("input_box", inputs, True)
    cone, input_box = _cone(file, inputs, input_box)
    if not np.isfinite([*state_box.ravel(), *input_box.ravel()]).any():
        file.fail("input_box", "no state and no input has a limit; an LQR needs no MPC")
    problem = Problem(
        path, file.get("title", str), file.whole("horizon"), file.whole("iterations"), sample_time,
        a, b, q, r, _terminal(file, a, b, q, r), reference, states, inputs, state_box, input_box,
        file.box("start", states, False), (np.zeros(n), np.zeros(m)), 1.0, cone,
    )  # fmt: skip
    return _with_penalty(file, problem)


def _cone(file: _File, inputs: tuple[str, ...], box: Matrix) -> tuple[Cone | None, Matrix]:
    """The cone of the file, if any, and the box of the inputs with what the cone implies."""
    key, table = "input_cone", file.get("input_cone", dict, {})
    if not table:
        return None, box
    for name in table:
        if name not in CONE:
            near = closest(name, CONE) or f"a cone has {', '.join(CONE)}"
            file.fail(key, f"unknown key '{key}.{name}'; {near}")

    def number(name: str, default: float) -> float:
        value = table.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            file.fail(key, f"{key}.{name} = {value!r}; give a number")
        return float(value)

    def known(name: object) -> int:
        if name not in inputs:
            near = closest(name, inputs) if isinstance(name, str) else ""
            file.fail(key, f"{key} names {name!r}; {near or 'inputs are ' + ', '.join(inputs)}")
        return inputs.index(str(name))

    given = table.get("norm")
    if not isinstance(given, list) or not given:
        file.fail(key, f"{key}.norm = {given!r}; give a list of inputs")
    norm = tuple(known(name) for name in given)
    axis = known(table["axis"]) if "axis" in table else None
    named = [*norm, *([] if axis is None else [axis])]
    twice = next((inputs[j] for j in named if named.count(j) > 1), None)
    if twice:
        file.fail(key, f"{key} names '{twice}' twice; take it out of norm or axis")
    if ("axis" in table) != ("slope" in table):
        file.fail(key, f"{key} has one of axis and slope; give both, or neither for a ball")
    slope, limit = number("slope", 0.0), number("limit", 0.0)
    if axis is not None and slope <= 0:
        file.fail(key, f"{key}.slope = {slope:g}; it is above 0")
    for j in norm:
        if np.isfinite(box[:, j]).any():
            file.fail("input_box", f"input_box limits '{inputs[j]}', which {key} limits; give it "
                      "-inf and inf there, or take it out of the cone")  # fmt: skip
    low = high = 0.0
    if axis is not None:
        low, high = max(float(box[0, axis]), -limit / slope), float(box[1, axis])
        if not np.isfinite(high):
            file.fail("input_box", f"input_box has no upper limit of '{inputs[axis]}', the axis of "
                      f"{key}; give one")  # fmt: skip
    cone = Cone(norm, axis, slope, limit, low, high)
    if not cone.radius > 0:
        file.fail(key, f"{key} allows a norm of {cone.radius:g} at most; give a larger limit")
    box = box.copy()
    box[:, list(norm)] = [[-cone.radius], [cone.radius]]
    if axis is not None:
        box[0, axis] = low
    return cone, box


def _terminal(file: _File, a: Matrix, b: Matrix, q: Matrix, r: Matrix) -> Matrix:
    given = file.get("terminal", (str, list), "lqr")
    if isinstance(given, list):
        return file.weight("terminal", len(a), False)
    if given == "Q":
        return q
    if given != "lqr":
        file.fail("terminal", f"terminal = '{given}'; it is 'lqr', 'Q' or a weight")
    try:
        return solve_discrete_are(a, b, q, r)
    except (LinAlgError, ValueError):
        file.fail("A", "A and B have no LQR: an unstable state that no input moves, or one that Q "
                  "does not weigh; set terminal = 'Q' or a matrix")  # fmt: skip


def _with_penalty(file: _File, problem: Problem) -> Problem:
    """The problem with the penalties of the file, or those with which the solver comes nearest to
    its own result after many iterations, from drawn initial states.
    """
    table = file.get("penalty", dict, {})
    for name in table:
        if name not in ("state", "input"):
            file.fail("penalty", f"unknown key 'penalty.{name}'; it has state and input")
    relaxation = file.get("relaxation", (int, float), 0)
    if relaxation and not 1 <= relaxation < 2:
        file.fail("relaxation", f"relaxation = {relaxation}; it is 1 to below 2")
    shapes = [_shape(problem.state_box), _shape(problem.input_box)]
    fixed = []
    for name, shape in zip(("state", "input"), shapes, strict=True):
        given = table.get(name)
        if given is not None and not (isinstance(given, int | float) and given > 0):
            file.fail("penalty", f"penalty.{name} = {given!r}; it is above 0")
        fixed.append(given if given is not None else None if shape.any() else 1.0)
    start = drawn(problem, SAMPLES, SEED)
    dense = _Dense(problem)
    least: Matrix | None = None
    centre, choice = [0.0, 0.0], problem
    for step in STEPS if None in fixed or not relaxation else STEPS[-1:]:
        grids = [
            [at] if at is not None else [10.0 ** (middle + k * step) for k in range(-2, 3)]
            for at, middle in zip(fixed, centre, strict=True)
        ]
        alphas = (float(relaxation),) if relaxation else RELAXATIONS
        choices = [
            _replace(problem, (x * shapes[0], u * shapes[1]), alpha)
            for x, u, alpha in itertools.product(*grids, alphas)
        ]
        if len(choices) == 1:
            return choices[0]
        if least is None:
            least, _ = dense.outcome(start, dense.solve(choices[len(choices) // 2], start, LONG))
        scores = [dense.score(each, start, least) for each in choices]
        best = int(np.argmin(scores))
        choice = choices[best]
        pair = list(itertools.product(*grids, alphas))[best]
        centre = [float(np.log10(each)) for each in pair[:2]]
    return choice


def _replace(problem: Problem, penalty: tuple[Matrix, Matrix], relaxation: float) -> Problem:
    return replace(problem, penalty=penalty, relaxation=relaxation)


def drawn(problem: Problem, count: int, seed: int) -> Matrix:
    """Initial states (count, n) drawn from the box `start`."""
    low, high = problem.start
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


def half_width(box: Matrix) -> Matrix:
    """Of each coordinate of a box (2, size); its size where one end is open, 1 where that is 0."""
    width = (box[1] - box[0]) / 2
    one = np.abs(np.where(np.isfinite(box[0]), box[0], box[1]))
    return np.where(np.isfinite(width), width, np.where(one > 0, one, 1.0))


def _shape(box: Matrix) -> Matrix:
    """Penalty of a coordinate by that of one with limits -1 and 1; 0 without limits."""
    return np.where(np.isfinite(box).any(axis=0), half_width(box) ** -2.0, 0.0)


class _Dense:
    """The same iterations on the inputs alone, the states written as sums of inputs: for many
    initial states at once.
    """

    def __init__(self, problem: Problem) -> None:
        n, m, steps = problem.sizes
        powers = [np.linalg.matrix_power(problem.a, k) for k in range(steps + 1)]
        self.free = np.vstack(powers[1:])
        self.forced = np.zeros((steps * n, steps * m))
        for k in range(steps):
            for j in range(k + 1):
                block = powers[k - j] @ problem.b
                self.forced[k * n : (k + 1) * n, j * m : (j + 1) * m] = block
        self.q = np.kron(np.eye(steps), problem.q)
        self.q[-n:, -n:] = problem.terminal
        self.r = np.kron(np.eye(steps), problem.r)
        self.box = np.tile(problem.state_box, steps)

    def solve(self, problem: Problem, start: Matrix, iterations: int) -> Matrix:
        """Inputs (samples, steps m) within their box after so many iterations from zero."""
        steps, alpha = problem.horizon, problem.relaxation
        rho = [np.tile(weights, steps) for weights in problem.penalty]
        weight = self.q + np.diag(rho[0])
        left = self.forced.T @ weight
        inverse = np.linalg.inv(left @ self.forced + self.r + np.diag(rho[1]))
        fixed = start @ (inverse @ left @ self.free).T
        free = start @ self.free.T
        gain = [(inverse @ self.forced.T * rho[0]).T, (inverse * rho[1]).T]
        w = [np.zeros((len(start), len(each))) for each in rho]
        h = [np.zeros_like(each) for each in w]
        slack = h
        for _ in range(iterations):
            u = -(fixed + h[0] @ gain[0] + h[1] @ gain[1])
            both = (free + u @ self.forced.T, u)
            t = [alpha * one + each for one, each in zip(both, w, strict=True)]
            inputs = t[1].reshape(len(start), steps, -1)
            slack = [
                np.clip(t[0], *self.box),
                problem.limited_inputs(inputs).reshape(t[1].shape),
            ]
            w = [one - alpha * v for one, v in zip(t, slack, strict=True)]
            h = [one - 2 * v for one, v in zip(t, slack, strict=True)]
        return slack[1]

    def score(self, problem: Problem, start: Matrix, least: Matrix) -> float:
        """Cost above the `least` one, as a share of it, below which nine of ten
        states stay, and the largest violation of a state's box, by half its width."""
        cost, beyond = self.outcome(start, self.solve(problem, start, problem.iterations))
        above = (cost - least) / np.maximum(least, 1e-12)
        return float(np.quantile(above, SHARE) + beyond.max())

    def outcome(self, start: Matrix, u: Matrix) -> tuple[Matrix, Matrix]:
        """Cost, and largest violation of a state's box by half its width, of each plan."""
        states = u @ self.forced.T + start @ self.free.T
        cost = (states @ self.q * states).sum(axis=1) + (u @ self.r * u).sum(axis=1)
        low, high = self.box
        half = half_width(self.box)
        return cost / 2, (np.maximum(low - states, states - high).clip(0) / half).max(axis=1)
