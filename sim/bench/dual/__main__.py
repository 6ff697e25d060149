# SPDX-License-Identifier: Apache-2.0
"""Two ASIPs, as RTL, follow a path in closed loop with the robot: one plans, one tracks."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from asip_asm.command import command, command_parser
from asip_asm.diagnostics import AssemblyError
from asip_asm.isa import IsaError, default_isa
from asip_asm.project import BUILD
from sim.bench.dual.loop import Loop, follow, stretches_of
from sim.bench.dual.moves import PathNotSuitedError, moves_of
from sim.bench.dual.report import (
    LONGEST_PERIOD,
    PageError,
    nominal_clocks,
    publish,
    results,
    tables,
    write,
)
from sim.bench.dual.system import TwoProcessors, program
from sim.bench.run.progress import TickProgress
from sim.core import closed_loop
from sim.core.controller import AsipController, ControllerFault
from sim.motion.command import add_override_option, add_robot_option
from sim.motion.gcode.interpreter import GcodeErrors, parse_file
from sim.motion.geometry.override import overridden_program
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.exact_stop import MotionSettings, WorkspaceError, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.report.marks import MarksError
from sim.robot.parameters import ParameterError, Robot
from sim.robot.records import SetPoints
from sim.robot.tracking import joint_path
from sim.rtl.asip_rtl import AsipError
from sim.rtl.build import BuildError

EPILOG = """\
examples:
  python -m sim.bench.dual sim/paths/agh.ngc --ticks 2000 --period 12500
  python -m sim.bench.dual --short-only
  python -m sim.bench.dual --docs

