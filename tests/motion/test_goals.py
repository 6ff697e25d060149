# SPDX-License-Identifier: Apache-2.0
"""Table of goals: measured small, misses seen, and the page written from results alone."""

from __future__ import annotations

import json
from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Console

from sim.bench.motion import goals, goals_lookahead, goals_planner, goals_rtl
from sim.motion.gcode.oracle import LEAST_EQUAL, OracleError, Samples
from sim.motion.lookahead import figures as lookahead_figures
from sim.motion.lookahead import stress
from sim.report.marks import between_marks

TINY = goals.Counts(10, 1, 20, 3, 3, 1, 4, 6, 2, 2, 500)
MARKED = "before\n<!-- goals: written by x -->\nold\n<!-- end of goals -->\nbehind\n"
FIGURES = (
    ("with blending, trapezoid", "s", 1.5),
    ("with blending, jerk-limited", "s", 1.51),
    ("without blending, trapezoid", "s", 5.04),
    ("five axes: final counts off", "steps", 0.0),
    ("five axes: steps off the plan", "steps", 0.5),
    ("1st-order loop: no feed-forward", "mm", 2.5),
    ("computed torque: tool error, 3 strokes", "um", 1.2),
    ("drives, velocity and acceleration: tool error, 3 strokes", "um", 0.4),
)


def rows(agrees: bool = True) -> list[dict]:
    return [
        {"name": name, "unit": unit, "ours": ours, "agrees": agrees} for name, unit, ours in FIGURES
    ]


@pytest.fixture
def alone(monkeypatch):
    """No campaign, core or LinuxCNC: those have tests of their own."""

    def missing():
        raise OracleError("LinuxCNC's samples are missing")

    monkeypatch.setattr(goals_lookahead, "compare_samples", missing)
    goals_lookahead._campaign.cache_clear()
    core = {goals_planner.core: lambda counts, rows: ("0.1 um", True)}
    features = [replace(row, check=core.get(row.check, row.check)) for row in goals.FEATURES]
    monkeypatch.setattr(goals, "FEATURES", features)


def test_goals__measured_small__all_met_but_those_that_cannot_be(alone):
    names: list[str] = []
    found = goals.table(rows(), TINY, names.append)
    by_name = {goal.feature: goal for goal in found}
    assert len(by_name) == len(found)
    assert {goal.feature for goal in found if goal.met is False} == set()
    assert by_name["G-code: LinuxCNC's samples, equal moves"].ours.startswith("not run: LinuxCNC")
    assert by_name["G64 program on five step axes (RTL)"].ours == "0 steps; 0.5 steps"
    assert by_name["robot on AGH, 2 m/min: law; drives"].ours == "1.2 um; 0.4 um"
    # Figures that this run has not made are no verdict.
    assert (by_name["current spikes"].ours, by_name["current spikes"].met) == ("", None)
    assert all(goal.command for goal in found)
    text = StringIO()
    Console(file=text, width=200).print(goals.printed(found))
    assert text.getvalue().count(" met ") == sum(goal.met is True for goal in found)
    page = between_marks(MARKED, {"goals": goals.markdown(goals.document(found))}, "page")
    assert page.startswith("before\n") and page.endswith("behind\n") and "old" not in page
    assert page.count("\n| ") == len(found) + 2
    assert "not in this run" in page


def test_goals__worse_than_asked__are_not_met(alone, monkeypatch):
    """Negative controls: a figure that differs, a corner beyond P, a broken limit."""
    monkeypatch.setattr(stress, "VIOLATION", 0.5)
    corner = lookahead_figures.corner_program
    monkeypatch.setattr(
        lookahead_figures,
        "corner_program",
        lambda mode, angle=90.0: corner(
            mode.replace("P", "P0") if mode == "G64 P0.1" else f"G64 P{2 * float(mode[5:])}", angle
        ),
    )
    found = {goal.feature: goal for goal in goals.table(rows(False), TINY, lambda name: None)}
    assert {name for name, goal in found.items() if goal.met is False} >= {
        "G64 P: 1, 5, 10, 25, 100 um",
        "limits of tool, legs, table; half in five axes",
        "G64 program on five step axes (RTL)",
        "robot on AGH, 2 m/min: law; drives",
    }


