# SPDX-License-Identifier: Apache-2.0
"""Measure the goals of the motor drives, to build/drive.json and build/drive.html.

    python -m sim.bench.drive               what is simulated; `microtick drive` adds the hardware
    python -m sim.bench.drive loops path    only these; the file keeps the rows of the others
    python -m sim.bench.drive motor.toml    bring up the motor of that file alone, to build/motor.*

Exit status: 0 if no goal is missed, 1 if one is or the run stopped with an error, 2 wrong command
line.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from rich.console import Console

from asip_asm.command import command, script_parser
from asip_asm.model.read import ModelError
from asip_asm.project import BUILD
from sim.bench.drive import page
from sim.bench.drive.axis.command import bring_up_alone
from sim.bench.drive.goals import PARTS, PATHS, Job, Part, Rows, Shown
from sim.bench.drive.hardware import load
from sim.bench.drive.start_up import StartUpError
from sim.core.controller import ControllerFault
from sim.motion.command import add_robot_option
from sim.report.goals import begin_goals, merge_goals, missed, terminal_table
from sim.robot.parameters import ROBOT_TOML, ParameterError


@command("python -m sim.bench.drive")
def main(
    argv: Sequence[str] | None = None,
    prog: str = "python -m sim.bench.drive",
    more: Mapping[str, Part] = MappingProxyType({}),
    lacks: Callable[[], str | None] = lambda: None,
) -> int:
    """Command line; more: further producers; lacks: why it cannot, which one motor alone does not
    need to know."""
    parts = {**PARTS, **more}
    example = (
        f"{prog} --robot my_robot.toml. Without --full the command simulates the first 3 s of "
        "the A-G-H path, and 0.2 s of it clock by clock, in some minutes. With --full it simulates "
        "the whole path, and 2 s clock by clock, in an hour or two. Results of the simulation "
        "clock by clock are cached, and the rows of each producer are written when it ends."
    )
    parser = script_parser(__doc__, example, prog)
    parser.add_argument(
        "what",
        nargs="*",
        metavar="WHAT",
        help=f"file of one motor: bring it up alone; or only these: {', '.join(parts)}",
    )
    add_robot_option(parser, "drive")
    parser.add_argument(
        "--results", type=Path, help="file written (build/drive.json, or build/motor.json)"
    )
    parser.add_argument("--loops", action="store_true", help=f"leave out {', '.join(PATHS)}")
    parser.add_argument("--full", action="store_true", help="whole path, and 2 s clock by clock")
    if more:
        parser.add_argument(
            "--docs", action="store_true", help="alone: write docs/drive.md from build/drive.json"
        )
    options = parser.parse_args(argv)
    if more and options.docs:
        parser.error("--docs writes what was measured before; leave out the other words")
    console = Console()
    unknown = [word for word in options.what if word not in parts]
    if (
        unknown
        and len(options.what) == 1
        and (Path(unknown[0]).suffix or Path(unknown[0]).exists())
    ):
        if options.loops or options.full or options.robot != ROBOT_TOML:
            parser.error("one motor alone: leave out --robot, --loops and --full")
        file = Path(unknown[0])
        return bring_up_alone(file, options.results or BUILD / "motor.json", console)
    if unknown:
        parser.error(f"no {', '.join(unknown)}; there are {', '.join(parts)}, or a motor's file")
    if (wrong := lacks()) is not None:
        console.print(f"error: {wrong}", style="red", markup=False, soft_wrap=True)
        return 1
    results = options.results or BUILD / "drive.json"
    names = options.what or list(parts)
    names = [name for name in names if not (options.loops and name in PATHS)]
    try:
        robot, drives = load(options.robot)
        job = Job(robot, drives, options.full, console.print)
        goals: list[dict[str, Any]] = []
        begin(results, options.robot, everything=not options.what)
        for name in names:  # written after each: a run that is stopped loses nothing
            rows = Rows()
            fields = parts[name](job, rows)
            own = {"robot": str(options.robot.resolve())}
            goals = merge_goals(results, name, rows, list(parts), options.full, **fields, **own)
    except (ParameterError, ModelError, ControllerFault, StartUpError) as error:
        text = str(error)
        text = text if ": error: " in text else f"error: {text}"
        console.print(text, style="red", markup=False, soft_wrap=True)
        return 1
    view = terminal_table(goals)
    console.print(view)
    console.print(f"written: {results}")
    if set(job.shown) == {field.name for field in dataclasses.fields(Shown)}:
        drawn = results.with_suffix(".html")
        page.write(drawn, view, Shown(**job.shown))
        console.print(f"written: {drawn}")
    return int(bool(missed(goal for goal in goals if goal["producer"] in names)))


def begin(results: Path, robot: Path, everything: bool) -> None:
    """A run with another robot begins with no file; one of everything is whole at its end only."""
    if results.exists():
        content = json.loads(results.read_text(encoding="utf-8"))
        if content.get("robot") != str(robot.resolve()):
            results.unlink()
    if everything:
        begin_goals(results)


if __name__ == "__main__":
    sys.exit(main())
