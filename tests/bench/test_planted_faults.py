# SPDX-License-Identifier: Apache-2.0
"""Planted faults: every table fits its sources; each fault fails the test that its table names.

`ROOMS` are the folders of tests that run on a copy of their parts of the RTL, of the C or of the
Python; the faults of the others have runners of their own, with many faults in one simulation.

One fault: `pytest -m full tests/bench/test_planted_faults.py -k "servo-8-pwm_phase"`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

import pytest

from sim.bench.drive.axis import hall
from sim.bus import line
from sim.rtl import dual_rtl, interpolator_rtl, motion_rtl
from sim.rtl.sources import sources_of
from tests.asip import resilient_bench
from tests.bench.faults import RTL, Fault, copy, load
from tests.ethercat import host
from tests.motion_rtl import test_interpolators, test_pulse_generator
from tests.servo import clocked

TESTS = Path(__file__).parents[1]
FOUND = [path for path in TESTS.glob("*/*.toml") if "[[fault]]" in path.read_text()]
TABLES = {path.parent.name: path for path in FOUND}
assert len(TABLES) == len(FOUND), "one table a folder"
LEAST = {"formal": 41, "motion_rtl": 15}  # faults
OPTIONS = ("-q", "-x", "-p", "no:cacheprovider", "-p", "no:randomly", "--no-header")
CACHES = (resilient_bench.core, resilient_bench.stream_core, test_interpolators.rtl)  # of models


def asip(folder: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(resilient_bench, "RTL", folder)


def ethercat(folder: Path, patch: pytest.MonkeyPatch) -> None:
    for harness in (line, clocked):
        patch.setattr(harness, "FOLDERS", (folder, RTL / "gen"))


def application(folder: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(host, "APPLICATION", folder)
    host.device_library()  # a copy that the compiler refuses is no fault that a test finds


def motion(folder: Path, patch: pytest.MonkeyPatch) -> None:
    for harness in (motion_rtl, interpolator_rtl, test_pulse_generator):
        patch.setattr(harness, "FOLDERS", (folder, RTL / "gen"))


def servo(folder: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(clocked, "FOLDERS", (folder, RTL / "gen"))
    patch.setattr(dual_rtl, "sources_of", lambda top: sources_of(top, (RTL, folder)))


def hall_lines(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """The functions of the copy in the module that everybody has imported."""
    file = folder / "hall.py"
    found: dict[str, object] = {"__name__": hall.__name__}
    exec(compile(file.read_text(), file, "exec"), found)
    for name, value in found.items():
        if getattr(value, "__module__", "") == hall.__name__:
            patch.setattr(hall, name, value)


@dataclass(frozen=True)
class Part:
    """A folder of sources, as `file` of a table names it, of which `use` puts a copy in place.

    passes: a test that must pass on a copy without a fault; without: modules of the RTL that need
    none, None where that is not asked.
    """

    folder: str
    use: Callable[[Path, pytest.MonkeyPatch], None]
    passes: str = ""
    without: Collection[str] | None = None

    def __str__(self) -> str:
        return self.folder.replace("/", "_")


ROOMS = {
    "asip": (Part("asip", asip),),
    "drive": (
        Part(
            "sim/bench/drive/axis",
            hall_lines,
            "test_one_motor.test_hall_lines__speed_is_that_of_the_last_two_edges",
        ),
    ),
    "ethercat": (
        Part("ethercat", ethercat, "test_tick.test_period__without_sync0_is_that_of_the_parameter"),
        Part("nios_sw/ethercat", application, "test_foe.test_wrong_name__8001"),
    ),
    "motion_rtl": (
        Part(
            "motion",
            motion,
            "test_pulse_generator.test_lowest_rate__first_pulse_after_half_a_period",
            without={"motion_axil"},  # does no arithmetic and holds no state of its own
        ),
    ),
    "servo": (
        Part(
            "drive",
            servo,
            "test_pwm.test_carrier__is_the_triangle_of_its_halves_with_one_window_each",
            without=(),
        ),
    ),
}
PARTS = [(name, part) for name, parts in ROOMS.items() for part in parts]
FAULTS = [(name, fault) for name in ROOMS for fault in load(TABLES[name])]


def item(name: str, test: str) -> str:
    """What pytest calls `file.function` of a room, or one case of it."""
    file, _, function = test.partition(".")
    return f"{TESTS / name / file}.py::{function}"


def part_of(name: str, fault: Fault) -> Part:
    """The part of a room that has the source of the fault."""
    (part,) = (part for part in ROOMS[name] if fault.file.startswith(f"{part.folder}/"))
    return part


def run(name: str, test: str, part: Part, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for a test of a table on the copy of the part in `folder`."""
    part.use(folder, monkeypatch)
    for cached in CACHES:
        cached.cache_clear()
    try:
        return int(pytest.main([*OPTIONS, item(name, test)]))
    finally:
        for cached in CACHES:
            cached.cache_clear()


@pytest.mark.parametrize("name", sorted(TABLES))
def test_table__fits_the_sources(name) -> None:
    faults = load(TABLES[name])
    assert len(faults) >= LEAST.get(name, 1)
    assert len({(fault.file, fault.right, fault.wrong) for fault in faults}) == len(faults)


@pytest.mark.parametrize("name", ROOMS)
def test_table__names_tests_and_cases_that_exist(name) -> None:
    items = set()
    for fault in load(TABLES[name]):
        (test,) = fault.found
        items.add(item(name, test))
    status = pytest.main([*OPTIONS, "--collect-only", *items])
    assert status == pytest.ExitCode.OK, "pytest names the missing one above"


@pytest.mark.parametrize(
    ("name", "part"), [(name, part) for name, part in PARTS if part.without is not None], ids=str
)
def test_table__every_module_has_a_fault(name, part) -> None:
    modules = {path.stem for path in (RTL / part.folder).glob("*.sv")}
    planted = {Path(fault.file).stem for fault in load(TABLES[name])}
    assert planted == modules - set(part.without)


@pytest.mark.parametrize(
    ("name", "part"), [(name, part) for name, part in PARTS if part.passes], ids=str
)
def test_no_fault__the_copy_passes(name, part, tmp_path, monkeypatch) -> None:
    folder = copy(tmp_path / "copy", [], part=part.folder)
    assert run(name, part.passes, part, folder, monkeypatch) == pytest.ExitCode.OK


@pytest.mark.full
@pytest.mark.parametrize(("name", "fault"), FAULTS, ids=str)
def test_fault__is_caught(name, fault, tmp_path, monkeypatch) -> None:
    (test,) = fault.found
    part = part_of(name, fault)
    folder = copy(tmp_path / "copy", [fault], part=part.folder)
    status = run(name, test, part, folder, monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
