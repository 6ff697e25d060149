# SPDX-License-Identifier: Apache-2.0
"""The main job: the ASIP, as RTL, tracks a G-code path in closed loop with the robot."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from types import FrameType

from rich.console import Console

from asip_asm.command import INTERRUPTED, cause_of, command_parser, count
from asip_asm.diagnostics import AssemblyError
from asip_asm.project import BUILD
from sim.bench.run.estimate import PLATFORMS
from sim.bench.run.job import Order, PathError, run
from sim.bench.run.workers import WorkerLost
from sim.core.controller import ControllerFault
from sim.motion.command import (
    add_line_option,
    add_override_option,
    add_robot_option,
    seconds_between,
)
from sim.motion.gcode.tools import add_tools_option
from sim.motion.trajectory.program import AGH
from sim.robot.observer import SPEEDS
from sim.robot.parameters import ParameterError
from sim.rtl.build import BuildError
from sim.rtl.nios_image import ImageError

EXCEEDED, TERMINATED = 3, 143

EPILOG = """examples:
  python -m sim.bench.run sim/paths/circle.ngc --output build/circle
  python -m sim.bench.run part.ngc --plan-only
  python -m sim.bench.run part.ngc --platforms fpga3 --ticks 20000
  python -m sim.bench.run part.ngc --from 4200 --seconds 10:25

G61 and G64 P in the program are planned with look-ahead (G64 P0.01 rounds corners within 0.01 mm);
G61.1 stops exactly at the end of every move, with an S-curve of set times.
Of a path of more than 150 s every tick is planned, and windows of it are simulated: both ends, some
at equal distances, and the hardest moments that the plan has found. --seconds takes one of yours.

exit status: 0 done, 1 the program, the robot file or a tool has an error, 2 wrong command line,
3 done, but an error exceeds its bound, 130 interrupted, 143 terminated
"""


class _Terminated(BaseException):
    """SIGTERM has come."""


def _terminate(number: int, frame: FrameType | None) -> None:
    raise _Terminated


def _platforms(text: str) -> tuple[str, ...]:
    """Platforms of a list such as fpga1,fpga3; in their own order, without repeats."""
    names = [name.strip().lower() for name in text.replace(",", " ").split()]
    for name in names:
        if name not in PLATFORMS:
            raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(PLATFORMS)}")
    if not names:
        raise argparse.ArgumentTypeError(f"no platform; expected some of {', '.join(PLATFORMS)}")
    return tuple(name for name in PLATFORMS if name in names)


def _arguments() -> argparse.ArgumentParser:
    parser = command_parser("python -m sim.bench.run", __doc__, EPILOG)
    parser.add_argument(
        "gcode",
        type=Path,
        nargs="?",
        default=AGH,
        help="path, G-code (sim/paths/agh.ngc)",
    )
    add_robot_option(parser, "run")
    add_tools_option(parser)
    add_override_option(parser)
    add_line_option(parser)
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--ticks", type=count, help="only the first TICKS ticks of the path")
    part.add_argument(
        "--seconds",
        type=seconds_between,
        metavar="A:B",
        help="only the motion from A to B seconds after its start; the machine runs in before it",
    )
    parser.add_argument(
        "--platforms",
        type=_platforms,
        default=PLATFORMS,
        metavar="LIST",
        help="some of fpga1,fpga2,fpga3 (all)",
    )
    parser.add_argument(
        "--all-ticks", action="store_true", help="FPGA1 and FPGA2 take every tick too (hours)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=BUILD,
        metavar="FOLDER",
        help="for results.json and index.html (build)",
    )
    parser.add_argument(
        "--plan-only",
        action="store_true",
        help="print path time, ticks and estimated time of the run, and stop",
    )
    parser.add_argument(
        "--speed",
        choices=SPEEDS,
        default=SPEEDS[0],
        help="observer, stamps: also run the program that takes speeds from observers or from the "
        "time between counts, and show it first (difference)",
    )
    parser.add_argument(
        "--scope",
        action="store_true",
        help="show the loop of the optimised program, or of that of --speed, in the browser while "
        "it runs",
    )
    parser.add_argument(
        "--no-plots", dest="plots", action="store_false", help="tables and results.json only"
    )
    return parser


def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    order = Order(**vars(_arguments().parse_args(argv)))
    console, errors = Console(), Console(stderr=True, soft_wrap=True)

    def stopped(text: str, status: int = 1) -> int:
        errors.print(text, markup=False, highlight=False)
        return status

    before = signal.signal(signal.SIGTERM, _terminate)
    try:
        data = run(order, console)
    except OSError as error:
        return stopped(f"error: {cause_of(error)}")
    except (PathError, ParameterError, AssemblyError, ImageError) as error:
        text = str(error)
        return stopped(text if ": error: " in text else f"error: {text}")
    except (BuildError, ControllerFault, WorkerLost) as error:
        return stopped(f"error: {error}")
    except MemoryError:
        return stopped("error: no memory left; take fewer ticks (--ticks)")
    except KeyboardInterrupt:
        return stopped("interrupted", INTERRUPTED)
    except _Terminated:
        return stopped("terminated", TERMINATED)
    finally:
        signal.signal(signal.SIGTERM, before)
    return 0 if data.get("bounds_ok", True) else EXCEEDED


if __name__ == "__main__":
    sys.exit(main())
