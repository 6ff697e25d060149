# SPDX-License-Identifier: Apache-2.0
"""Timing model of the core, read from `isa.toml` and `rtl/fpu/fp_pkg.sv`.

Times are clock cycles counted from the issue of a program's first bundle (cycle 0). The core issues
bundles in order and interlocks; a bundle waits until, in its issue cycle t,

- every source register has no pending write: an operation of latency L issued at u writes at u + L,
  readers can issue from u + L + 1 on ("operand");
- no destination register has a pending write ("waw");
- the unit is free: a unit of interval i takes its next operation i cycles later ("unit");
- bank C's write port, which auxiliary results and outputs share, is free at t + L ("port").

All operations of a bundle read at issue, before any of them writes. Bank K, `zero` and the words of
streams are always ready; a seek acts on the next bundle.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from asip_asm.ir import Bundle, Operation, Output, Register, Virtual
from asip_asm.isa import ISA_FILE, default_isa
from asip_asm.isa_records import Configuration, UnitRecord
from asip_asm.loops import Loop, loops_of
from asip_asm.project import ROOT

_PIPELINE = default_isa().pipeline

OPERAND_READ = _PIPELINE.operand_read
"""Cycles from issue to E1, the first stage of a unit."""

RUN_OVERHEAD = OPERAND_READ + _PIPELINE.write_back
"""Cycles of a run beyond max(issue + latency + 1): operand read, check of the last word."""

BRANCH_WAIT = OPERAND_READ + _PIPELINE.branch_decision
"""Cycles after a branch in which nothing issues: it is decided in E1, fetch follows in E2."""

REFETCH = _PIPELINE.refetch
"""Further cycles until the target of a taken branch is in stage D."""

FP_PKG_FILE = ROOT / "rtl/fpu/fp_pkg.sv"

BRANCHES = default_isa().branches

STALL_CAUSES = ("operand", "waw", "unit", "port")


class MachineError(ValueError):
    """The machine description is incomplete, or an operation does not fit the configuration."""


@dataclass(frozen=True)
class Issue:
    """Issue cycle of a bundle and the cycles it waited before, by cause (see `STALL_CAUSES`).

    A waiting cycle counts for the first cause of `STALL_CAUSES` that holds in it.
    """

    cycle: int
    operand: int = 0
    waw: int = 0
    unit: int = 0
    port: int = 0


@dataclass(frozen=True)
class Machine:
    """One configuration: its record, units with its latencies and intervals, unit of each
    operation, bank sizes.
    """

    build: Configuration
    units: Mapping[str, UnitRecord]
    unit_names: Mapping[str, str]
    bank_sizes: Mapping[str, int]
    data_words: int

    @property
    def configuration(self) -> str:
        """Name of the configuration."""
        return self.build.name

    @property
    def slots(self) -> tuple[str, ...]:
        """Kind of each slot: 'fma', 'aux' or 'any'."""
        return self.build.slots

    def unit(self, operation: Operation) -> UnitRecord:
        """Unit that executes the operation; MachineError if the mnemonic is unknown."""
        try:
            return self.units[self.unit_names[operation.mnemonic]]
        except KeyError:
            raise MachineError(f"{operation.mnemonic}: not an operation of the core") from None

    def latency(self, operation: Operation) -> int:
        """Register ranks of the operation's unit."""
        return self.unit(operation).ranks

    def writes_port(self, operation: Operation) -> bool:
        """Whether the operation takes bank C's write port (auxiliary results and outputs)."""
        return operation.dst is not None and self.unit(operation).bank == "C"

    def slots_of(self, operation: Operation) -> tuple[int, ...]:
        """Slots that can execute the operation; stores and branches use an auxiliary slot."""
        unit = self.unit(operation)
        return tuple(slot for slot in range(len(self.slots)) if self.build.allows(slot, unit))

    def places_of(self, operation: Operation) -> tuple[int, ...]:
        """Those of `slots_of` that read the operation's stream or vector: one, where it has one."""
        slots, pipe = self.slots_of(operation), operation.pipe
        return slots if pipe is None else tuple(slot for slot in slots if slot == pipe)

    def bank(self, operation: Operation, slot: int) -> str | None:
        """Bank that the operation's result goes to when it is in `slot`; None without a
        register result.
        """
        if operation.dst is None or isinstance(operation.dst, Output):
            return None
        return self.build.result_bank(slot, self.unit(operation))

    def bundle(self, operations: Mapping[int, Operation], halt: bool = False) -> Bundle:
        """Bundle with the given operations by slot."""
        return Bundle([operations.get(slot) for slot in range(len(self.slots))], halt)

    def issue_cycles(self, bundles: Sequence[Bundle]) -> list[Issue]:
        """Issue cycle and stalls of each bundle, issued one after the other (branches are not
        taken, bodies of loops run once).

        Exact model of the interlocks, started on an idle core. Works before and after register
        allocation.
        """
        interlocks = Interlocks(self)
        issues: list[Issue] = []
        cycle = 0
        for bundle in bundles:
            operations = bundle.operations
            stalls = dict.fromkeys(STALL_CAUSES, 0)
            while cause := interlocks.cause(operations, cycle):
                stalls[cause] += 1
                cycle += 1
            issues.append(Issue(cycle, **stalls))
            interlocks.issue(operations, cycle)
            cycle += 1
        return issues

    def landings(self, bundles: Sequence[Bundle]) -> dict[tuple[int, int], int]:
        """First bundle that can issue with the result of (bundle, slot) written, the number of
        bundles if none can; branches are not taken.
        """
        issues = [issue.cycle for issue in self.issue_cycles(bundles)]
        return {
            (i, slot): bisect_left(issues, issues[i] + self.latency(op) + 1)
            for i, bundle in enumerate(bundles)
            for slot, op in bundle.placed()
        }

    def run_cycles(self, bundles: Sequence[Bundle]) -> int:
        """Cycles of a run without branches: first issue to last write done, and `RUN_OVERHEAD`."""
        run = _Run(self, bundles, loops_of(bundles))
        run.bundles_of(0, len(bundles) - 1)
        return run.end + RUN_OVERHEAD

    def drain_cycle(self, bundles: Sequence[Bundle]) -> int:
        """First cycle without a pending write: max(issue + latency + 1) over the operations; bodies
        of loops run once.

        A bundle without a write, a store's among them, occupies the pipeline like latency 1.
        """
        return max(
            (
                issue.cycle + self._occupied(bundle)
                for bundle, issue in zip(bundles, self.issue_cycles(bundles), strict=True)
            ),
            default=0,
        )

    def _occupied(self, bundle: Bundle) -> int:
        """Cycles from the issue of a bundle until it has written all."""
        return 1 + max([1, *(self.latency(op) for op in bundle.operations if op.dst)])


