# SPDX-License-Identifier: Apache-2.0
"""Where the constants of a law live: bank K, registers that no operation writes, data memory.

A constant in data memory is loaded once in a run, in an auxiliary slot. A register that keeps it
from run to run saves the load. Only the banks of the multiply-add pipes hold constants: bank C is
left to states and to values just loaded. Registers that the program needs are left free too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from asip_asm.dependence import build_graph
from asip_asm.ir import Operation, Virtual
from asip_asm.isa import default_isa
from asip_asm.machine import Machine
from asip_asm.model.graph import LEAVES, Graph, binary32
from asip_asm.model.law import Law
from asip_asm.model.read import ModelError
from asip_asm.search import Value, build_problem, length, pressure, search

PIPES = ("A", "B")
EFFORT = 12
"""Schedules by which two forms of a program are compared."""
SHARES = (1.0, 0.75, 0.5, 0.25)
"""Shares of the free registers that may hold constants."""
SPARE, MORE = 6, 5 / 3
"""A final schedule is taken to need `MORE` times the registers of a trial, and `SPARE` of each bank
further: values that it had to store and load again would cost more than the loads saved.
"""


@dataclass(frozen=True)
class Places:
    """Constants outside bank K: registers by bank, and words of data memory."""

    registers: Mapping[str, tuple[float, ...]]
    data: tuple[float, ...]

    @property
    def loaded(self) -> frozenset[float]:
        return frozenset(self.data)


def beyond_bank(graph: Graph, law: Law, constants: int | None = None) -> list[float]:
    """Constants for which bank K has no place after inputs, parameters and integers: those that
    operations read least; those read most come first. Raises ModelError.
    """
    isa = default_isa()
    words = sum(p.kind in ("input", "parameter") for p in law.ports)
    reads: Counter[float] = Counter()
    uses = graph.uses()
    for i in graph.used():
        node = graph.nodes[i]
        if node.op == "int_const" and node.value != 0:
            words += 1
        if node.op == "const" and binary32(node.number) != 0:
            reads[float(binary32(node.number))] += uses[i]
    room = isa.banks["K"].size - words
    if room < 0:
        raise ModelError(
            f"{law.title}: {words} inputs, parameters and integers, bank K holds "
            f"{isa.banks['K'].size} words; take fewer inputs"
        )
    if constants is not None:
        room = min(room, constants)
    ranked = [value for value, _ in reads.most_common()]
    if len(ranked) - room > isa.data_words:
        raise ModelError(
            f"{law.title}: {len(ranked)} constants, {max(room, 0)} places are left for "
            f"them in bank K and {isa.data_words} in data memory; divide the law into several "
            "functions, or compute constants from others"
        )
    return ranked[room:]


def operations(graph: Graph, loaded: frozenset[float] = frozenset()) -> list[Operation]:
    """The graph for the scheduler, loads of `loaded` constants first: other leaves are at hand."""
    loads: dict[float, Operation] = {}
    result = []
    for i, node in graph.operations():
        operation = Operation(node.op, Virtual("value", i))
        for name, arg in zip("abc", node.args, strict=False):
            source = graph.nodes[arg]
            if source.op not in LEAVES:
                setattr(operation, name, Virtual("value", arg))
            elif source.op == "const" and (number := float(binary32(source.number))) in loaded:
                loads.setdefault(number, Operation("ld", Virtual("constant", arg)))
                setattr(operation, name, loads[number].dst)
        result.append(operation)
    return [*loads.values(), *result]


def choose_places(
    graph: Graph, law: Law, machine: Machine, constants: int | None, registers: bool
) -> Places:
    """The places with the shortest trial schedule; of places as short, those with the fewest
    registers. Raises ModelError.
    """
    outside = beyond_bank(graph, law, constants)
    none = Places({}, tuple(outside))
    if not registers or not outside:
        return none
    cycles, used = _trial(graph, law, machine, none)
    sizes = machine.bank_sizes
    pipes = [bank for bank in PIPES if sizes[bank]]
    free = {bank: sizes[bank] - MORE * used / len(pipes) - SPARE for bank in pipes}
    found = [(cycles, 0, none)]
    for share in SHARES:
        room = {bank: max(0, int(share * count)) for bank, count in free.items()}
        places = _dealt(outside, room)
        cycles, _ = _trial(graph, law, machine, places)
        held = sum(map(len, places.registers.values()))
        found.append((cycles, held, places))
    return min(found, key=lambda one: one[:2])[2]


def _dealt(outside: list[float], room: Mapping[str, int]) -> Places:
    """The constants read most go to registers, to the bank with the most room left."""
    left = dict(room)
    dealt: dict[str, list[float]] = {bank: [] for bank in room}
    for value in outside[: sum(room.values())]:
        bank = max(left, key=lambda name: left[name])
        left[bank] -= 1
        dealt[bank].append(value)
    count = sum(map(len, dealt.values()))
    return Places({bank: tuple(v) for bank, v in dealt.items() if v}, tuple(outside[count:]))


def _trial(graph: Graph, law: Law, machine: Machine, places: Places) -> tuple[int, int]:
    """Cycles of a quick schedule, and the registers of the pipes in use at once."""
    made = operations(graph, places.loaded)
    roots = set(graph.roots())
    readers: dict[object, list[int]] = {op.dst: [] for op in made}
    for i, op in enumerate(made):
        for source in (op.a, op.b, op.c):
            if isinstance(source, Virtual):
                readers[source].append(i)
    values = [
        Value(
            pool=int(machine.unit(op).bank == "C"),
            definition=i,
            readers=tuple(readers[op.dst]),
            kept=isinstance(op.dst, Virtual) and op.dst.version in roots,
        )
        for i, op in enumerate(made)
    ]
    states = len(law.of_kind("state")) + len(law.of_kind("rate"))
    held = sum(map(len, places.registers.values()))
    sizes = machine.bank_sizes
    capacity = (sizes["A"] + sizes["B"] - held, sizes["C"] - states)
    problem = build_problem(build_graph(made, machine), machine, None, values, capacity)
    times = search(problem, EFFORT)
    return length(problem, times), pressure(problem, times)[0]
