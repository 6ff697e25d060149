# SPDX-License-Identifier: Apache-2.0
"""Goals of area and clock of `microtick robots`: with their commit, never met by accident."""

from __future__ import annotations

import pytest

from scripts import clock_goals
from sim.bench.shown_robots import core_goals as module
from sim.bench.shown_robots.core_goals import ROWS, core_goals
from sim.report.goals import Goal

FAST = {
    "aluts": 12_010,
    "registers": 7_489,
    "dsp_18x18": 8,
    "fmax_mhz": {"median": 125.0, "runs": 5},
}
SMALL = {"aluts": 5_000, "fmax_mhz": {"median": 102.0, "runs": 5}}


@pytest.fixture
def same_rtl(monkeypatch):
    monkeypatch.setattr(module, "is_present", lambda top, figures: figures["commit"] == "abc")


def document(commit: str = "abc", **fast) -> dict:
    figures = {"asip_fast": FAST | fast, "asip_small": SMALL}
    return {"tops": {top: own | {"commit": commit} for top, own in figures.items()}}


def missed(goals: list[Goal]) -> list[str]:
    return [goal.name for goal in goals if not goal.met]


def test_figures_at_their_targets_are_met_and_name_their_commit(same_rtl):
    goals = core_goals(document())
    assert missed(goals) == [] and {goal.note for goal in goals} == {"measured at commit abc"}
    assert goals[3] == Goal(
        "core fast, clock", 125.0, "MHz", ">= 125", True, "measured at commit abc"
    )


@pytest.mark.parametrize(
    ("field", "value", "name"),
    [
        ("aluts", 12_011, "core fast, logic"),
        ("registers", 7_490, "core fast, registers"),
        ("dsp_18x18", 9, "core fast, multipliers"),
        ("fmax_mhz", {"median": 124.9, "runs": 5}, "core fast, clock"),
        ("fmax_mhz", {"median": 130.0, "runs": 4}, "core fast, clock"),
        ("fmax_mhz", {"median": 130.0, "seeds": {"1": 129.0, "2": 131.0}}, "core fast, clock"),
        ("fmax_mhz", {"median": 130.0}, "core fast, clock"),
    ],
)
def test_a_figure_beyond_its_target_is_not_met(same_rtl, field, value, name):
    assert missed(core_goals(document(**{field: value}))) == [name]


def test_seeds_are_counted_as_make_synth_writes_them__and_named_where_they_are_few(same_rtl):
    seeds = {str(seed): 130.0 for seed in range(5)}
    assert missed(core_goals(document(fmax_mhz={"median": 130.0, "seeds": seeds}))) == []
    seeds.pop("0")
    goal = core_goals(document(fmax_mhz={"median": 130.0, "seeds": seeds}))[3]
    assert not goal.met and goal.note == "measured at commit abc, with 4 seeds of 5"


def test_the_clock_target_is_no_property_of_the_core():
    """It stays where the clock that timings are stated at is another one."""
    assert {row[1]: row[4] for row in ROWS if row[2] == "fmax_mhz"} == {
        "core fast, clock": 125,
        "core small, clock": 102,
    }


def clocks(monkeypatch, producer, commit: str, mhz: float) -> dict[str, bool | None]:
    """Verdict of each row of a producer of clock goals, all clocks being `mhz`."""
    figures = FAST | {"commit": commit, "fmax_mhz": {"median": mhz, "runs": 5}}
    tops = dict.fromkeys(("asip_fast", "fpga1", "fpga2"), figures)
    monkeypatch.setattr(clock_goals, "synthesised", lambda: {"tops": tops})
    return {goal.name: goal.met for goal in producer(True)}


@pytest.mark.parametrize(
    ("producer", "rows", "enough", "too_little"),
    [(clock_goals.hardware, 4, 138.75, 138.7), (clock_goals.nios, 2, 100.0, 99.9)],
)
def test_clock_goals__figures_of_this_rtl_alone_are_met_or_missed(
    same_rtl, monkeypatch, producer, rows, enough, too_little
):
    met = clocks(monkeypatch, producer, "abc", enough)
    assert len(met) == rows and set(met.values()) == {True}
    missed = clocks(monkeypatch, producer, "abc", too_little)
    assert {name for name in missed if missed[name] is False} == {
        name for name in missed if "clock" in name or "tick" in name
    }
    assert set(clocks(monkeypatch, producer, "old", enough).values()) == {None}


@pytest.mark.parametrize(("fast", "small", "met"), [(11_930, 4_930, True), (11_931, 4_931, False)])
def test_matrix_goals__cores_without_streams_keep_cycles_and_area(
    same_rtl, monkeypatch, fast, small, met
):
    areas = {"asip_fast": fast, "asip_small": small}
    tops = {top: {"commit": "abc", "aluts": aluts} for top, aluts in areas.items()}
    monkeypatch.setattr(clock_goals, "synthesised", lambda: {"tops": tops})
    rows = {goal.name: goal for goal in clock_goals.matrix(True)}
    assert [rows[f"{core}: ALUTs"].met for core in ("fast", "small")] == [met, met]
    assert {row.value: row.met for name, row in rows.items() if "tick" in name} == {
        cycles: True for cycles in (111, 204, 264, 518)
    }


def test_figures_of_another_core_or_none_are_not_met(same_rtl):
    other = core_goals(document("old"))
    assert len(missed(other)) == len(ROWS)
    assert "the core is another one now; microtick synth measures it" in other[0].note
    none = core_goals({})
    assert len(missed(none)) == len(ROWS)
    assert (none[0].name, none[0].value, none[0].target) == ("core fast, logic", None, "<= 12010")
    assert none[0].note.startswith("not measured")
