# SPDX-License-Identifier: Apache-2.0
"""Opening a hostile file runs nothing, opens nothing that it names, shows nothing of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from sim.debug import nios_run
from tests.security.hostile_files import CASES, LEAST, MARK, RUN, Case, observe

REFUSED = (1, 2, nios_run.FILE_STATUS)


def quick(cases: list[Case]) -> list[Case]:
    """Two of each reader, from the beginning and the middle of its cases."""
    readers: dict[str, list[Case]] = {}
    for case in cases:
        readers.setdefault(case.name.partition(":")[0], []).append(case)
    return [each[n] for each in readers.values() for n in sorted({0, len(each) // 2})]


QUICK = quick(list(CASES))


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=() if case in QUICK else pytest.mark.full)
        for case in CASES
    ],
)
def test_hostile_file__is_data(case, tmp_path):
    seen = observe(case, tmp_path)
    assert not (seen.executed or seen.read or seen.shown), seen
    assert seen.status in (REFUSED if case.refused else (0, *REFUSED)), seen


def test_set__is_large_enough():
    assert len({case.name for case in CASES}) == len(CASES) >= LEAST
    assert 18 <= len(QUICK) <= 25
    assert "saved function: library" in [case.name for case in QUICK]


def test_observer__sees_a_command_an_opened_canary_and_its_text(tmp_path):
    """What the set observes is observed: a reader that does what it should not."""
    where: list[Path] = []
    run = Case("run", where.append, lambda: os.system(RUN))
    opened = Case("open", where.append, lambda: len(where[-1].read_text()))
    shown = Case("show", where.append, lambda: print(where[-1].read_text()))
    kept = Case("keep", where.append, lambda: Path("out").write_text(where[-1].read_text()))
    assert observe(run, tmp_path / "a").executed and (tmp_path / "a/work" / MARK).exists()
    found = observe(opened, tmp_path / "b")
    assert found.read and not found.shown and not found.executed
    assert observe(shown, tmp_path / "c").shown and observe(kept, tmp_path / "d").shown
