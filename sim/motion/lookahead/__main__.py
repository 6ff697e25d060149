# SPDX-License-Identifier: Apache-2.0
"""Command line of the look-ahead planner: path time, corner deviations, limits reached."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser
from asip_asm.files import open_output, refuse_overwriting
from sim.motion.command import (
    add_line_option,
    add_override_option,
    add_robot_option,
    failed,
    interruptible,
    output,
    require_positive,
)
from sim.motion.gcode.interpreter import stream_file
from sim.motion.gcode.tools import NO_TOOLS, Tool, add_tools_option, tools_of
from sim.motion.geometry.moves import from_line
from sim.motion.geometry.override import AS_PROGRAMMED, overridden
from sim.motion.lookahead.check import GROUPS, QUANTITIES, demand
from sim.motion.lookahead.joints import SlowestJoints
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.planner.optimal import Limits
from sim.robot.parameters import Robot

EPILOG = """examples:
  python -m sim.motion.lookahead sim/paths/agh.ngc
  python -m sim.motion.lookahead part.ngc --tool 250 4800 1e6 --json build/motion/part.json
  python -m sim.motion.lookahead part.ngc --steps --time-only
  python -m sim.motion.lookahead --figures build/motion

G61 (the start) stops at every corner; G64 P0.01 in the program rounds corners within 0.01 mm.
exit status: 0 done, 1 the program has mistakes, leaves the workspace or cannot be read, or a limit
is exceeded, 2 wrong command line
"""
UNITS = {"tool": ("mm", 1e3), "leg": ("mm", 1e3), "table": ("degree", math.degrees(1.0))}
NAMES = {"tool": "tool", "leg": "legs", "table": "table axes"}
LOGGED = 100.0  # seconds of motion between two lines of progress in a log
Part = TypeVar("Part")


def _arguments() -> argparse.ArgumentParser:
    parser = command_parser(
        "python -m sim.motion.lookahead",
        "Plan a G-code program with look-ahead and blended corners, sample it at every "
        "control period and check tool and joints against their limits.",
        EPILOG,
    )
    parser.add_argument("file", nargs="?", type=Path, help="program")
    add_robot_option(parser, "lookahead")
    add_tools_option(parser)
    add_override_option(parser)
    add_line_option(parser)
    metavar = ("SPEED", "ACCELERATION", "JERK")
    for group, text in (
        ("tool", "limits of the tool [mm/s, mm/s2, mm/s3]"),
        ("leg", "limits of each leg [mm/s, mm/s2, mm/s3]"),
        ("table", "limits of each table axis [degree/s, degree/s2, degree/s3]"),
    ):
        parser.add_argument(f"--{group}", nargs=3, type=float, metavar=metavar, help=text)
    parser.add_argument("--rapid", type=float, metavar="SPEED", help="of G0 [mm/s]")
    parser.add_argument("--steps", action="store_true", help="no limit of jerk")
    parser.add_argument("--depth", type=int, metavar="MOVES", help="least depth of the look-ahead")
    parser.add_argument("--time-only", action="store_true", help="plan only, without set-points")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the results")
    parser.add_argument(
        "--figures", type=Path, metavar="FOLDER", help="draw the CNC paper's figures 4-6"
    )
    return parser


def _unit(group: str, order: int) -> str:
    """Unit of a group's speed (order 1), acceleration (2), jerk (3)."""
    return f"{UNITS[group][0]}/s{order if order > 1 else ''}"


def settings_of(arguments: argparse.Namespace) -> LookaheadSettings:
    """Settings of the command line; raises ValueError naming a value outside its limit."""
    robot = Robot.load(arguments.robot)
    limits: dict[str, Any] = {}
    for group, (_, factor) in UNITS.items():
        values = getattr(arguments, group)
        if values is not None:
            for order, (name, value) in enumerate(zip(QUANTITIES, values, strict=True), start=1):
                require_positive(f"{name} of --{group}", value, _unit(group, order))
            limits[group] = Limits(*(value / factor for value in values))
    of_robot = MachineLimits.of(robot, jerk_limited=not arguments.steps)
    more: dict[str, Any] = {"robot": robot, "limits": replace(of_robot, **limits)}
    if arguments.rapid is not None:
        require_positive("--rapid", arguments.rapid, "mm/s")
        more["rapid"] = arguments.rapid / 1e3
    if arguments.depth is not None:
        more["depth"] = arguments.depth
    return LookaheadSettings(**more)


