# SPDX-License-Identifier: Apache-2.0
"""Records of the instruction set: what `asip_asm.isa` reads from isa.toml."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field

from asip_asm.regmap import BitField

SOURCE_FIELDS = ("a", "b", "c")


@dataclass(frozen=True)
class Bank:
    """Register bank: code of its first 64 registers, number of registers."""

    name: str
    code: int
    size: int
    doc: str


@dataclass(frozen=True)
class Configuration:
    """Build of the core: kind of each slot ('fma', 'aux', 'any'), number of multiply-add pipes.

    `intervals` and `latency_constants` hold the cycles between operations and the constant of the
    latency of the units that differ from their record; `stream_words` are the words of the constant
    memory of each multiply-add pipe, 0 without streams; `loops` are the levels of
    loops, `lanes` those of each pipe besides the first.
    """

    name: str
    slots: tuple[str, ...]
    fma_pipes: int
    doc: str
    intervals: Mapping[str, int] = field(default_factory=dict)
    latency_constants: Mapping[str, str] = field(default_factory=dict)
    stream_words: int = 0
    loops: int = 0
    lanes: int = 0

    @property
    def parameters(self) -> dict[str, int]:
        """Parameters of the RTL (`asip`) that build it; those that are 0 by default only where they
        are not.
        """
        shape = {"FmaPipes": self.fma_pipes, "Slots": len(self.slots)}
        more = {"StreamWords": self.stream_words, "Loops": self.loops, "Lanes": self.lanes}
        return shape | {name: value for name, value in more.items() if value}

    def streams(self, slot: int) -> bool:
        """Whether operations in the slot can read the stream of that number."""
        return self.stream_words > 0 and slot < self.fma_pipes

    def allows(self, slot: int, unit: UnitRecord) -> bool:
        """Whether the slot executes operations of the unit (`nop` is of no unit: always)."""
        kind = "fma" if unit.bank == "pipe" else "aux"
        return self.slots[slot] in (kind, "any")

    def result_bank(self, slot: int, unit: UnitRecord) -> str:
        """Bank that a register result goes to when the operation is in the slot."""
        return "AB"[slot] if unit.bank == "pipe" else unit.bank

    def interval(self, unit: UnitRecord) -> int:
        """Cycles between operations of the unit."""
        return self.intervals.get(unit.name, unit.interval)

    def latency_constant(self, unit: UnitRecord) -> str | None:
        """Constant that states the unit's latency; None if its record does."""
        return self.latency_constants.get(unit.name, unit.latency_constant)


@dataclass(frozen=True)
class UnitRecord:
    """Functional unit: latency in cycles or the constant that states it, cycles between operations,
    bank written ('pipe': the bank of the multiply-add pipe used; 'C' or 'none'), fields of the
    decoded operation with their widths.
    """

    name: str
    interval: int
    bank: str
    control: Mapping[str, int]
    doc: str
    latency: int | None = None
    latency_constant: str | None = None

    @property
    def ranks(self) -> int:
        """The latency, which a machine's units have: `machine` puts the constant's value there."""
        if self.latency is None:
            raise ValueError(f"{self.name}: its latency is {self.latency_constant}")
        return self.latency


@dataclass(frozen=True)
class OperationRecord:
    """One operation: opcode, unit, operands in assembly order with the types of those that are not
    floats, exception flags, control fields that are not 0 (a text is a constant of fp_pkg), value
    and condition of NV in the language of `semantics` (empty without), counts, text.
    """

    name: str
    opcode: int
    unit: str
    operands: tuple[str, ...]
    flags: tuple[str, ...]
    doc: str
    types: Mapping[str, str] = field(default_factory=dict)
    control: Mapping[str, int | str] = field(default_factory=dict)
    result: str = ""
    invalid: str = ""
    counts: Mapping[str, int] = field(default_factory=dict)

    def type_of(self, operand: str) -> str:
        """Type of dst or a source operand: 'float', 'int' or 'any'."""
        if operand == "b" and "address" in self.operands:
            return "int"
        return self.types.get(operand, "float")

    @property
    def unit_name(self) -> str:
        """Its name in the unit, for which floats are nothing to mention: MIN for fmin."""
        return self.name.removeprefix("f").upper()

    @property
    def branches(self) -> bool:
        """Whether it may continue elsewhere; such an operation is illegal in a halting bundle."""
        return "target" in self.operands

    @property
    def every(self) -> bool:
        """Whether registers of the pipe's own bank are vectors in all its operands."""
        return "every" in self.control

    @property
    def vector(self) -> str | None:
        """The source field that must be a vector of the pipe: a limit applies to a, 2^n to b."""
        if {"below", "above"} & set(self.control):
            return "a"
        return "b" if "power" in self.control else None

    @property
    def writes(self) -> bool:
        """Whether the operation has a destination."""
        return "dst" in self.operands

    @property
    def sources(self) -> tuple[str, ...]:
        """Source fields that hold registers, in assembly order; the index of an address is b."""
        return tuple(
            "b" if operand == "address" else operand
            for operand in self.operands
            if operand in SOURCE_FIELDS or operand == "address"
        )

    @property
    def immediate_high(self) -> str | None:
        """Field that holds imm[15:9] (imm[8:0] is field c); None without an immediate."""
        if not {"address", "target", "stream", "count"} & set(self.operands):
            return None
        return "a" if self.writes else "dst"


