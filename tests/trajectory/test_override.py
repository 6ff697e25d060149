# SPDX-License-Identifier: Apache-2.0
"""Feed override: path times by hand, M48 M49 M50 as LinuxCNC reads them, limits, bad values."""

from __future__ import annotations

import json
import re

import pytest

from sim.bench.dual.__main__ import main as dual
from sim.bench.run.__main__ import main as run
from sim.motion.gcode import oracle
from sim.motion.gcode.interpreter import parse
from sim.motion.geometry.override import overridden, overridden_program
from sim.motion.lookahead.__main__ import main as lookahead
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.__main__ import main as trajectory
from sim.motion.trajectory.program import plan
from sim.robot.parameters import Robot
from tests.bench.needs import needs
from tests.gcode.mistakes import errors_of

ROBOT = Robot.load()
TR = 0.36  # s, acceleration time of exact stops
SWITCHED = """G21 G90 F3000
G1 X10
M49 G1 X20
G0 X0
G2 X10 I5
M50 G1 X0
M50 P0
G1 X10
M50 P1 G1 X0
M70 M49
G1 X10
M72
G1 X0
M2"""


def feeds(text: str, percent: float) -> list[float | None]:
    return [move.feed for move in overridden_program(parse(text), percent).moves]


def time_of(text: str, percent: float) -> float:
    return plan(overridden_program(parse(text), percent), ROBOT).time


@pytest.mark.parametrize("percent", [40.0, 80.0, 100.0, 160.0])
def test_exact_stop__at_an_override__takes_the_time_of_the_s_curve(percent):
    """From rest to rest over L with the full speed v: L / v + tr, whole ticks."""
    speed = 3000 / 60 * percent / 100
    expected = 50 / speed + TR
    assert time_of("G61.1 G1 X50 F3000\nM2", percent) == pytest.approx(expected, abs=ROBOT.T_s)


@pytest.mark.parametrize("percent", [40.0, 80.0, 160.0])
def test_look_ahead__at_an_override__passes_more_way_at_the_scaled_feed(percent):
    """Starting and stopping take the same on both ways: 20 mm more take 20 mm / v."""
    short, far = (time_of(f"G64 G1 X{x} F3000\nM2", percent) for x in (40, 60))
    assert far - short == pytest.approx(20 / (50 * percent / 100), abs=2 * ROBOT.T_s)


def test_switches__in_a_program__act_on_the_moves_behind_them():
    assert feeds(SWITCHED, 50.0) == [
        1500, 3000, None, 3000, 1500, 3000, 1500, 3000, 1500
    ]  # fmt: skip


def test_m49__section__takes_its_time_at_any_override():
    text = "G61.1 F3000\nM49\nG1 X50\nG1 X0\nM2"
    assert time_of(text, 50.0) == time_of(text, 100.0) == time_of(text, 200.0)


def test_rapids_and_rests__at_an_override__take_their_time():
    text = "G64\nG0 X50\nG4 P0.5\nG0 X0\nM2"
    assert time_of(text, 20.0) == time_of(text, 100.0)


def test_inverse_time__at_an_override__is_scaled_too():
    assert feeds("G93 G1 X10 F2\nM2", 50.0) == [10.0]


def test_two_hundred_percent__of_a_fast_feed__keeps_to_the_machine():
    highest = MachineLimits.of(ROBOT).tool.speed
    fast = highest * 60e3 * 0.8
    program = parse(f"G1 X50 F{fast}\nA5\nG1 X0 A0 F{2 * highest * 60e3}\nM2")
    found = [move.feed for move in overridden(program.moves, 200.0, highest)]
    assert found == pytest.approx([highest * 60e3, 2 * fast, 2 * highest * 60e3])


def test_look_ahead_command__at_two_hundred_percent__keeps_every_limit(tmp_path, capsys):
    file, document = tmp_path / "part.ngc", tmp_path / "part.json"
    file.write_text("G64 P0.05 F15000\nG1 X30 A2\nY30 C20\nX0 A0\nG3 X0 Y0 J-15\nM2\n")
    assert lookahead([str(file), "--override", "200", "--json", str(document)]) == 0
    data = json.loads(document.read_text())
    assert data["feed override [%]"] == 200.0
    assert all(row["ratio"] <= 1.001 for row in data["limits"])
    assert "feed override 200 %" in capsys.readouterr().out


@needs("rs274")
def test_switches__in_rs274__are_on_and_off_for_the_same_moves():
    acts, on = [], True
    for line in oracle._canonical(SWITCHED).splitlines():
        if match := re.search(r"\b(ENABLE|DISABLE)_FEED_OVERRIDE\(", line):
            on = match[1] == "ENABLE"
        elif re.search(r"\b(STRAIGHT_FEED|ARC_FEED)\(", line):
            acts.append(on)
    assert acts == [move.override for move in parse(SWITCHED).moves if move.feed is not None]
    assert oracle.differences(SWITCHED) == []


@pytest.mark.parametrize(
    ("block", "what"),
    [
        ("M50 P2", "M50 switches the feed override on or off"),
        ("M48 M49", "second word of the override group in one block"),
        ("M48 P1", "P does not belong to this block"),
        ("M51", "M51, a switch of the spindle's override, is not supported"),
        ("M52", "M52, a switch of adaptive feed, is not supported"),
        ("M53", "M53, a switch of feed stop, is not supported"),
    ],
)
def test_switches__with_a_mistake__are_refused_by_name(block, what):
    (error,) = errors_of(f"{block}\nM2")
    assert error.what == what and error.help


@pytest.mark.parametrize("command", [run, lookahead, trajectory, dual])
@pytest.mark.parametrize("value", ["0", "-5", "200.1", "nan", "inf", "fast", ""])
def test_commands__with_an_impossible_override__say_what_is_possible(command, value, capsys):
    with pytest.raises(SystemExit) as caught:
        command(["part.ngc", f"--override={value}"])
    assert caught.value.code == 2
    assert "is no percentage above 0 and up to 200" in capsys.readouterr().err


@pytest.mark.parametrize("percent", [0.0, 200.5, float("nan")])
def test_overridden__outside_of_its_range__raises(percent):
    with pytest.raises(ValueError, match="0 < percent <= 200; 100 runs the feeds as programmed"):
        list(overridden([], percent))


def test_main_job__at_an_override__states_it_with_the_estimate(tmp_path, capsys):
    file = tmp_path / "part.ngc"
    file.write_text("G61.1 G1 X50 F3000\nM2\n")
    times = []
    for percent in ("100", "50"):
        assert run([str(file), "--plan-only", "--override", percent]) == 0
        shown = " ".join(capsys.readouterr().out.split())
        assert ("feed override 50 %" in shown) == (percent == "50")
        times.append(float(re.search(r"path time ([\d.]+) s", shown)[1]))
    assert times == pytest.approx([1.36, 2.36], abs=1e-3)
