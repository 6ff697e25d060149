# SPDX-License-Identifier: Apache-2.0
"""Loops of a program: where their bodies begin and end, and the marks that the core decides by.

A bundle with the operation `loop` is the one before the body. The core looks ahead, so the mark of
the body's end is `AHEAD` bundles before its last one (docs/architecture.md#loops).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from asip_asm.ir import Bundle, Operation, Program
from asip_asm.isa import LOOP_BITS

AHEAD = 2
SHORTEST = AHEAD + 1
"""Bundles of the shortest body."""


@dataclass(frozen=True)
class Loop:
    """A loop: level from 0, outside, rounds, and the bundles, or regions, of its body."""

    level: int
    rounds: int
    first: int
    last: int


def immediate(level: int, rounds: int) -> int:
    """Immediate of the operation that opens a loop."""
    return level << LOOP_BITS | rounds - 1


def level_and_rounds(operation: Operation) -> tuple[int, int]:
    """Inverse of `immediate`."""
    level, left = divmod(operation.imm or 0, 1 << LOOP_BITS)
    return level, left + 1


def opening(bundle: Bundle) -> Operation | None:
    """The operation of a bundle that opens a loop."""
    return next((op for op in bundle.operations if op.mnemonic == "loop"), None)


def loops_of(bundles: Sequence[Bundle]) -> list[Loop]:
    """Loops of marked bundles, in the order in which they begin. A loop whose end has no mark ends
    with the program.
    """
    found = []
    for i, bundle in enumerate(bundles):
        if (op := opening(bundle)) is not None:
            level, rounds = level_and_rounds(op)
            marks = (j for j in range(i + 1, len(bundles)) if bundles[j].ends >> level & 1)
            last = next(marks, len(bundles)) + AHEAD
            found.append(Loop(level, rounds, i + 1, min(last, len(bundles) - 1)))
    return found


def region_loops(program: Program) -> list[Loop]:
    """Loops of a program by their regions, in the order in which they end."""
    open_loops: list[tuple[int, int, int]] = []
    found = []
    for i, region in enumerate(program.regions):
        for _ in range(region.ends):
            level, rounds, first = open_loops.pop()
            found.append(Loop(level, rounds, first, i))
        last = region.bundles[-1:] if region.bundles is not None else []
        operations = last[0].operations if last else region.operations[-1:]
        for op in operations:
            if op.mnemonic == "loop":
                open_loops.append((*level_and_rounds(op), i + 1))
    return found


def mark_ends(program: Program, slots: int) -> None:
    """Set the marks of scheduled bundles; too short a body gets empty bundles at its end."""
    for loop in region_loops(program):
        body = [region.bundles or [] for region in program.regions[loop.first : loop.last + 1]]
        for _ in range(SHORTEST - sum(map(len, body))):
            body[-1].append(Bundle([None] * slots))
        marked = [bundle for bundles in body for bundle in bundles][-SHORTEST]
        marked.ends |= 1 << loop.level


def back_edges(bundles: Sequence[Bundle]) -> dict[int, list[int]]:
    """By last bundle of each body, the first ones of the loops that end there."""
    edges: dict[int, list[int]] = {}
    for loop in loops_of(bundles):
        edges.setdefault(loop.last, []).append(loop.first)
    return edges
