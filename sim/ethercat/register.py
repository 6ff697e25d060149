# SPDX-License-Identifier: Apache-2.0
"""What the register map of the slave controller says of a register. Addresses are of bytes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from asip_asm.regmap import BitField, compose


@dataclass(frozen=True)
class ByteRegister:
    """Register of `width` bytes at `address`; `count` of them, `stride` bytes apart.

    master, application: whether that side may write it. reset: None where hardware decides.
    """

    name: str
    address: int
    width: int
    reset: int | None
    master: bool
    application: bool
    fields: Mapping[str, BitField]
    doc: str
    count: int = 1
    stride: int = 0

    def at(self, index: int) -> int:
        """Byte address of the register's place `index`. Raises IndexError."""
        if not 0 <= index < self.count:
            raise IndexError(f"{self.name} has {self.count} places, not {index}")
        return self.address + index * self.stride

    def word(self, **values: int) -> int:
        """Value of the register by its fields; see `compose`."""
        return compose(self.fields, values)
