# SPDX-License-Identifier: Apache-2.0
"""Simulate a board with a serial port, to try the commands without a board."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from asip_asm.command import command, command_parser
from sim.rtl.board.model import BOARDS, BoardRtl
from sim.rtl.board.serial_device import SerialDevice
from sim.rtl.build import BuildError

EPILOG = """The path printed is a serial device as long as this command runs (Ctrl-C ends it):

  asip-run leg.s --port PATH --set x=0.3

A simulated board runs some hundred thousand clocks a second. At the 115 200 bit/s of colorlight-i9
a program takes minutes to load, so use ulx3s.

exit status: 0 ended, 1 no model could be built, 2 wrong command line
"""


@command("python -m sim.rtl.board")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = command_parser("python -m sim.rtl.board", __doc__, EPILOG)
    parser.add_argument("board", choices=tuple(BOARDS), nargs="?", default="ulx3s")
    options = parser.parse_args(arguments)
    try:
        device = SerialDevice(BoardRtl(options.board))
    except BuildError as error:
        print(f"sim.rtl.board: error: {error}", file=sys.stderr)
        return 1
    print(f"{options.board}: {device.path}", flush=True)
    try:
        while True:
            device.poll()
    except KeyboardInterrupt:
        return 0


if __name__ == "__main__":
    sys.exit(main())
