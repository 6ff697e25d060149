# SPDX-License-Identifier: Apache-2.0
"""The closed loop of `microtick dual`: repeats at another period, partial results, page."""

from __future__ import annotations

import json
import os
import signal

import numpy as np
import pytest

from sim.bench.dual import __main__ as command
from sim.bench.dual import report
from sim.bench.dual.loop import TICK, Loop, differing, follow, stretches_of
from sim.bench.dual.moves import moves_of
from sim.bench.dual.report import DATA, PAGE, PageError, nominal_clocks, publish, replaced
from sim.bench.dual.system import TwoProcessors
from sim.core import closed_loop
from sim.core.controller import ControllerFault
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import generate
from sim.motion.trajectory.program import set_points
from sim.report.marks import MarksError
from sim.robot.parameters import Robot
from tests.dual.test_path import MOVES, QUICK, SHORT

TICKS = 120


@pytest.fixture(scope="module")
def trajectory():
    return generate(parse_file(MOVES), QUICK)


def new_loop(trajectory, ticks: int = TICKS) -> Loop:
    controller = TwoProcessors(Robot.load(), moves_of(trajectory, QUICK), SHORT)
    return Loop(Robot.load(), set_points(trajectory, ticks), controller)


# ---------------------------------------------------------------------- stretches


@pytest.mark.parametrize(
    ("changes", "ticks", "expected"),
    [
        ([], 1000, [(0, 20), (980, 1000)]),
        ([500], 1000, [(0, 20), (495, 505), (980, 1000)]),
        ([21, 30, 978, 1003], 1000, [(0, 35), (973, 1000)]),
        ([0, 5000], 15, [(0, 15)]),
    ],
)
def test_stretches__ends_and_changes_are_merged_and_stay_inside(changes, ticks, expected):
    found = stretches_of(changes, ticks, ends=20, around=5)
    assert found == [range(*pair) for pair in expected]


# ---------------------------------------------------------------------- loop


@pytest.mark.full
def test_loop__is_the_closed_loop_of_make_run(trajectory):
    loop = new_loop(trajectory)
    loop.advance(TICKS)
    ours = loop.recording()
    path = set_points(trajectory, TICKS)
    controller = TwoProcessors(Robot.load(), moves_of(trajectory, QUICK), SHORT)
    theirs = closed_loop.run(Robot.load(), path, controller, lambda n: None)
    assert np.array_equal(ours.counts, theirs.counts)
    assert np.array_equal(ours.joints, theirs.joints)
    assert np.array_equal(ours.tool, theirs.tool)
    assert ours.ticks.outputs.tobytes() == theirs.ticks.outputs.tobytes()
    made = np.array(controller.set_points[:TICKS])
    assert np.array_equal(loop.ticks["set_point"], made)


def test_repeat__at_100_us_gives_the_same_bits_and_leaves_the_loop_where_it_was(trajectory):
    loop, alone = new_loop(trajectory), new_loop(trajectory)
    loop.advance(70)
    other = loop.repeat(90, nominal_clocks(Robot.load()))
    assert loop.done == 70 and len(other) == 20
    assert loop.controller.system.read("PERIOD") == SHORT
    loop.advance(TICKS)
    alone.advance(TICKS)
    assert not len(differing(loop.ticks, alone.ticks))
    assert not len(differing(loop.ticks[70:90], other))
    assert other["counts"].any() and np.ptp(other["period"]["words"], axis=0).any()


@pytest.mark.parametrize("name", ["counts", "joints", "tool", "set_point"])
def test_differing__one_bit_of_one_tick_shows(name):
    rows = np.zeros(5, dtype=TICK)
    other = rows.copy()
    other[name][3].view(np.uint8)[0] ^= 1
    assert differing(rows, other).tolist() == [3]


@pytest.mark.parametrize("name", ["commands", "words", "cycles", "stored", "updates", "late"])
def test_differing__one_bit_of_one_period_shows(name):
    rows = np.zeros(5, dtype=TICK)
    other = rows.copy()
    other["period"][name][2] = 1
    assert differing(rows, other).tolist() == [2]


def test_repeat__that_cannot_keep_its_period_says_so(trajectory):
    loop = new_loop(trajectory)
    loop.advance(10)
    with pytest.raises(ControllerFault, match=r"ticks 10\.\.19 at 200 clocks a period: tick 1\d: "):
        loop.repeat(20, 200)
    loop.advance(20)  # this one can
    assert loop.done == 20


def test_repeat__interrupted_ends_the_process_that_repeats(trajectory, monkeypatch):
    loop = new_loop(trajectory, 20)
    children = []
    fork = os.fork

    def forked() -> int:
        children.append(fork())
        return children[-1]

    def interrupt(*_) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fork", forked)
    monkeypatch.setattr(Loop, "advance", lambda *_: signal.pause())  # never comes back
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with pytest.raises(KeyboardInterrupt):
            loop.repeat(10, nominal_clocks(Robot.load()))
    finally:
        signal.signal(signal.SIGALRM, before)
    with pytest.raises(ChildProcessError):
        os.waitpid(children[0], 0)  # ended and waited for


def test_follow__repeats_every_stretch_and_tells(trajectory):
    loop = new_loop(trajectory)
    told, saved = {"path": 0, "repeat": 0}, []
    stretches = [range(0, 4), range(60, 66)]

    def progress(name: str, ticks: int) -> None:
        told[name] += ticks

    follow(loop, stretches, 2000, progress, lambda done: saved.append(list(done)))
    assert told == {"path": TICKS, "repeat": 10}
    assert saved[-1] == stretches


