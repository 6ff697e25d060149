# SPDX-License-Identifier: Apache-2.0
"""docs/units.md says what the RTL says; its example elaborates; intervals are measured."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from asip_asm.machine import load_machine
from scripts import units_page
from scripts.units_page import PAGE, RTL, PageError, main
from sim.core.fpbench.native import LANES
from sim.core.fpbench.variants import bench_unit
from sim.rtl.build import ROOT, verilator_driver
from sim.rtl.figures import rtl_mark
from sim.rtl.plain import plain
from sim.rtl.sources import sources_of
from tests.bench.commands import output
from tests.bench.copies import edited, edited_folder

RANK_OF_THE_BENCH = 1  # in front of the lanes; an iterative unit waits for it too


def changed(folder: Path, file: str, old: str, new: str) -> Path:
    """A copy of rtl/fpu with one replacement, which must apply."""
    return edited_folder(RTL, folder / "fpu", file, re.escape(old), new)


def test_page__present_rtl__is_up_to_date(capsys) -> None:
    assert main(["--check"]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Latency 4, interval 1.", "Latency 3, interval 1."),
        ("| `sub_i` | input |", "| `sub_i` | output |"),
        ("| [`fp_mul`]", "| [`fp_none`]"),
        ("microtick fp bench --op div", "microtick fp bench --op mul"),
    ],
)
def test_check__block_edited_by_hand__is_refused(
    old: str, new: str, tmp_path: Path, capsys
) -> None:
    page = edited(PAGE, tmp_path, old, new)
    assert main(["--check", "--page", str(page)]) == 1
    assert "differs from the RTL or its figures; python scripts/units" in capsys.readouterr().err


def test_page__section_missing__names_it(tmp_path: Path, capsys) -> None:
    page = tmp_path / "units.md"
    page.write_text(PAGE.read_text().replace("<!-- begin fp_lzc -->", ""))
    assert main(["--page", str(page)]) == 1
    assert "0 places `<!-- begin fp_lzc -->`" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("// fp_lzc: number", "// number", "header must start with `// fp_lzc: `"),
        ("input  logic [(1<<CountWidth)-1:0] value_i", "inout x", "cannot read `inout x,`"),
        ("module fp_lzc", "module lzc", "no `module fp_lzc"),
    ],
)
def test_module__that_cannot_be_read__is_an_error(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    copy = changed(tmp_path, "fp_lzc.sv", old, new)
    with pytest.raises(PageError, match=re.escape(message)):
        units_page.header("fp_lzc", copy)
        units_page.ports("fp_lzc", copy)


def test_units__file_list_without_latency__is_an_error(tmp_path: Path) -> None:
    copy = changed(tmp_path, "fp_pkg.sv", "FP_CMP_LATENCY", "FP_COMPARE_LATENCY")
    with pytest.raises(PageError, match="each unit needs both"):
        units_page.units(copy)


def test_mark__of_sources__sees_code_but_no_comment_and_no_other_latency(tmp_path: Path) -> None:
    mark = rtl_mark("fp_i2f")
    for n, (file, old, new, same) in enumerate(
        [
            ("fp_round.sv", "// fp_round:", "// fp_round, again:", True),
            ("fp_pkg.sv", "FP_ADD_LATENCY = 4", "FP_ADD_LATENCY = 5", True),
            ("fp_round.sv", "guard_i || round_i", "guard_i && round_i", False),
        ]
    ):
        copy = changed(tmp_path / str(n), file, old, new)
        assert (rtl_mark("fp_i2f", folders=(copy,)) == mark) is same, file


def test_example__of_the_page__elaborates_with_the_file_list(tmp_path: Path) -> None:
    example = re.search(r"```systemverilog\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert example
    source = tmp_path / "distance.sv"
    source.write_text(example[1])
    options = ["--lint-only", "-Wall", "-Wno-UNUSEDSIGNAL", "--quiet", "--top-module", "distance"]
    lists = ["-f", "rtl/fpu/fp_add.f", source]
    output(verilator_driver(), *options, *lists, cwd=ROOT)


def printed_commands(tool: str) -> list[str]:
    """Commands of that tool on the page, in its order: in the top folder, elsewhere."""
    blocks = re.findall(r"```sh\n(.*?)```", PAGE.read_text(), re.DOTALL)
    return [line for block in blocks for line in block.splitlines() if line.startswith(tool)]


@pytest.mark.parametrize("unit", units_page.units())
def test_commands__of_the_page__lint_each_unit_in_the_top_folder_and_elsewhere(
    unit: str, tmp_path: Path
) -> None:
    commands = printed_commands("verilator")
    assert len(commands) == 2 and all("-Wall" in command for command in commands)
    path = f"{verilator_driver().parent}:{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "MICROTICK": str(plain(ROOT))}
    for command, folder in zip(commands, (ROOT, tmp_path), strict=True):
        done = subprocess.run(
            command.replace("fp_add", unit),
            shell=True,
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert (done.returncode, done.stderr) == (0, ""), command


def test_commands__of_the_page__both_give_yosys_the_same_files(tmp_path: Path) -> None:
    here, elsewhere = (command.partition("-sv ")[2] for command in printed_commands("yosys"))
    listed = []
    for words, folder in ((here, ROOT), (elsewhere, tmp_path)):
        printed = f'printf %s "{words.partition(";")[0]}"'
        environment = os.environ | {"MICROTICK": str(plain(ROOT))}
        files = output("/bin/sh", "-c", printed, cwd=folder, env=environment).split()
        listed.append([(folder / file).resolve() for file in files])
    assert listed[0] == listed[1] == sources_of("fp_add")


def test_synthesis_macro__units_with_checks_are_named(tmp_path: Path) -> None:
    assert units_page.checked_files("fp_divsqrt_folded") == ["fp_divsqrt_folded.sv"]
    assert units_page.checked_files("fp_cmp") == []
    copy = changed(
        tmp_path, "fp_cmp.sv", "module fp_cmp", "`ifndef SYNTHESIS\n`endif\nmodule fp_cmp"
    )
    assert units_page.checked_files("fp_cmp", copy) == ["fp_cmp.sv"]
    for unit in units_page.units():
        told = re.search(rf"<!-- begin {unit} -->.*?`SYNTHESIS`: ([^.]*)", PAGE.read_text(), re.S)
        assert told and (told[1] == "not used") == (not units_page.checked_files(unit))


@pytest.mark.quick("fp_sincos-sin")
@pytest.mark.parametrize(
    ("unit", "op"),
    [
        *(("fp_mul", "mul"), ("fp_divsqrt_folded", "div")),
        *(("fp_sincos", "sin"), ("fp_sincos_overlapped", "cos")),
    ],
)
def test_interval__of_the_page__is_the_measured_one(unit: str, op: str) -> None:
    bench = bench_unit(unit)
    lanes = LANES[bench.name]
    few, more = (bench.run_list(op, [[0x3F800000] * 3] * n * lanes) for n in (100, 200))
    iterative = any(port.name == "ready_o" for port in units_page.ports(unit))
    step = units_page.interval(unit) + (RANK_OF_THE_BENCH if iterative else 0)
    assert more.cycles - few.cycles == 100 * step
    assert few.cycles == 99 * step + units_page.latency(unit) + RANK_OF_THE_BENCH


def test_interval__folded_divider__is_that_of_the_machine_description() -> None:
    assert (
        units_page.interval("fp_divsqrt_folded") == load_machine("small").units["divsqrt"].interval
    )


def test_interval__folded_unit_that_does_not_state_it__is_an_error(tmp_path: Path) -> None:
    copy = changed(tmp_path, "fp_divsqrt_folded.sv", "Interval = 7;", "Interval = 3 + 4;")
    with pytest.raises(PageError, match="no `Interval = <clocks>;`"):
        units_page.interval("fp_divsqrt_folded", copy)