Both ends of the path and its corners are repeated with the clocks of a control period from the same
state. The run stops if any bit of words, commands, counts or positions differs. results.json is
written during the run; a stopped run records there how far it got."""

SHORT_PERIOD = 512  # clocks: above the work of a period in every configuration
SAVE_TICKS = 10_000  # between two partial results
SINGLE = BUILD / "results.json"


def _single_core(robot: Robot, path: SetPoints, console: Console) -> dict[str, float]:
    """Tracking errors of one core that gets the planned set-points: of `make run`, or run here."""
    if SINGLE.is_file():
        data = json.loads(SINGLE.read_text(encoding="utf-8"))
        same = data["ticks"] == len(path) and data.get("robot", {}).get("values") == robot.values()
        if same and "optimised" in data["tracking"]:
            return data["tracking"]["optimised"]
    controller = AsipController(program("tracking_optimised", "fast", robot), intermediates=False)
    with TickProgress(console) as bars:
        progress = bars.add("one processor", len(path))
        recording = closed_loop.run(robot, path, controller, progress)
    desired = joint_path(robot, path)[0]
    return vars(closed_loop.tracking_error(robot, path, desired, recording))


def _one_core(loop: Loop, alone: AsipController, console: Console) -> dict[str, int]:
    """One core alone, given the words handed over and the counts seen: how many answers are equal.

    Its program keeps states, so that a set-point that came a period early or late would show.
    """
    rows = loop.ticks[: loop.done]
    path = SetPoints.from_words(rows["set_point"])
    with TickProgress(console) as bars:
        progress = bars.add("same words, one processor", len(rows))
        answers = closed_loop.replay(path, rows["counts"], alone, progress)
    same = answers.outputs.view(np.uint32) == rows["period"]["commands"]
    return {"ticks": len(rows), "ticks_equal": int(same.all(axis=1).sum())}


def run(arguments: argparse.Namespace, console: Console) -> None:
    """The whole job; writes results.json below arguments.output as it goes.

    Raises ControllerFault, KeyboardInterrupt: the results are those up to there.
    """
    robot = Robot.load(arguments.robot)
    nominal = nominal_clocks(robot)
    settings = MotionSettings(robot)
    highest = MachineLimits.of(robot).tool.speed
    asked = parse_file(arguments.gcode, robot=robot)
    moves_asked = overridden_program(asked, arguments.override, highest)
    trajectory = generate(moves_asked, settings)
    moves = moves_of(trajectory, settings)
    path = set_points(trajectory, arguments.ticks)
    desired = joint_path(robot, path)[0]
    stretches = []
    if not arguments.short_only and arguments.period != nominal:
        every = range(0, len(path), arguments.every or len(path))
        stretches = stretches_of([*trajectory.first_ticks, *every], len(path))
    console.print(
        f"{arguments.gcode}: {len(path)} ticks of {robot.T_s * 1e6:g} us, {len(moves)} moves; "
        f"{arguments.period} clocks a period; feed override {arguments.override:g} %"
    )
    controller = TwoProcessors(
        robot, moves, arguments.period, trajectory=arguments.trajectory, tracking=arguments.tracking
    )
    # Made here: a source that changes during a long run shall not end it.
    image = program("tracking_optimised", arguments.tracking, robot)
    alone = AsipController(image, intermediates=False)
    begin = time.perf_counter()
    file: Path = arguments.output / "results.json"
    repeated: list[range] = []
    loop = Loop(robot, path, controller)

    def figures() -> dict[str, Any]:
        data = {
            "path": arguments.gcode.name,
            "feed_override_percent": arguments.override,
            "whole_path": len(path) == len(set_points(trajectory, None)),
        }
        data |= results(robot, path, desired, loop, repeated)
        data["simulation"] = {
            "clocks": controller.system.clocks,
            "wall_s": time.perf_counter() - begin,
        }
        return data

    saved = 0

    def save(done: list[range]) -> None:
        nonlocal saved
        repeated[:] = done
        if loop.done - saved >= SAVE_TICKS:
            write(file, figures())
            saved = loop.done

    try:
        with TickProgress(console) as bars:
            progress = {"path": bars.add("two processors", len(path))}
            if stretches:
                ticks = sum(map(len, stretches))
                progress["repeat"] = bars.add(f"{nominal} clocks a period", ticks)
            follow(loop, stretches, nominal, lambda name, n: progress[name](n), save)
    except (ControllerFault, AsipError, KeyboardInterrupt) as stop:
        if loop.done:
            cause = str(stop) or "interrupted"
            write(file, {"path": arguments.gcode.name, **_so_far(figures, loop), "stopped": cause})
            console.print(f"stopped after {loop.done} of {len(path)} ticks; so far: {file}")
        raise
    data = figures()
    write(file, data)
    data["one_core"] = _one_core(loop, alone, console)
    if data["tracking"]:
        data["tracking_single_core"] = _single_core(robot, path, console)
    write(file, data)
    for table in tables(data):
        console.print(table)
    console.print(f"figures: {file}")


def _so_far(figures: Callable[[], dict[str, Any]], loop: Loop) -> dict[str, Any]:
    """The figures up to a stop; after a fault the registers may say more than the ticks done."""
    try:
        return figures()
    except (ControllerFault, AsipError):
        return {
            "complete": False,
            "ticks": len(loop.ticks),
            "ticks_done": loop.done,
            "flags": loop.controller.system.flags(),
        }


@command("python -m sim.bench.dual")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = command_parser("python -m sim.bench.dual", __doc__, EPILOG)
    parser.add_argument(
        "gcode", type=Path, nargs="?", default=AGH, help="path, G-code (sim/paths/agh.ngc)"
    )
    add_robot_option(parser, "dual")
    add_override_option(parser)
    parser.add_argument("--ticks", type=int, help="only the first TICKS ticks of the path")
    parser.add_argument(
        "--period",
        type=int,
        default=SHORT_PERIOD,
        metavar="CLOCKS",
        help="clocks of a period, written to the register of the period timer (%(default)s); those "
        "of 100 us are 12500, and nearly all of them are idle",
    )
    parser.add_argument(
        "--short-only",
        action="store_true",
        help="without the repetition of parts with whole control periods",
    )
    for core in ("trajectory", "tracking"):
        parser.add_argument(
            f"--{core}",
            choices=sorted(default_isa().configurations),
            default="fast",
            help=f"configuration of the {core} core (%(default)s)",
        )
    parser.add_argument(
        "--output", type=Path, default=BUILD / "dual", help="folder of results.json"
    )
    parser.add_argument(
        "--every",
        type=int,
        metavar="N",
        help="also repeat the ticks around every N-th tick",
    )
    parser.add_argument(
        "--docs",
        action="store_true",
        help="without a simulation, write docs/two_processors.md from the last run of the whole "
        "path",
    )
    arguments = parser.parse_args(argv)
    for name in ("ticks", "every"):
        value = getattr(arguments, name)
        if value is not None and value < 1:
            parser.error(f"--{name} {value} is not positive")
    if not 0 < arguments.period <= LONGEST_PERIOD:
        parser.error(f"--period {arguments.period} is not in 1..{LONGEST_PERIOD}")
    console = Console()
    try:
        if arguments.docs:
            publish(arguments.output / "results.json")
        else:
            run(arguments, console)
    except KeyboardInterrupt:
        return 130
    except PathNotSuitedError as error:
        text = f"{arguments.gcode}: {error}"
    except (GcodeErrors, WorkspaceError, ParameterError, AssemblyError, PageError, MarksError) as e:
        text = str(e)
    except (BuildError, ControllerFault, AsipError, IsaError) as error:
        text = f"error: {error}"
    else:
        return 0
    console.print(text, markup=False, highlight=False)
    return 1


if __name__ == "__main__":
    sys.exit(main())