@dataclass(frozen=True)
class Pipeline:
    """Depths of the pipeline in clock cycles, as isa.toml describes them."""

    operand_read: int
    branch_decision: int
    refetch: int
    write_back: int


@dataclass(frozen=True)
class Isa:
    """The whole instruction set; `fields` are those of the operation word."""

    word_width: int
    fields: Mapping[str, BitField]
    control_width: int
    halt_bit: int
    loop_bit: int
    loop_levels: int
    banks: Mapping[str, Bank]
    outputs: int
    program_bundles: int
    data_words: int
    clock_mhz: int
    pipeline: Pipeline
    configurations: Mapping[str, Configuration]
    units: Mapping[str, UnitRecord]
    operations: Mapping[str, OperationRecord]

    def bundle_width(self, configuration: str) -> int:
        """Bits of a bundle: control and one operation word per slot."""
        return self.control_width + self.word_width * len(self.configurations[configuration].slots)

    def lanes(self, configuration: str) -> int:
        """32-bit lanes of program memory per bundle."""
        return -(-self.bundle_width(configuration) // 32)

    def unit_of(self, mnemonic: str) -> UnitRecord:
        """Unit that executes the operation."""
        return self.units[self.operations[mnemonic].unit]

    @functools.cached_property
    def differing(self) -> tuple[str, ...]:
        """Units whose interval depends on the configuration, in their order."""
        named = {name for each in self.configurations.values() for name in each.intervals}
        return tuple(name for name in self.units if name in named)

    @functools.cached_property
    def without_streams(self) -> tuple[str, ...]:
        """Configurations without streams; one with them is otherwise the same as one of these."""
        return tuple(c.name for c in self.configurations.values() if not c.stream_words)

    @functools.cached_property
    def lanes_of_a_vector(self) -> int:
        """Words of a vector: lanes of the configurations that have more than one."""
        return 1 + max(configuration.lanes for configuration in self.configurations.values())

    @functools.cached_property
    def branches(self) -> frozenset[str]:
        """Operations that may continue elsewhere."""
        return frozenset(name for name, record in self.operations.items() if record.branches)

    def of_unit(self, unit: str) -> tuple[OperationRecord, ...]:
        """Operations of a unit in their order."""
        return tuple(record for record in self.operations.values() if record.unit == unit)

    @property
    def comparisons(self) -> Mapping[str, OperationRecord]:
        """Operations of fp_cmp by their name in the unit, in the order of their code."""
        records = sorted(self.of_unit("cmp"), key=lambda record: int(record.control["cmp_op"]))
        return {record.unit_name: record for record in records}

    @property
    def spare_comparisons(self) -> Mapping[str, int]:
        """Codes of fp_cmp that no operation has, by a name for each: the unit copies a."""
        used = {record.control["cmp_op"] for record in self.of_unit("cmp")}
        last = (1 << self.units["cmp"].control["cmp_op"]) - 1
        return {
            "MOV_SPARE" if code == last else f"MOV_SPARE_{code}": code
            for code in range(last + 1)
            if code not in used
        }

    @functools.cached_property
    def by_opcode(self) -> Mapping[int, OperationRecord]:
        """Operations by opcode."""
        return {record.opcode: record for record in self.operations.values()}

    @functools.cached_property
    def index_bits(self) -> int:
        """Index bits of a source field next to its bank code."""
        return self.fields["dst"].width - 1
