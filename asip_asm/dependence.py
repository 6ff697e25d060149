# SPDX-License-Identifier: Apache-2.0
"""Dependence graph of the operations of one straight-line region, for the timing of `machine`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import overload

from asip_asm.ir import Operation, Register, Virtual
from asip_asm.isa import STREAM_BITS
from asip_asm.machine import BRANCHES, Machine, sources


@dataclass(eq=False)
class Graph:
    """Operations and their order constraints.

    `successors[i]` holds (j, d): operation j issues at least d cycles after operation i,
    `predecessors` the same reversed. Every edge points forward in the order of `operations`.
    """

    operations: list[Operation]
    predecessors: list[list[tuple[int, int]]]
    successors: list[list[tuple[int, int]]]
    latency: list[int]

    @overload
    def heads(self) -> list[int]: ...

    @overload
    def heads(self, extra: Sequence[float]) -> list[float]: ...

    def heads(self, extra: Sequence[float] | None = None) -> list[int] | list[float]:
        """Earliest issue cycle of each operation without resource limits.

        `extra[i]` more cycles are allowed for operation i, for instance to wait for a resource.
        """
        extra = extra or [0] * len(self.operations)
        head: list[float] = [0] * len(self.operations)
        for i, edges in enumerate(self.successors):
            for j, distance in edges:
                head[j] = max(head[j], head[i] + extra[i] + distance)
        return head

    @overload
    def tails(self) -> list[int]: ...

    @overload
    def tails(self, extra: Sequence[float]) -> list[float]: ...

    def tails(self, extra: Sequence[float] | None = None) -> list[int] | list[float]:
        """Least number of cycles from the issue of each operation to the end of the last write.

        `extra[i]` more cycles are allowed for operation i.
        """
        extra = extra or [0] * len(self.operations)
        tail = [n + 1 + more for n, more in zip(self.latency, extra, strict=True)]
        for j in range(len(self.operations) - 1, -1, -1):
            for i, distance in self.predecessors[j]:
                tail[i] = max(tail[i], tail[j] + extra[i] + distance)
        return tail


def build_graph(
    operations: Sequence[Operation],
    machine: Machine,
    storage: Mapping[Virtual, Virtual] | None = None,
) -> Graph:
    """Graph of operations in program order.

    `storage` maps symbols that share a register (last write of a state) to the symbol that is used
    for it. Read after write costs latency + 1 cycles, write after read none (operands are read at
    issue), write after write latency + 1. Loads and stores that may meet at an address keep their
    order, and so do the reads and seeks of one stream; a final branch or loop stays last.
    """
    place: dict[object, Virtual] = {symbol: home for symbol, home in (storage or {}).items()}
    graph = Graph(
        list(operations),
        [[] for _ in operations],
        [[] for _ in operations],
        [machine.latency(op) for op in operations],
    )
    best: list[dict[int, int]] = [{} for _ in operations]

    def require(i: int, j: int, distance: int) -> None:
        if i != j:
            best[j][i] = max(distance, best[j].get(i, 0))

    writer: dict[object, int] = {}
    readers: dict[object, list[int]] = {}
    accesses: list[int] = []
    streams: dict[int, int] = {}
    key: object
    for j, op in enumerate(graph.operations):
        for source in sources(op):
            key = place.get(source, source)
            if key in writer:
                require(writer[key], j, graph.latency[writer[key]] + 1)
            readers.setdefault(key, []).append(j)
        if op.dst is not None:
            key = place.get(op.dst, op.dst)
            if key in writer:
                require(writer[key], j, graph.latency[writer[key]] + 1)
            for i in readers.get(key, ()):
                require(i, j, 0)
            writer[key] = j
            readers[key] = []
        if op.mnemonic in ("ld", "st"):
            for i in accesses:
                if may_conflict(graph.operations[i], op):
                    require(i, j, 1)
            accesses.append(j)
        if (stream := stream_place(op)) is not None:
            if stream in streams:
                # A seek acts on the next bundle, so the read before it may be in its own.
                before = streams[stream]
                reads_first = graph.operations[before].stream is not None and op.stream is None
                require(before, j, 0 if reads_first else 1)
            streams[stream] = j
        if op.mnemonic in BRANCHES or op.mnemonic == "loop":
            for i in range(j):
                require(i, j, 0)
    for j, edges in enumerate(best):
        for i, distance in edges.items():
            graph.predecessors[j].append((i, distance))
            graph.successors[i].append((j, distance))
    return graph


def edges_around(
    operations: Sequence[Operation],
    machine: Machine,
    storage: Mapping[Virtual, Virtual] | None = None,
) -> list[tuple[int, int, int]]:
    """Order constraints from round to round of the body of a loop: (i, j, d), operation j issues at
    least d cycles after operation i of the round before. A distance of 1 constrains nothing.
    """
    count = len(operations)
    twice = build_graph([*operations, *operations], machine, storage)
    return [
        (i, j - count, distance)
        for i, edges in enumerate(twice.successors[:count])
        for j, distance in edges
        if j >= count and distance > 1
    ]


def stream_place(operation: Operation) -> int | None:
    """Pipe whose stream the operation reads or moves; None without one."""
    if operation.mnemonic == "seek":
        return (operation.imm or 0) >> STREAM_BITS
    return operation.stream


def may_conflict(first: Operation, second: Operation) -> bool:
    """Whether two data memory operations must keep their order."""
    if first.mnemonic == "ld" and second.mnemonic == "ld":
        return False
    return not _fixed_address(first) or not _fixed_address(second) or first.imm == second.imm


def _fixed_address(operation: Operation) -> bool:
    return isinstance(operation.b, Register) and operation.b.bank == "zero"
