# SPDX-License-Identifier: Apache-2.0
"""`make goals`: the verdicts of goals, their tables, and what a partial run does to the file."""

from __future__ import annotations

import importlib
import json
import sys
from types import ModuleType

import pytest
from rich.console import Console

from scripts import goals as command
from sim.report.goals import (
    Goal,
    Pace,
    as_json,
    at_least,
    at_most,
    depth,
    exactly,
    markdown_table,
    missed,
    not_measured,
    terminal_table,
    write_goals,
)

CURE = "RUN=full measures it"


def test_verdict__sample_is_neither_met_nor_missed():
    goals = [depth("few", 40, 1000, "runs", CURE), depth("all", 1000, 1000, "runs", CURE)]
    assert [goal.met for goal in goals] == [None, True]
    assert missed(as_json(goals)) == []


@pytest.mark.parametrize(
    ("goal", "met"),
    [
        (at_most("a", 2, 2, ""), True),
        (at_most("a", 3, 2, ""), False),
        (at_least("a", 2, 2, ""), True),
        (at_least("a", 1, 2, ""), False),
        (exactly("a", 0, 0, ""), True),
        (exactly("a", 1, 0, ""), False),
        (at_most("a", float("nan"), 2, ""), False),
        (not_measured("a", "<= 2", "", CURE), None),
    ],
)
def test_verdict__follows_the_relation(goal, met):
    assert goal.met is met
    assert missed(as_json([goal])) == (["a"] if met is False else [])


def test_tables__name_what_is_sampled_missed_and_not_measured():
    goals = as_json(
        [
            at_most("time", 1.5, 1, "us"),
            depth("cases", 10, 20, "", CURE),
            not_measured("clock", ">= 100", "MHz", CURE),
        ]
    )
    text = markdown_table(goals)
    for line in (
        "| time | 1.5 us, missed | <= 1 us |",
        "| cases | 10, sampled | >= 20 |",
        "| clock | not measured | >= 100 MHz |",
    ):
        assert line in text
    console = Console(width=120, record=True, file=open("/dev/null", "w"))
    console.print(terminal_table(goals))
    shown = console.export_text()
    assert "missed" in shown and "sampled" in shown and "not measured" in shown and CURE in shown


@pytest.fixture
def area(monkeypatch, tmp_path):
    """An area of two producers, the second of which the test can change."""
    module = ModuleType("made_up_producers")
    module.first = lambda full: iter([at_most("one", 1, 1, "")])
    module.second = lambda full: iter([at_most("two", 2, 2, "")])
    monkeypatch.setitem(sys.modules, "made_up_producers", module)
    places = {name: f"made_up_producers:{name}" for name in ("first", "second")}
    monkeypatch.setattr(command, "AREAS", {"made up": command.Area("two goals", places)})
    monkeypatch.setattr(command, "BUILD", tmp_path)
    return module


def written(tmp_path) -> dict[str, bool | None]:
    goals = json.loads((tmp_path / "made up.json").read_text())["goals"]
    return {goal["name"]: goal["met"] for goal in goals}


def test_command__writes_the_goals__and_exits_by_the_missed_ones(area, tmp_path):
    assert command.main(["made up"]) == 0
    assert written(tmp_path) == {"one": True, "two": True}
    area.second = lambda full: iter([at_most("two", 3, 2, "")])
    assert command.main(["made up", "second"]) == 1
    assert written(tmp_path) == {"one": True, "two": False}  # The first keeps its value.
    area.second = lambda full: iter([not_measured("two", "<= 2", "", CURE)])
    assert command.main(["made up"]) == 0


def test_command__producer_that_fails_is_a_missed_goal(area, tmp_path):
    area.second = lambda full: 1 / 0
    assert command.main(["made up"]) == 1
    assert written(tmp_path) == {"one": True, "second": False}


def test_command__names_what_there_is(area, capsys):
    assert command.main([]) == 0 and "two goals" in capsys.readouterr().out
    assert command.main(["other"]) == 2 and "made up" in capsys.readouterr().err
    assert command.main(["made up", "third"]) == 2 and "first, second" in capsys.readouterr().err


def test_docs__table_from_the_file_into_the_page(area, monkeypatch, tmp_path, capsys):
    page = tmp_path / "docs/page.md"
    page.parent.mkdir()
    page.write_text("a\n<!-- rows: written by x -->\nold\n<!-- end of rows -->\nb\n")
    shown = command.Area("one", page="page.md", mark="rows", shown=("first",))
    monkeypatch.setitem(command.AREAS, "shown", shown)
    monkeypatch.setattr(command, "ROOT", tmp_path)
    assert command.main(["shown", "--docs"]) == 2 and "make goals" in capsys.readouterr().err
    assert command.main(["made up", "--docs"]) == 2 and "shown have" in capsys.readouterr().err
    assert command.main(["made up"]) == 0
    (tmp_path / "made up.json").rename(tmp_path / "shown.json")
    assert command.main(["shown", "--docs"]) == 0
    text = page.read_text()
    assert "| one | 1 | <= 1 |" in text and "two" not in text and "old" not in text


def test_areas__every_place_exists():
    for name, found in command.AREAS.items():
        for place in filter(None, [found.command, *found.producers.values()]):
            module, _, function = place.partition(":")
            assert callable(getattr(importlib.import_module(module), function)), (name, place)


def test_file__keeps_its_content_if_writing_fails(tmp_path):
    file = tmp_path / "x.json"
    write_goals(file, [], full=True)
    with pytest.raises(TypeError):
        write_goals(file, as_json([Goal("a", 1, "", "1", True)]), full=object())
    assert json.loads(file.read_text()) == {"full": True, "goals": []}


def test_runs_at_the_same_time__of_two_producers__lose_nothing(area, tmp_path):
    def second(full):
        assert command.main(["made up", "first"]) == 0
        yield at_most("two", 2, 2, "")

    area.second = second
    assert command.main(["made up", "second"]) == 0
    assert written(tmp_path) == {"one": True, "two": True}


def test_pace__reports_what_is_left__but_not_too_often(monkeypatch, capsys):
    clock = iter((0.0, 0.0, 1.0, 20.0, 21.0))
    monkeypatch.setattr("asip_asm.pace.time.monotonic", lambda: next(clock))
    pace = Pace("files", 10, next(clock), next(clock))
    for done in (1, 5, 6):
        pace.at(done)
    assert capsys.readouterr().err == "files: 5 of 10, about 20 s left\n"
