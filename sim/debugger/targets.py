# SPDX-License-Identifier: Apache-2.0
"""Which core a session debugs, by the options of the command line."""

from __future__ import annotations

import argparse

from asip_asm.image import Image
from sim.debugger.target import Target


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Options that `make_target` reads."""
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--iss",
        action="store_true",
        help="debug on the instruction-set model: nothing to build, no cycles",
    )


def make_target(options: argparse.Namespace, image: Image) -> Target:
    """Target for a program. Raises TargetError."""
    from sim.debugger.iss_target import IssTarget

    return IssTarget()
