# SPDX-License-Identifier: Apache-2.0
"""Measure the goals of the motor drives, to build/drive.json and build/drive.html.

    python -m sim.bench.drive               what is simulated; `microtick drive` adds the hardware
    python -m sim.bench.drive motor.toml    bring up the motor of that file alone, to build/motor.*

Exit status: 0 if no goal is missed, 1 if one is or the run stopped with an error, 2 wrong command
line.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from asip_asm.command import command, script_parser
from asip_asm.model.read import ModelError
from asip_asm.project import BUILD
from sim.bench.drive import page
from sim.bench.drive.axis.command import bring_up_alone
from sim.bench.drive.delays import delays
from sim.bench.drive.goals import Rows, measure, measure_loops
from sim.bench.drive.hardware import load
from sim.bench.drive.position import SHOWN
from sim.bench.drive.start_up import StartUpError
from sim.core.controller import ControllerFault
from sim.motion.command import add_robot_option
from sim.report.goals import as_json, missed, terminal_table, write_goals
from sim.robot.drives import Drives
from sim.robot.parameters import ROBOT_TOML, ParameterError, Robot

More = Callable[[Robot, Drives, bool, Rows, Callable[[str], None]], dict]


@command("python -m sim.bench.drive")
def main(
    argv: Sequence[str] | None = None,
    prog: str = "python -m sim.bench.drive",
    more: More = lambda robot, drives, full, rows, report: {},
    lacks: Callable[[], str | None] = lambda: None,
) -> int:
    """Command line; more: adds further rows, and returns what else the file shall have; lacks: why
    it cannot, which one motor alone does not need to know."""
    example = (
        f"{prog} --robot my_robot.toml. Without --full the command simulates the first 3 s of "
        "the A-G-H path, and 0.2 s of it clock by clock, in some minutes. With --full it simulates "
        "the whole path, and 2 s clock by clock, in an hour. Results of the simulation clock by "
        "clock are cached, so a full run that was stopped continues."
    )
    parser = script_parser(__doc__, example, prog)
    parser.add_argument(
        "motor", nargs="?", type=Path, metavar="MOTOR", help="file of one motor: bring it up alone"
    )
    add_robot_option(parser, "drive")
    parser.add_argument(
        "--results", type=Path, help="file written (build/drive.json, or build/motor.json)"
    )
    parser.add_argument(
        "--loops", action="store_true", help="only current loops and blocks, 4 minutes"
    )
    parser.add_argument("--full", action="store_true", help="whole path, and 2 s clock by clock")
    options = parser.parse_args(argv)
    console = Console()
    if options.motor is not None:
        if options.loops or options.full or options.robot != ROBOT_TOML:
            parser.error("one motor alone: leave out --robot, --loops and --full")
        return bring_up_alone(options.motor, options.results or BUILD / "motor.json", console)
    if (wrong := lacks()) is not None:
        console.print(f"error: {wrong}", style="red", markup=False, soft_wrap=True)
        return 1
    results = options.results or BUILD / "drive.json"
    try:
        robot, drives = load(options.robot)
        rows, shown = Rows(), None
        if options.loops:
            measure_loops(robot, drives, rows, console.print)
        else:
            shown = measure(robot, drives, options.full, rows, console.print)
        further = more(robot, drives, options.full, rows, console.print)
        late = delays(robot, drives)
    except (ParameterError, ModelError, ControllerFault, StartUpError) as error:
        text = str(error)
        text = text if ": error: " in text else f"error: {text}"
        console.print(text, style="red", markup=False, soft_wrap=True)
        return 1
    whole = options.full and options.robot.resolve() == ROBOT_TOML.resolve()
    goals = as_json(rows)
    document = {"delays": late, "whole": whole} | further
    if shown is not None:
        names = (page.NAMES[n] for n in SHOWN)
        document["position_loops"] = dict(zip(names, shown.positions.bandwidth, strict=True))
    write_goals(results, goals, **document)
    view = terminal_table(goals)
    console.print(view)
    console.print(f"written: {results}")
    if shown is not None:
        drawn = results.with_suffix(".html")
        page.write(drawn, view, shown)
        console.print(f"written: {drawn}")
    return int(bool(missed(goals)))


if __name__ == "__main__":
    sys.exit(main())
