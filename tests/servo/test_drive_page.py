# SPDX-License-Identifier: Apache-2.0
"""docs/drive.md takes its figures from build/drive.json; rows of the hardware."""

from __future__ import annotations

import pytest

from scripts import drive
from sim.bench.drive.goals import Rows
from sim.report.goals import as_json
from tests.servo.decoder_edges import Campaign

DELAYS = dict.fromkeys(("commands", "orders", "values", "voltage", "pulse", "count"), 7.0)


def test_page__takes_the_figures_and_keeps_the_rest():
    rows = Rows()
    rows.most("a", 1.5, "us", 1.5)
    rows.most("b", 0.75, "1", 0.5)
    rows.least("c", None, "MHz", 125)
    page = drive.PAGE.read_text(encoding="utf-8")
    block = {"name": "biss_master", "luts": 123, "registers": 45, "mhz": None}
    results = {"delays": DELAYS, "goals": as_json(rows), "blocks": [block, block | {"mhz": 161.7}]}
    results |= {"whole": True}
    text = drive.page_text(page, results)
    for line in (
        "| a | 1.5 us | <= 1.5 us |",
        "| b | 0.75, missed | <= 0.5 |",
        "| c | not measured | >= 125 MHz |",
        "| `biss_master` | 123 | 45 |  |",
        "| `biss_master` | 123 | 45 | 162 |",
        "| middle of the currents' window | compare values in force | 7.0 us |",
    ):
        assert line in text
    assert drive.page_text(text, results) == text
    assert text.count("\n## ") == page.count("\n## ")


def test_page__of_some_producers__changes_their_rows_alone():
    page = drive.PAGE.read_text(encoding="utf-8")
    known, kept = "five current loops on small", "five current loops on fast"
    rows = Rows()
    rows.most(known, 487, "cycles", 700)
    rows.most("a new row", 3, "cycles", 4)
    goals = [row | {"producer": "loops"} for row in as_json(rows)]
    sampled = Rows()
    sampled.most(kept, 5, "cycles", 6)
    goals += [row | {"producer": "path"} for row in as_json(sampled)]
    results = {"goals": goals, "depths": {"loops": True, "path": False}, "whole": False}
    text = drive.page_text(page, results)
    changed = set(text.splitlines()) - set(page.splitlines())
    assert changed == {f"| {known} | 487 cycles | <= 700 cycles |",
                       "| a new row | 3 cycles | <= 4 cycles |"}  # fmt: skip
    assert f"| {kept} | 188 cycles |" in text


def test_page__without_its_marks_is_refused():
    with pytest.raises(ValueError, match="drive.md: error: 0 pairs of marks `<!-- goals"):
        drive.page_text("# Motor drives", {"delays": DELAYS, "goals": [], "blocks": []})


def test_command__without_the_tools_of_the_hardware__names_the_cure(monkeypatch, capsys):
    monkeypatch.setattr(drive, "find_spec", lambda name: None)
    assert drive.main([]) == 1
    assert "make setup-synth" in capsys.readouterr().out
    assert drive.main(["none.toml"]) == 1  # one motor needs none of them
    said = "".join(capsys.readouterr())
    assert "none.toml" in said and "setup-synth" not in said


def test_decoder__a_wrong_count_is_missed__fewer_edges_are_a_sample(monkeypatch):
    monkeypatch.setattr(drive, "campaign", lambda edges, report: Campaign(10**8, 1, 1000, 0))
    rows = Rows()
    drive.decoder(False, rows, print)
    assert [row.met for row in rows] == [None, False, True]