def test_goals__without_rtl__builds_nothing_and_leaves_those_open(alone, monkeypatch):
    def build(*arguments):
        raise AssertionError("a model was asked for")

    monkeypatch.setattr(goals_rtl, "MotionRtl", build)
    monkeypatch.setattr(goals_rtl, "InterpolatorRtl", build)
    found = {g.feature: g for g in goals.table(rows(), TINY, lambda name: None, hardware=False)}
    assert found["pulse jitter"].met is found["line in steps"].met is None
    assert found["S-curve classes"].met


def test_samples__refused_and_different__are_counted_apart():
    found = Samples(["a", "e"], {"b": "x"}, {"c": "y"}, {"d": "z"}, {"a", "b", "c"})
    assert found.text == "1 of 3 equal, 1 different, 1 refused"
    assert not found.goal_met
    names = [str(number) for number in range(LEAST_EQUAL)]
    assert Samples(names, moving={*names, "more"}).goal_met
    assert not Samples(names[1:], moving=set(names)).goal_met
    assert not Samples(names, {"more": "x"}, moving=set(names)).goal_met


def test_page_of_the_repository__has_the_features_of_today():
    page = goals.PAGE.read_text(encoding="utf-8")
    table = page.split("<!-- goals: ")[1].split("<!-- end of goals -->")[0]
    listed = [line.split(" | ")[0].removeprefix("| ") for line in table.splitlines()[4:] if line]
    asked = [feature.name for feature in goals.FEATURES]
    assert listed == asked, "run microtick motion and .venv/bin/python -m sim.bench.motion.goals"


@pytest.mark.parametrize(
    ("results", "page", "message"),
    [
        (None, "x", "run microtick motion first"),
        ("{}", "x", "'goals'; run microtick motion again"),
        ('{"goals": []}', "x", "0 pairs of marks `<!-- goals: ... -->`"),
        ("no json", "x", "run microtick motion again"),
    ],
)
def test_command__without_results_or_marks__tells_what_to_do(
    tmp_path, capsys, results, page, message
):
    file, target = tmp_path / "results.json", tmp_path / "page.md"
    target.write_text(page)
    if results is not None:
        file.write_text(results)
    assert goals.main(["--results", str(file), "--page", str(target)]) == 1
    assert message in capsys.readouterr().err
    assert target.read_text() == page


def test_command__results__are_written_between_the_marks(tmp_path):
    file, target = tmp_path / "results.json", tmp_path / "page.md"
    goal = goals.Goal("a feature", "-", "1", "1.5", False, "microtick motion")
    file.write_text(json.dumps({"goals": goals.document([goal])}))
    target.write_text(MARKED)
    assert goals.main(["--results", str(file), "--page", str(target)]) == 0
    assert "| a feature | - | 1 | 1.5 | **not met** | `microtick motion` |" in target.read_text()


def test_command__measure__takes_the_figures_there_are_and_stores_the_goals(tmp_path, monkeypatch):
    file, target = tmp_path / "results.json", tmp_path / "page.md"
    file.write_text(json.dumps({"full": False, "figures": rows(), "goals": []}))
    target.write_text(MARKED)
    goal = goals.Goal("a feature", "-", "1", "1.5", True, "microtick motion")
    seen = []

    def table(figures, counts, report):
        seen.append((figures, counts))
        return [goal]

    monkeypatch.setattr(goals, "table", table)
    assert goals.main(["--measure", "--results", str(file), "--page", str(target)]) == 0
    assert seen == [(rows(), goals.Counts())]
    assert json.loads(file.read_text())["goals"] == goals.document([goal])
    assert "| a feature |" in target.read_text()
