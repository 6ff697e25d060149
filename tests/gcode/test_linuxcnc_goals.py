# SPDX-License-Identifier: Apache-2.0
"""Goals against LinuxCNC's interpreter: rows of a folder, and what they say."""

import pytest

from sim.bench.motion import goals_linuxcnc
from sim.motion.gcode.oracle import Samples


def test_rows__of_a_comparison__name_programs_and_are_missed():
    found = Samples(["a.ngc"] * 480, {"b.ngc": "record 3"}, {f"{n}.ngc": "G38" for n in range(11)})
    compared, different, refused = goals_linuxcnc.rows_of(found, 492)
    assert [goal.met for goal in (compared, different, refused)] == [False, False, False]
    assert (different.value, different.note) == (1, "b.ngc")
    assert refused.value == 11 and "10.ngc" in refused.note
    assert all(goal.met for goal in goals_linuxcnc.rows_of(Samples(["a.ngc"] * 500), 500))


def test_programs__without_a_folder__have_no_rows(monkeypatch):
    monkeypatch.delenv("PROGRAMS", raising=False)
    assert list(goals_linuxcnc.programs(False)) == []


def test_programs__folder_without_programs__is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv("PROGRAMS", str(tmp_path))
    with pytest.raises(ValueError, match="no file ends in"):
        list(goals_linuxcnc.programs(False))
