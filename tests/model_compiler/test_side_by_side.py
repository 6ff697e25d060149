# SPDX-License-Identifier: Apache-2.0
"""`microtick side-by-side`: what it measures is there and in order; times are free."""

from __future__ import annotations

import json

import pytest

from sim.bench.platforms import __main__ as command
from sim.bench.platforms import compare
from sim.laws.native.law import CompilerError
from tests.bench.needs import needs

OPTIONS = ["--law", "pendulum", "--runs", "2000"]


@needs("nios-gcc")
def test_every_platform_is_measured_and_has_the_interpreters_bits(tmp_path, capsys):
    assert command.main([*OPTIONS, "--output", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "side_by_side.json").read_text())
    for name in ("core", "fpga2", "pc"):
        assert found[name]["bits_equal"] and found[name]["form"] in compare.FORMS
    core, fpga2 = found["core"], found["fpga2"]
    assert core["cycles_min"] == core["cycles_max"] < fpga2["cycles_max"]
    assert core["worst_us"] == core["cycles_max"] / 125
    for times in (found["pc"]["pinned"], found["pc"]["unpinned"]):
        assert times["median_us"] <= times["p9999_us"] <= times["worst_us"]
    text = command.section(found)
    assert f"| {core['cycles_max']} |" in text and found["pc"]["machine"]["compiler"] in text
    area = command.area_section(found["area"]["tops"])
    for top in compare.TOPS.values():
        assert f"| {found['area']['tops'][top]['aluts']} |" in area


def result(difference: str = "") -> dict:
    row = {"form": "as written", "bits_equal": not difference, "first_difference": difference}
    cycles = {"clock_mhz": 100, "ticks": 3, "cycles_min": 7, "cycles_max": 9, "worst_us": 0.09}
    times = {"median_us": 0.1, "p9999_us": 0.2, "worst_us": 3.0, "clock_us": 0.02}
    pc = row | {"pinned": times, "unpinned": times, "runs": 5}
    return {"law": "x", "core": row | cycles, "fpga2": row | cycles, "pc": pc}


def test_other_bits_are_the_exit_status(tmp_path, monkeypatch, capsys):
    for difference, status in (("", 0), ("torque, tick 2", 1)):
        monkeypatch.setattr(command, "side_by_side", lambda *_, d=difference: result(d))
        assert command.main([*OPTIONS, "--output", str(tmp_path)]) == status
    shown = capsys.readouterr().out
    assert "platforms: fpga2: bits differ: torque, tick 2" in shown and "7..9" in shown


def test_missing_cross_compiler_is_told_with_its_cure(tmp_path, monkeypatch, capsys):
    def missing(*_):
        raise CompilerError("help:  make tools T=nios-toolchain builds it (once)")

    monkeypatch.setattr(command, "side_by_side", lambda request, say: missing())
    assert command.main([*OPTIONS, "--output", str(tmp_path)]) == 1
    assert "make tools T=nios-toolchain" in capsys.readouterr().err


@pytest.mark.parametrize("option", (["--runs", "0"], ["--law", "nobody"]))
def test_wrong_option_is_refused(option):
    with pytest.raises(SystemExit, match="^2$"):
        command.main(option)
