# SPDX-License-Identifier: Apache-2.0
"""Memory map of the Nios II systems, `nios_sw/system.toml`, validated, with their I/O registers.

The registers are those of rtl/nios/io_regmap.rdl. Addresses are byte addresses. A contradiction
raises SystemMapError, one line per finding.
"""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from asip_asm.interface import program_interface
from asip_asm.project import ROOT
from asip_asm.signals import Interface, InterfaceError
from sim.rtl.gen.n2_io_regmap import REGMAP

SYSTEM_TOML = ROOT / "nios_sw/system.toml"
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
class SystemMap:
    """The whole map."""

    clock_mhz: int
    reset_vector: int
    exception_vector: int
    memories: Mapping[str, Memory]
    io: IoRegion
    interface: Interface

    @property
    def inputs(self) -> tuple[str, ...]:
        """Words of the block inputs."""
        return tuple(signal.name for signal in self.interface.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Words of the block outputs."""
        return tuple(signal.name for signal in self.interface.outputs)

    @property
    def io_word_width(self) -> int:
        """Bits of a word address in the I/O region."""
        return (self.io.bytes // 4 - 1).bit_length()

    def address(self, register: str) -> int:
        """Byte address of a register."""
        return self.io.base + 4 * REGMAP.address(register)

    def base(self, block: str) -> int:
        """Byte address of a block's first word."""
        return self.io.base + 4 * REGMAP.blocks[block].base


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
    if system.io_word_width < REGMAP.address_width:
        found.append(
            f"io: {4 << REGMAP.address_width} bytes hold the registers, not {system.io.bytes}"
        )
    for name, words in (("inputs", system.inputs), ("outputs", system.outputs)):
        if len(words) > REGMAP.blocks[name].words:
            found.append(f"tick.interface: more {name} than the block has words")
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
