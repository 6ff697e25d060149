# SPDX-License-Identifier: Apache-2.0
"""Show where the cycles of a tick go on FPGA1 or FPGA2, by function and by instruction."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rich.console import Console

from asip_asm.command import command, count, script_parser
from asip_asm.files import write_text
from sim.bench.run.nios import profile_path
from sim.rtl.build import BuildError
from sim.rtl.nios_image import IMAGES, ImageError, load, read_elf
from sim.rtl.nios_profile import tables
from sim.rtl.nios_rtl import PLATFORMS, NiosError


@command("python -m sim.bench.run.nios_profile")
def main(arguments: list[str] | None = None) -> int:
    prog = "python -m sim.bench.run.nios_profile"
    parser = script_parser(__doc__, f"{prog} fpga1 --ticks 100", prog)
    parser.add_argument("platform", choices=PLATFORMS)
    parser.add_argument(
        "--program", help="committed image or ELF file (default: tracking_PLATFORM)"
    )
    parser.add_argument("--first", type=count, default=5000, help="first tick of the path A-G-H")
    parser.add_argument("--ticks", type=count, default=50, help="number of ticks")
    parser.add_argument("--json", type=Path, help="write the rows to this file too")
    options = parser.parse_args(arguments)
    console = Console()
    try:
        name = options.program or f"tracking_{options.platform}"
        program = read_elf(Path(name)) if name.endswith(".elf") else load(name, IMAGES)
        result = profile_path(options.platform, program, options.first, options.ticks)
    except (ImageError, NiosError, BuildError, ValueError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 1
    for table in tables(result, f"{program.name}, mean tick of {options.ticks}"):
        console.print(table)
    if options.json:
        rows = {
            "tick_cycles": result.tick_cycles,
            "functions": [vars(line) for line in result.functions],
            "kinds": [vars(line) for line in result.kinds],
        }
        write_text(options.json, json.dumps(rows, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
