# SPDX-License-Identifier: Apache-2.0
"""The instruction set of `isa.toml`, validated, as dataclasses.

One record per operation feeds the assembler, the disassembler, the encoder and the generated
packages and documents (`scripts/gen_isa.py`).
"""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from asip_asm.isa_records import (
    SOURCE_FIELDS,
    Bank,
    Configuration,
    Isa,
    OperationRecord,
    Pipeline,
    UnitRecord,
)
from asip_asm.regmap import BitField
from asip_asm.semantics import SemanticsError, check

ISA_FILE = Path(__file__).with_name("isa.toml")

WORD_FIELDS = ("op", "dst", "a", "b", "c")
OPERAND_KINDS = ("dst", "a", "b", "c", "address", "target", "stream", "count", "lane")
FLAG_NAMES = ("NV", "DZ", "OF", "UF", "NX")
TYPE_NAMES = ("int", "any")
UNIT_BANKS = ("pipe", "C", "none")
SLOT_KINDS = ("fma", "aux", "any")
BANK_NAMES = ("zero", "A", "B", "C", "K", "S")
LIMIT_NAMES = ("outputs", "program_bundles", "data_words")
PIPELINE_NAMES = ("operand_read", "branch_decision", "refetch", "write_back")
IMMEDIATE_WIDTH = 16
STREAM_BITS = IMMEDIATE_WIDTH - 1
"""Bits of a word's address in a stream; the highest bit of the immediate is the pipe."""
STREAM_PINS = "AB"
"""Pipes that have a stream, in the order of their slots."""
LOOP_BITS = IMMEDIATE_WIDTH - 2
"""Bits of the rounds of a loop, less one; the highest two bits of the immediate are its level."""


class IsaError(ValueError):
    """The instruction-set file contradicts itself; one line per finding, each naming its record."""


class _Findings:
    """Collects contradictions and raises them together."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: list[str] = []

    def add(self, where: str, what: str) -> None:
        self.lines.append(f"{self.path.name}: {where}: {what}")

    def known(self, where: str, what: str, value: object, names: Iterable[str]) -> bool:
        names = tuple(names)
        if value in names:
            return True
        self.add(where, f"unknown {what} '{value}'; known are {', '.join(names)}")
        return False

    def keys(
        self, where: str, record: Mapping[str, Any], required: set[str], optional: set[str]
    ) -> bool:
        missing = sorted(required - set(record))
        unknown = sorted(set(record) - required - optional)
        if missing:
            self.add(where, f"missing key {', '.join(missing)}")
        if unknown:
            self.add(where, f"unknown key {', '.join(unknown)}")
        return not missing and not unknown

    def stop(self) -> None:
        if self.lines:
            raise IsaError("\n".join(self.lines))


def load_isa(path: Path = ISA_FILE) -> Isa:
    """Instruction set of the file. Raises IsaError with every contradiction by name."""
    raw = tomllib.loads(path.read_text(encoding="utf-8"))
    findings = _Findings(path)
    sections = {
        *("operation_word", "bundle", "bank", "limits", "pipeline", "clock"),
        *("configuration", "unit", "op"),
    }
    findings.keys("file", raw, sections, set())
    findings.stop()
    width, fields = _read_word(raw["operation_word"], findings)
    findings.keys(
        "bundle", raw["bundle"], {"control_width", "halt_bit", "loop_bit", "loop_levels"}, set()
    )
    findings.keys("limits", raw["limits"], set(LIMIT_NAMES), set())
    findings.keys("clock", raw["clock"], {"clock_mhz"}, set())
    findings.keys("pipeline", raw["pipeline"], set(PIPELINE_NAMES), set())
    findings.stop()
    banks = _read_banks(raw["bank"], findings)
    units = _read_units(raw["unit"], findings)
    configurations = _read_configurations(
        raw["configuration"], units, raw["bundle"]["loop_levels"], findings
    )
    operations = _read_operations(raw["op"], fields, units, findings)
    findings.stop()
    isa = Isa(
        word_width=width,
        fields=fields,
        banks=banks,
        pipeline=Pipeline(**raw["pipeline"]),
        configurations=configurations,
        units=units,
        operations=operations,
        **raw["bundle"],
        **raw["limits"],
        **raw["clock"],
    )
    _check_sizes(isa, findings)
    findings.stop()
    return isa


@functools.cache
def default_isa() -> Isa:
    """Instruction set of the project's `isa.toml`."""
    return load_isa()


def _read_word(record: Mapping[str, Any], findings: _Findings) -> tuple[int, dict[str, BitField]]:
    if not findings.keys("operation_word", record, {"width", *WORD_FIELDS}, set()):
        findings.stop()
    width = record["width"]
    fields: dict[str, BitField] = {}
    owner: dict[int, str] = {}
    for name in WORD_FIELDS:
        high, low = record[name]
        if not width > high >= low >= 0:
            findings.add(
                f"operation_word.{name}", f"bits {high}..{low} do not fit a word of {width} bits"
            )
            continue
        fields[name] = BitField(name, low, high - low + 1)
        for bit in range(low, high + 1):
            if bit in owner:
                findings.add(f"operation_word.{name}", f"bit {bit} belongs to {owner[bit]} as well")
            owner[bit] = name
    for bit in range(width):
        if bit not in owner:
            findings.add("operation_word", f"bit {bit} belongs to no field")
    findings.stop()
    return width, fields


