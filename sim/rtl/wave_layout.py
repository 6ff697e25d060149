# SPDX-License-Identifier: Apache-2.0
"""Write layouts of waves for GTKWave and Surfer: pipeline stages, operands, source lines.

    python -m sim.rtl.wave_layout build/waves/asip-1.fst --program law.asip.json
    python -m sim.rtl.wave_layout build/waves/n2_system-1.fst --program hello.elf

The command writes NAME.gtkw (GTKWave's save file) and NAME.sucl (Surfer's commands) next to the FST
file, both with operands as binary32 numbers. With a program it also writes NAME.source.txt and
.surfer/mappings/NAME.txt, with which GTKWave and Surfer show the source line at each program
counter. A test that writes waves writes the first two by itself. A signal belongs to the stage that
its name ends with (`opa_e1_q`: E1).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pywellen

from asip_asm.command import command, command_parser
from asip_asm.files import write_text
from asip_asm.image import Image
from asip_asm.image import ImageError as AsipImageError
from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.nios_image import ImageError, read_elf
from sim.rtl.nios_map import default_system_map

STAGES = (*"fpdr", "r1", "r2", "e", *(f"e{n}" for n in range(1, 40)), *"maw", "wb")
STAGE = re.compile(r"_(" + "|".join(sorted(STAGES, key=len, reverse=True)) + r")(?:_[qdion]+)?$")
COUNTER = re.compile(r"(?:^|\.)(?:trace_)?pc(?:_[a-z]+\d?)?(?:_[qdo])?$")
# Words of 32 bits that are operands, results or data rather than addresses and instructions.
FLOAT = re.compile(
    r"(?:^|_)(?:op[abc]|[abc]|operands?|data[ab]?|[rw]data|result|value|product|sum|low|high)"
    r"(?:_|$)"
)
# Flags of a trace in GTKWave: hexadecimal to the right; with a process, or a file, that translates.
GTKW_HEX, GTKW_PROCESS, GTKW_FILE = "@22", "@4022", "@2022"
SURFER_FLOAT = "FP: 32-bit IEEE 754"
FLOAT_FILTER = Path(__file__).with_name("float_filter.py")
DEEPEST = 3  # levels of modules below TOP in a layout; all others are in the file


@dataclass(frozen=True)
class Wave:
    """A signal of the file: name with its scopes, bits."""

    name: str
    bits: int

    @property
    def in_gtkwave(self) -> str:
        """Its name in a save file."""
        return f"{self.name}[{self.bits - 1}:0]" if self.bits > 1 else self.name

    @property
    def leaf(self) -> str:
        """Its name alone."""
        return self.name.rpartition(".")[2]

    @property
    def stage(self) -> str:
        """Stage of the pipeline, '' without one."""
        found = STAGE.search(self.leaf)
        return found[1] if found else ""

    @property
    def is_float(self) -> bool:
        """An operand: shown as a binary32 number."""
        return self.bits == 32 and bool(FLOAT.search(self.leaf)) and not self.is_counter

    @property
    def is_counter(self) -> bool:
        """A program counter: shown as a source line."""
        return bool(COUNTER.search(self.leaf)) and self.bits > 1


def waves_of(path: Path) -> list[Wave]:
    """Signals of a file down to DEEPEST, each once. Raises OSError."""
    try:
        variables = pywellen.Waveform(str(path)).all_vars()
    except Exception as error:  # a damaged file fails anywhere in the library
        raise OSError(f"{path}: error: {error}") from None
    found: dict[str, Wave] = {}
    for var in variables:
        name, bits = var.full_name, var.bitwidth
        if bits and name.count(".") <= DEEPEST and "unused" not in name:
            found.setdefault(name, Wave(name, bits))
    return list(found.values())


def groups(waves: Sequence[Wave]) -> Iterator[tuple[str, list[Wave]]]:
    """Title and signals: program counters, ports, then each module's stages in their order."""
    yield "program counters", [wave for wave in waves if wave.is_counter]
    modules = dict.fromkeys(wave.name.rpartition(".")[0] for wave in waves)
    for module in modules:
        own = [w for w in waves if w.name.rpartition(".")[0] == module and not w.is_counter]
        for stage in ("", *STAGES):
            title = module.removeprefix("TOP.") + (f", stage {stage.upper()}" if stage else "")
            yield title, [wave for wave in own if wave.stage == stage]


