# SPDX-License-Identifier: Apache-2.0
"""`microtick drive motor.toml`: bring up one motor, print and write what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from asip_asm.model.compiler import Compiled
from asip_asm.model.program import build
from sim.bench.drive.axis import page
from sim.bench.drive.axis.bench import BringUpError, current_program
from sim.bench.drive.axis.motor_file import MotorFileError, OneMotor, load
from sim.bench.drive.axis.result import Result, bring_up
from sim.bench.drive.axis.tuning import velocity_program
from sim.laws.drive.clocks import CLOCK
from sim.report.goals import as_json, missed, terminal_table, write_goals


def bring_up_alone(file: Path, results: Path, console: Console) -> int:
    """The motor of a file: tables, results, page, both programs. The exit status: 1 for a goal that
    is missed, a file that is refused, or a start-up that stops."""
    try:
        one = load(file)
        result = bring_up(one, report=lambda text: console.print(f"{text} ...", markup=False))
    except MotorFileError as error:
        console.print(str(error), style="red", markup=False, soft_wrap=True)
        return 1
    except BringUpError as error:
        console.print(f"{file}: error: {error}", style="red", markup=False, soft_wrap=True)
        return 1
    cycles = write_programs(result, results.parent / results.stem)
    goals = as_json(result.goals())
    write_goals(results, goals, motor=str(file), cycles=cycles, **result.as_json())
    for table in (identified(result), gains(result, cycles)):
        console.print(table)
    console.print(terminal_table(goals))
    drawn = results.with_suffix(".html")
    page.write(drawn, (identified(result), gains(result, cycles), terminal_table(goals)), result)
    console.print(f"written: {results}, {drawn}, {results.parent / results.stem}/*.s", markup=False)
    return int(bool(missed(goals)))


def write_programs(result: Result, folder: Path) -> dict[str, int]:
    """Both loops as assembled programs in a folder; their cycles."""
    folder.mkdir(parents=True, exist_ok=True)
    found, one = result.found, result.one
    loops: dict[str, Compiled] = {
        "current_loop": current_program(one, found.motor(one.motor), result.tuned.crossover),
        "velocity_loop": velocity_program(result.tuned),
    }
    return {name: build(law, folder / f"{name}.s").cycles for name, law in loops.items()}


def identified(result: Result) -> Table:
    """What was found, next to the file."""
    view = Table("identified", "found", "file", "unit", "off", box=box.SIMPLE_HEAD)
    for name, (found, file, unit) in result.compared.items():
        off = f"{100 * (found / file - 1):+.2f} %" if file else ""
        view.add_row(name, f"{found:.5g}", f"{file:.5g}", unit, off)
    moved = f"{np.degrees(result.found.moved):.2f} degrees"
    for name, value in result.angles.items():
        note = f", the rotor moved by {moved}" if name == "without motion" else ""
        off = f"{np.degrees(value):+.2f} degrees{note}"
        still = result.found.still if name == "without motion" else None
        angle = result.found.angle if still is None else still
        view.add_row(f"angle {name}", f"{angle:.4f}", "", "rad", off)
    for name, why in result.not_done.items():
        view.add_row(name, "not done", "", "", why)
    if result.found.offset is not None:
        entered = result.one.encoder_offset
        given = "" if entered is None else f"{entered:.4f}"
        note = "" if given else f"enter encoder_offset = {result.found.offset:.4f}"
        view.add_row("encoder_offset", f"{result.found.offset:.4f}", given, "rad", note)
    for name, value in result.one.port.items():
        view.add_row(name, "", str(value), "", f"parameter of {result.one.port_name}")
    for name, value in result.one.counter.items():
        view.add_row(name, "", str(value), "", "parameter of absolute_position")
    if result.one.counter:
        frame, period = (1e6 * CLOCK * n for n in _frame(result.one))
        view.add_row("encoder frame", f"{frame:.4g}", "", "us", "from the position to its count")
        view.add_row("age of the position", f"{frame + period:.4g}", "", "us", "at most")
    for name, (rms, largest) in result.serial.items():
        degrees = f"{rms:.3g} rms, {largest:.3g} at most"
        view.add_row(f"angle {name}", degrees, "", "degrees", "error of the extrapolated count")
    return view


def _frame(one: OneMotor) -> tuple[int, int]:
    """Clocks of a frame, and from one to the next."""
    return one.frame_clocks, one.counter["Period"]


def gains(result: Result, cycles: dict[str, int]) -> Table:
    """Gains of both loops, and what runs them."""
    tuned, (k_p, k_i) = result.tuned, result.tuned.velocity_gains
    travel, force, _ = result.one.units
    view = Table("loop", "K_p", "K_i", "unit", "cycles of a run", box=box.SIMPLE_HEAD)
    current, velocity = str(cycles["current_loop"]), str(cycles["velocity_loop"])
    view.add_row("current, d", f"{tuned.k_d:.5g}", f"{tuned.k_i:.5g}", "V/A, V/(A s)", current)
    view.add_row("current, q", f"{tuned.k_q:.5g}", f"{tuned.k_i:.5g}", "V/A, V/(A s)", "")
    unit = f"{force} s/{travel}, {force}/{travel}"
    view.add_row("velocity", f"{k_p:.5g}", f"{k_i:.5g}", unit, velocity)
    return view
