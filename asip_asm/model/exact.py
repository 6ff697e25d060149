# SPDX-License-Identifier: Apache-2.0
"""Interpreter of a graph of core operations in exact binary32, many runs at once.

Independent of the assembler, of the instruction-set model and of the RTL: IEEE 754 by numpy, and
the fused multiply-add by rounding a double to odd before it is rounded to binary32 (Boldo and
Melquiond, "Emulation of FMA and correctly rounded sums", IEEE TC 57, 2008). Sine and cosine are
given, since the core's are not correctly rounded.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.graph import Graph, Node, binary32

Array = NDArray[np.float32 | np.int32 | np.uint32]
Sine = Callable[[NDArray[np.float32], bool], NDArray[np.float32]]
"""Sine, or with True cosine, of an array."""
INT32 = (-(1 << 31), (1 << 31) - 1)


def fma(a: Array, b: Array, c: Array) -> NDArray[np.float32]:
    """a*b + c with one rounding."""
    product = a.astype(np.float64) * b.astype(np.float64)  # exact: 48 bits
    addend = np.asarray(c, np.float64)
    total = product + addend
    virtual = total - product
    error = (product - (total - virtual)) + (addend - virtual)
    bits = np.atleast_1d(total).view(np.int64).copy()
    # Round to odd: an inexact sum whose last bit is even moves one place towards its error.
    error = np.atleast_1d(error)
    odd = np.isfinite(np.atleast_1d(total)) & (error != 0) & (bits & 1 == 0)
    away = (error > 0) == (bits >= 0)
    bits[odd] += np.where(away, 1, -1)[odd]
    return bits.view(np.float64).astype(np.float32).reshape(np.shape(total))


def _lesser(a: Array, b: Array) -> Array:
    """minimumNumber: -0 is below +0, a NaN loses."""
    zeros = (a == b) & np.signbit(a)
    return np.where(np.isnan(b) | (a < b) | zeros, a, b)


def _to_int(a: Array) -> NDArray[np.int32]:
    return np.clip(a.astype(np.float64), *INT32).astype(np.int64).astype(np.int32)


def _truth(a: NDArray[np.bool_]) -> NDArray[np.float32]:
    return a.astype(np.float32)


OPERATIONS: dict[str, Callable[..., Any]] = {
    "fmadd": fma,
    "fnmsub": lambda a, b, c: fma(-a, b, c),
    "fmsub": lambda a, b, c: fma(a, b, -c),
    "fnmadd": lambda a, b, c: fma(-a, b, -c),
    "fmul": lambda a, b: a * b,
    "fnmul": lambda a, b: -a * b,
    "fadd": lambda a, b: a + b,
    "fsub": lambda a, b: a - b,
    "feq": lambda a, b: _truth(a == b),
    "flt": lambda a, b: _truth(a < b),
    "fle": lambda a, b: _truth(a <= b),
    "fmin": _lesser,
    "fmax": lambda a, b: -_lesser(-a, -b),
    "fabs": np.abs,
    "fneg": lambda a: -a,
    "fsgn": lambda a: (np.sign(a) + np.float32(0)).astype(np.float32),
    "fsat": lambda a, b, c: np.where(a < b, b, np.where(a > c, c, a)),
    "sel": lambda a, b, c: np.where((a != 0) & ~np.isnan(a), b, c),
    "selge": lambda a, b, c: np.where(a >= 0, b, c),
    "selgt": lambda a, b, c: np.where(a > 0, b, c),
    "iadd": lambda a, b: a + b,
    "isub": lambda a, b: a - b,
    "fdiv": lambda a, b: a / b,
    "fsqrt": np.sqrt,
    "i2f": lambda a: a.astype(np.float32),
    "f2i": lambda a: _to_int(np.rint(a)),
    "f2it": lambda a: _to_int(np.trunc(a)),
}


FLOAT, INTEGER, BITS = KINDS = [np.dtype(kind) for kind in (np.float32, np.int32, np.uint32)]
TO_INT = ("iadd", "isub", "f2i", "f2it")
PART = 1 << 16  # values that are computed at once, so that the doubles of `fma` stay in the cache


def evaluate(graph: Graph, values: Mapping[str, Array], sine: Sine) -> dict[int, Array]:
    """Value of every node that is used, arrays (N,).

    values: arrays (N,) of inputs, states and parameters by name, float32 or int32. sine: of the
    core's unit. Operations of a kind that wait for no other one are computed at once: matrix laws
    have thousands of nodes.
    """

    def of_unit(a: NDArray[np.float32], cosine: bool) -> NDArray[np.float32]:
        return sine(a.ravel(), cosine).reshape(a.shape)

    operations = OPERATIONS | {
        "fsin": lambda a: of_unit(a, False),
        "fcos": lambda a: of_unit(a, True),
    }
    order = _order(graph)
    count = len(next(iter(values.values())))
    bits = np.empty((len(order.used), count), np.uint32)
    views = {kind: bits.view(kind) for kind in KINDS}
    kinds: dict[int, np.dtype[Any]] = dict.fromkeys(order.used, FLOAT)
    for row, i in enumerate(order.leaves):
        leaf = _leaf(graph.nodes[i], values, count)
        bits[row], kinds[i] = leaf.view(np.uint32), leaf.dtype
    for i in order.typed:
        kinds[i] = _kind(graph.nodes[i], kinds)
    most = max(1, PART // max(1, count))
    with np.errstate(all="ignore"):
        for op, first, size, args in order.groups:
            for begin in range(0, size, most):
                end = min(size, begin + most)
                words = [views[kind][rows[begin:end]] for kind, rows in args]
                bits[first + begin : first + end] = operations[op](*words).view(np.uint32)
    return {i: views[kinds[i]][row] for i, row in order.used.items()}


@dataclass(frozen=True)
class _Order:
    """Rows of the values of a graph, which has these nodes and roots: leaves first, then groups of
    operations of a kind that wait for no later one.
    """

    nodes: list[Node]
    roots: list[int]
    used: dict[int, int]  # node: its row, nodes as in the graph
    leaves: list[int]  # by row
    typed: list[int]  # operations that may give something else than binary32, as in the graph
    groups: list[tuple[str, int, int, list[tuple[np.dtype[Any], NDArray[np.intp]]]]]
    """Operation, first row and number of rows, and of each operand its type and its rows."""


_orders: WeakKeyDictionary[Graph, _Order] = WeakKeyDictionary()


def _order(graph: Graph) -> _Order:
    """Computed once for a graph that stays as it is: a law is interpreted tick by tick."""
    found = _orders.get(graph)
    if found is None or found.nodes != graph.nodes or found.roots != graph.roots():
        found = _orders[graph] = _ordered(graph)
    return found


def _ordered(graph: Graph) -> _Order:
    used, nodes = list(graph.used()), graph.nodes
    levels: dict[int, int] = {}
    groups: dict[tuple[int, str], list[int]] = {}
    for i in used:
        args = nodes[i].args
        levels[i] = 1 + max(levels[arg] for arg in args) if args else 0
        if args:
            groups.setdefault((levels[i], nodes[i].op), []).append(i)
    leaves = [i for i in used if not nodes[i].args]
    members = [group for _, group in sorted(groups.items())]
    row = {i: n for n, i in enumerate([*leaves, *(i for group in members for i in group)])}
    return _Order(
        nodes=list(nodes),
        roots=graph.roots(),
        used={i: row[i] for i in used},
        leaves=leaves,
        typed=[i for i in used if nodes[i].op in TO_INT or nodes[i].op.startswith("sel")],
        groups=[
            (
                nodes[group[0]].op,
                row[group[0]],
                len(group),
                [
                    (_read(nodes[group[0]].op, k), np.array([row[arg] for arg in args]))
                    for k, args in enumerate(zip(*(nodes[i].args for i in group), strict=True))
                ],
            )
            for group in members
        ],
    )


def _kind(node: Node, kinds: Mapping[int, np.dtype[Any]]) -> np.dtype[Any]:
    """Type of what an operation gives: a choice that of both its words, bits if they differ."""
    if node.op.startswith("sel"):
        first, second = (kinds[arg] for arg in node.args[1:])
        return first if first == second else BITS
    return INTEGER if node.op in TO_INT else FLOAT


def _read(op: str, position: int) -> np.dtype[Any]:
    """Words as the operation reads them: choices are of bits."""
    if op in ("iadd", "isub", "i2f"):
        return INTEGER
    return BITS if op.startswith("sel") and position > 0 else FLOAT


def _leaf(node: Node, values: Mapping[str, Array], size: int) -> Array:
    if node.op == "const":
        return np.full(size, binary32(node.number), np.float32)
    if node.op == "int_const":
        return np.full(size, node.value, np.int64).astype(np.int32)
    return np.ascontiguousarray(values[str(node.value)])
