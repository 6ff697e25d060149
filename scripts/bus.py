# SPDX-License-Identifier: Apache-2.0
"""What the bus is to reach: measures it, prints the table, writes build/bus.json and a capture.

    python -m scripts.bus            minutes: short runs; rows that need long ones say so
    python -m scripts.bus --full     100 000 cycles of pysoem, 10 000 of the clocks, place and route

Exit status 1 if a goal is missed or not measured.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from asip_asm.project import BUILD
from scripts.motion_size import area, speed
from scripts.synth_unit import SynthesisError
from sim.coe.dictionary import load
from sim.ethercat.clocks import synchronise
from sim.ethercat.line import Line, library
from sim.ethercat.measure import CLOCK_PS, forwarding, keeps_cycle
from sim.ethercat.tap import NamespaceError, in_namespace

FORWARDING_NS, NEAR_NS, LUTS, MHZ = 600, 20, 7000, 100
PERIODS_NS = (100_000, 31_250)
MASTER_CYCLES = {False: 200, True: 100_000}
CLOCK_CYCLES = 10_000
PPM = (0.0, 100.0, -100.0)
CABLE_PS = 500_000
SEEDS = (1, 2, 3)
TOP = "ethercat_slave"
# Rows that need the application and the robot behind the controller.
NOT_MEASURED = (
    ("A-G-H over the bus, CSP at 1 kHz, tool error", "um", 10),
    ("A-G-H over the bus, following-error faults", "faults", 0),
    ("CiA 402, controlwords that agree with python-canopen's table", "controlwords", 100_000),
)
MASTERS = ("pysoem", "scapy")

Row = dict[str, Any]


def row(name: str, value: float | None, unit: str, target: float, met: bool) -> Row:
    """As build/bus.json has it; value None: not measured."""
    return {"name": name, "value": value, "unit": unit, "target": target, "met": met}


def timing(report: Callable[[str], None]) -> list[Row]:
    """Forwarding and cycles, counted in clocks."""
    report("forwarding, all phases of the sender's clock")
    found = forwarding()
    worst = found.most * CLOCK_PS // 1000
    rows = [
        row("forwarding port to port, longest", worst, "ns", FORWARDING_NS, worst <= FORWARDING_NS),
        row("forwarding, between frames", found.spread, "clocks", 0, found.spread == 0),
    ]
    device = load()
    for period in PERIODS_NS:
        report(f"cycles of {period / 1000} us with the process data of five axes")
        wrong, late = keeps_cycle(device, period, 200)
        name = f"five axes every {period / 1000:g} us: wrong counters and late inputs of 200 cycles"
        rows.append(row(name, wrong + late, "cycles", 0, wrong + late == 0))
    return rows


def masters(full: bool, capture: Path, report: Callable[[str], None]) -> list[Row]:
    """pysoem with one slave and three."""
    rows = []
    cycles = MASTER_CYCLES[full]
    library()
    for slaves in (1, 3):
        report(f"pysoem, {slaves} slave(s), {cycles} cycles in OP")
        options = ["--slaves", str(slaves), "--cycles", str(cycles)]
        options += ["--capture", str(capture)] if slaves == 1 and not full else []
        name = f"pysoem, {slaves} slave(s): cycles in OP without a wrong counter"
        try:
            done = in_namespace("sim.ethercat.master_loop", options, timeout=4 * 3600)
        except NamespaceError as error:
            report(f"  {error}")
            rows.append(row(name, None, "cycles", MASTER_CYCLES[True], False))
            continue
        if done.returncode:
            report(done.stdout + done.stderr)
        right = cycles if done.returncode == 0 else 0
        rows.append(row(name, right, "cycles", MASTER_CYCLES[True], right >= MASTER_CYCLES[True]))
    rows.append(row("unrelated masters that work", len(MASTERS), "masters", 3, len(MASTERS) >= 3))
    return rows


def clocks(full: bool, report: Callable[[str], None]) -> Row:
    """System times of three slaves; only the full run is long enough to count."""
    name = f"system times apart, three slaves 100 ppm apart, {CLOCK_CYCLES} cycles"
    if not full:
        return row(name, None, "ns", NEAR_NS, False)
    report(f"distributed clocks, {CLOCK_CYCLES} cycles")
    with Line(PPM, cable_ps=CABLE_PS) as line:
        worst = synchronise(line, CLOCK_CYCLES).worst
    return row(name, worst, "ns", NEAR_NS, worst <= NEAR_NS)


def size(full: bool, report: Callable[[str], None]) -> list[Row]:
    """Area, and in a full run the routed clock, on ECP5."""
    names = ("slave controller on ECP5, area", "slave controller on ECP5, clock of three seeds")
    luts = mhz = None
    try:
        report("area on ECP5")
        luts = area(TOP, {})["luts"]
        if full:
            report("clock on ECP5")
            mhz = speed(TOP, {}, TOP, SEEDS)["mhz_median"]
    except (SynthesisError, FileNotFoundError) as error:
        report(f"  {error}; `make setup-synth` installs the tools")
    return [
        row(names[0], luts, "LUT4", LUTS, luts is not None and luts <= LUTS),
        row(names[1], mhz, "MHz", MHZ, mhz is not None and mhz >= MHZ),
    ]


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        prog="python -m scripts.bus",
        description=__doc__.splitlines()[0],
        epilog="example: python -m scripts.bus --full --results build/bus.json",
    )
    parser.add_argument("--full", action="store_true", help="the long runs too (hours)")
    parser.add_argument("--results", type=Path, default=BUILD / "bus.json", help="file written")
    parser.add_argument("--capture", type=Path, default=BUILD / "bus.pcap", help="file written")
    options = parser.parse_args(argv)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    console = Console()
    report = console.print
    rows = timing(report)
    rows += masters(options.full, options.capture, report)
    rows.append(clocks(options.full, report))
    rows += size(options.full, report)
    rows += [row(name, None, unit, target, False) for name, unit, target in NOT_MEASURED]
    text = json.dumps({"goals": rows}, indent=2) + "\n"
    options.results.write_text(text, encoding="utf-8")
    view = Table("goal", "value", "target", "met", box=box.SIMPLE_HEAD)
    for each in rows:
        value = "not measured" if each["value"] is None else f"{each['value']:g} {each['unit']}"
        view.add_row(each["name"], value, f"{each['target']} {each['unit']}", str(each["met"]))
    console.print(view)
    console.print(f"written: {options.results}, {options.capture}")
    return 0 if all(each["met"] for each in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
