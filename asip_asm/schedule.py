# SPDX-License-Identifier: Apache-2.0
"""Bundles for the linear regions of a program: order and slot of every operation, never the
operation itself.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence

from asip_asm.dependence import build_graph, edges_around
from asip_asm.ir import Bundle, Operation, Output, Program, Region, Register, Virtual
from asip_asm.loops import region_loops
from asip_asm.machine import Machine, sources
from asip_asm.search import Problem, Progress, Value, build_problem, delay_loads, search

DEFAULT_EFFORT = 8000
"""Schedules tried per region, unless a lower bound is reached before."""
PLACEMENTS = 1 << 21
"""Operations placed in all schedules of a program: larger programs get fewer schedules, so that the
search takes seconds whatever the program.
"""


class ScheduleError(ValueError):
    """An operation cannot be in the slot that its destination requires; the message names the
    operation and its line.
    """


class SizeError(ValueError):
    """The program cannot fit program memory, however it is scheduled; `help` is the cure."""

    help = "shorten the program, or repeat parts of it with a branch or a loop"


def schedule_program(
    program: Program,
    machine: Machine,
    effort: int = DEFAULT_EFFORT,
    progress: Callable[[Progress], None] | None = None,
) -> None:
    """Set `bundles` of every linear region to a short schedule; regions written as bundles stay as
    they are.

    `effort` bounds the schedules tried per region; same input and effort give the same bundles.
    `progress` is called during the search. Raises ScheduleError.
    """
    placement = _Placement(program, machine)
    linear = sum(len(region.operations) for region in program.regions if region.bundles is None)
    effort = min(effort, max(1, PLACEMENTS // max(1, linear)))
    for region in program.regions:
        if region.bundles is None:
            problem = placement.problem(region)
            times = delay_loads(problem, search(problem, effort, progress))
            region.bundles = placement.bundles(region, times)


def check_size(program: Program, machine: Machine, program_bundles: int) -> None:
    """Raises SizeError if slots alone show that the program has more bundles than the memory."""
    bundles = 0
    causes: list[str] = []
    for region in program.regions:
        if region.bundles is not None:
            bundles += len(region.bundles)
            continue
        counts: dict[tuple[int, ...], int] = defaultdict(int)
        for op in region.operations:
            counts[tuple(machine.slots_of(op))] += 1
        needed = {slots: -(-count // len(slots)) for slots, count in counts.items()}
        if needed:
            most = max(needed, key=needed.__getitem__)
            bundles += needed[most]
            causes.append(f"{counts[most]} operations for {len(most)} of its slots")
    if bundles > program_bundles:
        largest = f" ({causes[0]})" if len(causes) == 1 else ""
        raise SizeError(
            f"too many bundles: the program needs {bundles} or more{largest}, the core's program "
            f"memory holds {program_bundles}"
        )


def bundle_in_order(program: Program, machine: Machine) -> None:
    """Set `bundles` of every linear region to one operation per bundle, in the order written.

    Raises ScheduleError.
    """
    placement = _Placement(program, machine)
    for region in program.regions:
        if region.bundles is None:
            region.bundles = placement.bundles(region, range(len(region.operations)))


def state_storage(program: Program) -> dict[Virtual, Virtual]:
    """Symbols that share a register: the last write of each state, mapped to the state's first
    value.
    """
    return {state.last: state.first for state in program.states if state.last is not None}


def operations_of(regions: Iterable[Region]) -> Iterator[tuple[Operation, int | None]]:
    """All operations of regions; with the slot where the source fixes it."""
    for region in regions:
        if region.bundles is None:
            yield from ((op, None) for op in region.operations)
        else:
            for bundle in region.bundles:
                yield from ((op, slot) for slot, op in bundle.placed())


def decide_banks(program: Program, machine: Machine) -> dict[Virtual, str]:
    """Banks of the symbols that need one before scheduling.

    These are pinned states, and symbols that are written more than once: all their writes must go
    to one bank. Raises ScheduleError if they cannot.
    """
    choices: dict[Virtual, list[tuple[Operation, set[str]]]] = defaultdict(list)
    for op, slot in operations_of(program.regions):
        if not isinstance(op.dst, Virtual):
            continue
        slots = machine.places_of(op) if slot is None else (slot,)
        choices[op.dst].append((op, {machine.bank(op, s) or "" for s in slots}))
    pins = {state.last: state.pin for state in program.states if state.last and state.pin}
    fixed: dict[Virtual, str] = {}
    spread = 0
    for symbol, writes in choices.items():
        pin = pins.get(symbol)
        if pin is None and len(writes) == 1:
            continue
        possible = set.intersection(*(banks for _, banks in writes))
        if pin is not None:
            possible &= {pin}
        if not possible:
            where = f"bank {pin}" if pin is not None else "one bank"
            raise ScheduleError(
                f"{describe(writes[-1][0])}: the writes of '{symbol.name}' cannot all go to "
                f"{where}: multiply-add operations write to A or B, all others to C; "
                "use mov or another pin"
            )
        ordered = sorted(possible)
        fixed[symbol] = ordered[spread % len(ordered)]
        spread += len(ordered) > 1
    return fixed


def describe(operation: Operation) -> str:
    """Operation and its place in the source, for messages."""
    if operation.source is None:
        return operation.mnemonic
    return f"{operation.source.file}:{operation.source.line}: {operation.mnemonic}"


class _Placement:
    """Where the operations of a program may be placed: slots, search problems and bundles of its
    regions. `fixed` are the banks that `decide_banks` gives.
    """

    def __init__(self, program: Program, machine: Machine) -> None:
        self.program = program
        self.machine = machine
        self.fixed = decide_banks(program, machine)
        self.storage = state_storage(program)
        loops = region_loops(program)
        self.bodies = [program.regions[loop.first] for loop in loops if loop.first == loop.last]

    def slots(self, operation: Operation) -> tuple[int, ...]:
        """Slots where the operation's result goes to the bank its destination needs.

        Raises ScheduleError if none.
        """
        machine, destination = self.machine, operation.dst
        bank = destination.bank if isinstance(destination, Register) else None
        if isinstance(destination, Virtual):
            bank = self.fixed.get(destination)
        slots = machine.places_of(operation)
        if bank is not None:
            slots = tuple(slot for slot in slots if machine.bank(operation, slot) == bank)
        if not slots or (isinstance(destination, Output) and machine.unit(operation).bank != "C"):
            raise ScheduleError(
                f"{describe(operation)}: no slot of configuration '{machine.configuration}' "
                f"executes it with its result in {'an output' if bank is None else f'bank {bank}'}"
            )
        return slots

    def problem(self, region: Region) -> Problem:
        """Search problem of a linear region: its graph, resources and register values."""
        pipe: list[int | None] = []
        for op in region.operations:
            slots = self.slots(op)
            pipe.append(slots[0] if len(slots) < len(self.machine.slots_of(op)) else None)
        graph = build_graph(region.operations, self.machine, self.storage)
        around = None
        if region in self.bodies:
            around = edges_around(region.operations, self.machine, self.storage)
        return build_problem(graph, self.machine, pipe, *self._values(region), around)

    def _values(self, region: Region) -> tuple[list[Value], tuple[int, int]]:
        """Register values of the region in two pools, multiply-add banks and bank C, and the pools'
        free registers.
        """
        program, machine, storage = self.program, self.machine, self.storage
        reserved = set(storage) | {state.first for state in program.states} | set(self.fixed)
        kept = {export.value for export in program.exports}
        for op, _ in operations_of(other for other in program.regions if other is not region):
            kept.update(sources(op))
        sizes = machine.bank_sizes
        capacity = [sizes["A"] + sizes["B"], sizes["C"]]
        pool = {"pipe": 0, "C": 1}
        named = {state.register for state in program.fixed_states}
        holders: dict[Virtual, int] = {}
        for op, _ in operations_of(program.regions):
            named.update(place for place in (op.dst, *sources(op)) if isinstance(place, Register))
            if op.dst in reserved:
                holders[storage.get(op.dst, op.dst)] = pool[machine.unit(op).bank]
        for state in program.states:
            holders.setdefault(state.first, int(state.pin in (None, "C")))
        for index in [*holders.values(), *(int(register.bank == "C") for register in named)]:
            capacity[index] -= 1
        readers: dict[object, list[int]] = defaultdict(list)
        definition: dict[Virtual, int] = {}
        for i, op in enumerate(region.operations):
            for source in sources(op):
                readers[source].append(i)
            if isinstance(op.dst, Virtual) and op.dst not in reserved:
                definition[op.dst] = i
        values = [
            Value(
                pool=pool[machine.unit(region.operations[i]).bank],
                definition=i,
                readers=tuple(readers[symbol]),
                kept=symbol in kept,
            )
            for symbol, i in definition.items()
        ]
        return values, (capacity[0], capacity[1])

    def bundles(self, region: Region, times: Sequence[int]) -> list[Bundle]:
        """Bundles of a region with operation i issued in cycle times[i].

        Cycles without operations get no bundle: the core stalls there by itself. Only where that
        would make the region longer than planned (a bundle issued early can meet another one at the
        write port) there are bundles of nops.
        """
        machine = self.machine
        planned: dict[int, list[int]] = defaultdict(list)
        for i, time in enumerate(times):
            planned[time].append(i)
        chooser = _PipeChooser(self, region, times)
        filled = {
            cycle: machine.bundle(chooser.place(cycle, planned[cycle])) for cycle in sorted(planned)
        }
        bundles = list(filled.values())
        if not bundles and (region.halt or region.labels):
            bundles.append(machine.bundle({}))
        if region.halt:
            bundles[-1].halt = True
        latencies = [max(1, machine.latency(op)) for op in region.operations]
        end = max((t + n + 1 for t, n in zip(times, latencies, strict=True)), default=2)
        if machine.drain_cycle(bundles) > end:
            bundles = [filled.get(cycle) or machine.bundle({}) for cycle in range(max(times) + 1)]
            for nop in [bundle for bundle in bundles if not any(bundle.slots)]:
                fewer = [bundle for bundle in bundles if bundle is not nop]
                if machine.drain_cycle(fewer) <= end:
                    bundles = fewer
        return bundles


class _PipeChooser:
    """Puts the operations of each cycle into slots; free multiply-adds go where fewer registers are
    in use.
    """

    def __init__(self, placement: _Placement, region: Region, times: Sequence[int]) -> None:
        self.operations = region.operations
        self.slots_of = placement.slots
        end = max(times, default=0) + 1
        kept: set[object] = {export.value for export in placement.program.exports}
        kept.update(state.last for state in placement.program.states)
        self.last: dict[object, int] = {}
        for op, time in zip(self.operations, times, strict=True):
            if op.dst in kept:
                self.last[op.dst] = end
            for source in sources(op):
                self.last[source] = max(time, self.last.get(source, 0))
        self.ends: list[list[int]] = [[] for _ in placement.machine.slots]

    def place(self, cycle: int, members: Sequence[int]) -> dict[int, Operation]:
        """Slots of the operations that issue in `cycle`; cycles must come in rising order."""
        operations = [self.operations[i] for i in members]
        choices = {op: self.slots_of(op) for op in operations}
        # Fixed slots first, then long-lived results, which get the emptier bank.
        operations.sort(key=lambda op: (len(choices[op]), -self.last.get(op.dst, cycle)))
        slots: dict[int, Operation] = {}
        for op in operations:
            free = [slot for slot in choices[op] if slot not in slots]
            slot = min(free, key=lambda s: (self._live(s, cycle), s))
            slots[slot] = op
            self.ends[slot].append(self.last.get(op.dst, cycle + 1))
        return slots

    def _live(self, slot: int, cycle: int) -> int:
        self.ends[slot] = [end for end in self.ends[slot] if end > cycle]
        return len(self.ends[slot])
