# SPDX-License-Identifier: Apache-2.0
"""What command lines share: robot, override, output, errors."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from asip_asm.command import INTERRUPTED, count
from sim.motion.geometry.override import AS_PROGRAMMED, MOST_PERCENT
from sim.robot.parameter_uses import UNUSED
from sim.robot.parameters import ROBOT_TOML

WIDE = 1000  # columns where nobody looks at a terminal: nothing is wrapped or cut
LEAST_WIDTH = 100  # least width of tables on a terminal


def output(stderr: bool = False) -> Console:
    """Where a command prints: text as it is, [#1] too; not wrapped where it goes into a file."""
    console = Console(stderr=stderr, markup=False, highlight=False)
    console.width = max(console.width, LEAST_WIDTH) if console.is_terminal else WIDE
    return console


def add_robot_option(parser: argparse.ArgumentParser, command: str) -> None:
    """--robot FILE, for `Robot.load(arguments.robot)`; command: a key of `UNUSED`."""
    parser.add_argument(
        "--robot",
        type=Path,
        default=ROBOT_TOML,
        metavar="FILE",
        help=f"parameters of robot and controller (sim/robot.toml); this command does not use "
        f"{len(UNUSED[command])} of them: last column of docs/robot_parameters.md",
    )


def add_override_option(parser: argparse.ArgumentParser) -> None:
    """--override PERCENT, of the feeds."""
    parser.add_argument(
        "--override",
        type=_percent,
        default=AS_PROGRAMMED,
        metavar="PERCENT",
        help=f"feed override, at most {MOST_PERCENT:g}: scales feeds, not rapids; M49 switches "
        f"it off ({AS_PROGRAMMED:g})",
    )


def add_line_option(parser: argparse.ArgumentParser) -> None:
    """--from LINE, as `line`."""
    parser.add_argument(
        "--from",
        dest="line",
        type=count,
        metavar="LINE",
        help="begin at rest where the first move of this line begins, or of a later one",
    )


def seconds_between(text: str) -> tuple[float, float]:
    """Two times [s] with a colon between them; without the first 0, without the second infinite."""
    begin, colon, end = text.partition(":")
    try:
        found = float(begin or 0.0), float(end or math.inf)
    except ValueError:
        found = math.nan, math.nan
    if not (colon and 0.0 <= found[0] < found[1] and math.isfinite(found[0])):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no window; expected two times in seconds such as 12.5:20, with the "
            "earlier one first"
        )
    return found


def _percent(text: str) -> float:
    try:
        percent = float(text.removesuffix("%"))
    except ValueError:
        percent = math.nan
    if not 0.0 < percent <= MOST_PERCENT:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no percentage above 0 and up to {MOST_PERCENT:g}; "
            f"{AS_PROGRAMMED:g} runs the feeds as programmed"
        )
    return percent


def require_positive(option: str, value: float, unit: str) -> None:
    """Raise ValueError naming the option, in its own unit, unless the value is in 0..inf."""
    if not (value > 0.0 and math.isfinite(value)):
        raise ValueError(f"{option} = {value:g} is outside its limit: > 0 {unit}".rstrip())


def failed(program: str, error: ValueError) -> int:
    """One line on standard error and the exit status of a command that could not do its work.

    A message that names file and line is printed alone, any other after the program's name.
    """
    text = str(error)
    sys.stderr.write(f"{text if ': error: ' in text else f'{program}: error: {text}'}\n")
    return 1


def interruptible(main: Callable[[], int]) -> int:
    """Exit status of a command; one line in place of a traceback where the user stops it."""
    try:
        return main()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return INTERRUPTED
