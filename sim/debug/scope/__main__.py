# SPDX-License-Identifier: Apache-2.0
"""Look at a core with its debug block in the browser: curves, trigger, gains, black box."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import math
import sys
from pathlib import Path

from asip_asm.command import command, command_parser
from asip_asm.image import Image
from sim.debug import guard
from sim.debug.backend import open_block
from sim.debug.scope import server
from sim.debug.scope.block_source import MOST_CHANNELS, BlockSource, first_channels
from sim.motion.command import interruptible, output
from sim.rtl.asip_bus import AsipError

EPILOG = """examples:
  asip-scope axis.asip.json serial:/dev/ttyUSB0?baud=3000000
  asip-scope axis.asip.json tcp://localhost:2331 --channels force,speed,cycles --period 50e-6

The program runs already; the scope neither loads nor starts it. The simulated machine of the main
job has the same page: make run SCOPE=1.

exit status: 0 ended by Ctrl-C, 1 nothing answers or the image has an error, 2 wrong command line
"""


def _arguments() -> argparse.ArgumentParser:
    parser = command_parser("asip-scope", __doc__, EPILOG)
    parser.add_argument("image", type=Path, help="the program that the core runs, *.asip.json")
    parser.add_argument("target", help="serial:PATH?baud=N, /dev/ttyUSB0 or tcp://host:port")
    parser.add_argument(
        "--channels",
        metavar="NAMES",
        help=f"up to {MOST_CHANNELS} inputs, outputs, states, exports, registers or 'cycles', "
        "separated by commas (outputs first)",
    )
    parser.add_argument(
        "--period", type=_seconds, default=1e-4, metavar="S", help="between two runs [s] (1e-4)"
    )
    parser.add_argument(
        "--every", type=int, default=1, metavar="N", help="record one of N runs (1)"
    )
    parser.add_argument(
        "--trigger",
        default="",
        metavar="WORDS",
        help="trigger of the debug block, such as 'force rising 5' or 'speed outside -1 1'; the "
        "records around it are complete, even if the line is too slow for all others",
    )
    parser.add_argument(
        "--before",
        type=_share,
        default=0.5,
        metavar="SHARE",
        help="share of these records before the trigger (0.5)",
    )
    parser.add_argument("--port", type=int, default=0, help="TCP port of the page (any free one)")
    return parser


def _seconds(text: str) -> float:
    return _number(text, 1e-9, 1e3, "time from 1e-9 to 1e3 s")


def _share(text: str) -> float:
    return _number(text, 0.0, 1.0, "share from 0 to 1")


def _number(text: str, least: float, most: float, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is no {what}")
    return value


def _scope(arguments: argparse.Namespace) -> int:
    errors = output(stderr=True)
    try:
        image = Image.load(arguments.image)
        names = arguments.channels.split(",") if arguments.channels else first_channels(image)
        source = BlockSource(
            lambda: open_block(arguments.target),
            image,
            names,
            arguments.period,
            arguments.every,
            arguments.trigger,
            arguments.before,
        )
        listening = server.bind(arguments.port)
    except (AsipError, ValueError, OverflowError) as error:
        text = str(error)
        errors.print(text if "error: " in text else f"error: {text}")
        return 1
    token = guard.new_token()
    output().print(f"scope: {server.address(listening, token)}\nCtrl-C ends it")
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(server.serve(source, listening, token))
    return 0


@command("asip-scope")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit status."""
    arguments = _arguments().parse_args(argv)
    return interruptible(lambda: _scope(arguments))


if __name__ == "__main__":
    sys.exit(main())