def gtkwave(path: Path, waves: Sequence[Wave], source: Path | None) -> str:
    """Text of a save file: a closed group of each title, the program counters open."""
    lines = ["[*] GTKWave: layout of sim/rtl/wave_layout.py", f'[dumpfile] "{path.resolve()}"']
    for number, (title, members) in enumerate(groups(waves)):
        if not members:
            continue
        opened, closed = ("@800200", "@1000200") if number == 0 else ("@c00200", "@1401200")
        lines += [opened, f"-{title}"]
        for wave in members:
            if wave.is_counter and source is not None:
                lines += [GTKW_FILE, f"^1 {source.resolve()}", wave.in_gtkwave]
            elif wave.is_float:
                lines += [GTKW_PROCESS, f"^>1 {FLOAT_FILTER}", wave.in_gtkwave]
            else:
                lines += [GTKW_HEX, wave.in_gtkwave]
        lines += [closed, f"-{title}"]
    return "\n".join([*lines, ""])


def surfer(waves: Sequence[Wave], source: str = "") -> str:
    """Text of a command file: dividers and variables with their formats; source: the format of
    program counters.

    A format goes to the item in focus. What is added takes the focus if an item has it: so the
    first divider (`a`) gets it. Surfer drops a divider whose name is more than one word.
    """
    lines: list[str] = []
    for title, members in groups(waves):
        if members:
            lines.append(f"divider_add {re.sub(r'[^0-9A-Za-z]+', '_', title)}")
            lines += ["item_focus a"] if len(lines) == 1 else []
        for wave in members:
            form = SURFER_FLOAT if wave.is_float else source if wave.is_counter else ""
            lines.append(f"variable_add {wave.name}")
            lines += [f"item_set_format {form}"] if form else []
    return "\n".join([*lines, "item_unfocus", "zoom_fit", ""])


def source_lines(program: Path) -> tuple[int, dict[int, str]]:
    """Bits of a program counter, and the source line of each of its values.

    An image of the ASIP: by bundle. An ELF file of the Nios II systems: function and instruction,
    by byte address. Raises OSError, ImageError of either.
    """
    if program.suffix == ".elf":
        image, base = read_elf(program), default_system_map().memories["itcm"].base
        isa = default_isa()
        return 32, {
            base + 4 * n: f"{image.function_at(base + 4 * n)}: {isa.disassemble(word)}"
            for n, word in enumerate(image.memories["itcm"])
        }
    loaded = Image.load(program)
    return 16, {
        bundle: " | ".join(f"{Path(e.file).name}:{e.line} {e.text.strip()}" for e in entries)
        for bundle, entries in enumerate(loaded.sources)
        if entries
    }


def filter_text(bits: int, lines: Mapping[int, str]) -> str:
    """Translate filter file of GTKWave: a value in hexadecimal, its text."""
    return "".join(f"{at:0{bits // 4}x} {' '.join(text.split())}\n" for at, text in lines.items())


def mapping_text(name: str, bits: int, lines: Mapping[int, str]) -> str:
    """Mapping of Surfer: the format's name, bits of its signals, a text for each value."""
    texts = (f"0x{at:x} {' '.join(text.replace('#', ' ').split())}" for at, text in lines.items())
    return "\n".join([f"Name = {name}", f"Bits = {bits}", *texts, ""])


def write(path: Path, program: Path | None = None) -> list[Path]:
    """Write the layouts of an FST; the files. Raises OSError, ImageError of the program's kind."""
    waves = waves_of(path)
    texts = {}
    source, form = None, ""
    if program is not None:
        bits, lines = source_lines(program)
        source, form = path.with_suffix(".source.txt"), f"{path.stem} source"
        texts[source] = filter_text(bits, lines)
        mapping = path.parent / ".surfer/mappings" / f"{path.stem}.txt"
        mapping.parent.mkdir(parents=True, exist_ok=True)
        texts[mapping] = mapping_text(form, bits, lines)
    texts[path.with_suffix(".gtkw")] = gtkwave(path, waves, source)
    texts[path.with_suffix(".sucl")] = surfer(waves, form)
    for place, text in texts.items():
        write_text(place, text)
    return list(texts)


@command("python -m sim.rtl.wave_layout")
def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    parser = command_parser("python -m sim.rtl.wave_layout", __doc__)
    parser.add_argument("waves", type=Path, help="FST file")
    parser.add_argument("--program", type=Path, help="image of the ASIP, or ELF file")
    options = parser.parse_args(arguments)
    try:
        if not options.waves.is_file():
            raise FileNotFoundError(f"{options.waves}: error: no such file; WAVES=1 writes waves")
        print("\n".join(map(str, write(options.waves, options.program))))
    except (ImageError, AsipImageError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
