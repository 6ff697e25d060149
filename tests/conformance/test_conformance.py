# SPDX-License-Identifier: Apache-2.0
"""The suites of others: how their results are read, a sample of each, and all of them in full."""

from __future__ import annotations

import pytest

from tests.bench.needs import needs
from tests.conformance import coremark, dap_sessions, gdb_suite, page, torture
from tests.conformance.machine import MACHINES
from tests.conformance.tools import ToolError

GCC_SUMMARY = """
PASS: gcc.c-torture/execute/a.c   -O0  (test for excess errors)
PASS: gcc.c-torture/execute/a.c   -O0  execution test
PASS: gcc.c-torture/execute/b.c   -O2  (test for excess errors)
FAIL: gcc.c-torture/execute/b.c   -O2  execution test
FAIL: gcc.c-torture/execute/c.c   -Os  (test for excess errors)
UNSUPPORTED: gcc.c-torture/execute/d.c   -Os
PASS: gcc.c-torture/execute/ieee/e.c execution,  -Os
FAIL: gcc.c-torture/execute/ieee/f.c execution,  -Os
PASS: gcc.c-torture/execute/g.c   -O0  execution test
"""
GROUPS = [
    {"reason": "stated", "tests": ["ieee/f.c", "g.c"], "systems": ["fpga2"]},
    {"reason": "elsewhere", "tests": ["b.c"], "levels": ["-O0"]},
]


def test_gcc_summary__each_test_has_one_fate(tmp_path, monkeypatch):
    (tmp_path / "gcc.sum").write_text(GCC_SUMMARY)
    monkeypatch.setattr(torture, "exclusions", lambda: GROUPS)
    outcome = torture.judge("fpga2", tmp_path / "gcc.sum")
    assert (outcome.passed, outcome.unsupported) == (2, 1)
    assert outcome.failed == ["b.c -O2", "c.c -Os"]
    assert outcome.excluded == {"stated": 2} and outcome.unused == ["g.c -O0"]
    assert "ieee/f.c -Os" in torture.judge("qemu", tmp_path / "gcc.sum").failed


def test_gcc_part__replaces_results_of_its_tests(tmp_path, monkeypatch):
    (tmp_path / "gcc.sum").write_text(GCC_SUMMARY)
    (tmp_path / "part.sum").write_text("PASS: gcc.c-torture/execute/b.c   -O2  execution test\n")
    monkeypatch.setattr(torture, "exclusions", lambda: GROUPS)
    outcome = torture.judge("fpga2", tmp_path / "gcc.sum", tmp_path / "part.sum")
    assert outcome.passed == 3 and outcome.failed == ["c.c -Os"]


def test_gcc_last_whole_run__counts_only_if_it_ended_on_the_same_rtl(tmp_path, monkeypatch):
    monkeypatch.setattr(torture, "FOLDER", tmp_path)
    place = torture.folder("fpga1")
    place.mkdir()
    summary, mark = place / "gcc.sum", place / "rtl.txt"
    for text, rtl, counts in (
        (GCC_SUMMARY, torture.rtl_mark(torture.RTL), False),
        (GCC_SUMMARY + "=== gcc Summary ===", torture.rtl_mark(torture.RTL), True),
        (GCC_SUMMARY + "=== gcc Summary ===", "other", False),
    ):
        summary.write_text(text)
        mark.write_text(rtl)
        assert torture.last_whole("fpga1") == ([summary] if counts else [])


def test_gdb_summary__a_failure_needs_a_reason():
    lines = [
        "Running /x/gdb.base/a.exp ...",
        "PASS: gdb.base/a.exp: one",
        "FAIL: gdb.base/a.exp: mode=1: two",
        "Running /x/gdb.base/b.exp ...",
        "FAIL: gdb.base/b.exp: mode=1: two",
    ]
    rows = [
        gdb_suite.explain(row, {"a.exp": {"mode=1: *": "why", "mode=2: *": "why"}})
        for row in gdb_suite.judge(lines)
    ]
    assert [row["counts"] for row in rows] == [{"PASS": 1, "FAIL": 1}, {"FAIL": 1}]
    assert [row["failed"] for row in rows] == [["no failure matches: mode=2: *"], ["mode=1: two"]]
    again = gdb_suite.explain(rows[0], {"a.exp": {"mode=1: two": "why"}})
    assert (again["explained"], again["failed"]) == (["mode=1: two"], [])
    assert rows[0]["explained"] == ["mode=1: two"]


COREMARK_RUN = """2K performance run parameters for coremark.
Total ticks      : 4000000
Iterations       : 10
Compiler version : GCC 1
Correct operation validated. See README.md for run and reporting rules.
"""


def test_coremark__a_run_counts_only_if_its_checksums_are_right():
    assert coremark.score("fpga2", "-O2", COREMARK_RUN, 0).per_mhz == 2.5
    for console, status in (
        (COREMARK_RUN.replace(coremark.VALID, "Errors detected"), 0),
        (COREMARK_RUN.replace("2K performance", "2K validation"), 0),
        (COREMARK_RUN, 1),
        (COREMARK_RUN, None),
    ):
        with pytest.raises(ToolError, match="not valid on fpga2"):
            coremark.score("fpga2", "-O2", console, status)


def test_tables_of_reasons__name_each_test_once():
    files = gdb_suite.table()["files"]
    assert len(files) == len(set(files)) > 100
    assert set(gdb_suite.table()["expected"]) <= set(files)
    for group in torture.exclusions():
        assert set(group) <= {"reason", "tests", "systems", "levels"}
        assert group["reason"].endswith(".") and group["tests"]
        assert set(group.get("systems", MACHINES)) <= set(MACHINES)
        assert set(group.get("levels", torture.LEVELS)) <= set(torture.LEVELS)


def test_page__has_a_row_for_each_file():
    row = {"file": "gdb.base/a.exp", "counts": {"PASS": 3}, "failed": ["x"], "explained": []}
    text = page.gdb_section({"files": [row]})
    assert "| `a.exp` | 3 | 0 | 0 | 0 | 1 |\n| all | 3 | 0 | 0 | 0 | 1 |" in text


@pytest.mark.full
@needs("npm")
def test_debug_adapter_under_the_test_client_of_vs_code():
    found = dap_sessions.measure(full=True)
    failed = [check for checks in found.values() for check in checks if not check["passed"]]
    assert failed == [] and len(found) == 3


@pytest.mark.full
@needs("nios-gcc", "nios-gdb", "dejagnu")
def test_gdb_stub_under_gdbs_own_tests():
    assert [row["failed"] for row in gdb_suite.measure([]) if row["failed"]] == []


@pytest.mark.full
@needs("nios-gcc", "qemu", "dejagnu")
def test_execution_tests_of_gcc():
    found = torture.measure(MACHINES)
    assert {system: outcome.failed for system, outcome in found.items() if outcome.failed} == {}
    assert all(outcome.passed > 4_000 for outcome in found.values())
