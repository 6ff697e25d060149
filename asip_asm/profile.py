# SPDX-License-Identifier: Apache-2.0
"""What happened in every clock cycle of a run on the core.

Built from the core's own trace (issues and writes by cycle) and counters. Cycle 0 is the first
cycle that `CYCLES` counts, in which the first bundle issues. An operation that issues in cycle t is
in stages R1 and R2 from t + 1, in E1 at t + 3 and in W at t + 3 + latency (docs/architecture.md).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asip_asm.disassemble import decode_bundle, operation_text
from asip_asm.image import Image
from asip_asm.ir import Bundle, Operation, Output, Register, register_name
from asip_asm.isa import Isa, default_isa
from asip_asm.machine import (
    BRANCH_WAIT,
    BRANCHES,
    OPERAND_READ,
    REFETCH,
    Interlocks,
    Machine,
    load_machine,
    sources,
)

CAUSE_COUNTERS = {
    "operand": "STALL_OPERAND",
    "write port": "STALL_PORT",
    "unit": "STALL_UNIT",
    "fetch": "STALL_FETCH",
    "drain": "DRAIN",
}
"""Counter of the register map for each cause of a cycle without issue."""

LONGEST_WAITS = 10


class ProfileError(ValueError):
    """Trace, counters and program do not belong together; the message says what differs."""


@dataclass(frozen=True)
class Trace:
    """One run as the core saw it.

    issues: (cycle, program address); writes: (cycle, bank 'A', 'B', 'C' or 'O', index, word), both
    in any common time scale; counters by name of the register map, `CYCLES` among them.
    """

    issues: Sequence[tuple[int, int]]
    writes: Sequence[tuple[int, str, int, int]]
    counters: Mapping[str, int]


@dataclass(frozen=True)
class Execution:
    """One operation on its way through the pipeline; cycles as in the module's text.

    `unit`: 'pipe 0', 'pipe 1' or the unit's name. `decode`: first cycle in stage D. `end`: first
    cycle in no stage. `target`: register or output written in cycle `end - 1` with `word`, None
    without a result. `producers`: numbers of the executions that computed the operands in this
    run.
    """

    number: int
    address: int
    slot: int
    unit: str
    text: str
    where: str
    equation: str
    decode: int
    issue: int
    end: int
    target: str | None
    word: int | None
    producers: tuple[int, ...]

    @property
    def start(self) -> int:
        """Cycle of stage E1."""
        return self.issue + OPERAND_READ


@dataclass(frozen=True)
class Wait:
    """Cycles without issue, from `cycle` on, for one cause; `address` is the bundle that waits.

    `producer` is the number of the execution that the bundle waits for: the one that writes its
    operand, or the branch before it (cause 'fetch').
    """

    cycle: int
    cycles: int
    cause: str
    address: int | None
    producer: int | None = None


@dataclass(frozen=True)
class UnitUse:
    """Operations of a unit in a run, and the cycles in which it could take no other."""

    operations: int
    busy: int


@dataclass(frozen=True)
class Profile:
    """A run, clock by clock; `causes` (issue, and those of `CAUSE_COUNTERS`) add up to `cycles`."""

    title: str
    configuration: str
    cycles: int
    causes: dict[str, int]
    units: dict[str, UnitUse]
    issues: tuple[tuple[int, int], ...]
    executions: tuple[Execution, ...]
    waits: tuple[Wait, ...]

    def render(self) -> str:
        """Text for people, several lines."""
        rows = [
            f"profile of {self.title or 'program'} ({self.configuration}): {self.cycles} cycles, "
            f"{len(self.issues)} bundles, {len(self.executions)} operations",
            f"{'cycles':<12}{'':>10}{'share':>10}",
        ]
        rows += [f"  {k:<10}{n:>10}{self._share(n)}" for k, n in self.causes.items()]
        rows.append(f"{'unit':<12}{'operations':>10}{'busy':>10}")
        for name, use in self.units.items():
            rows.append(f"  {name:<10}{use.operations:>10}{self._share(use.busy)}")
        waits = [wait for wait in self.waits if wait.cause != "drain"]
        waits.sort(key=lambda wait: (-wait.cycles, wait.cycle))
        rows += ["longest waits"] if waits else []
        rows += [self.describe(wait) for wait in waits[:LONGEST_WAITS]]
        return "\n".join(rows) + "\n"

    def describe(self, wait: Wait) -> str:
        """Line about a wait: when, how long, why, which operations wait for which."""
        waiting = [e for e in self.executions if e.decode <= wait.cycle < e.issue]
        text = f"  cycle {wait.cycle}: {wait.cycles} {wait.cause}"
        if waiting:
            text += f", {waiting[0].where}: " + " | ".join(e.text for e in waiting)
        if wait.producer is not None:
            producer = self.executions[wait.producer]
            text += f", for {producer.where}: {producer.text}"
        return text

    def _share(self, cycles: int) -> str:
        return f"{100.0 * cycles / self.cycles:>8.1f} %"


def profile_run(image: Image, trace: Trace) -> Profile:
    """Profile of a run that ended without a fault. Raises ProfileError."""
    machine = load_machine(image.configuration)
    if not trace.issues:
        raise ProfileError("the trace holds no issue")
    replay = _Replay(image, machine, trace)
    cycles = trace.counters["CYCLES"]
    for cycle, address in replay.issues:
        replay.issue(cycle, address)
    replay.wait(replay.now, cycles, None)
    causes = {"issue": len(replay.issues), **dict.fromkeys(CAUSE_COUNTERS, 0)}
    for wait in replay.waits:
        causes[wait.cause] += wait.cycles
    for cause, name in CAUSE_COUNTERS.items():
        if causes[cause] != trace.counters[name]:
            raise ProfileError(
                f"{causes[cause]} cycles of '{cause}' in the trace, the core counted "
                f"{trace.counters[name]} ({name})"
            )
    return Profile(
        title=image.title,
        configuration=image.configuration,
        cycles=cycles,
        causes=causes,
        units=_unit_use(machine, replay.executions),
        issues=replay.issues,
        executions=tuple(replay.executions),
        waits=tuple(replay.waits),
    )


def unit_names(machine: Machine) -> list[str]:
    """Names of the units as executions have them, multiply-add pipes first."""
    pipes = sum(slot in ("fma", "any") for slot in machine.slots)
    others = [name for name, unit in machine.units.items() if unit.bank != "pipe"]
    return [f"pipe {i}" for i in range(pipes)] + others


def _unit_use(machine: Machine, executions: Sequence[Execution]) -> dict[str, UnitUse]:
    counts = Counter(execution.unit for execution in executions)
    intervals = {name: unit.interval for name, unit in machine.units.items()}
    return {
        name: UnitUse(counts[name], counts[name] * intervals.get(name, 1))
        for name in unit_names(machine)
    }


class _Replay:
    """Follows the interlocks along the trace and names what every bundle waited for."""

    def __init__(self, image: Image, machine: Machine, trace: Trace) -> None:
        origin = trace.issues[0][0]
        self.issues = tuple((cycle - origin, address) for cycle, address in trace.issues)
        self.words = {(c - origin, bank, index): word for c, bank, index, word in trace.writes}
        self.image = image
        self.machine = machine
        self.isa = default_isa()
        self.bundles: dict[int, Bundle] = {}
        self.executions: list[Execution] = []
        self.waits: list[Wait] = []
        self.now = 0  # first cycle whose bundle is not known yet
        self.branch: Execution | None = None  # in the last bundle
        self.interlocks = Interlocks(machine)
        self.writer: dict[object, int] = {}

    def issue(self, cycle: int, address: int) -> None:
        """The bundle at `address` issues in `cycle`."""
        bundle = self._bundle(address)
        decode = min(self.now + self._fetch_cycles(address), cycle)
        branch = self.branch.number if self.branch else None
        self._add_wait(self.now, decode, "fetch", address, branch)
        self.wait(decode, cycle, address)
        self.branch = None
        written: dict[object, int] = {}
        for slot, op in bundle.placed():
            execution = self._execution(op, address, slot, decode, cycle)
            self.executions.append(execution)
            written[op.dst] = execution.number
            if op.mnemonic in BRANCHES:
                self.branch = execution
        self.writer |= written
        self.interlocks.issue(bundle.operations, cycle)
        self.now = cycle + 1

    def wait(self, start: int, end: int, address: int | None) -> None:
        """Nothing issues from `start` to before `end`; `address` is in stage D (None: drain)."""
        while start < end:
            cause, producer = "drain", None
            if address is not None:
                cause, producer = self._cause(self._bundle(address), start)
            stop = start + 1
            while stop < end and (
                address is None or self._cause(self._bundle(address), stop) == (cause, producer)
            ):
                stop += 1
            self._add_wait(start, stop, cause, address, producer)
            start = stop

    def _add_wait(
        self, start: int, end: int, cause: str, address: int | None, producer: int | None = None
    ) -> None:
        if end > start:
            self.waits.append(Wait(start, end - start, cause, address, producer))

    def _fetch_cycles(self, address: int) -> int:
        """Cycles between the last issue and stage D of the bundle that follows it."""
        if self.branch is None:
            return 0
        mnemonics = {op.mnemonic for op in self._bundle(self.branch.address).operations}
        taken = "jmp" in mnemonics or address != self.branch.address + 1
        return BRANCH_WAIT + (REFETCH if taken else 0)

    def _cause(self, bundle: Bundle, cycle: int) -> tuple[str, int | None]:
        """What holds the bundle in stage D, and the execution that it waits for longest."""
        cause = self.interlocks.cause(bundle.operations, cycle)
        if cause in ("operand", "waw"):
            places = [place for op in bundle.operations for place in (*sources(op), op.dst)]
            ready = self.interlocks.ready
            return "operand", self.writer[max(places, key=lambda place: ready.get(place, 0))]
        if cause is None:
            return "fetch", None
        return "write port" if cause == "port" else cause, None

    def _bundle(self, address: int) -> Bundle:
        if address not in self.bundles:
            if address >= len(self.image.bundles):
                raise ProfileError(f"bundle {address} issued, the program has no such bundle")
            word = int(self.image.bundles[address], 16)
            self.bundles[address] = decode_bundle(word, self.image.configuration, self.isa)
        return self.bundles[address]

    def _execution(
        self, op: Operation, address: int, slot: int, decode: int, issue: int
    ) -> Execution:
        unit = self.machine.unit(op)
        target = word = None
        end = issue + OPERAND_READ + 1
        if op.dst is not None:
            target, bank, index = _target(op.dst)
            write = issue + OPERAND_READ + unit.ranks
            word = self.words.get((write, bank, index))
            if word is None:
                raise ProfileError(f"bundle {address}: no write of {target} in cycle {write}")
            end = write + 1
        entry = next((e for e in self.image.sources[address] if e.slot == slot), None)
        return Execution(
            number=len(self.executions),
            address=address,
            slot=slot,
            unit=f"pipe {slot}" if unit.bank == "pipe" else unit.name,
            text=entry.text if entry else _text(op, self.isa),
            where=f"{entry.file}:{entry.line}" if entry else f"bundle {address}",
            equation=entry.equation if entry else "",
            decode=decode,
            issue=issue,
            end=end,
            target=target,
            word=word,
            producers=tuple(
                dict.fromkeys(self.writer[place] for place in sources(op) if place in self.writer)
            ),
        )


def _target(place: object) -> tuple[str, str, int]:
    """Name, bank of the trace and index of a destination."""
    if isinstance(place, Output):
        return f"o{place.index}", "O", place.index
    assert isinstance(place, Register)
    return register_name(place), place.bank, place.index


def _text(operation: Operation, isa: Isa) -> str:
    """Text of an operation without a source line."""
    target = operation.imm or 0
    return operation_text(operation, isa, {target: str(target)})
