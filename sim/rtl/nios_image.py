# SPDX-License-Identifier: Apache-2.0
"""Programs of the Nios II systems, one ELF file each; memories for $readmemh and listings of them.

Addresses are byte addresses.
"""

from __future__ import annotations

import bisect
import io
import struct
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.nios_map import SystemMap, default_system_map

IMAGES = ROOT / "nios_sw/images"
MACHINE = "EM_ALTERA_NIOS2"
LARGEST_FILE = 8 << 20  # bytes, with symbols and debug information
LONGEST_NAME = 4096  # characters of a symbol
SYMBOL_BYTES = 16  # of an entry of the symbol table


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

    def function_at(self, address: int) -> str:
        """Name of the function that holds the instruction at a byte address."""
        functions = self.functions()
        place = bisect.bisect([function.address for function in functions], address) - 1
        return functions[place].name if place >= 0 else "(start-up)"


def read_elf(path: Path, system: SystemMap | None = None) -> Program:
    """Program in an ELF file for Nios II, linked for the system's memories.

    Raises ImageError, OSError.
    """
    system = system or default_system_map()
    if not path.is_file():
        cause = "no file with a program" if path.exists() else "no such file"
        raise ImageError(f"{path}: error: {cause}")
    data = path.read_bytes() if path.stat().st_size <= LARGEST_FILE else None
    if data is None:
        raise ImageError(f"{path}: error: larger than {LARGEST_FILE >> 20} MiB, no program here")
    if data[:6] != b"\x7fELF\x01\x01":
        raise ImageError(f"{path}: error: no little-endian 32-bit ELF file")
    try:
        return _program(path, ELFFile(io.BytesIO(data)), system)
    except ImageError:
        raise
    except Exception as error:  # a damaged file fails anywhere in the library, in any way
        cause = str(error) or type(error).__name__
        raise ImageError(f"{path}: error: damaged ELF file: {cause}") from error


def _program(path: Path, elf: ELFFile, system: SystemMap) -> Program:
    machine, kind = elf["e_machine"], elf["e_type"]
    if machine != MACHINE:
        raise ImageError(f"{path}: error: for machine {machine}, must be Nios II ({MACHINE})")
    if kind != "ET_EXEC":
        raise ImageError(f"{path}: error: {kind} is no linked program (ET_EXEC)")
    contents = {memory.name: bytearray(4 * memory.words) for memory in system.memories.values()}
    for segment in elf.iter_segments("PT_LOAD"):
        address, size = segment["p_paddr"], segment["p_memsz"]
        if size == 0:
            continue
        for memory in system.memories.values():
            start = address - memory.base
            if 0 <= start and start + size <= 4 * memory.words:
                held = segment.data() if segment["p_filesz"] <= size else b""
                if len(held) != segment["p_filesz"]:
                    raise ImageError(f"{path}: error: the segment at 0x{address:08x} is cut off")
                contents[memory.name][start : start + len(held)] = held
                break
        else:
            raise ImageError(
                f"{path}: error: {size} bytes at 0x{address:08x} are in no memory; "
                "link with nios_sw/link/tcm.ld"
            )
    entry = elf["e_entry"]
    if entry != system.reset_vector:
        raise ImageError(
            f"{path}: error: starts at 0x{entry:08x}, must be the reset vector "
            f"0x{system.reset_vector:08x}; link with nios_sw/lib/crt0.S"
        )
    symbols = {}
    table = elf.get_section_by_name(".symtab")
    if isinstance(table, SymbolTableSection):
        if table["sh_entsize"] != SYMBOL_BYTES:
            raise ImageError(f"{path}: error: damaged symbol table")
        for symbol in table.iter_symbols():
            if len(symbol.name) > LONGEST_NAME:
                raise ImageError(f"{path}: error: damaged symbol table")
            if symbol.name:
                symbols[symbol.name] = Symbol(
                    symbol.name,
                    symbol["st_value"],
                    symbol["st_size"],
                    symbol["st_info"]["type"] == "STT_FUNC",
                )
    memories = {name: _words(content) for name, content in contents.items()}
    return Program(path.stem, memories, entry, symbols)


def _words(content: bytes | bytearray) -> tuple[int, ...]:
    words = list(struct.unpack(f"<{len(content) // 4}I", content))
    while words and words[-1] == 0:
        words.pop()
    return tuple(words)


def load(name: str, folder: Path = IMAGES) -> Program:
    """Committed program by its name. Raises ImageError."""
    path = folder / f"{name}.elf"
    if not path.is_file():
        known = ", ".join(sorted(file.stem for file in folder.glob("*.elf"))) or "none"
        raise ImageError(
            f"{path}: error: no such program; `microtick nios-sw` builds them; got {known}"
        )
    return read_elf(path)


def listing(program: Program) -> str:
    """Functions with address, word and text of every instruction, then the symbols."""
    base = default_system_map().memories["itcm"].base
    starts = {symbol.address: symbol.name for symbol in program.functions()}
    isa, lines = default_isa(), []
    for address, word in enumerate(program.memories["itcm"]):
        at = base + 4 * address
        if at in starts:
            lines += ["", f"{at:08x} <{starts[at]}>:"]
        lines.append(f"{at:8x}:\t{word:08x}\t{isa.disassemble(word)}")
    symbols = sorted(program.symbols.values(), key=lambda symbol: (symbol.address, symbol.name))
    return "\n".join(
        [*lines, "", "symbols", *(f"{s.address:08x} {s.size:6d} {s.name}" for s in symbols), ""]
    )


def save(program: Program, folder: Path) -> list[Path]:
    """Write NAME.MEMORY.hex of each memory and NAME.lst below `folder`; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {folder / f"{program.name}.lst": listing(program)}
    for memory, words in program.memories.items():
        text = "".join(f"{word:08x}\n" for word in words)  # trailing zero words are left out
        texts[folder / f"{program.name}.{memory}.hex"] = text
    for path, text in texts.items():
        write_text(path, text)
    return list(texts)


@command("python -m sim.rtl.nios_image")
def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    prog = "python -m sim.rtl.nios_image"
    purpose = "Write memories for $readmemh and a listing of a program of the Nios II systems."
    parser = script_parser(purpose, f"{prog} tracking_fpga2 --output build/images", prog)
    parser.add_argument("program", nargs="+", help="committed program by its name, or ELF file")
    parser.add_argument("--output", type=Path, default=BUILD / "images", help="folder of the files")
    options = parser.parse_args(arguments)
    try:
        for name in options.program:
            program = read_elf(Path(name)) if name.endswith(".elf") else load(name)
            save(program, options.output)
            sizes = ", ".join(f"{4 * len(w)} bytes in {m}" for m, w in program.memories.items())
            print(f"{options.output / program.name}.lst: {sizes}")
    except ImageError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