def _read_banks(records: list[Mapping[str, Any]], findings: _Findings) -> dict[str, Bank]:
    banks: dict[str, Bank] = {}
    codes: dict[int, str] = {}
    for record in records:
        where = f"bank {record.get('name', '?')}"
        if not findings.keys(where, record, {"name", "code", "size", "doc"}, set()):
            continue
        if not findings.known(where, "bank name", record["name"], BANK_NAMES):
            continue
        bank = Bank(**record)
        if bank.name in banks:
            findings.add(where, "declared twice")
        for code in range(bank.code, bank.code + -(-bank.size // 64)):
            if code in codes:
                findings.add(where, f"code {code} belongs to bank {codes[code]} as well")
            codes[code] = bank.name
        banks[bank.name] = bank
    for name in BANK_NAMES:
        if name not in banks:
            findings.add(f"bank {name}", "missing")
    return banks


def _read_configurations(
    records: Mapping[str, Any], units: Mapping[str, UnitRecord], levels: int, findings: _Findings
) -> dict[str, Configuration]:
    configurations: dict[str, Configuration] = {}
    for name, record in records.items():
        where = f"configuration.{name}"
        if not findings.keys(
            where,
            record,
            {"slots", "fma_pipes", "doc"},
            {"intervals", "latency_constants", "stream_words", "loops", "lanes"},
        ):
            continue
        found = Configuration(name, **record | {"slots": tuple(record["slots"])})
        for kind in found.slots:
            findings.known(where, "slot kind", kind, SLOT_KINDS)
        pipes = sum(kind in ("fma", "any") for kind in found.slots)
        if pipes != found.fma_pipes:
            findings.add(where, f"fma_pipes is {found.fma_pipes}, its slots use {pipes}")
        words = found.stream_words
        if not isinstance(words, int) or words & (words - 1) or not 0 <= words <= 1 << STREAM_BITS:
            findings.add(
                where,
                f"stream_words is {words!r}, must be 0 or a power of two to {1 << STREAM_BITS}",
            )
        if not isinstance(found.loops, int) or not 0 <= found.loops <= (levels if pipes > 1 else 0):
            findings.add(where, f"loops is {found.loops!r}, must be 0 to {levels}, with one slot 0")
        if found.lanes not in range(4) or (found.lanes and not found.stream_words):
            findings.add(where, f"lanes is {found.lanes!r}, must be 0 to 3, with stream_words")
        for unit, interval in found.intervals.items():
            findings.known(where, "unit of an interval", unit, units)
            if not isinstance(interval, int) or interval < 1:
                findings.add(where, f"interval {interval!r} of unit {unit} is not 1 or more cycles")
        for unit in found.latency_constants:
            findings.known(where, "unit of a latency constant", unit, units)
        configurations[name] = found
    return configurations


def _read_units(records: Mapping[str, Any], findings: _Findings) -> dict[str, UnitRecord]:
    units: dict[str, UnitRecord] = {}
    fields: dict[str, str] = {}
    for name, record in records.items():
        where = f"unit.{name}"
        optional = {"latency", "latency_constant"}
        if not findings.keys(where, record, {"interval", "bank", "control", "doc"}, optional):
            continue
        for field, width in record["control"].items():
            if field in fields:
                findings.add(where, f"control field '{field}' is one of unit {fields[field]} too")
            fields[field] = name
            if not isinstance(width, int) or width < 1:
                findings.add(where, f"control field '{field}' has the width {width!r}")
        if ("latency" in record) == ("latency_constant" in record):
            findings.add(where, "needs either latency or latency_constant")
        findings.known(where, "bank", record["bank"], UNIT_BANKS)
        units[name] = UnitRecord(name, **record)
    return units


def _read_operations(
    records: Mapping[str, Any],
    fields: Mapping[str, BitField],
    units: Mapping[str, UnitRecord],
    findings: _Findings,
) -> dict[str, OperationRecord]:
    operations: dict[str, OperationRecord] = {}
    opcodes: dict[int, str] = {}
    width = fields["op"].width
    for name, record in records.items():
        where = f"op.{name}"
        required = {"encoding", "unit", "operands", "doc"}
        optional = {"types", "flags", "control", "result", "invalid", "counts"}
        if not findings.keys(where, record, required, optional):
            continue
        if not re.fullmatch(f"[01]{{{width}}}", record["encoding"]):
            findings.add(where, f"encoding '{record['encoding']}' is not {width} binary digits")
            continue
        opcode = int(record["encoding"], 2)
        if opcode == 0:
            findings.add(where, "encoding 0 must stay illegal: it is what empty memory holds")
        if opcode in opcodes:
            findings.add(where, f"encoding {record['encoding']} is {opcodes[opcode]}'s as well")
        opcodes[opcode] = name
        flags = tuple(record.get("flags", "").split())
        for flag in flags:
            findings.known(where, "flag", flag, FLAG_NAMES)
        read = {key: value for key, value in record.items() if key != "encoding"}
        read |= {"operands": tuple(record["operands"]), "flags": flags}
        operation = OperationRecord(name, opcode, **read)
        for operand, type_name in operation.types.items():
            if findings.known(where, "typed operand", operand, operation.operands):
                findings.known(where, f"type of operand {operand}", type_name, TYPE_NAMES)
        _check_operands(where, operation, findings)
        if findings.known(where, "unit", operation.unit, units):
            bank = units[operation.unit].bank
            if operation.writes and bank == "none":
                findings.add(where, f"has a destination, but unit {operation.unit} writes no bank")
            _check_control(where, operation, units[operation.unit], operations, findings)
        _check_semantics(where, operation, findings)
        operations[name] = operation
    return operations


def _check_control(
    where: str,
    operation: OperationRecord,
    unit: UnitRecord,
    before: Mapping[str, OperationRecord],
    findings: _Findings,
) -> None:
    for field, value in operation.control.items():
        if not findings.known(where, "control field", field, unit.control):
            continue
        if not isinstance(value, str) and not 0 <= value < 1 << unit.control[field]:
            findings.add(where, f"{field} = {value} does not fit {unit.control[field]} bits")
    if not operation.control and operation.name != "nop":
        findings.add(where, "needs control: without a field the decoder takes it for illegal")
    for other in before.values():
        if other.unit == operation.unit and other.control == operation.control:
            findings.add(where, f"control is that of {other.name}")


def _check_semantics(where: str, operation: OperationRecord, findings: _Findings) -> None:
    computes = operation.writes and "address" not in operation.operands
    if computes and not operation.result:
        findings.add(where, "needs result: what dst is, see asip_asm/semantics.py")
    for key, text in (("result", operation.result), ("invalid", operation.invalid)):
        try:
            if text:
                check(text, operation.sources, truth=key == "invalid")
        except SemanticsError as error:
            findings.add(where, f"{key}: {error}")
    if operation.invalid and "NV" not in operation.flags:
        findings.add(where, "has `invalid`, but its flags have no NV")


def _check_operands(where: str, operation: OperationRecord, findings: _Findings) -> None:
    if not all(findings.known(where, "operand", o, OPERAND_KINDS) for o in operation.operands):
        return
    used = list(operation.sources) + (["dst"] if operation.writes else [])
    if operation.immediate_high:
        used += [operation.immediate_high, "c"]
    for name in sorted(set(used)):
        if used.count(name) > 1:
            findings.add(where, f"its operands use field {name} {used.count(name)} times")


def _check_sizes(isa: Isa, findings: _Findings) -> None:
    if not 0 <= isa.halt_bit < isa.control_width:
        findings.add("bundle.halt_bit", f"not below control_width = {isa.control_width}")
    marks = range(isa.loop_bit, isa.loop_bit + isa.loop_levels)
    if isa.halt_bit in marks or not 0 < marks.start < marks.stop <= isa.control_width:
        findings.add("bundle.loop_bit", "the marks of loops are no control bits of their own")
    if isa.loop_levels > 1 << IMMEDIATE_WIDTH - LOOP_BITS:
        findings.add("bundle.loop_levels", f"does not fit {IMMEDIATE_WIDTH - LOOP_BITS} bits")
    bits = isa.index_bits
    for name in SOURCE_FIELDS:
        if isa.fields[name].width != bits + 3:
            findings.add(f"operation_word.{name}", f"needs {bits + 3} bits: bank code and index")
    for bank in isa.banks.values():
        if bank.code + -(-bank.size // (1 << bits)) > 8:
            findings.add(f"bank {bank.name}", "does not fit the 3-bit bank code")
    codes = {name: bank.code for name, bank in isa.banks.items()}
    if codes["K"] != 4 or isa.banks["K"].size != 2 << bits:
        findings.add("bank K", f"needs code 4 and {2 << bits} words: the RTL tells it by bit 2")
    if codes["S"] != 6 or isa.banks["S"].size != 2:
        findings.add("bank S", "needs code 6 and 2 registers, one for each multiply-add pipe")
    for name in ("zero", "A", "B", "C"):
        if codes[name] & 1 != (name in ("A", "C")):
            findings.add(
                f"bank {name}", "the RTL tells A and C from zero and B by bit 0 of the code"
            )
    if isa.fields["dst"].width + isa.fields["c"].width != IMMEDIATE_WIDTH:
        findings.add("operation_word", f"dst and c do not hold {IMMEDIATE_WIDTH} immediate bits")
    if isa.outputs > 1 << bits:
        findings.add("limits.outputs", f"does not fit {bits} index bits")
    for name in ("program_bundles", "data_words"):
        if getattr(isa, name) > 1 << IMMEDIATE_WIDTH:
            findings.add(f"limits.{name}", f"does not fit {IMMEDIATE_WIDTH} immediate bits")
