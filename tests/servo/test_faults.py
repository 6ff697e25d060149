# SPDX-License-Identifier: Apache-2.0
"""Planted faults in the blocks of a drive (faults.toml): each must make its test fail.

One fault: `pytest -m full tests/servo/test_faults.py -k "8-pwm_phase"`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from asip_asm.project import ROOT
from sim.harness import dual_rtl
from sim.harness.sources import sources_of
from tests.bench.faults import RTL, copy, load
from tests.bench.one_test import exit_status
from tests.servo import clocked

HERE = Path(__file__).parent
FAULTS = load(HERE / "faults.toml")


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for one test on the sources in `folder` instead of rtl/drive."""
    monkeypatch.setattr(clocked, "FOLDERS", (folder, ROOT / "rtl/gen"))
    monkeypatch.setattr(dual_rtl, "sources_of", lambda top: sources_of(top, (RTL, folder)))
    return exit_status(HERE, name)


def test_table__every_module_has_a_fault() -> None:
    assert {Path(fault.file).stem for fault in FAULTS} == {
        path.stem for path in (RTL / "drive").glob("*.sv")
    }


def test_no_fault__the_copy_passes(tmp_path, monkeypatch) -> None:
    folder = copy(tmp_path / "rtl", [], part="drive")
    assert run(FAULTS[4].found[0], folder, monkeypatch) == pytest.ExitCode.OK


@pytest.mark.full
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_fault__is_caught(fault, tmp_path, monkeypatch) -> None:
    (test,) = fault.found
    status = run(test, copy(tmp_path / "rtl", [fault], part="drive"), monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
