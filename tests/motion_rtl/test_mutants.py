# SPDX-License-Identifier: Apache-2.0
"""Planted faults in the motion front-end (mutants.toml): each must make its quick test fail.

One fault: `pytest -m full tests/motion_rtl/test_mutants.py -k "21-step_output"`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.harness import interpolator_rtl, motion_rtl
from sim.harness.build import ROOT
from tests.bench.faults import RTL, copy, load
from tests.bench.one_test import exit_status
from tests.motion_rtl import test_interpolators, test_pulse_generator

HERE = Path(__file__).parent
HARNESSES = (motion_rtl, interpolator_rtl, test_pulse_generator)
# Modules that do no arithmetic and hold no state of their own.
NOT_MUTATED = {"motion_axil"}
FAULTS = load(HERE / "mutants.toml")


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for one test on the sources in `folder` instead of rtl/motion."""
    for harness in HARNESSES:
        monkeypatch.setattr(harness, "FOLDERS", (folder, ROOT / "rtl/gen"))
    test_interpolators.rtl.cache_clear()
    try:
        return exit_status(HERE, name)
    finally:
        test_interpolators.rtl.cache_clear()


def test_table__every_module_has_a_fault() -> None:
    assert len({(fault.file, fault.right, fault.wrong) for fault in FAULTS}) == len(FAULTS) >= 15
    modules = {path.stem for path in (RTL / "motion").glob("*.sv")} - NOT_MUTATED
    assert {Path(fault.file).stem for fault in FAULTS} == modules


def test_no_fault__the_copy_passes(tmp_path, monkeypatch) -> None:
    folder = copy(tmp_path / "rtl", [], part="motion")
    assert run(FAULTS[0].found[0], folder, monkeypatch) == pytest.ExitCode.OK


@pytest.mark.full
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_fault__is_caught(fault, tmp_path, monkeypatch) -> None:
    (test,) = fault.found
    status = run(test, copy(tmp_path / "rtl", [fault], part="motion"), monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
