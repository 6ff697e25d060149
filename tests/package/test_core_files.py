# SPDX-License-Identifier: Apache-2.0
"""The blocks as other projects take them: file lists, FuseSoC cores, Bender's manifest."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from asip_asm.project import ROOT
from scripts.gen_core_files import CORES
from sim.rtl.build import file_list, verilator_driver
from sim.rtl.plain import plain
from sim.rtl.sources import sources_of
from tests.bench.commands import output
from tests.bench.needs import require

RTL = ROOT / "rtl"
TOPS = [(core, top) for core, (_, tops) in CORES.items() for top in tops]
QUICK = "fp_fma"  # one unit represents all in the quick tests; tests/fpu elaborates each
CASES = [
    pytest.param(core, top, marks=pytest.mark.full if core == "fpu" and top != QUICK else ())
    for core, top in TOPS
]
LISTS = {
    "asip": ["asip/asip.f"],
    "dual_asip": ["dual/dual.f"],
    "debug_asip": ["debug/debug.f"],
    "drive_front_end": ["drive/drive.f"],
    "biss_port": ["drive/biss_port.f"],
    "ssi_port": ["drive/ssi_port.f"],
    "endat_port": ["drive/endat_port.f"],
    "absolute_position": ["drive/absolute_position.f"],
    "sincos_position": ["drive/sincos_position.f"],
    "hall_decoder": ["drive/hall_decoder.f"],
    "ethercat_slave": ["ethercat/ethercat.f"],
    "motion_front_end": ["motion/motion.f"],
    "n2_core": ["nios/n2_core.f"],
    "n2_system": ["nios/n2_system.f"],
}


@pytest.mark.parametrize("top", LISTS)
def test_file_lists__of_a_block__name_what_it_needs_and_no_more(top: str) -> None:
    listed = [path for name in LISTS[top] for path in file_list(name)]
    assert sorted(listed) == sorted(sources_of(top))


@pytest.mark.quick(
    "fpu-*", "asip-asip_axil", "drive-drive_front_end", "ethercat-ethercat_slave", "nios-n2_core"
)
@pytest.mark.parametrize(("core", "top"), CASES)
def test_fusesoc__every_target_of_a_core__is_linted_by_verilator(
    core: str, top: str, tmp_path: Path
) -> None:
    fusesoc = Path(sys.executable).parent / "fusesoc"
    done = subprocess.run(
        [fusesoc, "--cores-root", plain(RTL), "run", "--target", top, f"microtick:rtl:{core}"],
        cwd=tmp_path,
        env=os.environ | {"PATH": f"{verilator_driver().parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Parse error" not in done.stdout + done.stderr
    assert f"verilator -f microtick_rtl_{core}_" in done.stdout


USER = """CAPI=2:
name: user:design:top:0
filesets:
  rtl: {{files: [top.sv], file_type: systemVerilogSource, depend: ["{depend}"]}}
targets:
  lint:
    flow: lint
    flow_options: {{tool: verilator, verilator_options: [-Wall, --assert]}}
    filesets: [rtl]
    toplevel: top
  build: {{default_tool: quartus, filesets: [rtl], toplevel: top,
          tools: {{quartus: {{family: Stratix III, device: EP3SL150F1152C2}}}}}}
  flow: {{flow: lint, flow_options: {{tool: verilator}}, flags: {{synthesis: true}},
         filesets: [rtl], toplevel: top}}
