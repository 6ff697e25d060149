# SPDX-License-Identifier: Apache-2.0
"""What a host register map says. Addresses are word addresses.

The maps themselves are written in SystemRDL (`regmap.rdl` next to the hardware); `make gen` makes
Python of them, the ASIP's being `asip_asm.gen.asip_regmap.REGMAP`. The texts of maps, registers and
fields are on the page of the map, and here only while that page is made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

REGISTER_BLOCK = "csr"
NUMBER = "value"  # the one field of a register that is a number
DATA_WIDTH = 32

Record = TypeVar("Record", "BitField", "Block", "Code", "RegisterRecord")


def by_name(*records: Record) -> dict[str, Record]:
    """The records by their names, in their order."""
    return {record.name: record for record in records}


@dataclass(frozen=True)
class BitField:
    """`width` bits of a word from bit `low` on."""

    name: str
    low: int
    width: int = 1
    doc: str = ""

    @property
    def high(self) -> int:
        """Highest bit of the field."""
        return self.low + self.width - 1

    @property
    def mask(self) -> int:
        """Ones at the field's bits in its word."""
        return ((1 << self.width) - 1) << self.low

    def of(self, value: int) -> int:
        """The field's value in a word."""
        return (value & self.mask) >> self.low


def bit_fields(**places: int | tuple[int, int]) -> dict[str, BitField]:
    """Fields by name, each from its bit or from its lowest bit and its width."""
    pairs = {n: place if isinstance(place, tuple) else (place, 1) for n, place in places.items()}
    return by_name(*(BitField(name, *place) for name, place in pairs.items()))


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


def number(width: int) -> dict[str, BitField]:
    """The one field of a register that is a number of so many bits."""
    return bit_fields(**{NUMBER: (0, width)})


@dataclass(frozen=True)
class Block:
    """Range of words that starts at `base`; `fields` of each word, where the map states them."""

    name: str
    base: int
    words: int
    access: str
    fields: Mapping[str, BitField] = field(default_factory=dict)
    doc: str = ""

    def word(self, **values: int) -> int:
        """A word of the block by its fields; see `compose`."""
        return compose(self.fields, values)


@dataclass(frozen=True)
class RegisterRecord:
    """Control or status register: word offset in block csr, reset value (None: not stated).

    `count` above 1: so many registers, one word after the other. Without fields of its own it is
    a number.
    """

    name: str
    offset: int
    access: str
    reset: int | None = None
    fields: Mapping[str, BitField] = field(default_factory=lambda: number(DATA_WIDTH))
    count: int = 1
    doc: str = ""

    def word(self, **values: int) -> int:
        """Value of the register by its fields; see `compose`."""
        return compose(self.fields, values)


@dataclass(frozen=True)
class Code:
    """Value of a field that is an enumeration."""

    name: str
    code: int
    doc: str


@dataclass(frozen=True, kw_only=True)
class RegisterMap:
    """The whole register map; `title` is what it belongs to, `note` what to know of accesses.

    faults: causes of a fault as STATUS.cause shows them. enumerations: the other codes by the
    names of enumeration and value.
    """

    address_width: int
    blocks: Mapping[str, Block]
    registers: Mapping[str, RegisterRecord]
    faults: Mapping[str, Code] = field(default_factory=dict)
    enumerations: Mapping[str, Mapping[str, Code]] = field(default_factory=dict)
    title: str = ""
    note: str = ""

    def address(self, register: str) -> int:
        """Word address of a register of block csr, of the first where there are more."""
        return self.blocks[REGISTER_BLOCK].base + self.registers[register].offset
