# SPDX-License-Identifier: Apache-2.0
"""Random laws, and their values in 200 bits, for the tests of the certificate."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import casadi as ca
import gmpy2
import numpy as np

from asip_asm.model.graph import Graph
from asip_asm.model.law import Law, Port, build_graph

PRECISION = 200
LIMITS = ((-1.0, 1.0), (0.25, 4.0), (-3.0, 0.5), (-100.0, 100.0))


def alone(expression: Callable[[ca.SX], ca.SX], size: int, limits: tuple[float, float]) -> Law:
    """A law r = expression(x) of inputs with the same limits."""
    x = ca.SX.sym("x", size)
    function = ca.Function("f", [x], [ca.vertcat(expression(x))], ["x"], ["r"])
    ports = [Port("input", f"x{i}", vector="x", limits=limits) for i in range(size)]
    ports += [Port("output", f"r{i}", vector="r") for i in range(function.nnz_out())]
    return Law("alone", function, ports)


def random_law(seed: int) -> Law:
    """Some operations on four inputs, of every kind that the core has."""
    rng = np.random.default_rng(seed)
    symbols = [ca.SX.sym(f"x{i}") for i in range(4)]
    known = [*symbols, ca.SX(float(rng.uniform(-2, 2))), ca.SX(0.1)]

    def some() -> ca.SX:
        return known[int(rng.integers(len(known)))]

    kinds: list[Callable[[], ca.SX]] = [
        lambda: some() + some(),
        lambda: some() - some(),
        lambda: some() * some(),
        lambda: some() * some() + some(),
        lambda: some() * some() - some() * some(),
        lambda: some() / (some() ** 2 + 0.5),
        lambda: ca.sqrt(ca.fabs(some()) + 0.25),
        lambda: ca.sqrt(ca.fmax(some() - some(), 0)),
        lambda: ca.sin(ca.fmin(ca.fmax(some(), -20), 20)),
        lambda: ca.cos(ca.fmin(ca.fmax(some(), -20), 20)),
        lambda: ca.fmin(some(), some()),
        lambda: ca.fmax(some(), some()),
        lambda: ca.fabs(some()),
        lambda: ca.sign(some()),
        lambda: ca.if_else(some() > some(), some(), some()),
        lambda: ca.if_else(some() == 0, 1, some()),
        lambda: ca.floor(ca.fmin(ca.fmax(some(), -50), 50)),
        lambda: ca.exp(ca.fmin(some(), 3)),
        lambda: ca.atan(some()),
    ]
    for _ in range(int(rng.integers(4, 14))):
        known.append(kinds[int(rng.integers(len(kinds)))]())
    last = known[-1] + known[-2]
    function = ca.Function("f", symbols, [last, known[-1]], [str(s) for s in symbols], ["a", "b"])
    ports = [
        Port("input", f"x{i}", limits=LIMITS[int(rng.integers(len(LIMITS)))]) for i in range(4)
    ]
    ports += [Port("output", "a", limits=(-50.0, 50.0)), Port("output", "b")]
    return Law("random", function, ports)


Number = gmpy2.mpfr
OPERATIONS: dict[str, Callable[..., Number]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "sqrt": gmpy2.sqrt,
    "abs": abs,
    "sin": gmpy2.sin,
    "cos": gmpy2.cos,
    "exp": gmpy2.exp,
    "atan": gmpy2.atan,
    "min": lambda a, b: min(a, b),
    "max": lambda a, b: max(a, b),
    "sign": lambda a: gmpy2.mpfr(gmpy2.sign(a)),
    "floor": gmpy2.floor,
    "trunc": gmpy2.trunc,
    "lt": lambda a, b: gmpy2.mpfr(a < b),
    "le": lambda a, b: gmpy2.mpfr(a <= b),
    "eq": lambda a, b: gmpy2.mpfr(a == b),
    "not": lambda a: gmpy2.mpfr(a == 0),
    "pow": lambda a, b: a**b,
    "fmod": gmpy2.fmod,
    "select": lambda a, b, c: b if a != 0 else c,
    "sat": lambda a, b, c: min(max(a, b), c),
}


def in_200_bits(law: Law, point: Mapping[str, float]) -> dict[str, Number]:
    """Values of the law as the user wrote it, at a point."""
    graph: Graph = build_graph(law)
    with gmpy2.context(gmpy2.get_context(), precision=PRECISION):
        values: dict[int, Number] = {}
        for i in graph.used():
            node = graph.nodes[i]
            if node.args:
                values[i] = OPERATIONS[node.op](*(values[arg] for arg in node.args))
            else:
                given = node.value if node.op == "const" else point[str(node.value)]
                values[i] = gmpy2.mpfr(float(given))
        return {name: values[root] for name, root in graph.outputs.items()}
