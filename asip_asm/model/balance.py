# SPDX-License-Identifier: Apache-2.0
"""Chooses the sines and cosines that leave the sine unit for the multiply-add pipes, so that unit
and pipes finish together.

The unit takes a call every few cycles, a polynomial takes slots that other operations want, and
which calls should go depends on when their results are needed. So forms of the program are
scheduled, briefly: calls in a row, then single calls to and fro, then pairs that change places.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

from asip_asm.model.graph import Graph
from asip_asm.model.law import Law
from asip_asm.model.sine import angles, replace_sines

TRIALS = 150
"""Forms that are scheduled."""
OPERATIONS = 90_000
"""Operations in all of them: larger programs get fewer trials."""

Calls = frozenset[int]
BY_CHOICES = -1
"""Among calls: their angles are folded by comparisons."""


def balance(graph: Graph, law: Law, cycles: Callable[[Graph], int]) -> Graph:
    """The form of a graph of real operations with the fewest cycles; of equal ones that with the
    most calls on the unit.
    """
    known = angles(graph, law)
    trials = min(TRIALS, OPERATIONS // max(1, len(graph.used())))
    found: dict[Calls, tuple[int, int]] = {}

    def form(calls: Calls) -> Graph:
        chosen = {call: known[call] for call in calls - {BY_CHOICES}}
        return replace_sines(graph, chosen, BY_CHOICES in calls)

    def cost(calls: Calls) -> tuple[int, int]:
        if calls not in found:
            found[calls] = (cycles(form(calls)), len(calls))
        return found[calls]

    best: Calls = frozenset()
    if len(known) > 1:
        cost(best)
        for calls in _rows(sorted(known)):
            if len(found) < trials and cost(calls) < cost(best):
                best = calls
        better = True
        while better:
            better = False
            for change in _changes(sorted(known)):
                if len(change) == 2 and len(change & best) != 1:
                    continue  # a pair changes places
                if len(found) < trials and cost(best ^ change) < cost(best):
                    best, better = best ^ change, True
    return form(best)


def _rows(calls: Sequence[int]) -> Iterator[Calls]:
    """Calls one after another, short rows first."""
    for count in range(1, len(calls) + 1):
        for start in range(len(calls) - count + 1):
            yield frozenset(calls[start : start + count])


def _changes(calls: Sequence[int]) -> Iterator[Calls]:
    """How calls are folded: single calls, then pairs."""
    yield frozenset((BY_CHOICES,))
    yield from map(frozenset, combinations(calls, 1))
    yield from map(frozenset, combinations(calls, 2))
