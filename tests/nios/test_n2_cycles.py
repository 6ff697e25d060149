# SPDX-License-Identifier: Apache-2.0
"""Cycles per instruction of the Nios II core: measured, compared with Nios II/f and the docs."""

from __future__ import annotations

import pytest

from sim.rtl.n2_lockstep_cycles import DOCUMENT, ROWS, main, measure, page_text
from tests.nios.n2_bench import core


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_instruction__cycles__as_nios2_f_or_better(row):
    found = measure(core(), row)
    if row.vendor is None:
        return
    if row.differs:
        assert found < row.vendor
    else:
        assert found == row.vendor


def test_cycle_table__in_the_documentation__is_what_was_measured():
    document = DOCUMENT.read_text(encoding="utf-8")
    assert page_text(document, core()) == document, "run: microtick nios-cycles"


def test_command__document_without_marks__says_which_lines_it_needs(tmp_path, capsys):
    path = tmp_path / "page.md"
    path.write_text("no marks\n")
    assert main(["--document", str(path)]) == 1
    assert f"{path}: error: 0 pairs of marks `<!-- cycles: " in capsys.readouterr().err
