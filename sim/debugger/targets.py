# SPDX-License-Identifier: Apache-2.0
"""Which core a session debugs, by the options of the command line."""

from __future__ import annotations

import argparse

from sim.debugger.target import Target


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Options that `make_target` reads."""
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--iss",
        action="store_true",
        help="debug on the instruction-set model: nothing to build, no cycles (default)",
    )
    place.add_argument(
        "--connect",
        metavar="ADDRESS",
        help="debug the core at tcp://HOST:PORT or serial:PATH[?baud=N]",
    )


def make_target(options: argparse.Namespace, configuration: str) -> Target:
    """Target for programs of a configuration. Raises TargetError."""
    if options.connect:
        # The client is loaded where it is needed: the model starts faster without.
        from sim.debug.client import connect
        from sim.debugger.block_target import BlockTarget

        return BlockTarget(lambda: connect(options.connect), f"core at {options.connect}")
    from sim.debugger.iss_target import IssTarget

    return IssTarget()
