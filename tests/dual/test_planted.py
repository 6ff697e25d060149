# SPDX-License-Identifier: Apache-2.0
"""Every planted fault of the two-processor RTL is found by the quick test that its entry names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from sim.rtl import dual_rtl
from sim.rtl.asip_rtl import AsipError
from tests.bench.faults import RTL, load
from tests.dual import test_hand_over
from tests.dual.planted import TABLE, VARIABLE, build_with_faults, planted, sources

FAULTS = load(TABLE)
NAMES = sorted({name for fault in FAULTS for name in fault.found})


def check(name: str) -> Callable[[], None]:
    """A test of test_hand_over.py as a function without arguments; the first of its cases."""
    function = getattr(test_hand_over, f"test_{name}")
    marks = [mark for mark in getattr(function, "pytestmark", []) if mark.name == "parametrize"]
    if not marks:
        return function
    case = marks[0].args[1][0]
    return lambda: function(case)


@pytest.fixture
def model(monkeypatch) -> Callable[[int], None]:
    """Choose a fault; 0 is none."""
    monkeypatch.setattr(dual_rtl, "build_library", build_with_faults)
    return lambda number: monkeypatch.setenv(VARIABLE, str(number))


def test_table__every_module_has_a_fault() -> None:
    modules = {path.name for path in (RTL / "dual").glob("*.sv")}
    assert {fault.name for fault in FAULTS} == modules


@pytest.mark.quick("hand_over__every*", "statistics__periods*")
@pytest.mark.parametrize("name", NAMES)
def test_no_fault__the_model_with_all_of_them_passes(name: str, model) -> None:
    model(0)
    check(name)()


@pytest.mark.quick("2-*", "25-*", "32-*", "38-*")
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_fault__is_found(fault, model) -> None:
    model(fault.number)
    with pytest.raises((AssertionError, AsipError)):
        for name in fault.found:
            check(name)()


def test_planted__choices_of_one_place_are_alternatives() -> None:
    one, two = (fault for fault in FAULTS if fault.number in (1, 2))
    text = planted((RTL / one.file).read_text(), [one, two])
    assert f"(chosen == 1 ? ({one.wrong}) : chosen == 2 ? ({two.wrong}) : ({one.right}))" in text
    assert text.count("initial chosen") == 1


def test_sources__files_without_a_fault_are_the_rtl(tmp_path: Path) -> None:
    original = [RTL / "dual/core_bus.sv", RTL / "dual/period_timer.sv"]
    copies = sources([fault for fault in FAULTS if fault.number == 1], original)
    assert copies[0] == original[0]
    assert copies[1] != original[1]
