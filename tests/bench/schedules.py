# SPDX-License-Identifier: Apache-2.0
"""Schedules that the search found, for all tests of a run: many files compile the same programs.

A schedule is in build/schedules, by a hash of everything that the search reads: the graph, the
resources, the effort, and the source of the search. Whoever asks for the progress of a search gets
a search. The tests of the assembler (tests/asm) take none of this, see their conftest.py.
"""

from __future__ import annotations

import functools
import hashlib
import sys
from collections.abc import Callable
from pathlib import Path

from asip_asm import dependence, search
from asip_asm.project import BUILD
from asip_asm.search import Problem, Progress
from sim.report import cache

FOLDER = BUILD / "schedules"
LEAST = 8
"""Operations of the smallest region whose schedule is worth a file."""


@functools.cache
def _sources() -> str:
    files = [Path(str(module.__file__)) for module in (search, dependence)]
    return cache.fingerprint(files, sys.version)


def key(problem: Problem, effort: int) -> str:
    """Hash of what a search reads of its arguments."""
    graph = problem.graph
    edges = graph.predecessors, graph.successors, graph.latency
    resources = problem.lanes, problem.lane, problem.pipe, problem.port, problem.blocked
    registers = problem.values, problem.capacity, problem.around
    return hashlib.sha256(repr((effort, edges, resources, registers)).encode()).hexdigest()[:32]


def found(
    problem: Problem, effort: int, progress: Callable[[Progress], None] | None = None
) -> list[int]:
    """As `asip_asm.search.search`."""
    if progress is not None or len(problem.lane) < LEAST:
        return search.search(problem, effort, progress)
    name = key(problem, effort)
    entry = cache.Entry(FOLDER / f"{name}.json", _sources())
    return cache.result_of(entry, lambda: search.search(problem, effort))
