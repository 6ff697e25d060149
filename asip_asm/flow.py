# SPDX-License-Identifier: Apache-2.0
"""Data flow between the parts of a program: fixed points over the graph of blocks.

Blocks are numbered; `follow[i]` lists the blocks that may run after block i, a run starts in block
0. Sets hold whatever is written: names, output indices.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import TypeVar

Item = TypeVar("Item", bound=Hashable)


def reachable(follow: Sequence[Sequence[int]]) -> set[int]:
    """Blocks that a run can come to."""
    reached: set[int] = set()
    pending = [0]
    while pending:
        i = pending.pop()
        if i not in reached:
            reached.add(i)
            pending += follow[i]
    return reached


def certain_before(
    follow: Sequence[Sequence[int]],
    writes: Sequence[set[Item]],
    start: set[Item],
    everything: set[Item],
) -> list[set[Item]]:
    """What is written on every path to each block; `start` is there when a run begins."""
    before = [set(everything) for _ in follow]
    before[0] = set(start)
    changed = True
    while changed:
        changed = False
        for i, successors in enumerate(follow):
            after = before[i] | writes[i]
            for j in successors:
                if not before[j] <= after:
                    before[j] &= after
                    changed = True
    return before


def possible_before(
    follow: Sequence[Sequence[int]], writes: Sequence[set[Item]]
) -> list[set[Item]]:
    """What is written on some path to each block."""
    before: list[set[Item]] = [set() for _ in follow]
    changed = True
    while changed:
        changed = False
        for i, successors in enumerate(follow):
            after = before[i] | writes[i]
            for j in successors:
                if not after <= before[j]:
                    before[j] |= after
                    changed = True
    return before


def live_after(
    follow: Sequence[Sequence[int]],
    reads: Sequence[set[Item]],
    writes: Sequence[set[Item]],
    at_end: Sequence[set[Item]],
) -> list[set[Item]]:
    """What is read behind each block before it is written again.

    `reads` are the reads of a block that no write of the same block precedes, `at_end` what is read
    when a run ends with the block.
    """
    live = [set(items) for items in at_end]
    changed = True
    while changed:
        changed = False
        for i in reversed(range(len(follow))):
            for j in follow[i]:
                wanted = reads[j] | (live[j] - writes[j])
                if not wanted <= live[i]:
                    live[i] |= wanted
                    changed = True
    return live
