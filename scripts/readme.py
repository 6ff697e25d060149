# SPDX-License-Identifier: Apache-2.0
"""Write the results section of README.md from build/results.json, so no figure is typed by hand.

`python scripts/readme.py [results.json]` replaces the text between the two results marks.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from sim.model.published import Published
from sim.model.records import OUTPUTS, TABLE_3
from sim.run.tables import OPERATIONS, unit

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
MARKS = re.compile(r"(<!-- results: [^\n]*-->\n).*?(<!-- end of results -->)", re.DOTALL)


def section(results: dict[str, Any]) -> str:
    """Markdown of the results."""
    published = Published.load()
    fpga3 = results["platforms"]["fpga3"]
    lines = [
        "",
        f"Path A-G-H, {results['ticks']} ticks of 100 µs.",
        "",
        "| platform | clock [MHz] | cycles per tick | time per tick [µs] |",
        "| --- | --- | --- | --- |",
    ]
    for name, row in published.time.items():
        clock, cycles, time = row["clock_mhz"], row["cycles"], row["time_us"]
        lines.append(f"| {name}, published | {clock} | {cycles} | {time} |")
    ours = {f"{name.upper()}, ours": results["platforms"][name] for name in results["nios"]}
    ours |= {f"FPGA3, ours, {program.replace('_', ' ')}": t for program, t in fpga3.items()}
    for program, timing in ours.items():
        low, high = timing["cycles_min"], timing["cycles_max"]
        cycles = f"{low}" if low == high else f"{low}..{high}"
        lines.append(
            f"| **{program}** | {timing['clock_mhz']} | "
            f"**{cycles}** | **{timing['time_us']:.3f}** |"
        )
    operations = results["operations"]
    lines += [
        "",
        "| operations of one tick | " + " | ".join(s for s, _ in OPERATIONS.values()) + " |",
        "| --- |" + " --- |" * len(OPERATIONS),
        "| published | "
        + " | ".join(str(published.operations[key]) for _, key in OPERATIONS.values())
        + " |",
    ]
    for program in ("as_printed", "optimised"):
        counts = " | ".join(str(operations[program][key]) for key in OPERATIONS)
        lines.append(f"| {program.replace('_', ' ')} | {counts} |")
    lines += [
        "",
        "| largest error | unit | PC float32 | FPGA1 | FPGA2 | FPGA3 as printed | optimised |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in (*TABLE_3, *OUTPUTS):
        error = results["errors"][row]
        figures = " | ".join(
            f"{error[key]:.2e}"
            for key in ("pc_float32", "fpga1", "fpga2", "fpga3", "fpga3_optimised")
        )
        lines.append(f"| {row} | {unit(row)} | {figures} |")
    tracking = results["tracking"]
    samples = [f"{n.upper()} {results['platforms'][n]['ticks']}" for n in results["nios"]]
    lines += [
        "",
        f"Ticks of the path that the Nios II systems take: {', '.join(samples)}.",
        "",
        f"Largest tracking error in closed loop: leg {tracking['max_leg_error_m'] * 1e6:.2f} µm, "
        f"tool {tracking['max_tool_error_m'] * 1e6:.2f} µm, "
        f"table axis {tracking['max_table_error_rad'] * 1e6:.1f} µrad.",
        "",
    ]
    return "\n".join(lines) + "\n"


def main(arguments: list[str]) -> int:
    """Rewrite README.md; returns the exit status."""
    file = Path(arguments[0]) if arguments else ROOT / "build/results.json"
    if not file.is_file():
        sys.stderr.write(f"error: no {file}; run `make run` first\n")
        return 1
    text = README.read_text(encoding="utf-8")
    body = section(json.loads(file.read_text(encoding="utf-8")))
    README.write_text(MARKS.sub(lambda m: m[1] + body + m[2], text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
