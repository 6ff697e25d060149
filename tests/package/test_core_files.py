# SPDX-License-Identifier: Apache-2.0
"""The blocks as other projects take them: file lists, FuseSoC cores, Bender's manifest."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from scripts.gen_core_files import CORES
from sim.harness.build import file_list, verilator_driver
from sim.harness.plain import plain
from sim.harness.sources import sources_of
from tests.bench.commands import output
from tests.bench.needs import require

RTL = ROOT / "rtl"
TOPS = [(core, top) for core, (_, tops) in CORES.items() for top in tops]
QUICK = "fp_fma"  # one unit stands for all in the quick tests; tests/fpu elaborates each
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
    "ethercat_slave": ["ethercat/ethercat.f"],
    "motion_front_end": ["motion/motion.f"],
    "n2_core": ["nios/n2_core.f"],
    "n2_system": ["nios/n2_system.f"],
}


@pytest.mark.parametrize("top", LISTS)
def test_file_lists__of_a_block__name_what_it_needs_and_no_more(top: str) -> None:
    listed = [path for name in LISTS[top] for path in file_list(name)]
    assert sorted(listed) == sorted(sources_of(top))


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


def test_bender__a_project_that_depends_on_ours__gets_files_that_elaborate(tmp_path: Path) -> None:
    bender = require("bender")
    shutil.copytree(RTL, tmp_path / "microtick")
    user = tmp_path / "user"
    user.mkdir()
    (user / "top.sv").write_text("module top; endmodule\n", encoding="utf-8")
    (user / "Bender.yml").write_text(
        "package: {name: user}\n"
        "dependencies: {microtick: {path: ../microtick}}\n"
        "sources: [top.sv]\n",
        encoding="utf-8",
    )
    script = output(bender, "script", "verilator", cwd=user)
    (user / "files.f").write_text(script, encoding="utf-8")
    listed = {Path(line).name for line in script.splitlines() if line.endswith(".sv")}
    assert listed == {path.name for _, top in TOPS for path in sources_of(top)} | {"top.sv"}
    for top in ("n2_system", "motion_axil", "dual_asip"):
        # One top leaves most constants of the other blocks' packages unused.
        options = ["--lint-only", "-Wall", "-Wno-UNUSEDPARAM", "--top-module", top]
        output(verilator_driver(), *options, plain(RTL / "waivers.vlt"), "-f", "files.f", cwd=user)
