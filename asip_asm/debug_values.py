# SPDX-License-Identifier: Apache-2.0
"""The debug map of an assembled program: which value each register holds at each bundle.

Reaching definitions (Aho, Lam, Sethi, Ullman: Compilers, 9.2.4) over the bundles, for every
register and output by itself. All operations of a bundle read before any writes, so a value is in
its register from the bundle after its write up to the next bundle that writes the register.
"""

from __future__ import annotations

import hashlib
from collections import defaultdict

from asip_asm.debug_map import SPANS, DebugMap, Value, Write
from asip_asm.encode import label_addresses
from asip_asm.image import Image
from asip_asm.ir import (
    FixedState,
    Operation,
    Output,
    Program,
    Register,
    SourceLine,
    State,
    Virtual,
    register_name,
)
from asip_asm.isa import default_isa
from asip_asm.loops import back_edges
from asip_asm.machine import BRANCHES, Machine
from asip_asm.reader import display_path

Key = tuple[str, int, str]
"""Name, version and place of a value."""
BEFORE: Key = ("", 0, "")
"""What a place holds when the run starts, where that has no name."""


def debug_map(program: Program, machine: Machine, image: Image) -> DebugMap:
    """Map of a program of `build_program` and its image."""
    return _Builder(program, machine, image).build()


