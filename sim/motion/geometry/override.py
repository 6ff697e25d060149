# SPDX-License-Identifier: Apache-2.0
"""Feed override: a program run at a share of its feeds, as by the override knob of a control.

It scales the feeds of G1, G2, G3, splines and cycles, not rapids and rests. M48 and M49 of the
program switch it on and off for the following moves (LinuxCNC, "M48, M49 Speed and Feed Override
Control"): off, the feeds are as programmed. No feed is raised above what the machine can do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

from sim.motion.geometry.moves import Dwell, GcodeProgram, Move

MOST_PERCENT = 200.0
AS_PROGRAMMED = 100.0  # percent


Item = TypeVar("Item", bound=Move | Dwell)


def overridden(items: Iterable[Item], percent: float, highest: float = math.inf) -> Iterator[Item]:
    """The items with the override at `percent`.

    highest: speed of the tool [m/s] above which no feed is raised; turns of the table alone keep to
    its own limit wherever they are planned. Raises ValueError for a percentage out of range.
    """
    if not 0.0 < percent <= MOST_PERCENT:
        raise ValueError(
            f"feed override = {percent:g} % is outside its limit: 0 < percent <= {MOST_PERCENT:g}; "
            f"{AS_PROGRAMMED:g} runs the feeds as programmed"
        )
    for item in items:
        if isinstance(item, Move) and item.override and item.feed is not None:
            feed = item.feed * percent / 100.0
            if not item.turns_only_the_table:
                feed = min(feed, max(item.feed, highest * 60e3))
            if feed != item.feed:
                item = replace(item, feed=feed)
        yield item


def overridden_program(
    program: GcodeProgram, percent: float, highest: float = math.inf
) -> GcodeProgram:
    """As `overridden`, for a whole program."""
    return replace(program, moves=tuple(overridden(program.moves, percent, highest)))