def test_follow__a_repeat_with_another_bit_stops_the_run(trajectory, monkeypatch):
    loop = new_loop(trajectory)
    original = Loop.repeat

    def flipped(self, end, clocks):
        rows = original(self, end, clocks).copy()
        rows["period"]["commands"][2, 4] ^= 1
        return rows

    monkeypatch.setattr(Loop, "repeat", flipped)
    with pytest.raises(ControllerFault, match=r"tick 32: other bits at 1000 clocks a period"):
        follow(loop, [range(30, 35)], 1000, lambda *_: None, lambda _: None)


# ---------------------------------------------------------------------- command


def test_command__stopped_run_leaves_what_it_has_done(tmp_path, monkeypatch, capsys):
    original = Loop.advance

    def stopped(self, end):
        original(self, min(end, 520))
        if end > 520:
            raise KeyboardInterrupt

    monkeypatch.setattr(Loop, "advance", stopped)
    arguments = [str(MOVES), "--ticks", "900", "--short-only", "--output", str(tmp_path)]
    assert command.main(arguments) == 130
    data = json.loads((tmp_path / "results.json").read_text())
    assert (data["complete"], data["ticks_done"], data["ticks"]) == (False, 520, 900)
    assert data["stopped"] == "interrupted"
    assert data["periods"]["left"]["min"] > 0 and data["tracking"]["tool"] > 0
    assert "stopped after 520 of 900 ticks" in " ".join(capsys.readouterr().out.split())


def test_command__partial_results_are_written_as_it_goes(tmp_path, monkeypatch):
    monkeypatch.setattr(command, "SAVE_TICKS", 500)
    files = []
    monkeypatch.setattr(command, "write", lambda file, data: files.append(data["ticks_done"]))
    monkeypatch.setattr(command, "_single_core", lambda *_: {"leg": 0, "tool": 0, "table": 0})
    arguments = [str(MOVES), "--ticks", "600", "--short-only", "--output", str(tmp_path)]
    assert command.main(arguments) == 0
    assert files == [500, 600, 600]


def test_command__whole_path_is_told_from_a_part(tmp_path, monkeypatch):
    gcode = tmp_path / "short.ngc"
    gcode.write_text("G17 G21 G90\nG0 X0.1 Z600.1\nM2\n")
    monkeypatch.setattr(command, "generate", lambda program, settings: generate(program, QUICK))
    monkeypatch.setattr(
        command, "moves_of", lambda trajectory, settings: moves_of(trajectory, QUICK)
    )
    whole = len(set_points(generate(parse_file(gcode), QUICK), None))
    for ticks in ([], ["--ticks", str(whole - 1)]):
        assert command.main([str(gcode), "--short-only", "--output", str(tmp_path), *ticks]) == 0
        data = json.loads((tmp_path / "results.json").read_text())
        assert (data["whole_path"], data["complete"]) == (not ticks, True)


def test_command__short_run_has_figures_and_no_tracking_error(tmp_path):
    arguments = [str(MOVES), "--ticks", "20", "--period", "1000", "--output", str(tmp_path)]
    assert command.main(arguments) == 0
    data = json.loads((tmp_path / "results.json").read_text())
    assert data["tracking"] is None and data["complete"]
    assert data["repeated"] == {
        "period_clocks": nominal_clocks(Robot.load()),
        "stretches": [[0, 20]],
        "ticks": 20,
        "same_bits": True,
    }


def test_registers__that_contradict_the_run_are_refused(trajectory, monkeypatch):
    loop = new_loop(trajectory, 20)
    loop.advance(20)
    report.checked_registers(loop)
    loop.ticks["period"]["used"][7] += 1
    with pytest.raises(ControllerFault, match=r"register USED_MAX says \d+, the run has seen \d+"):
        report.checked_registers(loop)


# ---------------------------------------------------------------------- page


def test_page__shows_the_figures_that_are_kept_beside_it():
    text = PAGE.read_text(encoding="utf-8")
    data = json.loads(DATA.read_text(encoding="utf-8"))
    assert replaced(text, data) == text, "run `python -m sim.bench.dual --docs`"
    assert data["complete"] and data["whole_path"] and data["ticks_done"] == data["ticks"]


@pytest.mark.parametrize(
    "change",
    [
        {"complete": False},
        {"whole_path": False},
        {"path": "circle.ngc"},
        {"feed_override_percent": 80.0},
    ],
)
def test_page__takes_no_other_run(change, tmp_path):
    data = json.loads(DATA.read_text(encoding="utf-8")) | change
    file = tmp_path / "results.json"
    file.write_text(json.dumps(data))
    with pytest.raises(
        PageError, match="the page shows the whole path A-G-H: run `microtick dual`"
    ):
        publish(file, tmp_path / "page.md", tmp_path / "kept.json")
    assert not (tmp_path / "kept.json").exists()


def test_page__without_results_or_marks_says_what_to_do(tmp_path, capsys):
    assert command.main(["--docs", "--output", str(tmp_path)]) == 1
    assert "run `microtick dual` first" in " ".join(capsys.readouterr().out.split())
    with pytest.raises(MarksError, match="0 pairs of marks `<!-- whole path"):
        replaced("nothing", json.loads(DATA.read_text(encoding="utf-8")))