"""
INSTANCE = """// verilator lint_off PINCONNECTEMPTY
module top (input logic clk_i, input logic rst_ni, output logic irq_o);
  asip u_asip (.clk_i, .rst_ni, .address_i('0), .read_i(1'b0), .write_i(1'b0), .writedata_i('0),
      .readdata_o(), .waitrequest_o(), .irq_o, .trace_issue_o(), .trace_pc_o(), .trace_write_o(),
      .trace_index_o(), .trace_data_o(), .hook_i('0), .hook_o());
endmodule
"""


def fusesoc(folder: Path, target: str, depend: str, *options: str) -> subprocess.CompletedProcess:
    """FuseSoC's run of a target of a user's core that depends on one of ours."""
    user = folder / "user"
    user.mkdir(exist_ok=True)
    (user / "top.sv").write_text(INSTANCE, encoding="utf-8")
    (user / "top.core").write_text(USER.format(depend=depend), encoding="utf-8")
    roots = [f"--cores-root={plain(path)}" for path in (user, RTL, ROOT / "sim/rtl/assertions")]
    tool = Path(sys.executable).parent / "fusesoc"
    return subprocess.run(
        [tool, *roots, "run", f"--target={target}", *options, "user:design:top:0"],
        cwd=folder,
        env=os.environ | {"PATH": f"{verilator_driver().parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
    )


@pytest.mark.parametrize(
    "depend",
    [pytest.param("microtick:rtl:asip", marks=pytest.mark.full), "microtick:assertions:asip"],
)
def test_fusesoc__of_a_user__has_no_warning_of_our_files(depend: str, tmp_path: Path) -> None:
    done = fusesoc(tmp_path, "lint", depend)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and "arning" not in said.replace("-Wno", ""), said
    listed = (tmp_path / "build/user_design_top_0/lint/user_design_top_0.vc").read_text()
    assert "waivers.vlt" in listed and "SYNTHESIS" not in listed
    assert ("asip_control_sva.sv" in listed) == ("assertions" in depend)


def test_fusesoc__for_quartus__defines_synthesis_and_has_no_waivers(tmp_path: Path) -> None:
    done = fusesoc(tmp_path, "build", "microtick:rtl:asip", "--setup")
    assert done.returncode == 0, done.stdout + done.stderr
    (script,) = tmp_path.rglob("*.tcl")
    text = script.read_text()
    assert "SYNTHESIS=1" in text or "SYNTHESIS=true" in text
    assert "asip.sv" in text and "waivers" not in text
    done = fusesoc(tmp_path, "flow", "microtick:rtl:asip", "--setup")
    assert done.returncode == 0, done.stdout + done.stderr
    listed = (tmp_path / "build/user_design_top_0/flow/user_design_top_0.vc").read_text()
    assert "SYNTHESIS" in listed and "waivers" not in listed


def test_fusesoc__assertions__of_every_core_bind_to_files_that_the_core_has() -> None:
    for core in CORES:
        found = yaml.safe_load((ROOT / f"sim/rtl/assertions/{core}.core").read_text())
        files = [file for part in found["filesets"].values() for file in part["files"]]
        assert files and len(files) == len(set(files))
        own = {Path(path).stem for top in CORES[core][1] for path in sources_of(top)}
        assert {file.removesuffix("_sva.sv") for file in files} <= own
    bound = {path.name for path in (ROOT / "sim/rtl/assertions").glob("*_sva.sv")}
    listed = (ROOT / f"sim/rtl/assertions/{core}.core" for core in CORES)
    named = {name for path in listed for name in re.findall(r"\w+_sva\.sv", path.read_text())}
    assert bound - named == {"encoder_registers_sva.sv"}  # of the boards, which are no core


def test_bender__a_project_that_depends_on_ours__gets_files_that_elaborate(tmp_path: Path) -> None:
    bender = require("bender")
    shutil.copytree(RTL, tmp_path / "microtick/rtl")
    shutil.copytree(ROOT / "sim/rtl/assertions", tmp_path / "microtick/sim/rtl/assertions")
    user = tmp_path / "user"
    user.mkdir()
    (user / "top.sv").write_text("module top; endmodule\n", encoding="utf-8")
    (user / "Bender.yml").write_text(
        "package: {name: user}\n"
        "dependencies: {microtick: {path: ../microtick/rtl}}\n"
        "sources: [top.sv]\n",
        encoding="utf-8",
    )
    for_vivado = output(bender, "script", "vivado", cwd=user)
    assert " SYNTHESIS \\" in for_vivado and "_sva" not in for_vivado
    assert "+define+SYNTHESIS" not in output(bender, "script", "flist-plus", cwd=user)
    bound = output(bender, "script", "verilator", "-t", "microtick_assertions", cwd=user)
    assert "asip_control_sva.sv" in bound and "+define+SYNTHESIS" not in bound.split()
    assert "assertions.vlt" in bound
    script = output(bender, "script", "verilator", cwd=user)
    assert "_sva" not in script and "+define+SYNTHESIS" in script.split()
    (user / "files.f").write_text(script, encoding="utf-8")
    listed = {Path(line).name for line in script.splitlines() if line.endswith(".sv")}
    assert listed == {path.name for _, top in TOPS for path in sources_of(top)} | {"top.sv"}
    for top in ("n2_system", "motion_axil", "dual_asip"):
        # One top leaves most constants of the other blocks' packages unused.
        options = ["--lint-only", "-Wall", "-Wno-UNUSEDPARAM", "--top-module", top]
        said = output(verilator_driver(), *options, "-f", "files.f", cwd=user)
        assert "arning" not in said
