# SPDX-License-Identifier: Apache-2.0
"""Operations of a law as a graph in which equal operations exist once.

A node is an operation on earlier nodes. Its meaning is a real number, or an int32 for the kinds in
`INT_KINDS`; what a pass may do to a graph keeps the meaning, and the bits too unless its header
says otherwise. Two families of operations share the graph:

- real operations, as a law is written, named as in CasADi: `ARITHMETIC`, `TESTS`, abs sign min max
  sin cos copysign exp log tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh erf log1p expm1
  pow floor ceil fmod remainder hypot; i2f, select (a != 0 ? b : c), sat (min(max(a, b), c));
- core operations, named like the instructions of isa.toml (`fmadd`, `fsat`, ...).

Leaves are `const` (value: double), `input`, `state` and `param` (value: name), `int_input`,
`int_state` (value: name) and `int_const` (value: int).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

Value = float | int | str | None

LEAVES = frozenset({"const", "input", "state", "param", "int_input", "int_state", "int_const"})
INT_KINDS = frozenset({"int_input", "int_state", "int_const", "iadd", "isub", "f2i", "f2it"})
ARITHMETIC = frozenset({"add", "sub", "mul", "neg", "div", "sqrt"})
TESTS = frozenset({"lt", "le", "eq", "not", "and", "or"})
"""Real operations whose value is 0 or 1."""


def binary32(value: float) -> np.float32:
    """The constant as the core holds it."""
    with np.errstate(over="ignore"):
        return np.float32(value)


@dataclass(frozen=True)
class Node:
    """Operation `op` on nodes `args` (indices in the graph); `value` belongs to leaves."""

    op: str
    args: tuple[int, ...] = ()
    value: Value = None

    @property
    def number(self) -> float:
        """Value of a constant."""
        return number_of(self.value)


def number_of(value: Value) -> float:
    """A leaf's value as a number. Raises TypeError for the name of an input or nothing."""
    if value is None or isinstance(value, str):
        raise TypeError(f"{value!r} is no number")
    return float(value)


@dataclass(eq=False)
class Graph:
    """Nodes in an order in which arguments come first.

    `outputs` and `next_states` (by name of the state) map names to nodes. `functions` marks nodes
    that approximate a function: its name and arguments.
    """

    nodes: list[Node] = field(default_factory=list)
    outputs: dict[str, int] = field(default_factory=dict)
    next_states: dict[str, int] = field(default_factory=dict)
    functions: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    _known: dict[Node, int] = field(default_factory=dict)

    def add(self, op: str, *args: int, value: Value = None) -> int:
        """Index of the operation, made if it is new."""
        node = Node(op, args, value)
        if op == "const":  # -0.0 and 0.0 are equal but not the same
            node = Node(op, (), number_of(value))
            key = Node("const", (), number_of(value).hex())
        else:
            key = node
        index = self._known.get(key)
        if index is None:
            index = self._known[key] = len(self.nodes)
            self.nodes.append(node)
        return index

    def const(self, value: float) -> int:
        """A constant, a double."""
        return self.add("const", value=value)

    def constant(self, index: int) -> float | None:
        """Value of a constant node, None for others."""
        node = self.nodes[index]
        return node.number if node.op == "const" else None

    def roots(self) -> list[int]:
        """Nodes that leave the graph: outputs, then next values of states."""
        return [*self.outputs.values(), *self.next_states.values()]

    def used(self) -> list[int]:
        """Nodes that a root needs, arguments first."""
        needed = set(self.roots())
        for index in range(len(self.nodes) - 1, -1, -1):
            if index in needed:
                needed.update(self.nodes[index].args)
        return sorted(needed)

    def uses(self) -> list[int]:
        """How often each node is read by nodes that are used, and by roots."""
        counts = [0] * len(self.nodes)
        for index in self.used():
            for arg in self.nodes[index].args:
                counts[arg] += 1
        for root in self.roots():
            counts[root] += 1
        return counts

    def operations(self) -> Iterator[tuple[int, Node]]:
        """Used nodes that are no leaves."""
        return ((i, self.nodes[i]) for i in self.used() if self.nodes[i].op not in LEAVES)


class Rewriter:
    """Builds a new graph from an old one, node by node: subclasses define `visit`."""

    def __init__(self, old: Graph) -> None:
        self.old = old
        self.new = Graph()
        self.map: dict[int, int] = {}

    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        """Node of the new graph for one of the old; args are in the new graph already."""
        return self.new.add(node.op, *args, value=node.value)

    def run(self) -> Graph:
        """The new graph."""
        for index in self.old.used():
            node = self.old.nodes[index]
            self.map[index] = self.visit(index, node, [self.map[arg] for arg in node.args])
        for i, (name, args) in self.old.functions.items():
            if i in self.map and all(arg in self.map for arg in args):
                mapped = tuple(self.map[arg] for arg in args)
                self.new.functions.setdefault(self.map[i], (name, mapped))
        self.new.outputs = {name: self.map[i] for name, i in self.old.outputs.items()}
        self.new.next_states = {name: self.map[i] for name, i in self.old.next_states.items()}
        return self.new
