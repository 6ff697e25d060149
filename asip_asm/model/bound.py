# SPDX-License-Identifier: Apache-2.0
"""Error bound of a compiled program at given inputs, derived from its operations.

With computed values y_i = f_i(y) + r_i and exact values x_i = f_i(x) the error of an output is at
most sum_i |d out / d x_i| (|r_i| + |remainder_i|): r_i is the rounding of operation i (half an ulp,
2^-24 of the result; the sine unit's stated error; a constant's distance from binary32; the stated
error of a function that the compiler approximates), and remainder_i what the first derivative of
f_i leaves out, bounded with a forward (running) bound of its arguments. Where a comparison is
closer than the error of its operands, either result counts. Higham, Accuracy and Stability of
Numerical Algorithms, chapter 3; adjoints as in Langlois' CENA method.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.functions import MARKED
from asip_asm.model.graph import Graph, binary32

Real = NDArray[np.float64]
Inputs = Mapping[str, NDArray[np.number]]
UNIT = 2.0**-24
"""Largest relative error of a rounding to nearest."""
TINY = 2.0**-150
"""Largest error of a rounding to a subnormal number."""
OWN = 1 + 2.0**-20
"""Allowance for the roundings of this computation itself, in double precision."""
SINE_ULP = 0.6
"""Largest error of the sine unit in ulp of the result (docs/units.md)."""


@dataclass(frozen=True)
class Step:
    """Value of an operation in double precision, its partial derivatives (by argument), its own
    error and a forward bound of its whole error; arrays (N,).
    """

    value: Real
    partials: tuple[Real, ...]
    own: Real
    error: Real


def bounds(graph: Graph, values: Inputs) -> tuple[dict[str, Real], dict[str, Real]]:
    """Values in double precision and error bounds of all outputs and next states, arrays (N,).

    values: inputs, states and parameters by name, exactly what the program gets.
    """
    steps: dict[int, Step] = {}
    with np.errstate(all="ignore"):
        for i in graph.used():
            steps[i] = _step(graph, i, values, steps)
        roots = {**graph.next_states, **graph.outputs}
        found = {name: OWN * _adjoint(graph, root, steps) for name, root in roots.items()}
    return {name: steps[root].value for name, root in roots.items()}, found


def _adjoint(graph: Graph, root: int, steps: Mapping[int, Step]) -> Real:
    """Sum over all operations of |derivative of the root| times own error."""
    weights: dict[int, Real] = {root: np.ones_like(steps[root].value)}
    total = np.zeros_like(steps[root].value)
    for i in range(root, -1, -1):
        weight = weights.pop(i, None)
        if weight is None:
            continue
        step = steps[i]
        total = total + _product(np.abs(weight), step.own)
        for arg, partial in zip(_arguments(graph, i), step.partials, strict=True):
            weights[arg] = weights.get(arg, 0.0) + _product(weight, partial)
    return total


def _product(a: Real, b: Real) -> Real:
    """a * b; 0 where one of them is: a branch not taken adds nothing, whatever its value is."""
    return np.where((a == 0) | (b == 0), 0.0, a * b)


def _arguments(graph: Graph, i: int) -> tuple[int, ...]:
    return graph.functions[i][1] if i in graph.functions else graph.nodes[i].args


def _step(graph: Graph, i: int, values: Inputs, steps: Mapping[int, Step]) -> Step:
    node = graph.nodes[i]
    size = len(next(iter(values.values())))
    zero = np.zeros(size)
    if node.op == "const":
        exact = node.number
        lost = abs(float(binary32(exact)) - exact)
        return Step(np.full(size, exact), (), zero + lost, zero + lost)
    if node.op == "int_const":
        return Step(np.full(size, node.number), (), zero, zero)
    if not node.args:
        return Step(values[str(node.value)].astype(np.float64), (), zero, zero)
    args = [steps[arg] for arg in _arguments(graph, i)]
    x, e = [a.value for a in args], [a.error for a in args]
    if i in graph.functions:
        function = MARKED[graph.functions[i][0]]
        value, partials = function.exact(*x), function.partials(*x)
        own = function.ulp * 2 * UNIT * np.abs(value) + function.absolute
        own = own + function.own(*x) if function.own else own
        curved = _curvature(function.partials, x, e, partials)
        return _finish(value, partials, own + curved, e)
    value, partials, own = RULES[node.op](x, e)
    return _finish(value, partials, own, e)


def _curvature(
    rule: Callable[..., tuple[Real, ...]], x: list[Real], e: list[Real], here: tuple[Real, ...]
) -> Real:
    """What the first derivatives leave out: their change over the error of the arguments."""
    total = np.zeros_like(x[0])
    for sign in (1, -1):
        moved = rule(*(v + sign * d for v, d in zip(x, e, strict=True)))
        change = [np.abs(m - h) * d for m, h, d in zip(moved, here, e, strict=True)]
        total = np.maximum(total, sum(change))
    return np.nan_to_num(total, nan=np.inf)


def _finish(value: Real, partials: tuple[Real, ...], own: Real, e: list[Real]) -> Step:
    error = own + sum(
        (_product(np.abs(p), d) for p, d in zip(partials, e, strict=True)), np.zeros_like(value)
    )
    return Step(value, partials, own, np.where(np.isnan(error), np.inf, error))


Rule = Callable[[list[Real], list[Real]], tuple[Real, tuple[Real, ...], Real]]


def _rounded(value: Real, spread: Real, units: float = 1.0) -> Real:
    """Error of one rounding of a value known up to `spread`."""
    return units * UNIT * (np.abs(value) + spread) + TINY


def _multiply(sign: int, addend: int = 0) -> Rule:
    """Product, with an addend of this sign if there is one."""

    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        value = sign * x[0] * x[1]
        partials: tuple[Real, ...] = (sign * x[1], sign * x[0])
        spread = np.abs(x[0]) * e[1] + np.abs(x[1]) * e[0]
        if addend:
            value = value + addend * x[2]
            partials = (*partials, addend * np.ones_like(value))
            spread = spread + e[2]
        second = e[0] * e[1]
        return value, partials, _rounded(value, spread + second) + second

    return rule


def _add(sign: int, exact: bool = False) -> Rule:
    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        value = x[0] + sign * x[1]
        ones = np.ones_like(value)
        own = np.zeros_like(value) if exact else _rounded(value, e[0] + e[1])
        return value, (ones, sign * ones), own

    return rule


def _divide(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
    a, b = x
    value = a / b
    partials = (1 / b, -a / (b * b))
    room = np.maximum(np.abs(b) - e[1], 0.0)
    second = (e[0] + np.abs(value) * e[1]) * e[1] / (np.abs(b) * room)
    spread = np.abs(partials[0]) * e[0] + np.abs(partials[1]) * e[1] + second
    return value, partials, _rounded(value, spread) + np.where(e[1] > 0, second, 0.0)


def _root(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
    """At 0 the root of an argument with error e is off by up to sqrt(e)."""
    value = np.sqrt(x[0])
    partial = np.where(value > 0, 0.5 / value, 0.0)
    low = np.sqrt(np.maximum(x[0] - e[0], 0.0))
    below = np.maximum(value - low - partial * np.minimum(e[0], x[0]), 0.0)
    second = np.where(value > 0, below, np.sqrt(e[0]))
    return value, (partial,), _rounded(value, partial * e[0] + second) + second


def _sine(cosine: bool) -> Rule:
    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        value, other = (np.cos(x[0]), -np.sin(x[0])) if cosine else (np.sin(x[0]), np.cos(x[0]))
        own = _rounded(value, np.abs(other) * e[0], 2 * SINE_ULP) + e[0] * e[0] / 2
        return value, (other,), own

    return rule


def _compare(test: Callable[[Real, Real], NDArray[np.bool_]]) -> Rule:
    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        spread = e[0] + e[1]
        doubtful = (np.abs(x[0] - x[1]) <= spread) & (spread > 0)
        zero = np.zeros_like(x[0])
        return test(x[0], x[1]).astype(float), (zero, zero), doubtful.astype(float)

    return rule


def _select(test: Callable[[Real], NDArray[np.bool_]]) -> Rule:
    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        chosen = test(x[0])
        value = np.where(chosen, x[1], x[2])
        doubtful = (np.abs(x[0]) <= e[0]) | ((e[0] >= 1) & (x[0] == 1)) & (e[0] > 0)
        doubtful &= e[0] > 0
        own = np.where(doubtful, np.abs(x[1] - x[2]) + e[1] + e[2], 0.0)
        one = chosen.astype(float)
        return value, (np.zeros_like(one), one, 1 - one), own

    return rule


def _extreme(choose: Callable[..., Real]) -> Rule:
    """Minimum, maximum, saturation: the value is one of the arguments; where another is nearer than
    their errors, theirs count too.
    """

    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        value = choose(*x)
        left = np.ones(len(value), bool)
        partials, own = [], np.zeros_like(value)
        for v in x:
            taken = left & (v == value)
            left &= ~taken
            partials.append(taken.astype(float))
            near = np.abs(v - value) <= sum(e)
            own += np.where(near & ~taken, sum(e), 0.0)
        return value, tuple(partials), own

    return rule


def _sign(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
    doubtful = (np.abs(x[0]) <= e[0]) & (e[0] > 0)
    return np.sign(x[0]), (np.zeros_like(x[0]),), 2.0 * doubtful.astype(np.float64)


def _absolute(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
    return np.abs(x[0]), (np.sign(x[0]),), np.where(np.abs(x[0]) <= e[0], 2 * e[0], 0.0)


def _to_float(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
    own = np.where(np.abs(x[0]) > 2.0**24, UNIT * np.abs(x[0]), 0.0)
    return x[0], (np.ones_like(x[0]),), own


def _to_int(round_: Callable[[Real], Real]) -> Rule:
    def rule(x: list[Real], e: list[Real]) -> tuple[Real, tuple[Real, ...], Real]:
        doubtful = round_(x[0] - e[0]) != round_(x[0] + e[0])
        return round_(x[0]), (np.zeros_like(x[0]),), doubtful.astype(float)

    return rule


RULES: dict[str, Rule] = {
    "fmadd": _multiply(1, 1),
    "fnmsub": _multiply(-1, 1),
    "fmsub": _multiply(1, -1),
    "fnmadd": _multiply(-1, -1),
    "fmul": _multiply(1),
    "fnmul": _multiply(-1),
    "fadd": _add(1),
    "fsub": _add(-1),
    "iadd": _add(1, exact=True),
    "isub": _add(-1, exact=True),
    "fdiv": _divide,
    "fsqrt": _root,
    "fsin": _sine(False),
    "fcos": _sine(True),
    "fneg": lambda x, e: (-x[0], (-np.ones_like(x[0]),), np.zeros_like(x[0])),
    "fabs": _absolute,
    "fsgn": _sign,
    "fmin": _extreme(np.minimum),
    "fmax": _extreme(np.maximum),
    "fsat": _extreme(lambda a, b, c: np.minimum(np.maximum(a, b), c)),
    "feq": _compare(np.equal),
    "flt": _compare(np.less),
    "fle": _compare(np.less_equal),
    "sel": _select(lambda a: a != 0),
    "selge": _select(lambda a: a >= 0),
    "selgt": _select(lambda a: a > 0),
    "i2f": _to_float,
    "f2i": _to_int(np.rint),
    "f2it": _to_int(np.trunc),
}
