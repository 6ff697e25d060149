# SPDX-License-Identifier: Apache-2.0
"""ELF files of a few instructions, for tests without a cross compiler."""

from __future__ import annotations

import struct
from pathlib import Path

from sim.rtl.n2_lockstep_program import LabelledWords
from sim.rtl.nios_map import default_system_map

HEADER, PROGRAM_HEADER = 52, 32
EM_ALTERA_NIOS2 = 113


def elf_bytes(program: LabelledWords, **fields: int) -> bytes:
    """An executable with one segment of code; `fields` replace what `value` holds."""
    [(address, code), *_] = program.image()
    value = {"type": 2, "machine": EM_ALTERA_NIOS2, "entry": address, "memory_size": len(code)}
    value |= fields
    identity = b"\x7fELF\x01\x01\x01".ljust(16, b"\0")
    header = struct.pack(
        "<16sHHIIIIIHHHHHH",
        *(identity, value["type"], value["machine"], 1, value["entry"], HEADER, 0, 0),
        *(HEADER, PROGRAM_HEADER, 1, 40, 0, 0),
    )
    start = HEADER + PROGRAM_HEADER
    segment = struct.pack("<8I", 1, start, address, address, len(code), value["memory_size"], 5, 4)
    return header + segment + code


def printing(text: str, status: int | None, program: LabelledWords | None = None) -> LabelledWords:
    """Writes a text to the console and ends with a status; None: writes it again and again.

    These instructions follow those of `program`.
    """
    system = default_system_map()
    program = program or LabelledWords()
    program.label("again")
    program.li(16, system.address("CONSOLE"))
    for character in text.encode():
        program.emit("addi", 2, 0, character)
        program.emit("stwio", 2, 0, 16)
    if status is not None:
        program.li(16, system.address("EXIT"))
        program.li(2, status)
        program.emit("stwio", 2, 0, 16)
    program.to("br", "again")
    return program


def write(path: Path, program: LabelledWords, **fields: int) -> Path:
    """Write the file; returns its path."""
    path.write_bytes(elf_bytes(program, **fields))
    return path
