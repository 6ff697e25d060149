# SPDX-License-Identifier: Apache-2.0
"""How close a scheduled program is to what its data flow and the core's units allow."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from asip_asm.dependence import build_graph
from asip_asm.ir import Bundle, FixedState, Operation, Program, Register, State, Virtual
from asip_asm.liveness import region_liveness
from asip_asm.loops import region_loops
from asip_asm.machine import BRANCHES, RUN_OVERHEAD, STALL_CAUSES, Machine, sources
from asip_asm.search import build_problem, critical_path, occupancy_bounds, round_bound

BANKS = ("A", "B", "C")
ROUNDS = 4
"""Rounds after which those of a loop are taken to last the same."""


@dataclass(frozen=True)
class Section:
    """Figures of straight-line bundles, issued on an idle core.

    `cycles` run from the first issue to the end of the last write and include `RUN_OVERHEAD`, as do
    the lower bounds: `critical_path` (data flow without resource limits) and `bounds` by resource
    (slots, write port of bank C, units that are not pipelined). `busy` holds the cycles in which a
    unit or port takes an operation; a unit that is not pipelined counts until its result is
    written. `places` is the number of units of a kind. `round_cycles`: of the body of a loop, from
    round to round, and what its slots, its write port and its longest chain need of them.
    """

    title: str
    operations: int
    bundles: int
    cycles: int
    critical_path: int
    bounds: dict[str, int]
    busy: dict[str, int]
    places: dict[str, int]
    stalls: dict[str, int]
    round_cycles: tuple[int, int] | None = None

    @property
    def bound(self) -> int:
        """Largest lower bound in cycles."""
        return max([self.critical_path, *self.bounds.values()])

    @property
    def distance(self) -> float:
        """Cycles above the largest lower bound, in percent of it."""
        return 100.0 * (self.cycles - self.bound) / self.bound

    def occupancy(self, resource: str) -> float:
        """Share of the cycles in which the resource is busy, in percent."""
        return 100.0 * self.busy[resource] / (self.places[resource] * self.cycles)


@dataclass(frozen=True)
class Report:
    """Figures of an allocated program; without branches and loops there is one section, else one
    per region.

    `registers` gives by bank the largest number of registers in use at once and the bank's size.
    """

    title: str
    configuration: str
    sections: tuple[Section, ...]
    registers: dict[str, tuple[int, int]]

    def render(self) -> str:
        """Text for people, several lines."""
        lines = [f"{self.title or 'program'} ({self.configuration})"]
        for section in self.sections:
            lines += [""] if len(self.sections) > 1 else []
            lines += _render(section)
        lines.append(
            "registers in use     "
            + ", ".join(f"{bank} {used}/{size}" for bank, (used, size) in self.registers.items())
        )
        return "\n".join(lines) + "\n"


def _render(section: Section) -> list[str]:
    bounds = {"critical path": section.critical_path, **section.bounds}
    busy = ", ".join(f"{name} {section.occupancy(name):.0f} %" for name in section.busy)
    rounds = []
    if section.round_cycles is not None:
        cycles, least = section.round_cycles
        rounds = [f"a round of the loop  {cycles} cycles, {least} at least"]
    return [
        f"{section.title:<20} {section.operations} operations in {section.bundles} bundles",
        *rounds,
        f"cycles               {section.cycles}, {section.distance:.1f} % above the lower bound",
        "lower bounds         " + ", ".join(f"{name} {value}" for name, value in bounds.items()),
        f"occupancy            {busy}",
        "stalled cycles       "
        + ", ".join(f"{cause} {count}" for cause, count in section.stalls.items()),
    ]


def report_program(program: Program, machine: Machine) -> Report:
    """Figures of a program after `allocate_registers`."""
    bodies = {loop.first for loop in region_loops(program) if loop.first == loop.last}
    parts = [
        (" ".join(region.labels) or f"region {i}", region.bundles or [], i in bodies)
        for i, region in enumerate(program.regions)
    ]
    if not any(op.mnemonic in (*BRANCHES, "loop") for _, _, op in program.placed()):
        parts = [("whole program", program.bundles, False)]
    return Report(
        title=program.title,
        configuration=machine.configuration,
        sections=tuple(
            _section(title, bundles, machine, body) for title, bundles, body in parts if bundles
        ),
        registers=_registers(program, machine),
    )


def _section(title: str, bundles: Sequence[Bundle], machine: Machine, body: bool) -> Section:
    operations = [op for op in _data_flow(bundles) if op.mnemonic != "nop"]
    problem = build_problem(build_graph(operations, machine), machine)
    busy: Counter[str] = Counter()
    places = {**problem.lanes, "write port": 1}
    for op, lane in zip(operations, problem.lane, strict=True):
        unit = machine.unit(op)
        busy[lane] += 1
        busy["write port"] += machine.writes_port(op)
        if unit.bank == "C":
            busy[unit.name] += unit.interval
            places[unit.name] = 1
    issues = machine.issue_cycles(bundles)
    rounds = None
    if body:
        begins = [issue.cycle for issue in machine.issue_cycles([*bundles] * ROUNDS)]
        rounds = begins[-len(bundles)] - begins[-2 * len(bundles)], round_bound(problem)
    return Section(
        title=title,
        operations=len(operations),
        bundles=len(bundles),
        cycles=machine.run_cycles(bundles),
        critical_path=critical_path(problem) + RUN_OVERHEAD,
        bounds={k: v + RUN_OVERHEAD for k, v in occupancy_bounds(problem).items() if v},
        busy=dict(busy),
        places=places,
        stalls={cause: sum(getattr(issue, cause) for issue in issues) for cause in STALL_CAUSES},
        round_cycles=rounds,
    )


def _data_flow(bundles: Sequence[Bundle]) -> list[Operation]:
    """Copies of the operations in which every written value has its own name."""
    current: dict[object, Virtual] = {}
    result: list[Operation] = []
    for bundle in bundles:
        written: dict[object, Virtual] = {}
        for op in bundle.operations:
            reads = {name: getattr(op, name) for name in ("a", "b", "c")}
            fields = {name: current.get(value, value) for name, value in reads.items()}
            if isinstance(op.dst, Register | Virtual):
                fields["dst"] = written[op.dst] = Virtual("value", len(result))
            result.append(replace(op, **fields))
        current.update(written)
    return result


def _registers(program: Program, machine: Machine) -> dict[str, tuple[int, int]]:
    """Largest number of registers in use at once, and size, of every bank."""
    states: list[State | FixedState] = [*program.states, *program.fixed_states]
    held = {state.register for state in states if state.register is not None}
    kept = held | {export.register for export in program.exports if export.register is not None}
    peak = dict.fromkeys(BANKS, 0)
    borders = region_liveness(program, kept)
    for region, (start, end) in zip(program.regions, borders, strict=True):
        live = set(end)
        for bundle in reversed(region.bundles or []):
            written = {op.dst for op in bundle.operations if isinstance(op.dst, Register)}
            _raise_peak(peak, live | written | held)
            live = (live - written).union(*(sources(op) for op in bundle.operations))
        _raise_peak(peak, start | held)
    return {bank: (peak[bank], machine.bank_sizes[bank]) for bank in BANKS}


def _raise_peak(peak: dict[str, int], live: set[Register | Virtual]) -> None:
    count = Counter(place.bank for place in live if isinstance(place, Register))
    for bank in peak:
        peak[bank] = max(peak[bank], count[bank])
