# SPDX-License-Identifier: Apache-2.0
"""Programs for the bare Nios II core: instructions by name with labels, and a common start."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.n2_lockstep_rtl import EXCEPTION, ITCM

ISA = default_isa()
ET, BT, EA, BA, RA = (ISA.register[name] for name in ("et", "bt", "ea", "ba", "ra"))


@dataclass
class LabelledWords:
    """Words from the reset vector on; labels are resolved when the image is made."""

    words: list[int] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    fixups: list[tuple[int, str, str]] = field(default_factory=list)
    data: list[tuple[int, bytes]] = field(default_factory=list)

    def emit(self, name: str, *values: int, **flags: int) -> None:
        """One instruction, operands in the order of isa.toml."""
        self.words.append(ISA.instructions[name].encode(*values, **flags))

    def word(self, value: int) -> None:
        """A raw word."""
        self.words.append(value)

    def label(self, name: str) -> None:
        """The next instruction's address gets a name."""
        self.labels[name] = len(self.words)

    def to(self, name: str, label: str, *values: int) -> None:
        """Branch, call or jmpi to a label."""
        self.fixups.append((len(self.words), name, label))
        record = ISA.instructions[name]
        self.words.append(record.encode(*values, 0))

    def li(self, register: int, value: int) -> None:
        """32-bit constant, two words always."""
        self.emit("orhi", register, 0, value >> 16 & 0xFFFF)
        self.emit("ori", register, register, value & 0xFFFF)

    def la(self, register: int, label: str) -> None:
        """Address of a label, two words."""
        self.fixups.append((len(self.words), "la", label))
        self.emit("orhi", register, 0, 0)
        self.emit("ori", register, register, 0)

    def pad_to(self, address: int) -> None:
        """Fill with the zero word up to an address."""
        self.words += [0] * ((address - ITCM) // 4 - len(self.words))

    def address(self, label: str) -> int:
        """Byte address of a label."""
        return ITCM + 4 * self.labels[label]

    def image(self) -> list[tuple[int, bytes]]:
        """(byte address, contents) of the memories, labels resolved."""
        words = list(self.words)
        for at, name, label in self.fixups:
            target = self.labels[label]
            if name == "la":
                address = ITCM + 4 * target
                words[at] |= (address >> 16) << 6
                words[at + 1] |= (address & 0xFFFF) << 6
            elif "i26" in ISA.instructions[name].operands:
                words[at] |= ((ITCM >> 2 & 0x3FF_FFFF) + target) << 6
            else:
                words[at] |= (4 * (target - at - 1) & 0xFFFF) << 6
        return [(ITCM, struct.pack(f"<{len(words)}I", *words)), *self.data]

    def end(self, status: int = 0) -> None:
        """End the program for QEMU and the lockstep."""
        self.emit("addi", 4, 0, 0)
        self.emit("addi", 5, 0, status)
        self.label("end")
        self.emit("break", 1)
        self.to("br", "end")


def prologue() -> LabelledWords:
    """Reset vector and a handler that skips the excepting instruction, after `break` too.

    The handler leaves cause and address of the exception in r22 and r23. bt (r25) is set before a
    break. QEMU's status bit 23 is cleared by the first return from an exception.
    """
    program = LabelledWords()
    program.to("br", "start")
    program.pad_to(EXCEPTION)
    program.to("bne", "break", BT, 0)
    program.emit("rdctl", 22, ISA.control["exception"])
    program.emit("rdctl", 23, ISA.control["badaddr"])
    program.emit("eret")
    program.label("break")
    program.emit("addi", BT, 0, 0)
    program.emit("rdctl", 22, ISA.control["bstatus"])
    program.emit("bret")
    program.label("start")
    program.emit("trap", 0)
    program.emit("wrctl", ISA.control["estatus"], 0)
    return program
