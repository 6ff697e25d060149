# SPDX-License-Identifier: Apache-2.0
"""Shared schedules are those of a search, and no other problem's."""

from __future__ import annotations

from dataclasses import replace

import pytest

from asip_asm import schedule, search
from asip_asm.assemble import build_program
from asip_asm.project import ROOT
from tests.bench import schedules

PROGRAM = ROOT / "asip_asm/programs/planner_scurve.s"


@pytest.fixture
def problems(tmp_path, monkeypatch):
    """Problems of a program, in an empty folder of schedules."""
    asked = []

    def recorded(problem, effort, progress=None):
        asked.append(problem)
        return search.search(problem, 20)

    monkeypatch.setattr(schedules, "FOLDER", tmp_path)
    monkeypatch.setattr(schedule, "search", recorded)
    build_program(PROGRAM, configuration="fast")
    return [problem for problem in asked if len(problem.lane) >= schedules.LEAST]


def test_schedule__searched_once__then_read__the_same(problems, monkeypatch):
    wanted = [search.search(problem, 20) for problem in problems]
    assert wanted and [schedules.found(problem, 20) for problem in problems] == wanted
    monkeypatch.setattr(search, "search", None)
    assert [schedules.found(problem, 20) for problem in problems] == wanted


def test_schedule__of_tests__is_shared():
    assert schedule.search is schedules.found


def test_progress__asked_for__is_that_of_a_search(problems, monkeypatch):
    # An unreachable bound keeps the search from ending early.
    monkeypatch.setattr(search, "lower_bound", lambda problem: 0)
    for _ in range(2):
        seen = []
        schedules.found(problems[0], 100, seen.append)
        assert seen


OTHERS = {
    "latency": lambda p: replace(p, graph=replace(p.graph, latency=[9, *p.graph.latency[1:]])),
    "successors": lambda p: replace(p, graph=replace(p.graph, successors=[[]] * len(p.lane))),
    "predecessors": lambda p: replace(p, graph=replace(p.graph, predecessors=[[]] * len(p.lane))),
    "lanes": lambda p: replace(p, lanes={name: n + 1 for name, n in p.lanes.items()}),
    "lane": lambda p: replace(p, lane=p.lane[::-1]),
    "pipe": lambda p: replace(p, pipe=[0] * len(p.lane)),
    "port": lambda p: replace(p, port=[True] * len(p.lane)),
    "blocked": lambda p: replace(p, blocked=[("divsqrt", 3)] * len(p.lane)),
    "values": lambda p: replace(p, values=p.values[1:]),
    "capacity": lambda p: replace(p, capacity=(1, 1)),
    "around": lambda p: replace(p, around=[(1, 0, 3)]),
}


@pytest.mark.parametrize("name", OTHERS)
def test_key__every_part_of_the_problem_counts(name, problems):
    other = OTHERS[name](problems[0])
    assert schedules.key(other, 20) != schedules.key(problems[0], 20)
    assert schedules.key(problems[0], 21) != schedules.key(problems[0], 20)


def test_key__names_every_part_of_a_problem():
    """Of the graph's operations a search reads nothing but their number."""
    parts = {*search.Problem.__annotations__, *search.Graph.__annotations__}
    assert parts == {*OTHERS, "graph", "operations"}
