# SPDX-License-Identifier: Apache-2.0
"""What the register map of the slave controller says of a register. Addresses are of bytes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from asip_asm.regmap import BitField, compose, number


@dataclass(frozen=True)
class ByteRegister:
    """Register of `width` bytes at `address`; `count` of them, `stride` bytes apart.

    master, application: whether that side may write it. reset: None where hardware decides.
    Without fields of its own it is a number of all its bits.
    """

    name: str
    address: int
    width: int
    reset: int | None = 0
    master: bool = False
    application: bool = False
    fields: Mapping[str, BitField] = field(default_factory=dict)
    count: int = 1
    stride: int = 0
    doc: str = ""

    def __post_init__(self) -> None:
        if not self.fields:
            object.__setattr__(self, "fields", number(8 * self.width))

    def at(self, index: int) -> int:
        """Byte address of the register's place `index`. Raises IndexError."""
        if not 0 <= index < self.count:
            raise IndexError(f"{self.name} has {self.count} places, not {index}")
        return self.address + index * self.stride

    def word(self, **values: int) -> int:
        """Value of the register by its fields; see `compose`."""
        return compose(self.fields, values)
