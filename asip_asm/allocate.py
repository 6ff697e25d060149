# SPDX-License-Identifier: Apache-2.0
"""Physical registers for the symbols of a scheduled program, and spilling to data memory.

Linear scan over all bundles in program order. A register is in use from the bundle that writes it
to the bundle that reads it last; operands are read at issue, so that last bundle may already write
it again. Free registers are used in turn. The register of a result that nothing reads comes last
until that result is written, so that no bundle waits to overwrite it.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from asip_asm.ir import Bundle, Operation, Program, Region, Register, Virtual
from asip_asm.isa import default_isa
from asip_asm.liveness import region_liveness
from asip_asm.machine import Machine, sources
from asip_asm.schedule import state_storage

BANKS = ("A", "B", "C")
VECTOR_WRITERS = frozenset(
    record.name for record in default_isa().of_unit("lanes") if "lane" not in record.operands
)
SPILL_WORK = 150_000
"""Values moved to data memory and back, times operations: bounds the allocation to seconds."""


class AllocationError(ValueError):
    """Registers or data memory do not suffice, or a register would have to hold two values."""


@dataclass(eq=False)
class Range:
    """Bundles [begin, end) in which a symbol needs its register, and the bundles that read it.

    `done` is the first bundle that may write the register again without waiting.
    """

    symbol: Virtual
    bank: str
    begin: int
    end: int
    done: int = 0
    reads: list[int] = field(default_factory=list)


@dataclass(eq=False)
class Overflow(Exception):
    """No register of `bank` is free in bundle `position`; `live` are the ranges that hold them."""

    bank: str
    position: int
    live: list[Range]


def allocate_registers(program: Program, machine: Machine) -> None:
    """Replace every `Virtual` of a scheduled program by a `Register`, and set those of states and
    exports.

    States keep one register from start to end, exports keep theirs to the end. If a bank overflows,
    the value with the longest time to its next use is stored in a data word after the program's
    own and loaded again; this adds data words, operations and, where no auxiliary slot is free,
    bundles. Raises AllocationError.
    """
    spiller = _Spiller(program, machine)
    most = SPILL_WORK // max(1, sum(1 for _ in program.placed()))
    while True:
        try:
            placement = _Allocation(program, machine).run()
            break
        except Overflow as overflow:
            if spiller.reloads >= most:
                raise AllocationError(
                    f"too many values at once: {most} were moved to data memory and bank "
                    f"{overflow.bank} still overflows in bundle {overflow.position}; compute "
                    "values shortly before they are read"
                ) from None
            spiller.spill(overflow)
    for _, _, op in program.placed():
        op.symbols = _symbols(op)
        _substitute(op, placement)
    for state in program.states:
        state.register = placement[state.first]
    for export in program.exports:
        value = export.value
        export.register = placement[value] if isinstance(value, Virtual) else value


def _symbols(operation: Operation) -> dict[str, Virtual]:
    operands = ((name, getattr(operation, name)) for name in ("dst", "a", "b", "c"))
    return {name: value for name, value in operands if isinstance(value, Virtual)}


def _substitute(operation: Operation, placement: Mapping[Virtual, Register | Virtual]) -> None:
    for name, value in _symbols(operation).items():
        setattr(operation, name, placement.get(value, value))


class _Allocation:
    """One attempt to place all symbols."""

    def __init__(self, program: Program, machine: Machine) -> None:
        self.program = program
        self.machine = machine
        self.storage = state_storage(program)
        self.placement: dict[Virtual, Register] = {}
        self.free = {
            bank: deque(Register(bank, i) for i in range(machine.bank_sizes[bank]))
            for bank in BANKS
        }

    def run(self) -> dict[Virtual, Register]:
        """Register of every symbol. Raises Overflow, AllocationError."""
        self._reserve_named()
        self._place_states()
        active: dict[str, list[Range]] = {bank: [] for bank in BANKS}
        done: dict[Register, int] = {}
        for value in sorted(self._ranges(), key=lambda r: (r.begin, r.bank)):
            in_use, free = active[value.bank], self.free[value.bank]
            for ended in sorted((r for r in in_use if r.end <= value.begin), key=lambda r: r.end):
                in_use.remove(ended)
                register = self.placement[ended.symbol]
                free.append(register)
                done[register] = ended.done
            if not free:
                raise Overflow(value.bank, value.begin, in_use)
            register = min(free, key=lambda r: max(done.get(r, 0), value.begin))
            free.remove(register)
            self.placement[value.symbol] = register
            in_use.append(value)
        for state in self.program.states:
            if state.last is not None:
                self.placement[state.last] = self.placement[state.first]
        return self.placement

    def _reserve_named(self) -> None:
        """Take registers that the source names out of the pools."""
        named: set[object] = {export.value for export in self.program.exports}
        named.update(state.register for state in self.program.fixed_states)
        for _, _, op in self.program.placed():
            named.update((op.dst, op.a, op.b, op.c))
        for bank in BANKS:
            self.free[bank] = deque(r for r in self.free[bank] if r not in named)

    def _place_states(self) -> None:
        bank_of = {
            op.dst: self.machine.bank(op, slot)
            for _, slot, op in self.program.placed()
            if isinstance(op.dst, Virtual)
        }
        for state in self.program.states:
            written = bank_of.get(state.last) if state.last is not None else None
            bank = written or state.pin or "C"
            if not self.free[bank]:
                raise AllocationError(f"state '{state.name}': bank {bank} has no register left")
            self.placement[state.first] = self.free[bank].popleft()
        overwritten = {s.first for s in self.program.states if s.last not in (None, s.first)}
        for export in self.program.exports:
            if export.value in overwritten:
                raise AllocationError(
                    f"export '{export.name}': the state's value at the start is overwritten"
                )

    def _ranges(self) -> list[Range]:
        """Live range of every symbol that is not a state."""
        states = set(self.placement) | set(self.storage)
        found: dict[Virtual, Range] = {}
        for position, slot, op in self.program.placed():
            for source in sources(op):
                if isinstance(source, Virtual) and source in found:
                    found[source].reads.append(position)
                    found[source].end = max(found[source].end, position)
            if isinstance(op.dst, Virtual) and op.dst not in states:
                bank = self.machine.bank(op, slot) or ""
                value = found.setdefault(op.dst, Range(op.dst, bank, position, position + 1))
                value.end = max(value.end, position + 1)
                if value.bank != bank:
                    raise AllocationError(
                        f"'{op.dst.name}' is written to bank {value.bank} and to bank {bank}"
                    )
        self._find_unread(found)
        self._cross_borders(found, states)
        return list(found.values())

    def _cross_borders(self, found: dict[Virtual, Range], states: set[Virtual]) -> None:
        """Extend the ranges of values that live across borders of regions."""
        begin = 0
        exports = {export.value for export in self.program.exports}
        borders = region_liveness(self.program, exports)
        for region, (first, last) in zip(self.program.regions, borders, strict=True):
            end = begin + len(region.bundles or [])
            symbols = [s for s in first | last if isinstance(s, Virtual) and s not in states]
            for symbol in sorted(symbols, key=lambda s: (s.name, s.version)):
                if symbol not in found:
                    raise AllocationError(f"'{symbol.name}' is read or exported but never written")
                value = found[symbol]
                if symbol in first:
                    value.begin = min(value.begin, begin)
                    value.end = max(value.end, begin)
                if symbol in last:
                    value.begin = min(value.begin, max(begin, end - 1))
                    value.end = max(value.end, end)
            begin = end

    def _find_unread(self, found: dict[Virtual, Range]) -> None:
        """Set `done` of values whose last write nothing reads."""
        position = 0
        for region in self.program.regions:
            bundles = region.bundles or []
            for (i, slot), done in self.machine.landings(bundles).items():
                op = bundles[i].slots[slot]
                value = found.get(op.dst) if op and isinstance(op.dst, Virtual) else None
                if value is not None and all(read <= position + i for read in value.reads):
                    value.done = position + done
            position += len(bundles)


class _Spiller:
    """Moves values to data memory and back, in place: bundles keep their order."""

    def __init__(self, program: Program, machine: Machine) -> None:
        self.program = program
        self.machine = machine
        self.stored: dict[Virtual, int] = {}
        self.reader: dict[Virtual, Operation] = {}
        self.reloads = 0
        self.later: set[Virtual] = set()
        self.changed = {op.imm for _, _, op in program.placed() if op.mnemonic == "st"}

    def spill(self, overflow: Overflow) -> None:
        """Free a register of the bank in the overflowing bundle. Raises AllocationError."""
        region, start = self._region(overflow.position)
        index = overflow.position - start
        local = self._local_symbols(region)
        choices = [
            (next_read, value)
            for value in overflow.live
            if value.symbol in local
            for next_read in [min((r for r in value.reads if r > overflow.position), default=0)]
            if next_read
        ]
        if not choices:
            raise AllocationError(
                f"bank {overflow.bank} has {self.machine.bank_sizes[overflow.bank]} registers; "
                f"bundle {overflow.position} needs one more and none of its values can be spilled"
            )
        next_read, value = max(choices, key=lambda choice: choice[0])
        bundles = region.bundles or []
        reader = self.reader.get(value.symbol)
        if reader is not None and reader in bundles[next_read - start].slots:
            raise AllocationError(
                f"bundle {next_read} reads more values than bank {overflow.bank} can hold at once"
            )
        stored_at = self._store(region, value.symbol, value.begin - start, index)
        self._reload(region, value.symbol, stored_at)

    def _region(self, position: int) -> tuple[Region, int]:
        start = 0
        for region in self.program.regions:
            if position < start + len(region.bundles or []):
                return region, start
            start += len(region.bundles or [])
        raise AssertionError("position after the last bundle")

    def _local_symbols(self, region: Region) -> set[Virtual]:
        """Symbols written once, in this linear region, read only there, and not exported; no
        vectors.
        """
        if not region.operations:
            return set()
        writes = Counter(op.dst for op in region.operations if isinstance(op.dst, Virtual))
        local = {symbol for symbol, count in writes.items() if count == 1}
        own = set(region.operations)
        for _, _, op in self.program.placed():
            if op not in own:
                local.difference_update((op.dst, op.a, op.b, op.c))
        # A word of data memory holds one lane.
        vectors = {op.dst for op in own if op.mnemonic in VECTOR_WRITERS}
        return local - vectors - {export.value for export in self.program.exports}

    def _store(self, region: Region, symbol: Virtual, written: int, index: int) -> int:
        """Store the value after bundle `written` and not after bundle `index`. A value loaded from
        a word that nothing stores to is in memory already.

        Returns the index of the first bundle that may follow with the overflowing write.
        """
        if symbol in self.stored:
            return index
        writer = next(op for op in region.operations if op.dst == symbol)
        word = writer.imm if writer.mnemonic == "ld" else None
        if word is not None and word not in self.changed:
            self.stored[symbol] = word
            return index
        address = len(self.program.data)
        if address >= self.machine.data_words:
            raise AllocationError(
                f"more values at once than the registers and the {self.machine.data_words} words "
                f"of data memory hold: there is no word left for '{symbol.name}'"
            )
        self.program.data.append(0)
        self.stored[symbol] = address
        store = Operation("st", a=symbol, imm=address, source=writer.source)
        region.operations.insert(region.operations.index(writer) + 1, store)
        bundles = region.bundles or []
        issues = [issue.cycle for issue in self.machine.issue_cycles(bundles)]
        ready = issues[written] + self.machine.latency(writer) + 1
        for i in range(written + 1, index + 1):
            if issues[i] >= ready and self._fill(bundles[i], store):
                return index
        self._insert(bundles, index, store)
        return index + 1

    def _reload(self, region: Region, symbol: Virtual, index: int) -> None:
        """Load the value again after bundle `index`, for all later readers.

        The first time it is loaded early enough for its reader not to wait. A value that has to
        give way once more is loaded right before its reader.
        """
        bundles = region.bundles or []
        readers = [
            i
            for i in range(index + 1, len(bundles))
            if any(symbol in sources(op) for op in bundles[i].operations)
        ]
        first = readers[0]
        self.reloads += 1
        renamed = [op for i in readers for op in bundles[i].operations if symbol in sources(op)]
        load = self._take_unread_load(region, symbol, index)
        if load is None:
            copy = Virtual(f"{symbol.name.split('~')[0]}~{self.reloads}", 1)
            self.stored[copy] = self.stored[symbol]
            for op in renamed:
                _substitute(op, {symbol: copy})
            load = Operation("ld", copy, imm=self.stored[symbol], source=renamed[0].source)
        place = min(region.operations.index(op) for op in renamed)
        region.operations.insert(place, load)
        if "~" in symbol.name and isinstance(load.dst, Virtual):
            self.reader[load.dst] = next(op for op in bundles[first].slots if op in renamed)
            self._insert(bundles, first, load)
            return
        issues = [issue.cycle for issue in self.machine.issue_cycles(bundles)]
        needed = self.machine.latency(load) + 1
        early = [i for i in range(index + 1, first) if issues[first] - issues[i] >= needed]
        for i in reversed(early):
            if self._fill(bundles[i], load):
                return
        self._insert(bundles, early[-1] + 1 if early else index + 1, load)

    def _take_unread_load(self, region: Region, symbol: Virtual, index: int) -> Operation | None:
        """Take the load of a value that gives way in bundle `index` before anything read it out of
        its bundle; the value then is loaded later. None if there is no such load, or if the value
        gave way before.
        """
        bundles = region.bundles or []
        readers = (op for bundle in bundles[: index + 1] for op in bundle.operations)
        if symbol in self.later or any(symbol in sources(op) for op in readers):
            return None
        for bundle in bundles[: index + 1]:
            for slot, op in bundle.placed():
                if op.dst == symbol and op.mnemonic == "ld" and op.imm not in self.changed:
                    bundle.slots[slot] = None
                    region.operations.remove(op)
                    self.later.add(symbol)
                    return op
        return None

    def _fill(self, bundle: Bundle, operation: Operation) -> bool:
        """Put the operation into a free slot of the bundle, if there is one."""
        for slot in self.machine.slots_of(operation):
            if bundle.slots[slot] is None:
                bundle.slots[slot] = operation
                return True
        return False

    def _insert(self, bundles: list[Bundle], index: int, operation: Operation) -> None:
        slot = self.machine.slots_of(operation)[0]
        bundles.insert(index, self.machine.bundle({slot: operation}))
