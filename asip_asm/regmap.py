# SPDX-License-Identifier: Apache-2.0
"""What a host register map says. Addresses are word addresses.

The maps themselves are written in SystemRDL (`regmap.rdl` beside the hardware); `make gen` makes
Python of them, the ASIP's being `asip_asm.gen.asip_regmap.REGMAP`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

REGISTER_BLOCK = "csr"

Record = TypeVar("Record")


def named(record: Callable[..., Record], /, **values: tuple[object, ...]) -> dict[str, Record]:
    """Records by their names, each with its name as its first value."""
    return {name: record(name, *rest) for name, rest in values.items()}


@dataclass(frozen=True)
class BitField:
    """Bits high..low of a word."""

    name: str
    high: int
    low: int
    doc: str = ""

    @property
    def width(self) -> int:
        """Bits of the field."""
        return self.high - self.low + 1

    @property
    def mask(self) -> int:
        """Ones where the field stands in its word."""
        return ((1 << self.width) - 1) << self.low

    def of(self, value: int) -> int:
        """The field's value in a word."""
        return (value & self.mask) >> self.low


def compose(fields: Mapping[str, BitField], values: Mapping[str, int]) -> int:
    """Word with these values in its fields, 0 elsewhere.

    Raises KeyError for a field that the word does not have, ValueError for a value too wide for it.
    """
    word = 0
    for name, value in values.items():
        place = fields[name]
        if not 0 <= value < 1 << place.width:
            raise ValueError(f"{name}: {value} does not fit {place.width} bits")
        word |= int(value) << place.low
    return word


@dataclass(frozen=True)
class Block:
    """Range of words that starts at `base`; `fields` of each word, where the map states them."""

    name: str
    base: int
    words: int
    access: str
    doc: str
    fields: Mapping[str, BitField] = field(default_factory=dict)

    def word(self, **values: int) -> int:
        """A word of the block by its fields; see `compose`."""
        return compose(self.fields, values)


@dataclass(frozen=True)
class RegisterRecord:
    """Control or status register: word offset in block csr, reset value (None: not stated).

    `count` above 1: so many registers, one word after the other.
    """

    name: str
    offset: int
    access: str
    reset: int | None
    fields: Mapping[str, BitField]
    doc: str
    count: int = 1

    def word(self, **values: int) -> int:
        """Value of the register by its fields; see `compose`."""
        return compose(self.fields, values)


@dataclass(frozen=True)
class Fault:
    """Cause of a fault as STATUS.cause shows it."""

    name: str
    code: int
    doc: str


@dataclass(frozen=True)
class Code:
    """Value of a field that is an enumeration."""

    name: str
    code: int
    doc: str


@dataclass(frozen=True)
class RegisterMap:
    """The whole register map; `title` is what it belongs to, `note` what to know of accesses.

    enumerations: codes by the names of enumeration and value, but for the fault causes.
    """

    title: str
    note: str
    address_width: int
    data_width: int
    blocks: Mapping[str, Block]
    registers: Mapping[str, RegisterRecord]
    faults: Mapping[str, Fault]
    enumerations: Mapping[str, Mapping[str, Code]] = field(default_factory=dict)

    def address(self, register: str) -> int:
        """Word address of a register of block csr, of the first where there are more."""
        return self.blocks[REGISTER_BLOCK].base + self.registers[register].offset
