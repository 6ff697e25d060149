# SPDX-License-Identifier: Apache-2.0
"""`asip-run --coverage`: executions and cycles of source lines over all runs."""

from __future__ import annotations

import csv
from pathlib import Path

from sim.debug.asip_run.__main__ import main

SOURCE = """.program  "two ways"
.input    x
.output   y, safe = 0.0
        flt     below, x, zero
        fadd    result, x, zero
        bz      below, done
        fadd    result, x, x
done:
        mov     y, result
        halt
"""


def covered(folder: Path, *values: float) -> tuple[list[dict[str, str]], str]:
    """Rows of the table and the listing, for a run per value of x."""
    source, table = folder / "ways.s", folder / "ways.csv"
    source.write_text(SOURCE)
    (folder / "x.csv").write_text("x\n" + "".join(f"{value}\n" for value in values))
    arguments = [str(source), "--inputs", str(folder / "x.csv"), "--coverage", str(table)]
    assert main(arguments) == 0
    with open(table) as file:
        return list(csv.DictReader(file)), table.with_suffix(".lst").read_text()


def test_lines__their_executions_add_up_and_their_cycles_are_those_of_the_core(tmp_path, capsys):
    rows, listing = covered(tmp_path, -1.0, -2.0, 3.0)
    executions = {int(row["line"]): int(row["executions"]) for row in rows}
    assert executions == {4: 3, 5: 3, 6: 3, 7: 2, 9: 3}
    core = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    mean = sum(int(row["cycles"]) for row in core) / len(core)
    assert abs(sum(float(row["cycles_per_run"]) for row in rows) - mean) < 0.01
    assert "5 of 5 lines" in listing and "#" not in listing


def test_line_that_no_run_executes__is_marked(tmp_path, capsys):
    rows, listing = covered(tmp_path, 1.0)
    assert {row["line"] for row in rows if row["executions"] == "0"} == {"7"}
    assert "4 of 5 lines" in listing
    assert [line.split()[2:4] for line in listing.splitlines() if "#" in line] == [["#", "7"]]


def test_file_that_would_be_overwritten__or_no_csv__is_refused(tmp_path, capsys):
    source = tmp_path / "ways.s"
    source.write_text(SOURCE)
    assert main([str(source), "--coverage", str(source)]) == 1
    assert main([str(source), "--coverage", str(tmp_path / "a.lst")]) == 2
    assert main([str(source), "--iss", "--coverage", str(tmp_path / "a.csv")]) == 2
    assert main([str(tmp_path / "a.asip.json"), "--coverage", str(tmp_path / "a.csv")]) == 2
    assert source.read_text() == SOURCE and not (tmp_path / "a.csv").exists()
