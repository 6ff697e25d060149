# SPDX-License-Identifier: Apache-2.0
"""Rows of `microtick silicon`: what was not measured, or at another clock, is not met."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from scripts import silicon
from sim.report.goals import at_least
from tests.silicon import ticks
from tests.silicon.netlist import NetlistError


def result(achieved: float, constraint: float, met: bool) -> dict:
    clock = {"achieved": achieved, "constraint": constraint}
    return {"clocks": {"2": {"core": clock}}, "seed": 2, "met": met, "commit": "0123456789ab"}


@pytest.fixture
def board_rows(monkeypatch, tmp_path):
    """Rows of the boards for results by board."""
    monkeypatch.setattr(silicon, "BOARD_RESULTS", tmp_path / "none")
    monkeypatch.setattr(silicon, "KEPT_BOARDS", tmp_path / "boards.json")

    def rows(**results: dict) -> dict[str, silicon.Goal]:
        text = json.dumps({name.replace("_", "-"): found for name, found in results.items()})
        (tmp_path / "boards.json").write_text(text)
        return {row.name: row for row in silicon.boards()}

    return rows


def test_boards__without_a_result__are_listed_and_not_met(board_rows):
    rows = board_rows()
    assert len(rows) == len(silicon.BOARDS) + 1
    assert not any(row.met for row in rows.values())
    assert rows["ulx3s: core clock"].value is None


def test_boards__result_at_another_clock__counts_for_nothing(board_rows):
    row = board_rows(ulx3s=result(101.0, 100.0, True))["ulx3s: core clock"]
    assert row.value is None and not row.met and "microtick bitstream ulx3s" in row.note


def test_boards__two_that_meet_100_mhz__meet_the_goal(board_rows):
    fast = {"ecpix5": result(104.0, 100.0, True), "versa_ecp5": result(101.0, 100.0, True)}
    goal = "bitstreams of boards at 100 MHz or above"
    assert board_rows(**fast)[goal].met
    fast["ecpix5"] = result(99.0, 100.0, False)
    slow = board_rows(ulx3s=result(80.0, 75.0, True), **fast)
    assert (slow[goal].value, slow[goal].met) == (1, False)
    assert slow["ulx3s: core clock"].met and not slow["ecpix5: core clock"].met


def test_clocks__of_tops_never_synthesised__are_listed_as_not_run(monkeypatch):
    small = {"fmax_mhz": {"median": 118, "runs": 5}, "commit": "c", "aluts": 1}
    tops = {"asip_small": small, "asip_fast": small}
    monkeypatch.setattr(silicon, "synthesised", lambda: {"tops": tops})
    rows = {row.name: row for row in silicon.clocks()}
    assert not rows["asip_small: clock"].met
    assert rows["fpga1: whole system placed and routed"].note == "not run"
    assert not rows["fpga1: whole system placed and routed"].met


def test_netlists__short_form__lists_what_it_leaves_out(monkeypatch, tmp_path):
    monkeypatch.setattr(silicon, "OUTCOMES", tmp_path)
    monkeypatch.setattr(silicon.lockstep, "run", lambda top, clocks: silicon.Outcome(7, 2, ()))
    rows = [*silicon.netlist_units(full=False), *silicon.at_work(full=False)]
    assert {row.note for row in rows if row.value is None} == {silicon.FULL}
    assert {row.met for row in rows if row.value is None} == {None}


def test_comparison__done_with_the_same_sources__is_not_done_again(monkeypatch, tmp_path):
    monkeypatch.setattr(silicon, "OUTCOMES", tmp_path)
    first, second = silicon.Outcome(None, 2, ("a[0]",)), silicon.Outcome(7, 2, ())
    assert silicon.outcome_of("a", lambda: first) == first
    assert silicon.outcome_of("a", lambda: second) == first
    assert silicon.outcome_of("b", lambda: second) == second
    monkeypatch.setattr(silicon, "fingerprint", lambda places: "other sources")
    assert silicon.outcome_of("a", lambda: second) == second


def test_fingerprint__changes_with_a_source(monkeypatch, tmp_path):
    (tmp_path / "rtl").mkdir()
    monkeypatch.setattr(silicon, "ROOT", tmp_path)
    marks = set()
    for text in ("a", "b"):
        (tmp_path / "rtl/a.sv").write_text(text)
        silicon.fingerprint.cache_clear()
        marks.add(silicon.fingerprint((tmp_path / "rtl",)))
        marks.add(silicon.fingerprint((tmp_path / "rtl/a.sv",)))
    silicon.fingerprint.cache_clear()
    assert len(marks) == 2  # one for each text


@pytest.mark.parametrize(
    ("outcome", "value", "met"),
    [
        (silicon.Outcome(None, 2, ("a[0]",)), 0, True),
        (silicon.Outcome(7, 2, ()), 1, False),
        (silicon.Outcome(None, 2, ("a[0]", "a[1]")), 0, False),
    ],
)
def test_comparison__is_met_without_a_difference_if_outputs_changed(outcome, value, met):
    row = silicon.compared("a", "5 frames", outcome)
    assert (row.value, row.met) == (value, met)


def test_netlist__that_cannot_be_made__is_a_row_that_is_not_met(monkeypatch):
    def broken(full: bool):
        yield at_least("first", 1, 1, "")
        raise NetlistError("yosys: no such cell\nmore")

    monkeypatch.setattr(silicon, "PRODUCERS", {"units": broken})
    first, last = silicon.measured("units", False)
    assert first.met and not last.met
    assert (last.value, last.note) == (None, "yosys: no such cell")


class Stopped:
    """A core that a fault stops after two ticks."""

    def load(self, image) -> None:
        pass

    def input_addresses(self, names) -> list[int]:
        return []

    output_addresses = input_addresses

    def run(self, addresses, data, reads) -> SimpleNamespace:
        return SimpleNamespace(words=np.zeros((2, 1)), status=np.zeros(2), cycles=np.full(2, 9))


def test_ticks__that_both_cores_end_too_early__are_not_equal():
    image = ticks.program("tracking_optimised", "small")
    data = np.zeros((5, 20), np.uint32)
    assert ticks.compared(image, data, Stopped(), Stopped()) == (2, 0)
    assert ticks.compared(image, data[:2], Stopped(), Stopped()) == (None, 9)
