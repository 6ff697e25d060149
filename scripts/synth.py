# SPDX-License-Identifier: Apache-2.0
"""Area and speed of the ASIP in both configurations, units, Nios II core, custom instructions.

Writes build/synth.json and prints it next to table 4. Area is Yosys for Cyclone V, the ALM family
nearest to Stratix III that Yosys knows; speed is nextpnr on ECP5-85 speed grade 8. A top that has
not changed since its last result is not run again, so an interrupted campaign goes on.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from scripts.synth_unit import MAP_FILE, OUTPUT, ROOT, TOOLS, SynthesisError, synthesise
from sim.bench.run.tables import resource_table
from sim.report.cache import Entry, fingerprint, result_of
from sim.report.provenance import commit
from sim.robot.published import Published
from sim.rtl.figures import rtl_mark
from sim.rtl.sources import sources_of

RESULT = ROOT / "build/synth.json"
SEEDS = (1, 2, 3, 4, 5)
CONVERSION = (
    "one MISTRAL_MUL18X18 or MISTRAL_MUL9X9 cell, one 18x18 part of a significand product each, "
    "counts as one 18x18 element; a MISTRAL_MUL27X27 counts as four"
)


@dataclass(frozen=True)
class Top:
    """A module to synthesise under a name of its own, with parameters."""

    name: str
    module: str
    parameters: Mapping[str, int] = field(default_factory=dict)
    memories: Mapping[str, int] = field(default_factory=dict)  # as for alm_area
    placer: str = "heap"  # of synth_unit.PLACERS


UNITS = (
    *("fp_fma", "fp_add", "fp_mul", "fp_divsqrt", "fp_divsqrt_folded"),
    *("fp_cmp", "fp_i2f", "fp_f2i", "fp_sincos", "fp_sincos_overlapped"),
)
CUSTOM = ("ci_faddsub", "ci_fmul", "ci_fdivsqrt", "ci_fsincos", "ci_fsat", "ci_fcmp", "ci_fph1")
TCM_BITS = 16384 * 32  # of n2_tcm as it is by default, and as both memories of the systems are
TOPS = (
    *(Top(unit, unit) for unit in UNITS),
    Top("asip_fast", "asip", {"FmaPipes": 2, "Slots": 3}),
    Top("asip_small", "asip", {"FmaPipes": 1, "Slots": 1}),
    Top("asip_stream", "asip", {"FmaPipes": 2, "Slots": 3, "StreamWords": 8192, "Loops": 3}),
    Top(
        "asip_wide",
        "asip",
        {"FmaPipes": 2, "Slots": 3, "StreamWords": 8192, "Loops": 3, "Lanes": 3},
        placer="static",
    ),
    *(Top(unit, unit) for unit in ("n2_core", *CUSTOM)),
    *(Top(f"fpga{n}", "n2_system", {"Platform": n}, {"n2_tcm": TCM_BITS}) for n in (1, 2)),
)


def entry(top: Top, seeds: tuple[int, ...]) -> Entry:
    """Where the result of a top is cached, and what it depends on."""
    own = (Path(__file__), Path(__file__).with_name("synth_unit.py"), MAP_FILE, TOOLS)
    files = [*sources_of(top.module), *own]
    return Entry(OUTPUT / "results" / f"{top.name}.json", fingerprint(files, top, seeds))


def run(top: Top, seeds: tuple[int, ...], console: Console, jobs: int = 1) -> dict:
    """Result of one top, from the last run if nothing changed."""
    routed = f", nextpnr with seeds {', '.join(map(str, seeds))}" if seeds else ""
    console.print(f"  {top.name}: Yosys{routed} ...")
    begin, files = time.monotonic(), sources_of(top.module)

    def measure() -> dict:
        set_up = (top.parameters, top.name, jobs, top.memories, top.placer)
        return synthesise(top.module, files, seeds, *set_up)

    result = result_of(entry(top, seeds), measure)
    console.print(f"  {top.name}: {time.monotonic() - begin:.0f} s")
    return result


def figures(result: dict) -> dict:
    """What build/synth.json says of one top."""
    alm = result["alm"]
    area = {
        "aluts": alm["alut"],
        "registers": alm["ff"],
        "dsp_18x18": alm["mul18"],
        "memory_bits": alm["memory_bits"],
        "m10k": alm["m10k"],
        "mlab_cells": alm["mlab"],
        "modules": result["modules"],
    }
    if "ecp5" not in result:
        return area
    ecp5 = result["ecp5"]
    speeds = list(ecp5["fmax_mhz"].values())
    return area | {
        "lut4": ecp5["lut4"],
        "ecp5_registers": ecp5["ff"],
        "fmax_mhz": {
            "median": ecp5["fmax_median_mhz"],
            "min": min(speeds),
            "max": max(speeds),
            "seeds": ecp5["fmax_mhz"],
        },
        "critical_path": ecp5["critical_path"],
    }


@command("scripts/synth.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 done, 1 if a tool failed, 2 usage."""
    prog = "python scripts/synth.py"
    parser = script_parser(__doc__, f"{prog} --only asip_small --seeds 1 2", prog)
    names = [top.name for top in TOPS]
    parser.add_argument(
        "--only", nargs="+", choices=names, default=names, metavar="TOP", help="these tops (all)"
    )
    parser.add_argument(
        "--seeds",
        nargs="*",
        type=int,
        default=list(SEEDS),
        metavar="N",
        help="seeds of placement; none: area alone",
    )
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="placements at a time")
    options = parser.parse_args(argv)
    console = Console()
    OUTPUT.mkdir(parents=True, exist_ok=True)
    data: dict = {}
    for top in TOPS:
        if top.name not in options.only:
            continue
        try:
            result = run(top, tuple(options.seeds), console, options.jobs)
        except SynthesisError as error:
            console.print(f"error: {error}", markup=False)
            return 1
        # Read only now: another run may have measured another top meanwhile.
        data = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.is_file() else {}
        tops = data.get("tops", {})
        mark = rtl_mark(top.name, result["modules"])
        tops[top.name] = figures(result) | {"commit": commit(), "rtl": mark}
        data |= {
            "measured": "area: Yosys synth_intel_alm, Cyclone V; speed: nextpnr, ECP5-85 grade 8",
            "inferred": "Stratix III has the same ALM with two registers and is a faster fabric "
            "than ECP5; nothing here was placed on a Stratix III",
            "dsp_conversion": CONVERSION,
            "tops": {name: tops[name] for name in names if name in tops},
        }
        write_text(RESULT, json.dumps(data, indent=2) + "\n")
    console.print(resource_table(data, Published.load()))
    console.print(f"figures: {RESULT.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
