# SPDX-License-Identifier: Apache-2.0
"""Bins, counts of code coverage and planted faults: their tables fit, and holes are reported."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest

from scripts import code_coverage
from sim.cocotb import bins
from sim.rtl import coverage
from sim.rtl.coverage import Point
from tests.bench.faults import RTL
from tests.cocotb import functional, planted

COUNTED = (
    "# SystemC::Coverage-3\n"
    "C '\x01f\x02{root}/rtl/fpu/fp_cmp.sv\x01l\x027\x01n\x0228\x01t\x02toggle\x01page\x02"
    "v_toggle/fp_cmp\x01o\x02op_i[0]:0->1\x01h\x02{top}' {count}\n"
    "C '\x01f\x02{root}/rtl/fpu/fp_cmp.sv\x01l\x029\x01n\x0224\x01t\x02branch\x01page\x02"
    "v_branch/fp_cmp\x01o\x02if\x01S\x0210-12\x01h\x02{top}' 0\n"
    "C '\x01f\x02{root}/rtl/board/asip_de3.sv\x01l\x029\x01n\x024\x01t\x02line\x01page\x02"
    "v_line/asip_de3\x01o\x02block\x01h\x02{top}' 3\n"
)
TOGGLE = Point("rtl/fpu/fp_cmp.sv", 7, 28, "toggle", "op_i[0]:0->1")
BRANCH = Point("rtl/fpu/fp_cmp.sv", 9, 24, "branch", "if")


def test_counts__of_instances_and_files__are_added_and_only_those_of_the_parts(tmp_path):
    for top, count in (("a", 2), ("b", 5)):
        text = COUNTED.format(root=coverage.ROOT, top=top, count=count)
        (tmp_path / f"{top}.dat").write_text(text)
    merged = coverage.merge(sorted(tmp_path.glob("*.dat")), tmp_path / "all.json")
    assert dict(merged) == {TOGGLE: 7, BRANCH: 0} == dict(coverage.load(tmp_path / "all.json"))
    assert [path.name for path in tmp_path.iterdir()] == ["all.json"]
    table = code_coverage.shares(merged)["rtl/fpu"]
    assert (table["toggle"], table["branch"]) == ([1, 1, 0], [0, 1, 0])
    assert code_coverage.holes(merged) == [BRANCH]


@pytest.mark.parametrize(
    ("more", "explains"),
    [
        ({}, True),
        ({"text": ["module fp_cmp"]}, True),
        ({"what": "i."}, True),
        ({"kinds": ["toggle"]}, False),
        ({"text": ["no such text"]}, False),
        ({"what": "i"}, False),
        ({"files": ["rtl/fpu/fp_add.sv"]}, False),
    ],
)
def test_explanation__takes_only_its_holes_out_of_the_share(more, explains, monkeypatch):
    lines = (coverage.ROOT / BRANCH.file).read_text().splitlines()
    (line,) = (n for n, text in enumerate(lines, 1) if text.startswith("module fp_cmp"))
    entry = {"files": [BRANCH.file], "why": "x"} | more
    monkeypatch.setattr(code_coverage, "explanations", lambda: [entry])
    shares = code_coverage.shares({BRANCH._replace(line=line): 0})
    assert shares["rtl/fpu"]["branch"] == ([0, 0, 1] if explains else [0, 1, 0])


def test_explanations__name_files_and_give_reasons():
    for entry in code_coverage.explanations():
        assert all((coverage.ROOT / file).is_file() for file in entry["files"]), entry
        assert entry["why"] and entry.keys() <= {"files", "why", "kinds", "what", "text"}, entry


def test_page__has_the_shares_of_the_data():
    data = json.loads(code_coverage.DATA.read_text(encoding="utf-8"))
    assert code_coverage.page_table(data["suites"], data["parts"]) in code_coverage.PAGE.read_text()
    assert set(data["parts"]) == set(coverage.PARTS)


@pytest.mark.parametrize(
    ("exact", "bits", "name"),
    [
        (Fraction(1), 0x3F800000, "exact"),
        (1 + Fraction(1, 1 << 24), 0x3F800000, "tie_down"),
        (-1 - Fraction(3, 1 << 24), 0xBF800002, "tie_up"),
        (1 + Fraction(1, 1 << 25), 0x3F800000, "down"),
        (1 + Fraction(3, 1 << 25), 0x3F800001, "up"),
    ],
)
def test_rounding__class_of_a_result(exact, bits, name, tmp_path, monkeypatch):
    monkeypatch.setenv("BINS", str(tmp_path / "bins.txt"))
    monkeypatch.setattr(bins, "_hit", set())
    bins.rounding("op", exact, bits)
    assert bins.read([tmp_path / "bins.txt"]) == {f"rounding op {name}"}


def test_results__exceptions_and_classes(tmp_path, monkeypatch):
    monkeypatch.setenv("BINS", str(tmp_path / "bins.txt"))
    monkeypatch.setattr(bins, "_hit", set())
    bins.results("op", np.uint32([0x80000000, 1, 0x7F800000]), np.uint8([0, 3, 5]))
    names = bins.read([tmp_path / "bins.txt"])
    want = {f"exception op {name}" for name in ("none", "of", "uf", "nx")}
    assert names == want | {f"result op {name}" for name in ("zero", "subnormal", "infinite")}


def test_bins__that_are_impossible_are_bins():
    assert functional.IMPOSSIBLE.keys() <= functional.declared()


def test_planted__faults_of_both_tables_are_written_and_selected_by_number():
    planted.write_copies()
    tables = {case.table for case in planted.cases()}
    assert tables == {"units", "own"} and len(planted.cases()) >= 150
    for case in planted.cases():
        kind = "shared" if case.shared else "alone"
        text = planted.copy_of(case.table, kind, case.fault.file).read_text()
        choice = f"chosen == {case.fault.number} ?" if case.shared else case.fault.macro
        assert choice in text and text != (RTL / case.fault.file).read_text(), case.name