@dataclass
class Interlocks:
    """Cycles from which a register can be read and a unit is free, and those in which bank C's
    write port is taken, by the operations issued so far.
    """

    machine: Machine
    ready: dict[object, int] = field(default_factory=dict)
    unit_free: dict[str, int] = field(default_factory=dict)
    port: set[int] = field(default_factory=set)

    def cause(self, operations: Sequence[Operation], cycle: int) -> str | None:
        """First of `STALL_CAUSES` that keeps the operations from issuing in `cycle`."""
        machine, ready = self.machine, self.ready
        if any(ready.get(source, 0) > cycle for op in operations for source in sources(op)):
            return "operand"
        if any(ready.get(op.dst, 0) > cycle for op in operations if op.dst is not None):
            return "waw"
        units = [machine.unit(op) for op in operations]
        if any(u.interval > 1 and self.unit_free.get(u.name, 0) > cycle for u in units):
            return "unit"
        ends = [cycle + machine.latency(op) for op in operations if machine.writes_port(op)]
        return "port" if not self.port.isdisjoint(ends) else None

    def issue(self, operations: Sequence[Operation], cycle: int) -> None:
        """The operations of a bundle issue in `cycle`."""
        for op in operations:
            unit = self.machine.unit(op)
            self.unit_free[unit.name] = cycle + unit.interval
            if op.dst is not None and not isinstance(op.dst, Output):
                self.ready[op.dst] = cycle + unit.ranks + 1
            if self.machine.writes_port(op):
                self.port.add(cycle + unit.ranks)

    def pending(self, cycle: int) -> frozenset[tuple[object, int]]:
        """What a bundle may have to wait for from `cycle` on, by how long."""
        waits = (*self.ready.items(), *self.unit_free.items(), *((c, c + 1) for c in self.port))
        relative = ((what, until - cycle) for what, until in waits if until > cycle)
        return frozenset((0 if isinstance(what, int) else what, left) for what, left in relative)