class _Builder:
    def __init__(self, program: Program, machine: Machine, image: Image) -> None:
        self.program = program
        self.machine = machine
        self.image = image
        self.isa = default_isa()
        self.bundles = program.bundles
        self.lands = machine.landings(self.bundles)
        self.follow = self._follow()
        self.found: dict[Key, Value] = {}
        self.types: dict[str, str] = {s.name: s.type for s in program.states}
        self.types |= {s.name: s.type for s in program.fixed_states}
        self.k_types = {f"k{entry.index}": entry.type for entry in image.inputs}
        self.k_types |= {f"k{constant.index}": constant.type for constant in image.constants}
        # Physical registers that the source gives a name.
        self.aliases = {register_name(s.register): s.name for s in program.fixed_states}
        self.aliases |= {
            register_name(e.value): e.name
            for e in program.exports
            if isinstance(e.value, Register) and e.value.bank not in ("K", "zero")
        }
        self.outputs = {output.index: output.name for output in program.outputs}
        self.copies = self._copies()

    def build(self) -> DebugMap:
        places = self._definitions()
        for place, writes in places.items():
            self._spans(place, writes)
        return DebugMap(
            image=self.image.to_json()["checksum"],
            bundles=len(self.bundles),
            files={
                display_path(path): hashlib.sha256(path.read_bytes()).hexdigest()
                for path in dict.fromkeys(self.program.files)
            },
            cycles=[issue.cycle for issue in self.machine.issue_cycles(self.bundles)],
            follow={str(i): follow for i, follow in enumerate(self.follow) if follow != [i + 1]},
            calls={
                f"{i}.{slot}": list(op.source.expansions)
                for i, slot, op in self.program.placed()
                if op.source and op.source.expansions
            },
            values=list(self.found.values()),
        )

    def _follow(self) -> list[list[int]]:
        labels = label_addresses(self.program)
        turns = back_edges(self.bundles)
        end = len(self.bundles)
        follow = []
        for i, bundle in enumerate(self.bundles):
            branches = [op for op in bundle.operations if op.mnemonic in BRANCHES]
            next_ones = [] if any(op.mnemonic == "jmp" for op in branches) else [i + 1]
            next_ones += turns.get(i, [])
            next_ones += [labels[op.target] for op in branches if op.target is not None]
            follow.append([end] if bundle.halt else sorted(set(next_ones)))
        return follow

    def _copies(self) -> dict[tuple[str, int], tuple[Virtual, int]]:
        """By name and data word of each value that the allocator loads again, the value and the
        bundle from which on the word has it: that of its store, or of its own load.
        """
        words = {
            (self._symbol_name(op).split("~")[0], op.imm)
            for _, _, op in self.program.placed()
            if "~" in self._symbol_name(op)
        }
        found: dict[tuple[str, int], tuple[Virtual, int]] = {}
        for i, _, op in self.program.placed():
            symbol = op.symbols.get({"st": "a", "ld": "dst"}.get(op.mnemonic, ""))
            if symbol is not None and op.imm is not None and (symbol.name, op.imm) in words:
                found.setdefault((symbol.name, op.imm), (symbol, i))
        return found

    # ------------------------------------------------------------------ values
    def _definitions(self) -> dict[str, dict[int, Key]]:
        """By place, the value that each bundle writes there; fills `found`."""
        places: dict[str, dict[int, Key]] = defaultdict(dict)
        states: list[State | FixedState] = [*self.program.states, *self.program.fixed_states]
        for state in states:
            if state.register is not None:
                version = state.first.version if isinstance(state, State) else -1
                place = register_name(state.register)
                self._value((state.name, version, place), state.type)
                places[place][-1] = (state.name, version, place)
        for i, slot, op in self.program.placed():
            key = self._key(op)
            if key is None:
                continue
            places[key[2]][i] = key
            value = self._value(key, self._type(op), op.source)
            value.writes.append(Write(i, slot, self.lands[i, slot]))
            self.types.setdefault(self._symbol_name(op), value.type)
        for (_, address), (symbol, bundle) in self.copies.items():
            for value in self.found.values():
                if (value.name, value.version) == (symbol.name, symbol.version):
                    value.spilled = (bundle, address)
        return places

    def _value(self, key: Key, type_name: str, source: SourceLine | None = None) -> Value:
        """The value of a key, made if it is new; its line is that of its first write."""
        if key not in self.found:
            name, version, place = key
            self.found[key] = Value(name, version, type_name, place, "", 0, "", writes=[], held=[])
        value = self.found[key]
        if source and not value.writes:
            value.file, value.line, value.equation = source.file, source.line, source.equation
        return value

    def _symbol_name(self, op: Operation) -> str:
        return op.symbols["dst"].name if "dst" in op.symbols else ""

    def _key(self, op: Operation) -> Key | None:
        """Value that an operation writes."""
        if isinstance(op.dst, Output):
            return self.outputs.get(op.dst.index, f"o{op.dst.index}"), 1, f"o{op.dst.index}"
        if not isinstance(op.dst, Register):
            return None
        place = register_name(op.dst)
        symbol = op.symbols.get("dst")
        if symbol is None:
            return self.aliases.get(place, place), -1, place
        if "~" in symbol.name and op.imm is not None:  # a copy from data memory
            symbol = self.copies[symbol.name.split("~")[0], op.imm][0]
        return symbol.name, symbol.version, place

    def _type(self, op: Operation) -> str:
        record = self.isa.operations[op.mnemonic]
        wrote = record.type_of("dst")
        if wrote != "any":
            return wrote
        for operand in record.sources:
            if record.type_of(operand) == "any":
                symbol = op.symbols.get(operand)
                if symbol is not None:
                    return self.types.get(symbol.name, "float")
                register = getattr(op, operand)
                return self.k_types.get(register_name(register), "float")
        return "float"

    def _spans(self, place: str, writes: dict[int, Key]) -> None:
        """Positions at which each value is in a place."""
        end = len(self.bundles)
        before: list[set[Key]] = [set() for _ in range(end + 1)]
        before[self.image.entry].add(writes.get(-1, BEFORE))
        waiting = [self.image.entry]
        while waiting:
            i = waiting.pop()
            if i == end:
                continue
            after = {writes[i]} if i in writes else before[i]
            for j in self.follow[i]:
                if not after <= before[j]:
                    before[j] |= after
                    waiting.append(j)
        for position, keys in enumerate(before):
            for key in keys - {BEFORE}:
                value = self.found[key]
                spans = value.held if len(keys) == 1 else value.perhaps
                if spans and spans[-1][1] == position - 1:
                    spans[-1] = (spans[-1][0], position)
                elif len(spans) < SPANS:
                    spans.append((position, position))
