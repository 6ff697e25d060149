# SPDX-License-Identifier: Apache-2.0
"""Dhrystone 2.1 on the RTL of the Nios II system: DMIPS per MHz, printed and written as JSON."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console

from asip_asm.command import command
from asip_asm.files import write_text
from sim.rtl.build import BuildError
from sim.rtl.nios_image import ImageError, load
from sim.rtl.nios_rtl import PLATFORMS, NiosError, NiosRtl

RESULT = Path(__file__).resolve().parents[2] / "build/dhrystone.json"
VAX_RUNS_PER_SECOND = 1757  # of the VAX 11/780, which is 1 DMIPS by definition
LIMIT = 5_000_000  # cycles
RULES = "two source files, no inlining, no statement changed in its effect"


@dataclass(frozen=True)
class Dhrystone:
    """A result and how it was made: the program itself says options and alignment (bytes)."""

    platform: str
    runs: int
    cycles_per_run: float
    dmips_per_mhz: float
    string_alignment: int
    options: str
    rules: str = RULES


def measure(platform: str) -> Dhrystone:
    """Run the committed image on 'fpga1' or 'fpga2'.

    Raises NiosError if the program finds one of its final values wrong.
    """
    core = NiosRtl(platform)
    core.load(load("dhrystone"))
    core.start()
    wrong = core.execute(LIMIT)
    if wrong:
        raise NiosError(f"dhrystone: {wrong} of its final values are wrong")
    said = dict(line.split(" ", 1) for line in core.console.splitlines())
    runs, cycles = int(said["runs"]), int(said["cycles"])
    return Dhrystone(
        platform=platform,
        runs=runs,
        cycles_per_run=cycles / runs,
        dmips_per_mhz=1e6 * runs / cycles / VAX_RUNS_PER_SECOND,
        string_alignment=int(said["string_alignment"]),
        options=said["options"],
    )


@command("python -m sim.rtl.nios_dhrystone")
def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m sim.rtl.nios_dhrystone",
        description=__doc__,
        epilog="example: python -m sim.rtl.nios_dhrystone --output build/dhrystone.json",
    )
    parser.add_argument("--platform", choices=PLATFORMS, default="fpga2")
    parser.add_argument("--output", type=Path, default=RESULT, help="JSON file")
    options = parser.parse_args(arguments)
    console = Console()
    try:
        result = measure(options.platform)
        options.output.parent.mkdir(parents=True, exist_ok=True)
        write_text(options.output, json.dumps(asdict(result), indent=2) + "\n")
    except (ImageError, NiosError, BuildError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 1
    console.print(
        f"Dhrystone 2.1: {result.cycles_per_run:.0f} cycles per run, "
        f"{result.dmips_per_mhz:.3f} DMIPS/MHz ({options.output})\n"
        f"  {result.rules}; local strings aligned to {result.string_alignment} bytes\n"
        f"  {result.options}",
        highlight=False,
        soft_wrap=True,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
