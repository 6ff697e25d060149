# SPDX-License-Identifier: Apache-2.0
"""Two ASIPs, as RTL, follow a path in closed loop with the robot: one plans, one tracks."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from rich.console import Console

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from asip_asm.isa import default_isa
from sim.dual.moves import PathNotSuitedError, moves_of
from sim.dual.report import NOMINAL_CLOCKS, results, tables
from sim.dual.system import PROGRAMS, TwoProcessors
from sim.harness.asip_rtl import AsipError
from sim.harness.build import ROOT, BuildError
from sim.model.parameters import ParameterError, Robot
from sim.model.records import SetPoints
from sim.model.tracking import joint_path
from sim.motion.gcode import GcodeErrors, parse_file
from sim.motion.trajectory import WorkspaceError, generate
from sim.run import closed_loop
from sim.run.controller import AsipController, ControllerFault
from sim.run.nios import set_points
from sim.run.progress import TickProgress

SHORT_PERIOD = 512  # clocks: above the work of a period in every configuration
SINGLE = ROOT / "build/results.json"


def _single_core(robot: Robot, path: SetPoints, console: Console) -> dict[str, float]:
    """Tracking errors of one core that gets the planned set-points: of `make run`, or run here."""
    if SINGLE.is_file():
        data = json.loads(SINGLE.read_text(encoding="utf-8"))
        if data["ticks"] == len(path):
            return data["tracking"]["optimised"]
    controller = AsipController(assemble(PROGRAMS / "tracking_optimised.s", configuration="fast"))
    with TickProgress(console) as bars:
        bars.add("one processor", len(path))
        recording = closed_loop.run(
            robot, path, controller, lambda n: bars.advance("one processor", n)
        )
    desired = joint_path(robot, path)[0]
    return vars(closed_loop.tracking_error(robot, path, desired, recording))


def run(arguments: argparse.Namespace, console: Console) -> None:
    """The whole job; writes results.json below arguments.output."""
    robot = Robot.load()
    trajectory = generate(parse_file(arguments.gcode))
    moves = moves_of(trajectory)
    path = set_points(trajectory, arguments.ticks)
    console.print(f"{arguments.gcode}: {len(path)} ticks of 100 us, {len(moves)} moves")
    controller = TwoProcessors(
        moves, arguments.period, trajectory=arguments.trajectory, tracking=arguments.tracking
    )
    begin = time.perf_counter()
    with TickProgress(console) as bars:
        bars.add("two processors", len(path))
        recording = closed_loop.run(
            robot, path, controller, lambda n: bars.advance("two processors", n)
        )
    data = results(robot, path, recording, controller)
    data["simulation"] = {
        "clocks": controller.system.clocks,
        "wall_s": time.perf_counter() - begin,
    }
    data["tracking_single_core"] = _single_core(robot, path, console)
    out: Path = arguments.output
    out.mkdir(parents=True, exist_ok=True)
    (out / "results.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    for table in tables(data):
        console.print(table)
    console.print(f"figures: {out / 'results.json'}")


def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m sim.dual",
        description=__doc__,
        epilog="example: python -m sim.dual sim/paths/agh.ngc --ticks 2000 --period 12500",
    )
    parser.add_argument(
        "gcode", type=Path, nargs="?", default=ROOT / "sim/paths/agh.ngc", help="path (RS-274)"
    )
    parser.add_argument("--ticks", type=int, help="only the first TICKS ticks of the path")
    parser.add_argument(
        "--period",
        type=int,
        default=SHORT_PERIOD,
        metavar="CLOCKS",
        help=f"clocks of a simulated period, %(default)s leave out idle clocks of {NOMINAL_CLOCKS}",
    )
    for core in ("trajectory", "tracking"):
        parser.add_argument(
            f"--{core}",
            choices=sorted(default_isa().configurations),
            default="fast",
            help=f"configuration of the {core} core (%(default)s)",
        )
    parser.add_argument(
        "--output", type=Path, default=ROOT / "build/dual", help="folder of results.json"
    )
    arguments = parser.parse_args(argv)
    if arguments.ticks is not None and arguments.ticks < 1:
        parser.error(f"--ticks {arguments.ticks} is not positive")
    if not 0 < arguments.period < 1 << 16:
        parser.error(f"--period {arguments.period} is not in 1..65535")
    console = Console()
    try:
        run(arguments, console)
    except (GcodeErrors, WorkspaceError, ParameterError, AssemblyError) as error:
        console.print(str(error), markup=False, highlight=False)
        return 1
    except PathNotSuitedError as error:
        console.print(f"{arguments.gcode}: {error}", markup=False, highlight=False)
        return 1
    except (BuildError, ControllerFault, AsipError, OSError) as error:
        console.print(f"error: {error}", markup=False, highlight=False)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
