# SPDX-License-Identifier: Apache-2.0
"""docs/custom_instructions.md, "Add your own": its steps carried out as printed, in a copy."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from sim.rtl.build import ROOT, WAIVERS, verilator_driver
from tests.bench.commands import output

PAGE = ROOT / "docs/custom_instructions.md"
COPIED = ("rtl", "scripts", "nios_sw", "sim/rtl", "asip_asm", "docs")
GROUP = "      always_comb begin\n        combo_result_o = 32'd0;\n"  # of ci_slaves: results of it
LAST = "        if (combo_n_i == ci_pkg::FPGA2_N_FSIGN) combo_result_o = sign;\n"


def blocks(language: str) -> list[str]:
    """Code blocks of the section in order, without the indentation of the list."""
    section = PAGE.read_text(encoding="utf-8").split("## Add your own")[1].split("\n## ")[0]
    found = re.findall(rf"^   ```{language}\n(.*?)^   ```$", section, re.M | re.S)
    return [re.sub(r"(?m)^   ", "", text) for text in found]


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """A copy of the sources with steps 1 to 4 done."""
    root = tmp_path_factory.mktemp("guide")
    for name in COPIED:
        shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", root)  # tells a checkout from an installed wheel
    module, instance, result = blocks("systemverilog")
    (root / "rtl/custom/ci_bswap.sv").write_text(module)
    table = root / "nios_sw/custom.toml"
    table.write_text(table.read_text() + "\n" + blocks("toml")[0])
    slaves = root / "rtl/custom/ci_slaves.sv"
    text = slaves.read_text()
    assert text.count(GROUP) == 1 and text.count(LAST) == 1
    slaves.write_text(text.replace(GROUP, instance + GROUP).replace(LAST, LAST + result))
    (root / "nios_sw/demo/ci_bswap.c").write_text(blocks("c")[0])
    output(sys.executable, root / "scripts/gen_custom.py", env=os.environ | {"PYTHONPATH": root})
    return root


def test_guide__generated_files__have_the_new_instruction(copy):
    assert "FPGA2_N_BSWAP = 8'h00" in (copy / "rtl/gen/ci_pkg.sv").read_text()
    assert "ci_bswap(int a)" in (copy / "docs/ci.md").read_text()
    script = (copy / "scripts/platform_designer/ci_bswap_hw.tcl").read_text()
    assert "opcodeExtensionLockedValue 0x00" in script and "COMBINATORIAL" in script


@pytest.mark.full
def test_guide__hardware__lint_and_a_run_through_the_interconnect(copy):
    source = copy / "try_bswap.sv"
    source.write_text(
        textwrap.dedent(
            """\
            module try_bswap;
              logic [31:0] result, unused_result;
              logic unused_done;
              ci_slaves #(.Platform(2)) slaves (
                .multi_clk_i(1'b0), .multi_reset_i(1'b1),
                .combo_dataa_i(32'h12345678), .combo_datab_i(32'd0), .combo_n_i(8'd0),
                .combo_readra_i(1'b1), .combo_readrb_i(1'b1), .combo_writerc_i(1'b1),
                .combo_a_i(5'd0), .combo_b_i(5'd0), .combo_c_i(5'd0), .combo_result_o(result),
                .multi_clk_en_i(1'b1), .multi_start_i(1'b0), .multi_dataa_i(32'd0),
                .multi_datab_i(32'd0), .multi_n_i(8'd0), .multi_readra_i(1'b1),
                .multi_readrb_i(1'b1), .multi_writerc_i(1'b1), .multi_a_i(5'd0),
                .multi_b_i(5'd0), .multi_c_i(5'd0), .multi_done_o(unused_done),
                .multi_result_o(unused_result));
              initial $finish;
              final $display("%h %b", result, ci_pkg::FPGA2_COMBINATIONAL[0]);
            endmodule
            """
        )
    )
    listing = (
        "import json; from sim.rtl.sources import sources_of; "
        "print(json.dumps([str(path) for path in sources_of('ci_slaves')]))"
    )
    files = json.loads(output(sys.executable, "-c", listing, cwd=copy))
    assert any(name.endswith("ci_bswap.sv") for name in files)
    lint = ["--lint-only", "-Wall", "--quiet", "--top-module", "ci_slaves", WAIVERS]
    output(verilator_driver(), *lint, *files)
    build = ["--cc", "--exe", "--main", "--build", "-Wno-fatal", "--quiet", "-CFLAGS", "-O0"]
    build += ["--top-module", "try_bswap", "--Mdir", copy / "obj"]
    output(verilator_driver(), *build, *files, source)
    assert "78563412 1" in output(copy / "obj/Vtry_bswap")


def test_guide__demo__compiles_and_agrees_on_a_host(copy, tmp_path):
    compiler = [os.environ.get("CC", "gcc"), "-std=c11", "-Wall", "-Wextra", "-Werror"]
    compiler += [f"-I{copy}/nios_sw/include"]
    output(*compiler, copy / "nios_sw/demo/ci_bswap.c", "-lm", "-o", tmp_path / "demo")
    assert output(tmp_path / "demo") == "bswap: software on a host, same result\n"


def test_guide__reference_of_the_page__is_the_function(copy):
    import numpy as np

    (line,) = blocks("python")
    reference = eval("{" + line + "}")["fpga2.bswap"]
    assert reference(np.array([0x12345678], np.uint32)).tolist() == [0x78563412]


def test_guide__forgotten_ports_or_number__refused_with_a_name(copy, tmp_path):
    table = (copy / "nios_sw/custom.toml").read_text()
    (tmp_path / "custom.toml").write_text(table.replace("n = 0\n", "n = 230\n"))
    command = [sys.executable, copy / "scripts/gen_custom.py", "--check", "--source"]
    command += [tmp_path / "custom.toml"]
    environment = os.environ | {"PYTHONPATH": copy}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 1 and "n = 230 is already that of `fcmple`" in done.stderr
