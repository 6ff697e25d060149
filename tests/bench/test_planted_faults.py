# SPDX-License-Identifier: Apache-2.0
"""Planted faults: every table fits the RTL; each fault makes the test fail that its table names.

`ROOMS` are the folders of tests that run on a copy of their part of the RTL; the faults of the
others have runners of their own, with many faults in one simulation.

One fault: `pytest -m full tests/bench/test_planted_faults.py -k "servo-8-pwm_phase"`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

import pytest

from sim.bus import line
from sim.rtl import dual_rtl, interpolator_rtl, motion_rtl
from sim.rtl.sources import sources_of
from tests.asip import resilient_bench
from tests.bench.faults import RTL, copy, load
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
    patch.setattr(line, "FOLDERS", (folder, RTL / "gen"))


def motion(folder: Path, patch: pytest.MonkeyPatch) -> None:
    for harness in (motion_rtl, interpolator_rtl, test_pulse_generator):
        patch.setattr(harness, "FOLDERS", (folder, RTL / "gen"))


def servo(folder: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(clocked, "FOLDERS", (folder, RTL / "gen"))
    patch.setattr(dual_rtl, "sources_of", lambda top: sources_of(top, (RTL, folder)))


@dataclass(frozen=True)
class Room:
    """part: folder below rtl/, for which `use` puts a copy; passes: a test that must pass on a copy
    without a fault; without: modules of the part that need none, None where that is not asked."""

    part: str
    use: Callable[[Path, pytest.MonkeyPatch], None]
    passes: str = ""
    without: Collection[str] | None = None


ROOMS = {
    "asip": Room("asip", asip),
    "ethercat": Room("ethercat", ethercat),
    "motion_rtl": Room(
        "motion",
        motion,
        "test_pulse_generator.test_lowest_rate__first_pulse_after_half_a_period",
        without={"motion_axil"},  # does no arithmetic and holds no state of its own
    ),
    "servo": Room(
        "drive",
        servo,
        "test_pwm.test_carrier__is_the_triangle_of_its_halves_with_one_window_each",
        without=(),
    ),
}
FAULTS = [(name, fault) for name in ROOMS for fault in load(TABLES[name])]


def item(name: str, test: str) -> str:
    """What pytest calls `file.function` of a room, or one case of it."""
    file, _, function = test.partition(".")
    return f"{TESTS / name / file}.py::{function}"


def run(name: str, test: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for a test of a table on the sources in `folder`."""
    ROOMS[name].use(folder, monkeypatch)
    for cached in CACHES:
        cached.cache_clear()
    try:
        return int(pytest.main([*OPTIONS, item(name, test)]))
    finally:
        for cached in CACHES:
            cached.cache_clear()


@pytest.mark.parametrize("name", sorted(TABLES))
def test_table__fits_the_rtl(name) -> None:
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


@pytest.mark.parametrize("name", [name for name, room in ROOMS.items() if room.without is not None])
def test_table__every_module_has_a_fault(name) -> None:
    modules = {path.stem for path in (RTL / ROOMS[name].part).glob("*.sv")}
    planted = {Path(fault.file).stem for fault in load(TABLES[name])}
    assert planted == modules - set(ROOMS[name].without)


@pytest.mark.parametrize("name", [name for name, room in ROOMS.items() if room.passes])
def test_no_fault__the_copy_passes(name, tmp_path, monkeypatch) -> None:
    folder = copy(tmp_path / "rtl", [], part=ROOMS[name].part)
    assert run(name, ROOMS[name].passes, folder, monkeypatch) == pytest.ExitCode.OK


@pytest.mark.full
@pytest.mark.parametrize(("name", "fault"), FAULTS, ids=str)
def test_fault__is_caught(name, fault, tmp_path, monkeypatch) -> None:
    (test,) = fault.found
    status = run(name, test, copy(tmp_path / "rtl", [fault], part=ROOMS[name].part), monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
