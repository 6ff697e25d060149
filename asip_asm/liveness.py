# SPDX-License-Identifier: Apache-2.0
"""Which registers, symbolic or physical, are live where the regions of a program begin and end."""

from __future__ import annotations

from collections.abc import Collection

from asip_asm.flow import live_after
from asip_asm.ir import Program, Register, Virtual
from asip_asm.loops import region_loops
from asip_asm.machine import BRANCHES, sources

Place = Virtual | Register


def region_liveness(
    program: Program, kept: Collection[Place] = ()
) -> list[tuple[set[Place], set[Place]]]:
    """Places live at the start and at the end of every region of a scheduled program.

    A place is live if a later bundle reads it before it is written again, or if the run can end
    with it in `kept`, the places read after a run. Data-flow equations over the branches and loops
    between regions.
    """
    regions = program.regions
    loops = region_loops(program)
    label = {name: i for i, region in enumerate(regions) for name in region.labels}
    following: list[set[int]] = []
    reads: list[set[Place]] = []
    writes: list[set[Place]] = []
    for i, region in enumerate(regions):
        follow = set() if region.halt or i + 1 == len(regions) else {i + 1}
        follow.update(loop.first for loop in loops if loop.last == i)
        read: set[Place] = set()
        written: set[Place] = set()
        for bundle in region.bundles or []:
            for op in bundle.operations:
                read.update(source for source in sources(op) if source not in written)
                if op.mnemonic == "jmp":
                    follow.clear()
                if op.mnemonic in BRANCHES and op.target is not None:
                    follow.add(label[op.target])
            places = [op.dst for op in bundle.operations]
            written.update(place for place in places if isinstance(place, Virtual | Register))
        following.append(follow)
        reads.append(read)
        writes.append(written)
    at_end = [set() if follow else set(kept) for follow in following]
    after = live_after([sorted(follow) for follow in following], reads, writes, at_end)
    return [
        (read | (live - written), live)
        for read, written, live in zip(reads, writes, after, strict=True)
    ]