def results(
    file: Path,
    settings: LookaheadSettings,
    sampled: bool,
    console: Console | None = None,
    tools: Mapping[int, Tool] = NO_TOOLS,
    override: float = AS_PROGRAMMED,
    line: int = 0,
) -> dict[str, Any]:
    """What the command prints, as one document; lengths in mm, angles in degrees.

    console: for progress, by default none; tools: as for `stream_file`; override [percent]; line:
    where the path begins.
    """
    console = console or Console(quiet=True)
    joints = SlowestJoints()
    items = stream_file(file, tools=tools, robot=settings.robot)
    items = overridden(from_line(items, line, str(file)) if line else items, override)
    plan = Lookahead(items, settings, joints, str(file))
    document: dict[str, Any] = {"file": str(file), "feed override [%]": override}
    if sampled:
        period = settings.period
        points = _watched(plan.setpoints(), plan, lambda part: len(part) * period, console)
        found = demand(points, settings.robot, period)
        ratios = found.ratios(settings.limits)
        document["ticks"] = found.ticks
        document["limits"] = [
            {
                "what": group,
                "quantity": quantity,
                "unit": _unit(group, order),
                "reached": found.greatest[group, quantity] * UNITS[group][1],
                "limit": getattr(getattr(settings.limits, group), quantity) * UNITS[group][1],
                "ratio": ratios[group, quantity],
                "line": found.lines.get((group, quantity)),
            }
            for group in GROUPS
            for order, quantity in enumerate(QUANTITIES, start=1)
            if quantity != "jerk" or settings.limits.jerk_limited
        ]
    else:
        for _ in _watched(plan.stretches(), plan, lambda part: part.duration, console):
            pass
    summary = plan.summary
    document |= {
        "time [s]": float(summary.duration),
        "moves": summary.moves,
        "blended corners": summary.blends,
        "turned corners": summary.turns,
        "smooth joints": summary.smooth,
        "stops inside": summary.stops,
        "slowest corners": [
            {
                "line": joint.line,
                "angle [degree]": math.degrees(joint.angle),
                "P [mm]": joint.tolerance * 1e3 if math.isfinite(joint.tolerance) else None,
                "apex [mm]": joint.apex * 1e3,
                "speed [mm/s]": joint.speed * 1e3,
            }
            for joint in joints
        ],
    }
    return document


def _watched(
    stream: Iterable[Part], plan: Lookahead, seconds: Callable[[Part], float], console: Console
) -> Iterator[Part]:
    """The stream, with a line of progress that a terminal keeps up to date and a log repeats.

    seconds: of motion in a part of the stream.
    """
    done = 0.0
    with console.status("planning") as status:
        for part in stream:
            before, done = done, done + seconds(part)
            text = f"{plan.summary.moves} moves read, {done:.1f} s of motion"
            status.update(text)
            if not console.is_terminal and done // LOGGED > before // LOGGED:
                console.print(text)
            yield part


def _show(document: dict[str, Any], console: Console) -> None:
    percent = document["feed override [%]"]
    console.print(
        f"{document['file']}: {document['time [s]']:.4f} s, {document['moves']} moves, "
        f"{document['blended corners']} blended corners, {document['turned corners']} turned, "
        f"{document['smooth joints']} smooth joints, "
        f"{document['stops inside']} stops"
        + (f", feed override {percent:g} %" if percent != AS_PROGRAMMED else "")
    )
    corners = document["slowest corners"]
    if corners:
        count = document["blended corners"] + document["turned corners"]
        table = Table(title=f"slowest corners, {len(corners)} of {count}")
        for name in corners[0]:
            table.add_column(name, justify="right")
        for corner in corners:
            table.add_row(
                *("none" if value is None else f"{value:.6g}" for value in corner.values())
            )
        console.print(table)
    if "limits" in document:
        table = Table(title=f"limits reached, {document['ticks']} set-points")
        for name in ("what", "quantity", "reached", "limit", "ratio", "line"):
            table.add_column(name, justify="left" if name in ("what", "quantity") else "right")
        for row in document["limits"]:
            table.add_row(
                NAMES[row["what"]],
                f"{row['quantity']} [{row['unit']}]",
                f"{row['reached']:.6g}",
                f"{row['limit']:.6g}",
                f"{row['ratio']:.4f}",
                str(row["line"] or ""),
            )
        console.print(table)


@command("python -m sim.motion.lookahead")
def main(argv: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = _arguments()
    arguments = parser.parse_args(argv)
    if arguments.file is None and arguments.figures is None:
        parser.error("nothing to do: give a program or --figures")
    console, log = output(), output(stderr=True)
    status = 0
    try:
        if arguments.json is not None:
            inputs = (arguments.file, arguments.robot, arguments.tools)
            refuse_overwriting([arguments.json], [path for path in inputs if path])
        if arguments.figures is not None:
            from sim.motion.lookahead.figures import figures

            console.print_json(json.dumps(figures(arguments.figures)))
        if arguments.file is not None:
            settings, sampled = settings_of(arguments), not arguments.time_only
            tools = tools_of(arguments)
            percent = arguments.override
            document = results(
                arguments.file, settings, sampled, log, tools, percent, arguments.line or 0
            )
            _show(document, console)
            if arguments.json is not None:
                arguments.json.parent.mkdir(parents=True, exist_ok=True)
                text = json.dumps(document, indent=2) + "\n"
                with open_output(arguments.json) as file:
                    file.write(text)
            status = int(any(row["ratio"] > 1.001 for row in document.get("limits", ())))
    except ValueError as error:
        return failed(parser.prog, error)
    return status


if __name__ == "__main__":
    sys.exit(interruptible(main))
