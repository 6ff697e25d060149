# SPDX-License-Identifier: Apache-2.0
"""Planted faults in the motion front-end (mutants.toml): each must make its quick test fail.

One fault: `pytest -m full tests/motion_rtl/test_mutants.py -k "21-step_output"`.
"""

from __future__ import annotations

import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from sim.harness import interpolator_rtl, motion_rtl
from sim.harness.build import ROOT
from tests.motion_rtl import test_front_end, test_interpolators, test_path, test_pulse_generator

TABLE = Path(__file__).with_name("mutants.toml")
RTL = ROOT / "rtl/motion"
TESTS = {
    module.__name__.rpartition(".")[2]: module
    for module in (test_front_end, test_interpolators, test_path, test_pulse_generator)
}
HARNESSES = (motion_rtl, interpolator_rtl, test_pulse_generator)
# Modules that do no arithmetic and hold no state of their own.
NOT_MUTATED = {"motion_axil"}


@dataclass(frozen=True)
class Fault:
    """One entry of the table: `right` stands once in `file`, `test` fails with `wrong` there."""

    file: str
    breaks: str
    right: str
    wrong: str
    test: str

    def planted(self) -> str:
        """The file with the fault. Raises ValueError if the entry does not fit it."""
        text = (RTL / self.file).read_text()
        if text.count(self.right) != 1:
            raise ValueError(
                f"{TABLE}: error: {self.file}: `right` stands {text.count(self.right)} times, not "
                f"once: {self.right!r}; adapt the entry to the present text"
            )
        return text.replace(self.right, self.wrong)


FAULTS = [Fault(**entry) for entry in tomllib.loads(TABLE.read_text())["fault"]]
NAMES = [f"{number:02d}-{fault.file[:-3]}" for number, fault in enumerate(FAULTS, 1)]


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for one test on the sources in `folder` instead of rtl/motion."""
    module, _, test = name.partition(".")
    for harness in HARNESSES:
        monkeypatch.setattr(harness, "FOLDERS", (folder, ROOT / "rtl/gen"))
    test_interpolators.rtl.cache_clear()
    try:
        options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:randomly", "--no-header"]
        return int(pytest.main([*options, f"{TESTS[module].__file__}::{test}"]))
    finally:
        test_interpolators.rtl.cache_clear()


def copy(folder: Path, fault: Fault | None = None) -> Path:
    """The sources with the fault, or as they are, in a folder."""
    shutil.copytree(RTL, folder)
    if fault:
        (folder / fault.file).write_text(fault.planted())
    return folder


def test_table__every_entry_fits_and_every_module_has_one() -> None:
    for fault in FAULTS:
        assert fault.planted()
    assert len({(fault.file, fault.right, fault.wrong) for fault in FAULTS}) == len(FAULTS) >= 15
    modules = {path.stem for path in RTL.glob("*.sv")} - NOT_MUTATED
    assert {fault.file.removesuffix(".sv") for fault in FAULTS} == modules


def test_table__text_that_is_not_there__named() -> None:
    with pytest.raises(ValueError, match="pulse_generator.sv: `right` stands 0 times"):
        Fault("pulse_generator.sv", "", "no such text", "", "").planted()


def test_no_fault__the_copy_passes(tmp_path, monkeypatch) -> None:
    name = FAULTS[0].test
    assert run(name, copy(tmp_path / "rtl"), monkeypatch) == pytest.ExitCode.OK


@pytest.mark.full
@pytest.mark.parametrize("fault", FAULTS, ids=NAMES)
def test_fault__is_caught(fault, tmp_path, monkeypatch) -> None:
    status = run(fault.test, copy(tmp_path / "rtl", fault), monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {fault.test} gave {status}"
