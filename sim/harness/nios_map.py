# SPDX-License-Identifier: Apache-2.0
"""Memory map and I/O registers of the Nios II systems, `nios_sw/system.toml`, validated.

Addresses are byte addresses. A contradiction raises SystemMapError, one line per finding.
"""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asip_asm.interface import program_interface
from asip_asm.project import ROOT
from asip_asm.regmap import BitField
from asip_asm.signals import Interface, InterfaceError

SYSTEM_TOML = ROOT / "nios_sw/system.toml"
ACCESS_KINDS = ("r", "w", "rw")
VECTOR_BYTES = 32  # room of the reset code before the exception vector


class SystemMapError(ValueError):
    """The map contradicts itself; one line per finding, each naming its record."""


@dataclass(frozen=True)
class Memory:
    """Tightly coupled memory: first byte, size in 32-bit words."""

    name: str
    base: int
    words: int
    doc: str


@dataclass(frozen=True)
class IoRegion:
    """Range of the I/O agent in bytes."""

    base: int
    bytes: int
    doc: str


@dataclass(frozen=True)
class IoBlock:
    """Words of the I/O region that start at `offset` bytes."""

    name: str
    offset: int
    words: int
    doc: str
    access: str = "rw"


@dataclass(frozen=True)
class IoRegister:
    """Word `offset` of a block; reset None: not stated."""

    name: str
    block: str
    offset: int
    access: str
    doc: str
    reset: int | None = None
    fields: Mapping[str, BitField] | None = None


@dataclass(frozen=True)
class SystemMap:
    """The whole map."""

    clock_mhz: int
    reset_vector: int
    exception_vector: int
    memories: Mapping[str, Memory]
    io: IoRegion
    blocks: Mapping[str, IoBlock]
    registers: Mapping[str, IoRegister]
    interface: Interface

    @property
    def inputs(self) -> tuple[str, ...]:
        """Words of the block input."""
        return tuple(signal.name for signal in self.interface.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Words of the block output."""
        return tuple(signal.name for signal in self.interface.outputs)

    @property
    def io_word_width(self) -> int:
        """Bits of a word address in the I/O region."""
        return (self.io.bytes // 4 - 1).bit_length()

    def offset(self, register: str) -> int:
        """Byte offset of a register in the I/O region."""
        record = self.registers[register]
        return self.blocks[record.block].offset + 4 * record.offset

    def address(self, register: str) -> int:
        """Byte address of a register."""
        return self.io.base + self.offset(register)


def _register(name: str, table: dict[str, Any]) -> IoRegister:
    fields = {
        field: BitField(field, high, low) for field, (high, low) in table.pop("fields", {}).items()
    }
    return IoRegister(name=name, fields=fields, **table)


def _findings(system: SystemMap) -> list[str]:
    found = []
    regions = [(m.name, m.base, m.base + 4 * m.words) for m in system.memories.values()]
    regions.append(("io", system.io.base, system.io.base + system.io.bytes))
    for i, (name, first, end) in enumerate(regions):
        for other, other_first, other_end in regions[i + 1 :]:
            if first < other_end and other_first < end:
                found.append(f"{name} and {other} overlap")
        if (end - first) & (end - first - 1) or first % (end - first):
            found.append(f"{name}: size must be a power of two and divide the base")
    code = system.memories["itcm"]
    if system.reset_vector != code.base:
        found.append("reset_vector: must be the base of itcm, where start-up code is linked")
    if system.exception_vector != code.base + VECTOR_BYTES:
        found.append(f"exception_vector: must be {VECTOR_BYTES} bytes above reset_vector")
    used: dict[int, str] = {}
    for block in system.blocks.values():
        where = f"block.{block.name}"
        if block.access not in ACCESS_KINDS:
            found.append(
                f"block.{block.name}: access '{block.access}' is not one of {ACCESS_KINDS}"
            )
        if block.words & (block.words - 1) or block.offset % (4 * block.words):
            found.append(
                f"block.{block.name}: words must be a power of two that divides the offset"
            )
        for word in range(block.offset // 4, block.offset // 4 + block.words):
            if word in used:
                found.append(f"{where}: overlaps block.{used[word]}")
                break
            used[word] = block.name
        if block.offset + 4 * block.words > system.io.bytes:
            found.append(f"{where}: ends behind the I/O region")
    taken: dict[tuple[str, int], str] = {}
    for register in system.registers.values():
        where = f"register.{register.name}"
        block = system.blocks.get(register.block)
        if block is None:
            found.append(f"{where}: no block '{register.block}'")
            continue
        if not 0 <= register.offset < block.words:
            found.append(f"{where}: offset {register.offset} is not in block.{block.name}")
        if register.access not in ACCESS_KINDS:
            found.append(f"{where}: access '{register.access}' is not one of {ACCESS_KINDS}")
        other = taken.setdefault((register.block, register.offset), register.name)
        if other != register.name:
            found.append(f"{where}: same word as register.{other}")
    for name, words in (("input", system.inputs), ("output", system.outputs)):
        if len(words) > system.blocks[name].words:
            found.append(f"tick.interface: more {name}s than block.{name} has words")
    return found


def load_system_map(path: Path = SYSTEM_TOML) -> SystemMap:
    """Read and check the map. Raises SystemMapError, also for missing or unknown keys."""
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    try:
        system = SystemMap(
            clock_mhz=tables["clock_mhz"],
            reset_vector=tables["reset_vector"],
            exception_vector=tables["exception_vector"],
            memories={n: Memory(name=n, **t) for n, t in tables["memory"].items()},
            io=IoRegion(**tables["io"]),
            blocks={n: IoBlock(name=n, **t) for n, t in tables["block"].items()},
            registers={n: _register(n, t) for n, t in tables["register"].items()},
            interface=program_interface(tables["tick"]["interface"]),
        )
    except KeyError as error:
        raise SystemMapError(f"{path.name}: error: {error.args[0]} is missing") from error
    except (TypeError, InterfaceError, OSError) as error:
        raise SystemMapError(f"{path.name}: error: {error}") from error
    found = _findings(system)
    if found:
        raise SystemMapError("\n".join(f"{path.name}: error: {line}" for line in found))
    return system


@functools.cache
def default_system_map() -> SystemMap:
    """The map of the repository."""
    return load_system_map()
