# SPDX-License-Identifier: Apache-2.0
"""Host register maps, validated; the ASIP's is `regmap.toml`. Addresses are word addresses."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

REGMAP_FILE = Path(__file__).with_name("regmap.toml")
ACCESS_KINDS = ("r", "w", "rw")
REGISTER_BLOCK = "csr"


class RegisterMapError(ValueError):
    """The register map contradicts itself; one line per finding, each naming its record."""


@dataclass(frozen=True)
class Block:
    """Range of words that starts at `base`."""

    name: str
    base: int
    words: int
    access: str
    doc: str


@dataclass(frozen=True)
class BitField:
    """Bits high..low of a register."""

    name: str
    high: int
    low: int

    @property
    def width(self) -> int:
        return self.high - self.low + 1

    def of(self, value: int) -> int:
        """The field's value in a register value."""
        return (value >> self.low) & ((1 << self.width) - 1)


@dataclass(frozen=True)
class RegisterRecord:
    """Control or status register: word offset in block csr, reset value (None: not stated)."""

    name: str
    offset: int
    access: str
    reset: int | None
    fields: Mapping[str, BitField]
    doc: str


@dataclass(frozen=True)
class Fault:
    """Cause of a fault as STATUS.cause shows it."""

    name: str
    code: int
    doc: str


@dataclass(frozen=True)
class RegisterMap:
    """The whole register map; `title` is what it belongs to, `note` what to know of accesses."""

    title: str
    note: str
    address_width: int
    data_width: int
    blocks: Mapping[str, Block]
    registers: Mapping[str, RegisterRecord]
    faults: Mapping[str, Fault]

    def address(self, register: str) -> int:
        """Word address of a register of block csr."""
        return self.blocks[REGISTER_BLOCK].base + self.registers[register].offset


def load_register_map(path: Path = REGMAP_FILE) -> RegisterMap:
    """Register map of the file. Raises RegisterMapError with every contradiction by name."""
    raw = tomllib.loads(path.read_text(encoding="utf-8"))
    findings: list[str] = []
    data_width = raw["data_width"]
    blocks = {name: _block(name, record, findings) for name, record in raw["block"].items()}
    registers = {
        name: _register(name, record, data_width, findings)
        for name, record in raw["register"].items()
    }
    codes, texts = raw.get("fault", {}), raw.get("fault_doc", {})
    if set(codes) != set(texts):
        odd = ", ".join(sorted(set(codes) ^ set(texts)))
        findings.append(f"fault: {odd} stands in only one of [fault] and [fault_doc]")
    faults = {name: Fault(name, code, texts.get(name, "")) for name, code in codes.items()}
    result = RegisterMap(
        raw["title"],
        raw["note"].strip(),
        raw["address_width"],
        data_width,
        blocks,
        registers,
        faults,
    )
    _check(result, findings)
    if findings:
        raise RegisterMapError("\n".join(f"{path.name}: {finding}" for finding in findings))
    return result


@functools.cache
def default_register_map() -> RegisterMap:
    """Register map of the project's `regmap.toml`."""
    return load_register_map()


def _access(where: str, record: Mapping[str, Any], findings: list[str]) -> str:
    access = record.get("access", "rw")
    if access not in ACCESS_KINDS:
        findings.append(f"{where}: unknown access '{access}'; known are {', '.join(ACCESS_KINDS)}")
    return access


def _block(name: str, record: Mapping[str, Any], findings: list[str]) -> Block:
    access = _access(f"block.{name}", record, findings)
    return Block(name, record["base"], record["words"], access, record["doc"])


def _register(
    name: str, record: Mapping[str, Any], data_width: int, findings: list[str]
) -> RegisterRecord:
    where = f"register.{name}"
    fields: dict[str, BitField] = {}
    owner: dict[int, str] = {}
    for field, (high, low) in record.get("fields", {}).items():
        if not data_width > high >= low >= 0:
            findings.append(f"{where}.{field}: bits {high}..{low} do not fit {data_width} bits")
        fields[field] = BitField(field, high, low)
        for bit in range(low, high + 1):
            if bit in owner:
                findings.append(f"{where}.{field}: bit {bit} belongs to {owner[bit]} as well")
            owner[bit] = field
    reset = record.get("reset")
    if reset is not None and not 0 <= reset < 1 << data_width:
        findings.append(f"{where}: reset {reset} does not fit {data_width} bits")
    return RegisterRecord(
        name, record["offset"], _access(where, record, findings), reset, fields, record["doc"]
    )


def _check(regmap: RegisterMap, findings: list[str]) -> None:
    for block in regmap.blocks.values():
        where = f"block.{block.name}"
        if block.words & (block.words - 1):
            findings.append(f"{where}: {block.words} words are not a power of two")
        elif block.base % block.words:
            findings.append(f"{where}: base {block.base:#06x} is not a multiple of its words")
        if block.base + block.words > 1 << regmap.address_width:
            findings.append(f"{where}: ends beyond {regmap.address_width} address bits")
        for other in regmap.blocks.values():
            if other.base < block.base < other.base + other.words:
                findings.append(f"{where}: overlaps block.{other.name}")
            elif other is not block and other.base == block.base and other.name < block.name:
                findings.append(f"{where}: overlaps block.{other.name}")
    offsets: dict[int, str] = {}
    if REGISTER_BLOCK not in regmap.blocks:
        findings.append(f"block.{REGISTER_BLOCK}: missing; the registers stand in it")
    else:
        for register in regmap.registers.values():
            if not 0 <= register.offset < regmap.blocks[REGISTER_BLOCK].words:
                findings.append(f"register.{register.name}: offset outside block {REGISTER_BLOCK}")
    for register in regmap.registers.values():
        if register.offset in offsets:
            findings.append(
                f"register.{register.name}: offset {register.offset} is "
                f"{offsets[register.offset]}'s as well"
            )
        offsets[register.offset] = register.name
    codes: dict[int, str] = {}
    for fault in regmap.faults.values():
        if fault.code in codes:
            findings.append(f"fault.{fault.name}: code is {codes[fault.code]}'s as well")
        codes[fault.code] = fault.name
