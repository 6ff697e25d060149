# SPDX-License-Identifier: Apache-2.0
"""Which core a session debugs, by the options of the command line."""

from __future__ import annotations

import argparse

from sim.debugger.target import Target, TargetError


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Options that `make_target` reads; without one it is the Verilated core in this process."""
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--iss",
        action="store_true",
        help="debug on the instruction-set model: nothing to build, no cycles; without this the "
        "Verilated core with its debug block, built at first use",
    )
    place.add_argument(
        "--uart",
        action="store_true",
        help="as without, through the serial pins of the Verilated core",
    )
    place.add_argument(
        "--connect",
        metavar="ADDRESS",
        help="debug the core at tcp://HOST:PORT or serial:PATH[?baud=N], which has the program and "
        "gets its ticks from another host",
    )
    parser.add_argument(
        "--load",
        action="store_true",
        help="with --connect: load the program, write inputs and start ticks from here",
    )


def make_target(options: argparse.Namespace, configuration: str) -> Target:
    """Target for programs of a configuration. Raises TargetError."""
    # Each kind takes its own packages, and a session only one.
    if options.iss:
        from sim.debugger.iss_target import IssTarget

        return IssTarget()
    from sim.debug.client import Client, connect
    from sim.debugger.block_target import BlockTarget
    from sim.debugger.driven_target import DrivenTarget

    if options.connect:
        kind = BlockTarget if options.load else DrivenTarget
        return kind(lambda: connect(options.connect), f"core at {options.connect}")
    from sim.debug.model import DebugRtl
    from sim.harness.build import BuildError

    try:
        model = DebugRtl(configuration)
    except BuildError as error:
        raise TargetError(f"{error}\n--iss debugs without a built core") from None
    if options.uart:
        return BlockTarget(lambda: Client(model.serial_link()), "Verilated core by its serial pins")
    return BlockTarget(lambda: connect(model), "Verilated core")
