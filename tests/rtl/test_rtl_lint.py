# SPDX-License-Identifier: Apache-2.0
"""Each module below rtl/ is clean alone: Verilator -Wall with only the sources that it names."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from pyslang import ast, syntax

from scripts import lint_rtl
from sim.rtl.build import verilator_driver
from sim.rtl.sources import sources_of

ROOT = Path(__file__).resolve().parents[2]
VERILATOR = verilator_driver()
WAIVERS = [ROOT / "rtl/waivers.vlt", ROOT / "tests/rtl/alone.vlt"]
MODULES = sorted(path.stem for path in (ROOT / "rtl").rglob("*.sv") if path.stem[-4:] != "_pkg")
CONFIGURATIONS = {
    "asip": ({"FmaPipes": 2, "Slots": 3}, {"FmaPipes": 1, "Slots": 1}),
    "asip_de3": ({"FmaPipes": 2, "Slots": 3}, {"FmaPipes": 1, "Slots": 1}),
}
CASES = [(module, set_) for module in MODULES for set_ in CONFIGURATIONS.get(module, ({},))]


def lint(
    top: str, files: list[Path | str], parameters: dict[str, int]
) -> subprocess.CompletedProcess:
    options = [f"-G{name}={value}" for name, value in parameters.items()]
    return subprocess.run(
        [VERILATOR, "--lint-only", "-Wall", "--quiet", "--top-module", top, *options]
        + [*WAIVERS, *files],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


@pytest.mark.quick(
    "asip-*",
    "dual_asip",
    "debug_asip",
    "drive_front_end",
    "motion_front_end",
    "ethercat_slave",
    "n2_core",
    "fp_fma",
)
@pytest.mark.parametrize(
    ("module", "parameters"),
    CASES,
    ids=["-".join([name, *map(str, given.values())]) for name, given in CASES],
)
def test_module_elaborates_alone_without_a_warning(module, parameters):
    done = lint(module, sources_of(module), parameters)
    assert done.returncode == 0, done.stderr


def test_lint_refuses_a_signal_that_nothing_reads(tmp_path):
    text = (ROOT / "rtl/fpu/fp_lzc.sv").read_text()
    broken = tmp_path / "fp_lzc.sv"
    broken.write_text(text.replace(");", ");\n  logic [3:0] stray;", 1))
    done = lint("fp_lzc", [broken], {})
    assert done.returncode != 0
    assert "UNUSEDSIGNAL" in done.stderr or "UNDRIVEN" in done.stderr, done.stderr


def test_board_top_with_its_pll_elaborates_against_the_ports_of_altpll(tmp_path):
    text = (ROOT / "rtl/board/board_pll.sv").read_text()
    names = re.findall(r"^\s*\.(\w+)\s*\((?=[\"\d])", text, re.M)  # constants: parameters
    assert {"clk0_multiply_by", "clk0_divide_by", "inclk0_input_frequency"} <= set(names)
    box = (ROOT / "scripts/quartus/altpll.v").read_text()
    assert set(names) == set(re.findall(r"parameter (\w+)", box))
    stand_in = tmp_path / "altpll.sv"
    drive = "  assign {clk, locked} = {width_clock + 1{inclk[0]}};\nendmodule"
    stand_in.write_text(box.replace("endmodule", drive))
    files = [stand_in, *sources_of("asip_de3")]
    options = ["-DQUARTUS", "-Wno-UNUSEDPARAM", "-Wno-UNUSEDSIGNAL"]  # of the substitute
    done = lint("asip_de3", [*options, *files], {})
    assert done.returncode == 0, done.stderr


# What Verilator forgives and the standard does not.
REFUSED = {
    "use before the declaration": ("assign late = 1'b0;\n  logic late;", "before its declaration"),
    "two processes write a register": (
        "logic twice_q;\n  initial twice_q = 1'b0;\n  always_ff @(posedge clk_i) twice_q <= 1'b1;",
        "multiple-always-assigns",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_slang__what_verilator_forgives__is_refused(tmp_path, capfd, case):
    body, message = REFUSED[case]
    file = tmp_path / "planted.sv"
    file.write_text(f"module planted (input logic clk_i);\n  {body}\nendmodule\n")
    assert not lint_rtl.run_slang("planted", [str(file)], ())
    assert message in "".join(capfd.readouterr())


def test_slang__warning_that_is_not_waived__is_refused(tmp_path, capfd):
    file = tmp_path / "planted.sv"
    ports = "input logic [4:0] x_i, output logic [3:0] x_o"
    file.write_text(f"module planted ({ports});\n  assign x_o = x_i;\nendmodule\n")
    assert not lint_rtl.run_slang("planted", [str(file)], ())
    assert "width-trunc" in "".join(capfd.readouterr())


def test_widths_beside_packed_structs_are_the_widths_of_the_structs():
    compilation = ast.Compilation()
    compilation.addSyntaxTree(syntax.SyntaxTree.fromFile(str(ROOT / "rtl/asip/asip_pkg.sv")))
    members = {member.name: member for member in compilation.getPackage("asip_pkg")}
    for name, constant in (("decoded_t", "DECODED_WIDTH"), ("tag_t", "TAG_WIDTH")):
        width = members[name].targetType.type.bitWidth
        assert int(members[constant].value.value) == width, constant
