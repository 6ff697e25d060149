# SPDX-License-Identifier: Apache-2.0
"""Sizes and clock of the motion front-end: Yosys for ECP5 and 7 series, nextpnr for ECP5-85.

    python -m scripts.motion_size

A LUT of ECP5 is a cell LUT4, half a CCU2C (two bits of carry) or a quarter of a TRELLIS_DPR16X4
(16 x 4 bits of memory), as nextpnr counts them; one of 7 series is a LUT, an inverter, a shift
register or its part of a distributed memory, as its tools do (carries are next to the LUTs). The
7 series is that of the published sizes, which count LUTs of six inputs. The clock is that of
scripts/synth_unit.py, per seed.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from asip_asm.command import command, script_parser
from scripts.synth_unit import (
    OUTPUT,
    SynthesisError,
    cells_of,
    ecp5_speed,
    read_commands,
    units_kept,
)
from sim.bench.motion.sizes import DESIGNS, FLOWS, LIMITS, RESULTS, entry, within
from sim.report import cache
from sim.rtl.sources import sources_of

SEEDS = (1, 2, 3)


def area(top: str, parameters: Mapping[str, int], flow: str = "ecp5") -> dict[str, int]:
    """{"luts", "registers", "multipliers"} of a module alone. Raises SynthesisError."""
    script, luts, registers, multiplier = FLOWS[flow]
    folder = OUTPUT / f"size_{top}_{flow}"
    folder.mkdir(parents=True, exist_ok=True)
    read = read_commands(top, sources_of(top), parameters)
    cells = cells_of(f"{read}; {units_kept(read)}{script} -top {top}", folder / "stat")
    return {
        "luts": sum(cells.get(cell, 0) * count for cell, count in luts.items()),
        "registers": sum(cells.get(cell, 0) for cell in registers),
        "multipliers": cells.get(multiplier, 0),
    }


def speed(top: str, parameters: Mapping[str, int], name: str, seeds: Sequence[int]) -> dict:
    """Routed clock per seed [MHz], and the LUT4 with the wrapper of the measurement."""
    folder = OUTPUT / f"size_{name.replace(', ', '_')}"
    folder.mkdir(parents=True, exist_ok=True)
    found = ecp5_speed(top, read_commands(top, sources_of(top), parameters), folder, seeds)
    return {"mhz": found["fmax_mhz"], "mhz_median": found["fmax_median_mhz"], "lut4": found["lut4"]}


def measure(seeds: Sequence[int], report: Callable[[str], None]) -> dict[str, Any]:
    """Name -> {"ecp5", "xc7", "mhz", "mhz_median", "lut4"} of every design."""
    found: dict[str, Any] = {}
    for name, (top, parameters, timed) in DESIGNS.items():
        report(f"{name}: area")
        found[name] = {flow: area(top, parameters, flow) for flow in FLOWS}
        if timed:
            report(f"{name}: place and route, {len(seeds)} seeds")
            found[name] |= speed(top, parameters, name, seeds)
    return found


def table(designs: Mapping[str, Any]) -> Table:
    """One row per design: LUT4 and registers on ECP5, LUT6 on 7 series, routed clock."""
    view = Table("module", "LUT4", "LUT6", "registers", "limit", "MHz", box=box.SIMPLE_HEAD)
    for name, found in designs.items():
        luts, registers = LIMITS.get(name, (None, None))
        limit = f"{luts}" + (f" / {registers}" if registers else "") if luts else ""
        clock = ""
        if "mhz" in found:
            values = found["mhz"].values()
            clock = f"{statistics.median(values):.0f} ({min(values):.0f}..{max(values):.0f})"
        sizes = (found["ecp5"]["luts"], found["xc7"]["luts"], found["ecp5"]["registers"])
        verdict = "" if within(name, found) else " NOT KEPT"
        view.add_row(name, *map(str, sizes), limit + verdict, clock)
    return view


@command("scripts/motion_size.py")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 ok, 1 for a tool that failed or a limit not met."""
    parser = script_parser(
        __doc__, "python -m scripts.motion_size --seeds 1 2 3 4 5", "python -m scripts.motion_size"
    )
    parser.add_argument("--seeds", nargs="+", type=int, default=list(SEEDS))
    parser.add_argument("--results", type=Path, default=RESULTS, help="JSON file written")
    options = parser.parse_args(argv)
    console = Console()
    try:
        designs = measure(options.seeds, console.print)
    except SynthesisError as error:
        console.print(f"error: {error}", style="red", markup=False)
        return 1
    cache.save(entry(options.results), designs)
    console.print(table(designs))
    console.print(f"written: {options.results}")
    return 0 if all(within(name, found) for name, found in designs.items()) else 1


if __name__ == "__main__":
    sys.exit(main())
