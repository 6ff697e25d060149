# SPDX-License-Identifier: Apache-2.0
"""Programs of the Nios II systems: ELF files and the committed images made of them.

An image NAME is NAME.itcm.hex and NAME.dtcm.hex ($readmemh, one 32-bit word per line, trailing zero
words left out) and NAME.lst, symbols and disassembly by objdump. Addresses are byte addresses.
"""

from __future__ import annotations

import argparse
import re
import struct
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sim.harness.nios_map import SystemMap, default_system_map

IMAGES = Path(__file__).resolve().parents[2] / "nios_sw/images"
EM_ALTERA_NIOS2 = 113
PT_LOAD = 1
SHT_SYMTAB = 2
STT_FUNC = 2


class ImageError(ValueError):
    """A file is no program of these systems; the message names the file and the cause."""


@dataclass(frozen=True)
class Symbol:
    """Name with address and size in bytes; functions are marked."""

    name: str
    address: int
    size: int
    is_function: bool


@dataclass(frozen=True)
class Program:
    """Words of each memory from its base (name -> words), entry address, symbols by name."""

    name: str
    memories: Mapping[str, tuple[int, ...]]
    entry: int
    symbols: Mapping[str, Symbol]

    def address(self, symbol: str) -> int:
        """Address of a symbol. Raises ImageError naming it."""
        if symbol not in self.symbols:
            raise ImageError(f"{self.name}: error: no symbol '{symbol}' in the program")
        return self.symbols[symbol].address

    def functions(self) -> list[Symbol]:
        """Functions in ascending order of address."""
        found = [symbol for symbol in self.symbols.values() if symbol.is_function]
        return sorted(found, key=lambda symbol: symbol.address)


def read_elf(path: Path, system: SystemMap | None = None) -> Program:
    """Program in an ELF file for Nios II. Raises ImageError."""
    system = system or default_system_map()
    data = path.read_bytes()
    if data[:6] != b"\x7fELF\x01\x01":
        raise ImageError(f"{path}: error: no little-endian 32-bit ELF file")
    (machine,) = struct.unpack_from("<H", data, 18)
    if machine != EM_ALTERA_NIOS2:
        raise ImageError(
            f"{path}: error: for machine {machine}, must be Nios II ({EM_ALTERA_NIOS2})"
        )
    entry, program_headers, section_headers = struct.unpack_from("<III", data, 24)
    ph_size, ph_count, sh_size, sh_count = struct.unpack_from("<HHHH", data, 42)
    contents = {memory.name: bytearray(4 * memory.words) for memory in system.memories.values()}
    for i in range(ph_count):
        kind, offset, _, address, size = struct.unpack_from(
            "<5I", data, program_headers + i * ph_size
        )
        if kind != PT_LOAD or size == 0:
            continue
        for memory in system.memories.values():
            start = address - memory.base
            if 0 <= start and start + size <= 4 * memory.words:
                contents[memory.name][start : start + size] = data[offset : offset + size]
                break
        else:
            raise ImageError(
                f"{path}: error: {size} bytes at 0x{address:08x} are in no memory; "
                "link with nios_sw/link/tcm.ld"
            )
    symbols = {}
    for i in range(sh_count):
        _, kind, _, _, offset, size, link, _, _, entry_size = struct.unpack_from(
            "<10I", data, section_headers + i * sh_size
        )
        if kind != SHT_SYMTAB:
            continue
        (names,) = struct.unpack_from("<I", data, section_headers + link * sh_size + 16)
        for at in range(offset, offset + size, entry_size):
            name_at, value, length, info = struct.unpack_from("<IIIB", data, at)
            end = data.index(b"\0", names + name_at)
            name = data[names + name_at : end].decode("ascii")
            if name:
                symbols[name] = Symbol(name, value, length, info & 15 == STT_FUNC)
    memories = {name: _words(content) for name, content in contents.items()}
    return Program(path.stem, memories, entry, symbols)


def _words(content: bytes | bytearray) -> tuple[int, ...]:
    words = list(struct.unpack(f"<{len(content) // 4}I", content))
    while words and words[-1] == 0:
        words.pop()
    return tuple(words)


def save(program: Program, folder: Path, listing: str) -> list[Path]:
    """Write the image below `folder`; returns its files."""
    written = []
    for name, words in program.memories.items():
        path = folder / f"{program.name}.{name}.hex"
        path.write_text("".join(f"{word:08x}\n" for word in words), encoding="ascii")
        written.append(path)
    path = folder / f"{program.name}.lst"
    path.write_text(listing, encoding="utf-8")
    return [*written, path]


SYMBOL_LINE = re.compile(r"([0-9a-f]{8}) .{6}(.) \S+\t([0-9a-f]{8}) (?:(?:0x\w\w|\.hidden) )?(\S+)")


def load(name: str, folder: Path = IMAGES, system: SystemMap | None = None) -> Program:
    """Committed image by its name. Raises ImageError."""
    system = system or default_system_map()
    memories = {}
    for memory in system.memories.values():
        path = folder / f"{name}.{memory.name}.hex"
        if not path.is_file():
            raise ImageError(
                f"{path}: error: no such image; `make nios-sw` builds them from nios_sw/"
            )
        try:
            words = tuple(int(line, 16) for line in path.read_text(encoding="ascii").split())
        except ValueError as error:
            raise ImageError(f"{path}: error: {error}") from error
        if len(words) > memory.words:
            raise ImageError(f"{path}: error: {len(words)} words, memory has {memory.words}")
        memories[memory.name] = words
    symbols = {}
    for line in (folder / f"{name}.lst").read_text(encoding="utf-8").splitlines():
        match = SYMBOL_LINE.fullmatch(line)
        if match:
            address, kind, size, symbol = match.groups()
            symbols[symbol] = Symbol(symbol, int(address, 16), int(size, 16), kind == "F")
    return Program(name, memories, system.reset_vector, symbols)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m sim.harness.nios_image",
        description="Images of Nios II programs from ELF files.",
        epilog="example: python -m sim.harness.nios_image --objdump nios2-elf-objdump "
        "--output build/images build/nios_sw/tracking_fpga2.elf",
    )
    parser.add_argument("elf", type=Path, nargs="+")
    parser.add_argument("--objdump", default="nios2-elf-objdump", help="program for the listing")
    parser.add_argument("--output", type=Path, default=IMAGES, help="folder of the images")
    options = parser.parse_args(arguments)
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        for elf in options.elf:
            program = read_elf(elf)
            command = [options.objdump, "--syms", "--disassemble", elf.name]
            done = subprocess.run(
                command, cwd=elf.parent, capture_output=True, text=True, check=True
            )
            save(program, options.output, done.stdout)
            sizes = ", ".join(f"{4 * len(w)} bytes in {m}" for m, w in program.memories.items())
            print(f"{program.name}: {sizes}")
    except (ImageError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"error: {options.objdump} failed: {error.stderr}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
