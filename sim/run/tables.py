# SPDX-License-Identifier: Apache-2.0
"""The tables that `make run` prints, measured figures beside the published ones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich import box
from rich.table import Table

from sim.model.published import Published
from sim.model.records import OUTPUTS, TABLE_3

UNITS = {"l": "m", "v": "m/s", "a": "m/s²", "theta": "rad", "omega": "rad/s", "eps": "rad/s²"}
UNITS |= {"F": "N", "tau": "N·m"}
# Measured columns of table 3; the last is what rounding the set-points to binary32 does by itself.
ERRORS = ("pc_float32", "fpga3", "fpga3_optimised", "set_point_rounding")
# Other builds of the program of FPGA1 and FPGA2.
VARIANTS = {
    "shared_subexpressions": "shared terms",
    "software_square_root": "sqrt in C",
    "unoptimised": "-O0",
    "double_library": "double sqrt",
}
# Keys of results.json beside those of the published table 1.
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


def operation_table(results: dict[str, Any], published: Published) -> Table:
    """Table 1."""
    table = Table(title="Table 1  operations of one tick (a fused multiply-add counts as × and +)")
    table.add_column("operation")
    for title in ("published", "as printed", "optimised"):
        table.add_column(title, justify="right")
    for key, (symbol, printed) in OPERATIONS.items():
        table.add_row(
            symbol,
            str(published.operations[printed]),
            *(f"{results['operations'][program][key]}" for program in ("as_printed", "optimised")),
        )
    return table


def time_table(results: dict[str, Any], published: Published) -> Table:
    """Table 2."""
    table = Table(title="Table 2  longest time of one tick")
    for title in ("platform", "clock [MHz]", "cycles min", "cycles max", "time [µs]"):
        table.add_column(title, justify="left" if title == "platform" else "right")
    for name, row in published.time.items():
        clock, cycles, time = row["clock_mhz"], row["cycles"], row["time_us"]
        table.add_row(f"{name} (published)", f"{clock}", "", f"{cycles}", f"{time}")
    ours = {}
    for platform, measured in results["nios"].items():
        timing = results["platforms"][platform]
        ours[f"{platform.upper()} ours, {timing['ticks']} ticks"] = timing
        for variant, timing in measured["variants"].items():
            ours[f"{platform.upper()} ours, {VARIANTS[variant]}"] = timing
    for program, timing in results["platforms"]["fpga3"].items():
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
    table = Table(
        title=f"Table 3  largest error against double precision over {results['ticks']} ticks",
        box=box.SIMPLE_HEAD,
        padding=0,
    )
    table.add_column("row", no_wrap=True)
    for title in ("PC\npublished", "FPGA\npublished", "PC\nfloat32", "as\nprinted", "optimised"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("inputs\nalone", justify="right", no_wrap=True)
    for row in (*TABLE_3, *OUTPUTS):
        error = results["errors"][row]
        table.add_row(
            f"{row} [{unit(row)}]".replace("[", "\\["),
            *(_figure(published.error[column].get(row)) for column in ("PC", "FPGA")),
            *(_figure(error[key]) for key in ERRORS),
            end_section=row == TABLE_3[-1],
        )
    return table


def nios_error_table(results: dict[str, Any], published: Published) -> Table:
    """Table 3 of FPGA1 and FPGA2, beside the PC on the same ticks."""
    measured = results["nios"]
    ticks = ", ".join(f"{p.upper()} {m['replayed_ticks']}" for p, m in measured.items())
    table = Table(
        title=f"Table 3, Nios II systems; ticks: {ticks}",
        box=box.SIMPLE_HEAD,
        padding=0,
    )
    table.add_column("row", no_wrap=True)
    table.add_column("FPGA\npublished", justify="right", no_wrap=True)
    for platform in measured:
        for title in (platform.upper(), "PC, same\nticks"):
            table.add_column(title, justify="right", no_wrap=True)
    for row in (*TABLE_3, *OUTPUTS):
        cells = []
        for platform, figures in measured.items():
            cells += [results["errors"][row][platform], figures["pc_float32_same_ticks"][row]]
        table.add_row(
            f"{row} [{unit(row)}]".replace("[", "\\["),
            _figure(published.error["FPGA"].get(row)),
            *map(_figure, cells),
            end_section=row == TABLE_3[-1],
        )
    return table


def bound_table(results: dict[str, Any]) -> Table:
    """Errors of the outputs as fractions of their derived bounds."""
    table = Table(
        title="Outputs: largest error as a fraction of its derived bound (sim/run/bounds.py)"
    )
    table.add_column("program")
    for title in OUTPUTS:
        table.add_column(title, justify="right")
    for program, fractions in results["worst_fraction_of_bound"].items():
        table.add_row(program.replace("_", " "), *(f"{fractions[name]:.3f}" for name in OUTPUTS))
    return table


def tracking_table(results: dict[str, Any]) -> Table:
    """Closed-loop tracking errors."""
    table = Table(title="Tracking in closed loop after the first 50 ms, largest error")
    table.add_column("program")
    for title in ("leg [µm]", "tool [µm]", "table axis [µrad]"):
        table.add_column(title, justify="right")
    runs = {
        f"FPGA3 {program.replace('_', ' ')}": results["tracking"][program]
        for program in ("as_printed", "optimised")
    }
    for platform, measured in results["nios"].items():
        ticks = measured["closed_loop_ticks"]
        runs[f"{platform.upper()}, first {ticks} ticks"] = measured["tracking"]
    for name, error in runs.items():
        table.add_row(
            name,
            *(f"{error[key] * 1e6:.3f}" for key in ("leg", "tool", "table")),
        )
    return table


def resource_table(tops: dict[str, Any], published: Published) -> Table:
    """Table 4. tops: the synthesised tops of build/synth.json, or nothing."""
    table = Table(
        title="Table 4  resources; ours: Cyclone V ALUTs by Yosys, Fmax on ECP5-85-8 by nextpnr"
        if tops
        else "Table 4  resources (`make synth` measures ours)",
        box=box.SIMPLE_HEAD,
        padding=0,
    )
    table.add_column("", no_wrap=True)
    for title in ("ALUTs", "registers", "DSP 18x18", "memory\n[kbit]", "LUT4", "Fmax [MHz]\n"):
        table.add_column(title, justify="right", no_wrap=True)
    for name, row in published.resources.items():
        kilobits = f"{row['memory_kb'] * 8}"
        table.add_row(
            f"{name} published", f"{row['lut']}", f"{row['register']}", f"{row['dsp18']}", kilobits
        )
    for name, row in tops.items():
        speed = row["fmax_mhz"]
        table.add_row(
            name,
            f"{row['aluts']}",
            f"{row['registers']}",
            f"{row['dsp_18x18']}",
            f"{row['memory_bits'] / 1000:.0f}",
            f"{row['lut4']}",
            f"{speed['median']:.0f} ({speed['min']:.0f}..{speed['max']:.0f})",
        )
    return table


def all_tables(results: dict[str, Any], tops: dict[str, Any]) -> Iterator[Table]:
    """Everything that the main job prints, in order. tops: as for `resource_table`."""
    published = Published.load()
    yield operation_table(results, published)
    yield time_table(results, published)
    yield error_table(results, published)
    yield nios_error_table(results, published)
    yield bound_table(results)
    yield tracking_table(results)
    yield resource_table(tops, published)


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.2e}"
