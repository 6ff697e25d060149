# SPDX-License-Identifier: Apache-2.0
"""Data flow between the parts of a program: fixed points over the graph of blocks.

Blocks are numbered; `follow[i]` lists the blocks that may run after block i, a run starts in block
0. Sets hold whatever is written: names, output indices.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import TypeVar

Item = TypeVar("Item", bound=Hashable)


def reachable(start: Iterable[int], follow: Callable[[int], Iterable[int]]) -> set[int]:
    """The places of the start, and those that a run can come to from them."""
    reached: set[int] = set()
    pending = list(start)
    while pending:
        i = pending.pop()
        if i not in reached:
            reached.add(i)
            pending += follow(i)
    return reached


def certain_before(
    follow: Sequence[Sequence[int]],
    writes: Sequence[set[Item]],
    start: set[Item],
    everything: set[Item],
) -> list[set[Item]]:
    """What is written on every path to each block; `start` is there when a run begins."""
    return _handed_on(follow, writes, [start, *(everything for _ in follow[1:])], set.intersection)


def possible_before(
    follow: Sequence[Sequence[int]], writes: Sequence[set[Item]]
) -> list[set[Item]]:
    """What is written on some path to each block."""
    return _handed_on(follow, writes, [set() for _ in follow], set.union)


def _handed_on(
    follow: Sequence[Sequence[int]],
    writes: Sequence[set[Item]],
    first: Sequence[set[Item]],
    join: Callable[[set[Item], set[Item]], set[Item]],
) -> list[set[Item]]:
    """What is written before each block, from `first` on joined with what comes from each block
    that it may follow.
    """
    before = list(first)
    changed = True
    while changed:
        changed = False
        for i, successors in enumerate(follow):
            for j in successors:
                joined = join(before[j], before[i] | writes[i])
                changed = changed or joined != before[j]
                before[j] = joined
    return before


def live_after(
    follow: Sequence[Sequence[int]],
    reads: Sequence[set[Item]],
    writes: Sequence[set[Item]],
    at_end: Sequence[set[Item]],
) -> list[set[Item]]:
    """What is read after each block before it is written again.

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
