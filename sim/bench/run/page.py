# SPDX-License-Identifier: Apache-2.0
"""The page of the main job: what ran, the path, errors and forces to zoom into, every table."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from sim.bench.run import figures
from sim.bench.run.checks import timing_of_programs
from sim.core.closed_loop import SETTLED_S, Recording
from sim.report import provenance
from sim.report.document import Page
from sim.robot.parameters import ROBOT_TOML, Robot
from sim.robot.records import SetPoints

TITLE = "Microtick: a five-axis robot under floating-point control, tick by tick"
LEAD = (
    "A robot with three legs and a tilting, turning table follows the program below. At every tick "
    "of the control period a processor, simulated clock by clock from its hardware description, "
    "reads the encoders and computes the five forces and torques; a model of the robot's mechanics "
    "answers. This page shows how exactly the robot followed, and how long the processor needed."
)
MOST_TEXT = 200_000  # characters of the program that are shown


@dataclass(frozen=True)
class Shown:
    """What a page shows: N ticks of a program.

    gcode, robot_file: files that were read; desired (N, 5): joints that the path wants; drawing
    (N,): ticks of feed moves; recordings: closed loops by name of their program, the one to show
    first, none if no program ran over the whole path; results: as in results.json.
    """

    gcode: Path
    robot: Robot
    path: SetPoints
    desired: NDArray[np.float64]
    drawing: NDArray[np.bool_]
    recordings: Mapping[str, Recording]
    results: Mapping[str, Any]
    tables: Sequence[Table]
    robot_file: Path = ROBOT_TOML


def write(out: Path, shown: Shown) -> None:
    """Write out/index.html, and the pictures path.png, tracking_errors.png and forces.png."""
    first = next(iter(shown.recordings.values()), None)
    if first is not None:
        from sim.bench.run import plots  # here: Matplotlib is half a second of every command

        plots.tool_path(shown.robot, shown.path, first, shown.drawing, out / "path.png")
        plots.errors(shown.robot, shown.desired, first, out / "tracking_errors.png")
        plots.forces(shown.robot, first, out / "forces.png")
    page = Page(TITLE, LEAD)
    exceeded = shown.results.get("exceeded", [])
    if exceeded:
        page.alarm("Beyond their bounds in this run:", [entry["text"] for entry in exceeded])
    page.key_figures(_key_figures(shown))
    _what_ran(page, shown)
    _figures(page, shown)
    page.section("Tables", "The figures of this run next to those of the paper.")
    for table in shown.tables:
        page.table(table)
    page.write(out / "index.html")


def _key_figures(shown: Shown) -> dict[str, str]:
    found = {}
    for name, recording in list(shown.recordings.items())[:1]:
        error = figures.tool_error(shown.robot, shown.path, recording).max()
        found[f"largest distance of the tool from its path ({name})"] = f"{error:.2f} µm"
    period = shown.robot.T_s * 1e6
    for name, timing in timing_of_programs(shown.results).items():
        found[f"longest tick of {name}; the control period is {period:g} µs"] = (
            f"{timing['time_us']:.3f} µs"
        )
    if "bounds_ok" in shown.results:
        beyond = len(shown.results.get("exceeded", []))
        found["comparisons beyond their bound"] = str(beyond) if beyond else "none"
    return found


def _what_ran(page: Page, shown: Shown) -> None:
    ticks = len(shown.path)
    period = shown.robot.T_s
    page.section("What ran")
    facts = {
        "program": _named(shown.gcode),
        "path time": f"{shown.results.get('path_time_s', (ticks - 1) * period):.2f} s",
        "feed override": f"{shown.results.get('feed_override_percent', 100):g} %",
        "ticks": f"{ticks} of {period * 1e6:g} µs, the rest before the first move included",
        "robot": _named(shown.robot_file),
        "processors": ", ".join(timing_of_programs(shown.results)),
        "date": provenance.now(),
        "commit": provenance.commit(),
    }
    facts |= _path_facts(shown.results.get("path", {}))
    simulation = shown.results.get("simulation", {})
    if simulation.get("cycles"):
        facts["simulated"] = (
            f"{simulation['cycles']:,} clock cycles in {simulation['wall_s']:.0f} s"
        )
    page.facts(facts)
    with shown.gcode.open(encoding="utf-8", errors="replace") as file:
        text = file.read(MOST_TEXT)
        text += "\n(cut here)" if file.read(1) else ""
    page.text(f"The program, {shown.gcode.name} (G-code)", text)
    page.folded(f"The robot, {shown.robot_file.name}", _robot_table(shown.robot_file))


def _path_facts(path: Mapping[str, Any]) -> dict[str, str]:
    """What became of the corners, and what the speed was limited by, from results.json."""
    if not path:
        return {}
    limits = [f"{name} {share:.0%}" for name, share in path["speed_limited_by"].items()]
    return {
        "moves": f"{path['moves']}; between them {path['corners_rounded']} corners rounded, "
        f"{path['joints_smooth']} smooth, {path['stops']} stops; {path['rests_s']:g} s of rests",
        "speed limited by": ", ".join(limits[:4]) + " of the time" if limits else "nothing",
    }


def _named(file: Path) -> str:
    """The file's path, relative to the repository if it is in it."""
    file = file.resolve()
    return str(file.relative_to(provenance.ROOT) if file.is_relative_to(provenance.ROOT) else file)


