# SPDX-License-Identifier: Apache-2.0
"""The rooms of sim: arrows between them are counted, old names of modules still work."""

import importlib
import subprocess
import sys

import pytest

from asip_asm.project import ROOT
from scripts import lint_rooms
from sim.moved import MOVED, moved

ROOMS = ["robot", "core", "bench"]


def test_faults__imports_down__are_counted_once_for_two_rooms():
    down = [("sim.core.api", "sim.robot.plant"), ("sim.core.iss", "sim.robot.plant")]
    inside = [("sim.core.api", "sim.core.fault"), ("sim", "sim.core.api")]
    assert lint_rooms.faults(ROOMS, down + inside) == (1, [])


def test_faults__too_many_rooms_and_arrows__are_refused(monkeypatch):
    rooms = [f"room{n}" for n in range(11)]
    monkeypatch.setattr(lint_rooms, "MOST_ARROWS", 0)
    _, found = lint_rooms.faults(rooms, [("sim.room1.a", "sim.room0.b")])
    assert [text.split(":")[0] for text in found] == [
        "11 rooms, at most 10",
        "1 arrows, at most 0",
    ]


@pytest.mark.filterwarnings("ignore:sim.:FutureWarning")
@pytest.mark.parametrize("old", [name for name in MOVED if not name.endswith("__main__")])
def test_old_name__imports_the_same_module(old: str):
    module = importlib.import_module(f"sim.{old}")
    assert module is importlib.import_module(f"sim.{MOVED[old]}")
    assert module.__spec__.name == module.__name__ == f"sim.{MOVED[old]}"


@pytest.mark.filterwarnings("ignore:sim.:FutureWarning")
def test_old_name__below_a_folder_that_moved__is_the_same_module():
    planner = importlib.import_module("sim.lookahead.planner")
    assert planner is importlib.import_module("sim.motion.lookahead.planner")
    with pytest.raises(ModuleNotFoundError, match="No module named 'sim.lookahead.nothing'"):
        importlib.import_module("sim.lookahead.nothing")


def test_name_of_today__is_not_another_one():
    modules = ("core.api", "motion.lookahead.planner", "bench.run.job", "debug.client", "cocotb")
    assert [moved(f"sim.{name}") for name in modules] == [None] * len(modules)


def test_old_command__runs_and_names_the_new_one():
    command = [sys.executable, "-m", "sim.trajectory", "--help"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("usage: python -m sim.motion.trajectory ")
    (warning,) = done.stderr.splitlines()
    assert warning.endswith("FutureWarning: sim.trajectory is now sim.motion.trajectory")
