# SPDX-License-Identifier: Apache-2.0
"""`python -m sim.core.host`: the Verilated core as a shared library for C programs."""

from __future__ import annotations

import sys
from pathlib import Path

from asip_asm.command import command, command_parser
from asip_asm.files import write_bytes
from asip_asm.isa import default_isa
from sim.core.host import DRIVER, simulated_core
from sim.rtl.build import BuildError

EPILOG = f"""example, for a program main.c that uses asip.h and sim_bus.h:
  python -m sim.core.host -o libcore.so
  cc -I {DRIVER} main.c {DRIVER}/asip.c ./libcore.so -o main

exit status: 0 written, 1 the model cannot be built or written, 2 wrong command line
"""


@command("python -m sim.core.host")
def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = command_parser(
        "python -m sim.core.host",
        "Write the Verilated core as a shared library that C programs link with: the "
        "bus of sim/core/host/sim_bus.h. The first call builds the model: a minute or two.",
        EPILOG,
    )
    parser.add_argument(
        "-o", dest="output", type=Path, required=True, metavar="FILE", help="library to write"
    )
    parser.add_argument(
        "--config",
        choices=tuple(default_isa().configurations),
        default="fast",
        help="configuration of the core (default: fast)",
    )
    options = parser.parse_args(arguments)
    try:
        write_bytes(options.output, simulated_core(options.config).read_bytes())
    except BuildError as error:
        print(f"python -m sim.core.host: error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
