# SPDX-License-Identifier: Apache-2.0
"""`microtick side-by-side`: one law on the core, on FPGA2 and on this machine."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from asip_asm.command import command_parser, count, run_command
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from sim.bench.platforms.compare import TOPS, Request, side_by_side
from sim.bench.shown_robots.job import SHOWN
from sim.core.api import CoreFault
from sim.laws.native.law import CompilerError
from sim.report.marks import write_between_marks
from sim.rtl.nios_rtl import NiosError

PAGE = ROOT / "docs/platforms.md"
RESULTS = BUILD / "side_by_side.json"
RUNS = 1_000_000
EPILOG = """examples:
  python -m sim.bench.platforms                        # iiwa14; build/side_by_side.json
  python -m sim.bench.platforms --law scara --runs 5000000
  python -m sim.bench.platforms --docs          # docs/platforms.md from build/side_by_side.json

FPGA2 needs the cross compiler, `make tools T=nios-toolchain`.

exit status: 0 written, 1 an error, or results whose bits are not the interpreter's; 2 wrong command
line
"""
HEADINGS = ("platform", "form of the law", "median [µs]", "99.99 % [µs]", "worst [µs]", "cycles")


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    body = _docs if options.docs else partial(_measure, options)
    return run_command("platforms", body, CompilerError, CoreFault, NiosError)


def _measure(options: argparse.Namespace) -> int:
    options.output.mkdir(parents=True, exist_ok=True)
    shown = SHOWN[options.law]
    law = shown.law()
    request = Request(law, shown.sample(law), options.runs, options.seed, options.output)
    found = side_by_side(request, lambda text: print(text, file=sys.stderr, flush=True))
    file = options.output / RESULTS.name
    write_text(file, json.dumps(found, indent=1) + "\n")
    view = Table(*HEADINGS, title=f"{found['law']}, one tick")
    for row in rows(found):
        view.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 132).print(view)
    print(f"{file}; `make docs T=platforms` writes docs/platforms.md from it")
    wrong = [n for n in ("core", "fpga2", "pc") if not found[n]["bits_equal"]]
    for name in wrong:
        print(f"platforms: {name}: bits differ: {found[name]['first_difference']}")
    return 1 if wrong else 0


def _docs() -> int:
    found = json.loads(RESULTS.read_text(encoding="utf-8"))
    texts = {"side by side": section(found), "area": area_section(found["area"]["tops"])}
    write_between_marks(PAGE, texts)
    return 0


def rows(found: dict[str, Any]) -> list[list[str]]:
    """Text of a row per platform; a core's every tick has one time."""
    result = []
    for name, title in (("core", "the core, `fast`"), ("fpga2", "FPGA2")):
        row = found[name]
        low, high = row["cycles_min"], row["cycles_max"]
        time = f"{high / row['clock_mhz']:.2f}"
        middle = time if low == high else f"{low / row['clock_mhz']:.2f}.."
        cycles = f"{low}" if low == high else f"{low}..{high}"
        clock = f"{row['clock_mhz']:g} MHz"
        result.append([f"{title}, {clock}", row["form"], middle, time, time, cycles])
    for name in ("pinned", "unpinned"):
        row = found["pc"][name]
        times = [f"{row[key]:.2f}" for key in ("median_us", "p9999_us", "worst_us")]
        result.append([f"PC, {name}", found["pc"]["form"], *times, "-"])
    return result


def section(found: dict[str, Any]) -> str:
    """Markdown of the measured part of docs/platforms.md."""
    lines = [
        "",
        f"Law: {found['law']}.",
        "",
        f"| {' | '.join(HEADINGS)} |",
        f"| {' | '.join(['---'] * len(HEADINGS))} |",
        *(f"| {' | '.join(row)} |" for row in rows(found)),
        "",
        f"{found['core']['ticks']} ticks on the core and {found['fpga2']['ticks']} on FPGA2, both "
        f"in RTL; {found['pc']['runs']} on the PC, each timed by itself, without the "
        f"{found['pc']['pinned']['clock_us']:.3f} µs of reading the clock.",
        "",
        f"The PC: {_machine(found['pc']['machine'])}.",
        "",
    ]
    return "\n".join(lines) + "\n"


def area_section(tops: Mapping[str, Any]) -> str:
    """Markdown of area and clock of both cores, for docs/platforms.md. tops: of `synthesised`."""
    lines = [
        "",
        "| what it takes | logic [ALUTs] | registers | multipliers (18x18) | memory [kbit] "
        "| clock [MHz] |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    titles = {"core": "the core, `fast`", "fpga2": "FPGA2, the whole system"}
    for name, top in TOPS.items():
        row = tops[top]
        lines.append(
            f"| {titles[name]} | {row['aluts']} | {row['registers']} | {row['dsp_18x18']} | "
            f"{row['memory_bits'] / 1000:.0f} | {row['fmax_mhz']['median']:.0f} |"
        )
    return "\n".join([*lines, ""]) + "\n"


def _machine(machine: dict[str, Any]) -> str:
    virtual = ", a virtual machine" if machine["virtual"] else ""
    return (
        f"{machine['processor']}, {machine['processors']} processors{virtual}; "
        f"{machine['system']}; {machine['compiler']}; load average {machine['load']}"
    )


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    parser = command_parser(
        "python -m sim.bench.platforms",
        "Measure one law on the core, on FPGA2 and on this machine.",
        EPILOG,
    )
    parser.add_argument("--law", choices=tuple(SHOWN), default="iiwa14", help="which law")
    parser.add_argument("--runs", type=count, default=RUNS, help="ticks on this machine")
    parser.add_argument("--seed", type=int, default=1, help="seed of the inputs")
    parser.add_argument("--output", type=Path, default=BUILD, help="folder to write")
    parser.add_argument("--docs", action="store_true", help="write docs/platforms.md instead")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
