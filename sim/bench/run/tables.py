# SPDX-License-Identifier: Apache-2.0
"""The tables that `make run` prints, measured figures next to the published ones.

A platform that did not run has no entries in the results, and then no rows or columns here.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from sim.bench.run.checks import is_marked
from sim.robot.errors import RIPPLE_ABOVE
from sim.robot.published import Published
from sim.robot.records import OUTPUTS, TABLE_3
from sim.rtl.figures import measured_at

ROOT = Path(__file__).resolve().parents[3]
# Area and clock as synthesised here, else as last measured and saved, each top with its commit.
SYNTHESIS = (ROOT / "build/synth.json", ROOT / "docs/data/synthesis.json")
UNITS = {"l": "m", "v": "m/s", "a": "m/s²", "theta": "rad", "omega": "rad/s", "eps": "rad/s²"}
UNITS |= {"F": "N", "tau": "N·m"}
# Measured columns of table 3 and their titles; the last is what rounding the set-points to
# binary32 does by itself.
ERRORS = {
    "pc_float32": "PC\nfloat32",
    "fpga3": "as\nprinted",
    "fpga3_optimised": "optimised",
    "fpga3_observer": "observer",
    "fpga3_stamps": "time\nstamps",
    "set_point_rounding": "inputs\nalone",
}
# Other builds of the program of FPGA1 and FPGA2.
VARIANTS = {
    "shared_subexpressions": "shared terms",
    "software_square_root": "sqrt in C",
    "unoptimised": "-O0",
    "double_library": "double sqrt",
}
# Keys of results.json other than those of the published table 1.
OPERATIONS = {
    "add_sub": ("+ −", "add_sub"),
    "mul": ("×", "mul"),
    "div": ("/", "div"),
    "sqrt": ("sqrt", "sqrt"),
    "sin": ("sin", "sin"),
    "float_int": ("float(int)", "float_of_int"),
    "sat": ("sat", "saturate"),
}


def unit(row: str) -> str:
    """Unit of a row of table 3 or an output."""
    return UNITS[row.rstrip("0123456789")]


def _table(
    title: str, caption: str, first: str, figures: Iterable[str], dense: bool = False
) -> Table:
    """A table with the sentence that explains it, and its columns; dense: of many figures."""
    look: dict[str, Any] = {"box": box.SIMPLE_HEAD, "padding": 0} if dense else {}
    table = Table(title=title, caption=caption, caption_justify="left", **look)
    table.add_column(first, no_wrap=dense)
    for head in figures:
        table.add_column(head, justify="right", no_wrap=dense)
    return table


def _row_name(row: str) -> str:
    return f"{row} [{unit(row)}]".replace("[", "\\[")


def operation_table(results: dict[str, Any], published: Published) -> Table:
    """Table 1."""
    programs = results.get("operations", {})
    table = _table(
        "Table 1  operations of one tick",
        "How much arithmetic the control law takes at every tick: as the paper states, in our "
        "program that evaluates its equations one by one as printed, and in our optimised one. A "
        "fused multiply-add counts as × and as +.",
        "operation",
        ("published", *(name.replace("_", " ") for name in programs)),
    )
    for key, (symbol, printed) in OPERATIONS.items():
        table.add_row(
            symbol,
            str(published.operations[printed]),
            *(f"{counts[key]}" for counts in programs.values()),
        )
    return table


def time_table(results: dict[str, Any], published: Published) -> Table:
    """Table 2."""
    table = _table(
        "Table 2  longest time of one tick",
        "How long each processor needs for a tick; it must be done within the control period. "
        "FPGA1: a Nios II processor with the vendor's floating-point instructions; FPGA2: the "
        "same with instructions of its own; FPGA3: the ASIP, a processor made for this law. "
        "Cycles are counted in simulation, microseconds assume the published clock.",
        "platform",
        ("clock [MHz]", "cycles min", "cycles max", "time [µs]"),
    )
    for name, row in published.time.items():
        clock, cycles, time = row["clock_mhz"], row["cycles"], row["time_us"]
        table.add_row(f"{name} (published)", f"{clock}", "", f"{cycles}", f"{time}")
    ours = {}
    for platform, measured in results.get("nios", {}).items():
        timing = results["platforms"][platform]
        ours[f"{platform.upper()} ours, {timing['ticks']} ticks"] = timing
        for variant, timing in measured["variants"].items():
            ours[f"{platform.upper()} ours, {VARIANTS[variant]}"] = timing
    for program, timing in results["platforms"].get("fpga3", {}).items():
        ours[f"FPGA3 ours, {program.replace('_', ' ')}"] = timing
    for name, timing in ours.items():
        table.add_row(
            name,
            f"{timing['clock_mhz']}",
            f"{timing['cycles_min']}",
            f"{timing['cycles_max']}",
            f"{timing['time_us']:.3f}",
            style="bold",
        )
    return table


def error_table(results: dict[str, Any], published: Published) -> Table:
    """Table 3 with the five outputs."""
    has = results["errors"][OUTPUTS[0]]
    table = _table(
        f"Table 3  largest error against double precision over {results['ticks']} ticks",
        "How far 32-bit arithmetic is from 64-bit arithmetic on the same inputs, at worst: length, "
        "speed and acceleration of the legs (l, v, a), the same of the table axes (theta, omega, "
        "eps), and the forces and torques. “Inputs alone” is what rounding the set-points to 32 "
        "bits does by itself, which no program can undo.",
        "row",
        (
            "PC\npublished",
            "FPGA\npublished",
            *(title for key, title in ERRORS.items() if key in has),
        ),
        dense=True,
    )
    for row in (*TABLE_3, *OUTPUTS):
        error = results["errors"][row]
        table.add_row(
            _row_name(row),
            *(_figure(published.error[column].get(row)) for column in ("PC", "FPGA")),
            *(_figure(error[key]) for key in ERRORS if key in has),
            end_section=row == TABLE_3[-1],
        )
    return table


def nios_error_table(results: dict[str, Any], published: Published) -> Table:
    """Table 3 of FPGA1 and FPGA2, next to the PC on the same ticks."""
    measured = results.get("nios", {})
    ticks = ", ".join(f"{p.upper()} {m['replayed_ticks']}" for p, m in measured.items())
    table = _table(
        f"Table 3, Nios II systems; ticks: {ticks}",
        "The same of the two Nios II systems, which take a part of the ticks; beside each a PC "
        "that computes the printed formulas in 32 bits on exactly those ticks.",
        "row",
        ("FPGA\npublished", *(t for p in measured for t in (p.upper(), "PC, same\nticks"))),
        dense=True,
    )
    table.add_column("")
    for row in (*TABLE_3, *OUTPUTS):
        cells = []
        for platform, figures in measured.items():
            cells += [results["errors"][row][platform], figures["pc_float32_same_ticks"][row]]
        table.add_row(
            _row_name(row),
            _figure(published.error["FPGA"].get(row)),
            *map(_figure, cells),
            *_mark(results, "nios", row),
            end_section=row == TABLE_3[-1],
        )
    return table


def bound_table(results: dict[str, Any]) -> Table:
    """Errors of the outputs as fractions of their derived bounds."""
    table = _table(
        "Outputs: largest error as a fraction of its derived bound",
        "An analysis of every rounding (sim/bench/run/bounds.py) says how large the error of a "
        "force or torque can be: 1 is that bound, more than 1 is a fault of the program or the "
        "processor.",
        "program",
        OUTPUTS,
    )
    table.add_column("")
    for program, fractions in results.get("worst_fraction_of_bound", {}).items():
        table.add_row(
            program.replace("_", " "),
            *(f"{fractions[name]:.3f}" for name in OUTPUTS),
            *_mark(results, "worst_fraction_of_bound", program),
        )
    return table


def tracking_table(results: dict[str, Any]) -> Table:
    """Closed-loop tracking errors."""
    table = _table(
        "Tracking in closed loop after the first 50 ms, largest error",
        "How far the simulated robot is from where the path wants it, at worst: length of a leg, "
        "distance of the tool, angle of a table axis.",
        "program",
        ("leg [µm]", "tool [µm]", "table axis [µrad]"),
    )
    table.add_column("")
    runs = {
        f"FPGA3 {program.replace('_', ' ')}": results["tracking"][program]
        for program in ("as_printed", "optimised", "observer", "stamps")
        if program in results["tracking"]
    }
    for platform, measured in results.get("nios", {}).items():
        ticks = measured["closed_loop_ticks"]
        runs[f"{platform.upper()}, first {ticks} ticks"] = measured["tracking"]
    for name, error in runs.items():
        table.add_row(
            name,
            *(f"{error[key] * 1e6:.3f}" for key in ("leg", "tool", "table")),
            *_mark(results, "tracking", name.removeprefix("FPGA3 ").replace(" ", "_")),
        )
    return table


def ripple_table(results: dict[str, Any]) -> Table:
    """What is above 1 kHz in the outputs."""
    table = _table(
        f"Ripple of the outputs: root mean square of what is above {RIPPLE_ABOVE:g} Hz",
        "How much forces and torques jump from tick to tick. A step of an encoder is a step of a "
        "speed that is the difference of two counts, and so of the force; an observer spreads it.",
        "program",
        (*(f"{name} [{unit(name)}]".replace("[", "\\[") for name in OUTPUTS),),
    )
    for program, found in results["ripple"].items():
        table.add_row(program.replace("_", " "), *(f"{found[name]:.3f}" for name in OUTPUTS))
    return table


def _mark(results: dict[str, Any], key: str, row: str) -> tuple[str, ...]:
    """Last cell of a row whose comparison failed."""
    return ("[bold red]EXCEEDED[/]",) if is_marked(results, key, row) else ("",)


def synthesised() -> dict[str, Any]:
    """Figures of each top from the first of SYNTHESIS that has it, {} if no file is there."""
    found = [json.loads(file.read_text(encoding="utf-8")) for file in SYNTHESIS if file.is_file()]
    tops = {name: top for document in reversed(found) for name, top in document["tops"].items()}
    return found[0] | {"tops": tops} if found else {}


def resource_table(document: Mapping[str, Any], published: Published) -> Table:
    """Table 4. document: build/synth.json or what is saved of it, or nothing."""
    where = f"measured at commit {measured_at(document['tops'])}; " if document else ""
    table = _table(
        "Table 4  resources",
        "How much of an FPGA each processor takes, and its clock frequency. Published: Stratix "
        f"III. Ours: {where}area is Yosys for Cyclone V, clock is nextpnr for ECP5-85 grade 8, "
        "median and range over several runs; `microtick synth` measures again.",
        "",
        ("ALUTs", "registers", "DSP 18x18", "memory\n\\[kbit]", "Fmax [MHz]\n"),
        dense=True,
    )
    for name, row in published.resources.items():
        kilobits = f"{row['memory_kb'] * 8}"
        table.add_row(
            f"{name} published", f"{row['lut']}", f"{row['register']}", f"{row['dsp18']}", kilobits
        )
    for name, row in document.get("tops", {}).items():
        speed = row.get("fmax_mhz")
        table.add_row(
            name,
            f"{row['aluts']}",
            f"{row['registers']}",
            f"{row['dsp_18x18']}",
            f"{row['memory_bits'] / 1000:.0f}",
            f"{speed['median']:.0f} ({speed['min']:.0f}..{speed['max']:.0f})" if speed else "-",
        )
    return table


def all_tables(results: dict[str, Any]) -> Iterator[Table]:
    """Everything that the main job prints, in order."""
    published = Published.load()
    ran = results["platforms"]
    if "fpga3" in ran:
        yield operation_table(results, published)
    yield time_table(results, published)
    if "fpga3" in ran:
        yield error_table(results, published)
    if results.get("nios"):
        yield nios_error_table(results, published)
    if results.get("worst_fraction_of_bound"):
        yield bound_table(results)
    yield tracking_table(results)
    if results.get("ripple"):
        yield ripple_table(results)
    yield resource_table(synthesised(), published)


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.2e}"