@dataclass
class _Run:
    """A run of bundles with loops: rounds that repeat what was seen before are not simulated.

    `cycle` is that of the next bundle, `written` the end of the last write; both happen `skipped`
    cycles later.
    """

    machine: Machine
    bundles: Sequence[Bundle]
    loops: Sequence[Loop]
    cycle: int = 0
    written: int = 0
    skipped: int = 0

    def __post_init__(self) -> None:
        self.interlocks = Interlocks(self.machine)
        self.at = {loop.first: loop for loop in self.loops}

    @property
    def end(self) -> int:
        """First cycle without a pending write."""
        return self.written + self.skipped

    def bundles_of(self, first: int, last: int) -> None:
        """Issue the bundles from `first` to `last`, with bodies of loops as often as stated."""
        i = first
        while i <= last:
            bundle = self.bundles[i]
            while self.interlocks.cause(bundle.operations, self.cycle):
                self.cycle += 1
            self.interlocks.issue(bundle.operations, self.cycle)
            self.written = max(self.written, self.cycle + self.machine._occupied(bundle))
            self.cycle += 1
            i += 1
            if (loop := self.at.get(i)) is not None:
                self._rounds(loop)
                i = loop.last + 1

    def _rounds(self, loop: Loop) -> None:
        seen: dict[object, tuple[int, int]] = {}
        done = 0
        while done < loop.rounds:
            state = self.interlocks.pending(self.cycle), max(0, self.written - self.cycle)
            if state in seen:
                before, cycle = seen.pop(state)
                times = (loop.rounds - done) // (done - before)
                self.skipped += times * (self.cycle + self.skipped - cycle)
                done += times * (done - before)
                seen = {}
                if done == loop.rounds:
                    return
            seen[state] = done, self.cycle + self.skipped
            self.bundles_of(loop.first, loop.last)
            done += 1


def sources(operation: Operation) -> list[Register | Virtual]:
    """Registers of banks A, B, C (or their symbols) that the operation reads, in operand order."""
    return [
        source
        for source in (operation.a, operation.b, operation.c)
        if not (isinstance(source, Register) and source.bank in ("zero", "K", "S"))
    ]


def fp_latencies(path: Path = FP_PKG_FILE) -> dict[str, int]:
    """Latency constants of the arithmetic units by name, from the package that the RTL is built
    with.
    """
    pattern = re.compile(
        r"^\s*localparam\s+int\s+unsigned\s+(FP_\w+_LATENCY)\s*=\s*(\d+)\s*;", re.M
    )
    return {name: int(value) for name, value in pattern.findall(path.read_text(encoding="utf-8"))}


def load_machine(configuration: str, fp_pkg_file: Path = FP_PKG_FILE) -> Machine:
    """Machine of a configuration.

    Raises MachineError naming the file and the constant or configuration that is missing.
    """
    isa = default_isa()
    latencies = fp_latencies(fp_pkg_file)
    build = isa.configurations.get(configuration)
    if build is None:
        known = ", ".join(isa.configurations)
        raise MachineError(f"{ISA_FILE}: no configuration '{configuration}'; it has {known}")
    units: dict[str, UnitRecord] = {}
    for name, record in isa.units.items():
        constant = build.latency_constant(record)
        latency = record.latency if constant is None else latencies.get(constant)
        if latency is None:
            raise MachineError(
                f"{fp_pkg_file}: no 'localparam int unsigned {constant} = n;', "
                f"needed by unit {name}"
            )
        units[name] = replace(record, latency=latency, interval=build.interval(record))
    sizes = {name: bank.size for name, bank in isa.banks.items()}
    if build.fma_pipes < 2:
        sizes["B"] = 0
    return Machine(
        build=build,
        units=units,
        unit_names={name: record.unit for name, record in isa.operations.items()},
        bank_sizes=sizes,
        data_words=isa.data_words,
    )
