# SPDX-License-Identifier: Apache-2.0
"""Measure the Nios II systems: Dhrystone and the law per MHz, and the user's own C programs.

    microtick nios-bench                     Dhrystone and the law on FPGA1 and FPGA2
    microtick nios-bench folder     these, and each C program of a folder

Each file NAME.c of the folder is a program, and so is each subfolder with C files. The command
compiles each program with nios_sw/nios-gcc, runs it from reset to its end, and prints its cycles,
instructions, exit status and profile. Figures go to build/nios_bench.json.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser, count
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from sim.bench.run.nios import profile_path
from sim.rtl.build import BuildError
from sim.rtl.nios_dhrystone import measure as dhrystone
from sim.rtl.nios_image import ImageError, Program, load, read_elf
from sim.rtl.nios_profile import Profile, profile, tables
from sim.rtl.nios_rtl import PLATFORMS, NiosError, NiosRtl

RESULTS = BUILD / "nios_bench.json"
COMPILER = ROOT / "nios_sw/nios-gcc"
OPTIONS = "-O2"
LIMIT = 1_000_000_000  # cycles of a program
FIRST_TICK, TICKS = 5000, 50  # of the path A-G-H
ROWS = 10  # of a profile's tables


@dataclass(frozen=True)
class Figures:
    """Of a system: Dhrystone, and the law's mean tick; per_mhz of the law are ticks per second."""

    dmips_per_mhz: float
    dhrystone_cycles: float
    law_cycles: float
    law_per_mhz: float


@dataclass(frozen=True)
class Run:
    """A program's run on a system. status: None if it did not end well; why says what happened."""

    name: str
    system: str
    cycles: int
    instructions: int
    status: int | None
    why: str
    profile: Profile


def figures(system: str) -> Figures:
    """Dhrystone and the law. Raises NiosError, ImageError, BuildError."""
    found = dhrystone(system)
    law = profile_path(system, load(f"tracking_{system}"), FIRST_TICK, TICKS).tick_cycles
    return Figures(found.dmips_per_mhz, found.cycles_per_run, law, 1e6 / law)


def sources(folder: Path) -> Iterator[tuple[str, list[Path]]]:
    """Programs of a folder by name. Raises ImageError if there are none."""
    if not folder.is_dir():
        raise ImageError(f"{folder}: error: no such folder")
    found = [(file.stem, [file]) for file in sorted(folder.glob("*.c"))]
    for below in sorted(each for each in folder.iterdir() if each.is_dir()):
        if files := sorted(below.glob("*.c")):
            found.append((below.name, files))
    if not found:
        raise ImageError(f"{folder}: error: no C file in it, or in its subfolders")
    yield from found


def compiled(name: str, files: Sequence[Path], system: str, options: str) -> Program:
    """A program by nios-gcc. Raises ImageError with what the compiler printed."""
    elf = BUILD / f"nios_bench/{system}/{name}.elf"
    elf.parent.mkdir(parents=True, exist_ok=True)
    given = [str(file) for file in files]
    command = [str(COMPILER), "--system", system, *shlex.split(options), *given, "-o", str(elf)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise ImageError(f"{files[0]}: error: it does not compile\n{done.stderr.rstrip()}")
    return read_elf(elf)


def run(core: NiosRtl, name: str, program: Program, limit: int) -> Run:
    """Run a program to its end, at most `limit` cycles."""
    core.load(program)
    core.profile(whole=True)
    core.guard()
    core.start()
    begin, before = core.cycles, core.retired
    status = core.advance(limit)
    cycles = core.cycles - begin
    why = ""
    if core.stray is not None:
        why = f"accesses 0x{core.stray:08x}, neither memory nor a register"
    elif status is None:
        why = f"no end within {limit} cycles"
    retired = (core.retired - before) & 0xFFFF_FFFF
    spent = profile(core, program, 1, cycles)
    return Run(name, core.platform, cycles, retired, None if why else status, why, spent)


def figures_table(found: dict[str, Figures]) -> Table:
    """Figures per MHz."""
    table = Table("system", title="per MHz")
    for head in (
        "DMIPS/MHz",
        "cycles of a Dhrystone",
        "cycles of a tick of the law",
        "ticks/s/MHz",
    ):
        table.add_column(head, justify="right")
    for system, row in found.items():
        table.add_row(
            system,
            f"{row.dmips_per_mhz:.3f}",
            f"{row.dhrystone_cycles:.0f}",
            f"{row.law_cycles:.0f}",
            f"{row.law_per_mhz:.0f}",
        )
    return table


def runs_table(runs: Sequence[Run]) -> Table:
    """Programs of the user."""
    table = Table("program", "system", title="programs")
    for head in ("cycles", "instructions", "cycles each", "exit status"):
        table.add_column(head, justify="right")
    for row in runs:
        each = f"{row.cycles / row.instructions:.2f}" if row.instructions else "-"
        status = row.why if row.status is None else str(row.status)
        table.add_row(row.name, row.system, f"{row.cycles}", f"{row.instructions}", each, status)
    return table


@command("microtick nios-bench")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status 1 if a program did not end."""
    parser = command_parser("microtick nios-bench", __doc__)
    parser.add_argument("folder", nargs="?", type=Path, help="C programs of the user")
    parser.add_argument("--options", default=OPTIONS, help=f"of the compiler (default: {OPTIONS})")
    parser.add_argument("--system", choices=PLATFORMS, action="append", help="default: both")
    parser.add_argument("--max-cycles", type=count, default=LIMIT, help="end a program there")
    options = parser.parse_args(arguments)
    console = Console()
    systems = options.system or list(PLATFORMS)
    runs: list[Run] = []
    try:
        found = {system: figures(system) for system in systems}
        console.print(figures_table(found))
        for name, files in sources(options.folder) if options.folder else ():
            for system in systems:
                program = compiled(name, files, system, options.options)
                runs.append(run(NiosRtl(system), name, program, options.max_cycles))
                for table in tables(runs[-1].profile, f"{name}, {system}", ROWS):
                    console.print(table)
    except (ImageError, NiosError, BuildError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 2
    if runs:
        console.print(runs_table(runs))
    document = {
        "per_mhz": {system: asdict(row) for system, row in found.items()},
        "options": options.options,
        "programs": [asdict(row) for row in runs],
    }
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    write_text(RESULTS, json.dumps(document, indent=2) + "\n")
    console.print(f"figures: {RESULTS.relative_to(ROOT)}", markup=False, highlight=False)
    return int(any(row.status is None for row in runs))


if __name__ == "__main__":
    sys.exit(main())
