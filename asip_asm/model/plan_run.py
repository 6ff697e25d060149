# SPDX-License-Identifier: Apache-2.0
"""A run of a plan on nodes of a graph: it lays out the streams and gives the operations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, cast

from asip_asm.machine import Machine
from asip_asm.model.expand import LEAST, MAGIC, STEP
from asip_asm.model.graph import Graph, Node
from asip_asm.model.plan_items import PIPES, Item, Loop, Op, Operand, Rewind, Vectors, Words


class Planned(Protocol):
    """What a run reads and writes of a plan."""

    title: str
    machine: Machine
    inputs: list[str]
    outputs: dict[str, float]
    spaces: dict[str, int]
    marks: dict[str, tuple[str, Sequence[Operand]]]
    items: list[Item]
    graph: Graph
    streams: dict[str, list[float]]
    step_words: int
    steps: int


def _multiply_add(graph: Graph, a: int, b: int, c: int) -> int:
    return graph.add("fadd", a, c) if graph.constant(b) == 1.0 else graph.add("fmadd", a, b, c)


def _multiply(graph: Graph, a: int, b: int) -> int:
    return a if graph.constant(b) == 1.0 else graph.add("fmul", a, b)


def _scale(graph: Graph, a: int, b: int, c: int) -> int:
    """a 2^n + c, n = b - MAGIC."""
    bits = graph.add("fmadd", b, graph.const(STEP), graph.const((127 - MAGIC) * STEP))
    return graph.add("fmadd", a, graph.add("f2i", bits), c)


def _below(graph: Graph, a: int, b: int) -> int:
    return _multiply(graph, graph.add("fsat", a, graph.const(LEAST), graph.const(0.0)), b)


def _above(graph: Graph, a: int, b: int, c: int) -> int:
    if graph.constant(b) == 1.0 and graph.functions.get(c) == ("expm1_below", (a,)):
        # c is +0 where a is positive, and never -0: the sum is one of its terms.
        return graph.add("selgt", a, a, c)
    return _multiply_add(graph, graph.add("fmax", a, graph.const(0.0)), b, c)


LANE: dict[str, Callable[..., int]] = {
    "vfmul": _multiply,
    "vfmadd": _multiply_add,
    "vmadd": _multiply_add,
    "vscale": _scale,
    "vbelow": _below,
    "vabove": _above,
}
"""What a lane computes of its words, on the nodes of a graph."""
VECTOR = frozenset({*LANE, "vout"})


class Run:
    """One run of a plan on nodes of its graph in place of numbers: `values` of words, `vectors`."""

    def __init__(self, plan: Planned) -> None:
        self.plan, self.graph = plan, plan.graph
        self.values = {name: self.graph.add("input", value=name) for name in plan.inputs}
        self.vectors: dict[str, list[int]] = {}
        self.integers: dict[str, int] = {}
        self.memory: dict[tuple[str, int], int] = {}
        self.begin: dict[tuple[str, int], int] = {}
        self.place = dict.fromkeys(PIPES, 0)
        self.counters: dict[str, int] = {}

    def run(self) -> None:
        self._items(self.plan.items)
        self.graph.outputs = {name: self.values[name] for name in self.plan.outputs}
        for key, node in self.begin.items():
            if self.memory[key] == node:  # nothing writes it: it is zero, as loaded
                self.graph.nodes[node] = Node("const", value=0.0)
        held = {key: node for key, node in self.begin.items() if self.memory[key] != node}
        names = {key: f"{key[0]}_{key[1]}" for key in held}
        # A word counts as a state if an output depends on it, at once or through others.
        needed: set[tuple[str, int]] = set()
        while True:
            self.graph.next_states = {names[key]: self.memory[key] for key in sorted(needed)}
            used = set(self.graph.used())
            found = {key for key, node in held.items() if node in used}
            if found == needed:
                break
            needed = found

    def _items(self, items: Sequence[Item]) -> None:
        for item in items:
            if isinstance(item, Loop):
                for k in range(item.count):
                    self.counters[item.name] = k
                    self._items(item.body)
            elif isinstance(item, Rewind):
                for pipe in PIPES:
                    stream = len(self.plan.streams[pipe]) // self.plan.step_words
                    self.place[pipe] = item.places.setdefault(pipe, stream)
            else:
                self._step(item)

    def _step(self, op: Op) -> None:
        self.plan.steps += 1
        if op.name == "iadd" and all(self._whole(arg) for arg in op.args):
            self.integers[op.dst] = sum(self._integer(arg) for arg in op.args)
            return
        if op.block:
            self._memory(op)
            return
        if op.name in VECTOR:
            self._vector(op)
            return
        args = [self._node(op, arg) for arg in op.args]
        node = args[0] if op.name == "mov" else self.graph.add(op.name, *args)
        self.values[op.dst] = node
        if op.dst in self.plan.marks:
            function, arguments = self.plan.marks[op.dst]
            nodes = tuple(self._node(op, each) for each in arguments)
            self.graph.functions[node] = (function, nodes)

    def _whole(self, arg: Operand) -> bool:
        return isinstance(arg, int) or (isinstance(arg, str) and arg in self.integers)

    def _integer(self, arg: Operand) -> int:
        return self.integers[arg] if isinstance(arg, str) else cast(int, arg)  # _whole() made it

    def _node(self, op: Op, arg: Operand) -> int:
        if isinstance(arg, str):
            return self.values[arg]
        if isinstance(arg, Words):
            return self.graph.const(self._word(op.pipe, arg.at(self.counters)))
        if isinstance(arg, int):
            return self.graph.add("int_const", value=arg)
        return self.graph.const(arg)

    def _word(self, pipe: str, value: float) -> float:
        stream, place = self.plan.streams[pipe], self.place[pipe]
        if place == len(stream):
            stream.append(value)
        if stream[place] != value:
            raise AssertionError(f"{self.plan.title}: word {place} of stream {pipe} has two values")
        self.place[pipe] += 1
        return value

    def _vector(self, op: Op) -> None:
        """An operation in all lanes, or one that takes a lane."""
        if op.name == "vout":
            word, vector = op.args
            made = [self.graph.add("fadd", self._node(op, word), self._lanes(op, vector)[op.lane])]
            self.values[op.dst] = made[0]
        else:
            args = [self._lanes(op, arg) for arg in op.args]
            made = [LANE[op.name](self.graph, *each) for each in zip(*args, strict=True)]
            self.vectors[op.dst] = made
        if op.dst in self.plan.marks:
            function, arguments = self.plan.marks[op.dst]
            given = [self._lanes(op, each) for each in arguments]
            for node, *nodes in zip(made, *given, strict=True):
                self.graph.functions[node] = (function, tuple(nodes))

    def _lanes(self, op: Op, arg: Operand) -> list[int]:
        """Nodes of an operand, one for each lane."""
        if isinstance(arg, str) and arg in self.vectors:
            return self.vectors[arg]
        count = 1 + self.plan.machine.build.lanes
        if not isinstance(arg, Vectors):
            return [self._node(op, arg)] * count
        words = arg.lanes(self.counters)
        stream, place = self.plan.streams[op.pipe], count * self.place[op.pipe]
        if place == len(stream):
            stream += words
        if stream[place : place + count] != words:
            raise AssertionError(f"{self.plan.title}: vector {place // count} has two values")
        self.place[op.pipe] += 1
        return [self.graph.const(word) for word in words]

    def _memory(self, op: Op) -> None:
        index = op.args[1:] if op.name == "st" else op.args
        address = op.offset + sum(self._integer(arg) for arg in index)
        if not 0 <= address < self.plan.spaces[op.block]:
            raise AssertionError(f"{self.plan.title}: {op.block}+{address} is outside of its block")
        key = (op.block, address)
        if op.name == "st":
            self.memory[key] = self.values[str(op.args[0])]
            return
        if key not in self.memory:
            name = f"{op.block}_{address}"
            self.memory[key] = self.begin[key] = self.graph.add("state", value=name)
        self.values[op.dst] = self.memory[key]
