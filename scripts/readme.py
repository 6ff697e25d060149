# SPDX-License-Identifier: Apache-2.0
"""Write the measured sections of README.md from JSON files, so no figure is typed by hand.

`python scripts/readme.py results` replaces the text between the results marks by what
build/results.json says (of `make run`), and so the figures of docs/index.md. `python
scripts/readme.py synthesis` saves the cores' figures in build/synth.json (of `microtick synth`) in
docs/data/synthesis.json, each core with its commit. The text between the synthesis marks is written
from there, and so are the areas of docs/platforms.md, and table 4 of `make run` on a machine that
has synthesised nothing.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from scripts.generated import table
from sim.bench.platforms.__main__ import area_section
from sim.bench.run.tables import OPERATIONS, unit
from sim.report.marks import write_between_marks
from sim.robot.published import Published
from sim.robot.records import OUTPUTS

ROOT = Path(__file__).resolve().parents[1]
README, PLATFORMS = ROOT / "README.md", ROOT / "docs/platforms.md"
INDEX = ROOT / "docs/index.md"
KEPT = ROOT / "docs/data/synthesis.json"
CORES = {
    "asip_fast": "ASIP `fast`",
    "asip_small": "ASIP `small`",
    "asip_wide": "ASIP `wide`",
    "n2_core": "Nios II core",
    "fpga1": "FPGA1, whole system",
    "fpga2": "FPGA2, whole system",
}


def section(results: dict[str, Any]) -> str:
    """Markdown of the results."""
    published = Published.load()
    fpga3 = results["platforms"]["fpga3"]
    times = [
        [f"{name}, published", str(row["clock_mhz"]), str(row["cycles"]), str(row["time_us"])]
        for name, row in published.time.items()
    ]
    ours = {f"{name.upper()}, ours": results["platforms"][name] for name in results["nios"]}
    ours |= {f"FPGA3, ours, {program.replace('_', ' ')}": t for program, t in fpga3.items()}
    for program, timing in ours.items():
        low, high = timing["cycles_min"], timing["cycles_max"]
        cycles = f"{low}" if low == high else f"{low}..{high}"
        time = f"**{timing['time_us']:.3f}**"
        times.append([f"**{program}**", str(timing["clock_mhz"]), f"**{cycles}**", time])
    counts = [["published", *(str(published.operations[key]) for _, key in OPERATIONS.values())]]
    for program in ("as_printed", "optimised"):
        operations = results["operations"][program]
        counts.append([program.replace("_", " "), *(str(operations[key]) for key in OPERATIONS)])
    columns = {
        **{"pc_float32": "PC float32", "fpga1": "FPGA1", "fpga2": "FPGA2"},
        **{"fpga3": "FPGA3 as printed", "fpga3_optimised": "optimised"},
    }
    errors = [
        [row, unit(row), *(f"{results['errors'][row][key]:.2e}" for key in columns)]
        for row in OUTPUTS
    ]
    tracking = results["tracking"]
    samples = [f"{n.upper()} {results['platforms'][n]['ticks']}" for n in results["nios"]]
    lines = [
        "",
        f"Path A-G-H, {results['ticks']} ticks of {results['robot']['values']['T_s'] * 1e6:g} µs.",
        "",
        *table(["platform", "clock [MHz]", "cycles per tick", "time per tick [µs]"], times),
        "",
        *table(["operations of one tick", *(symbol for symbol, _ in OPERATIONS.values())], counts),
        "",
        *table(["largest error", "unit", *columns.values()], errors),
        "",
        f"Ticks of the path that the Nios II systems take: {', '.join(samples)}.",
        "",
        f"Largest tracking error in closed loop: leg {tracking['max_leg_error_m'] * 1e6:.2f} µm, "
        f"tool {tracking['max_tool_error_m'] * 1e6:.2f} µm, "
        f"table axis {tracking['max_table_error_rad'] * 1e6:.1f} µrad.",
        "",
    ]
    return "\n".join(lines) + "\n"


def figures(results: dict[str, Any]) -> str:
    """Markdown of the few figures on the first page of the site."""
    rows = []
    for program, name in (("optimised", "optimised"), ("as_printed", "as printed")):
        timing = results["platforms"]["fpga3"][program]
        low, high = timing["cycles_min"], timing["cycles_max"]
        cycles = f"{low}" if low == high else f"{low}..{high}"
        time = f"{timing['time_us']:.3f} µs at {timing['clock_mhz']} MHz"
        rows.append(
            [f"one tick of the robot's law on the ASIP, {name}", f"{cycles} cycles, {time}"]
        )
    rows.append(
        ["ticks of the path that ran clock by clock through the RTL", str(results["ticks"])]
    )
    tool = results["tracking"]["max_tool_error_m"] * 1e6
    rows.append(["largest error of the tool on the path, in closed loop", f"{tool:.2f} µm"])
    return "\n".join(["", *table(["figure", "measured"], rows), ""]) + "\n"


def kept(data: dict[str, Any]) -> dict[str, Any]:
    """The part of build/synth.json that is committed.

    The cores, without the figure of each seed.
    """
    names = ("aluts", "registers", "dsp_18x18", "memory_bits", "modules", "commit", "rtl")
    tops = json.loads(KEPT.read_text(encoding="utf-8"))["tops"] if KEPT.is_file() else {}
    for core in CORES & data["tops"].keys():
        top = data["tops"][core]
        tops[core] = {name: top[name] for name in names}
        if "fmax_mhz" in top:
            clock = {name: top["fmax_mhz"][name] for name in ("median", "min", "max")}
            clock["runs"] = len(top["fmax_mhz"]["seeds"])
            tops[core]["fmax_mhz"] = clock
    ordered = {core: tops[core] for core in CORES if core in tops}
    return {"measured": data["measured"], "tops": ordered}


def clock_text(clock: dict[str, Any] | None) -> str:
    """Median, range and seeds of a clock; a dash for a core of which the area alone is measured."""
    if clock is None:
        return "-"
    if clock["runs"] == 1:
        return f"{clock['median']:.0f} (one seed)"
    spread = f"({clock['min']:.0f}..{clock['max']:.0f}, {clock['runs']} seeds)"
    return f"{clock['median']:.0f} {spread}"


def synthesis(data: dict[str, Any]) -> str:
    """Markdown of area and clock of the cores, from docs/data/synthesis.json."""
    head = ["core", "logic [ALUTs]", "registers", "multipliers (18x18)", "memory [kbit]"]
    rows = []
    for name, top in data["tops"].items():
        area = [str(top[key]) for key in ("aluts", "registers", "dsp_18x18")]
        memory = f"{top['memory_bits'] / 1000:.0f}"
        rows.append([CORES[name], *area, memory, clock_text(top.get("fmax_mhz"))])
    return "\n".join(["", *table([*head, "clock [MHz], median (range)"], rows), ""]) + "\n"


def write_results(folder: Path) -> None:
    """The results of `make run` into README.md and docs/index.md; raises FileNotFoundError, and
    ValueError for results of a part."""
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    if len(data["platforms"]) < 3 or not data["path"]["whole"]:
        raise ValueError("results.json is of a part; run `make run` without PLATFORMS, TICKS")
    write_between_marks(README, {"results": section(data)})
    write_between_marks(INDEX, {"figures": figures(data)})


def write_synthesis(folder: Path) -> None:
    """The cores' figures of `microtick synth` into docs/data, README.md and docs/platforms.md;
    raises FileNotFoundError."""
    document = kept(json.loads((folder / "synth.json").read_text(encoding="utf-8")))
    write_text(KEPT, json.dumps(document, indent=2) + "\n")
    write_between_marks(README, {"synthesis": synthesis(document)})
    write_between_marks(PLATFORMS, {"area": area_section(document["tops"])})


SECTIONS = {"results": write_results, "synthesis": write_synthesis}


@command("scripts/readme.py")
def main(arguments: list[str]) -> int:
    """Rewrite one section of README.md; returns the exit status."""
    prog = "python scripts/readme.py"
    parser = script_parser("Write a measured section of README.md.", f"{prog} synthesis", prog)
    parser.add_argument("section", choices=SECTIONS, help="the section to write")
    parser.add_argument(
        "--folder", type=Path, default=ROOT / "build", help="of the JSON file (build)"
    )
    options = parser.parse_args(arguments)
    try:
        SECTIONS[options.section](options.folder)
    except (FileNotFoundError, ValueError) as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