def _robot_table(file: Path) -> Table:
    table = Table(title="Parameters of robot, controller and plant")
    table.add_column("name")
    table.add_column("value", justify="right")
    table.add_column("unit", justify="left")
    table.add_column("meaning", justify="left")
    for name, entry in tomllib.loads(file.read_text(encoding="utf-8")).items():
        table.add_row(name, f"{entry['value']:g}", entry["unit"], entry["meaning"])
    return table


def _figures(page: Page, shown: Shown) -> None:
    robot, path = shown.robot, shown.path
    first = next(iter(shown.recordings.values()), None)
    page.section(
        "The path",
        "Drag to turn, scroll or pinch to zoom, point at the line to read place, time and value.",
    )
    page.figure(
        figures.tool_path(robot, path, shown.drawing, first),
        "The way of the tool in space, in millimetres that are equally long along x, y and z. "
        "Thick: moves at the programmed feed; thin: rapid moves. The buttons choose what the "
        "colour means; a diamond marks its largest value.",
        square=True,
    )
    page.figure(
        figures.axes(robot, path),
        "Where the program wants the tool (x, y, z) and the two table axes, over time.",
    )
    if first is None:
        return
    name = next(iter(shown.recordings))
    others = ", ".join(list(shown.recordings)[1:])
    more = f" Click “{others}” in the legend to see it too." if others else ""
    page.section(
        "How exactly the robot followed",
        "Drag a rectangle to zoom, double-click to see everything again. The curves are thinned "
        "out, but the smallest and largest value of every interval stay.",
    )
    page.figure(
        figures.errors(robot, path, shown.desired, shown.recordings),
        f"Tracking errors with the program “{name}”: distance of the tool from where it should be "
        "at that moment, and of every axis its desired minus its true position, from "
        f"{SETTLED_S * 1e3:g} ms on, when the loop has settled. Where an axis reverses, friction "
        f"changes its sign and the error has a peak.{more}",
    )
    page.figure(
        figures.histogram(robot, path, shown.desired, first),
        f"How many ticks had an error of which size (program “{name}”). The scale is logarithmic, "
        "so that a single tick shows.",
    )
    page.figure(
        figures.forces(robot, path, shown.recordings),
        "Forces of the legs and torques of the table axes as the processor commands them. Their "
        f"limits: {robot.F_max:g} N, {robot.tau_max_4:g} N·m (tilt), {robot.tau_max_5:g} N·m "
        "(rotation). The width of the bands comes from the encoders: one step of theirs is a step "
        f"of the measured speed, and so of the force.{more}",
    )
