# SPDX-License-Identifier: Apache-2.0
"""python -m sim.motion.planner: tables, JSON, plots, and errors without a traceback."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

from sim.motion.planner.__main__ import main

MOVE = "--v0 100 --vm 600 --tr 0.6 --tm 0.15 --length 800".split()


def test_command__ramp_time_mode__prints_phases_and_writes_exact_json(tmp_path, capsys):
    file = tmp_path / "new" / "move.json"
    assert main([*MOVE, "--json", str(file)]) == 0
    text = capsys.readouterr().out
    assert "7-segment profile" in text and "1.83333333 s" in text and "85.8333" in text
    document = json.loads(file.read_text())
    assert document["class"] == "SEVEN_SEGMENT" and document["segments"] == 7
    assert Fraction(document["exact"]["total_time"]) == Fraction(11, 6)
    assert len(document["phases"]) == 7
    assert sum(phase["displacement"] for phase in document["phases"]) == pytest.approx(800)


def test_command__optimal_mode__prints_both_times(tmp_path, capsys):
    file = tmp_path / "move.json"
    short = [*MOVE[:-1], "120"]
    assert main([*short, "--optimal", "--json", str(file)]) == 0
    assert "with set times as in the S-curve paper: 1.2 s" in capsys.readouterr().out
    document = json.loads(file.read_text())
    assert document["total_time"] <= 0.63 and document["ramp_time_mode_time"] == 1.2
    limits = ["--acceleration", "1000", "--jerk", "1e4", "--ve", "50"]
    assert main([*MOVE, "--optimal", *limits, "--json", str(file)]) == 0
    document = json.loads(file.read_text())
    assert document["limits"] == {"speed": 600.0, "acceleration": 1000.0, "jerk": 1e4}
    assert document["end_speed"] == 50.0


@pytest.mark.parametrize("mode", [[], ["--optimal"]])
@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_command__plot__is_written(tmp_path, mode, suffix):
    file = tmp_path / f"move.{suffix}"
    assert main([*MOVE, *mode, "--plot", str(file)]) == 0
    assert file.stat().st_size > 1000


def test_command__core__shows_errors_and_cycles(capsys):
    assert main([*MOVE, "--core", "fast"]) == 0
    text = capsys.readouterr().out
    assert "no error" in text and "clock cycles" in text


def test_command__figures__lists_every_number(tmp_path, capsys):
    assert main(["--figures", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "agrees" in text and "DIFFERS" not in text
    assert (tmp_path / "scurve_fig3.svg").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*MOVE, "--tm", "0.4"], "tm = 0.4 is outside its limit: 0 <= tm <= tr/2 = 0.3"),
        ([*MOVE, "--v0", "x"], "v0 = 'x' is not a finite number"),
        ([*MOVE, "--tm", "0", "--optimal"], "the move has no jerk of its own"),
        ([*MOVE, "--v0", "600", "--optimal"], "the move has no acceleration of its own"),
        ([*MOVE, "--optimal", "--ve", "700"], "ve = 700.0 is outside its limit"),
        ([*MOVE, "--optimal", "--ve", "600", "--length", "9"], "length = 9.0 is too short"),
        ([*MOVE, "--json", "/dev/null/x.json"], "/dev/null"),
        ([*MOVE, "--plot", "/dev/null/x"], "--plot /dev/null/x has no suffix"),
        ([*MOVE, "--length", "1e400"], "length = '1e400' is outside its limit"),
        ([*MOVE, "--tr", "1e308", "--length", "1e-9"], "tr = '1e308' is outside its limit"),
        ([*MOVE, "--v0", "1e1000000000"], "v0 = '1e1000000000' is not"),
        ([*MOVE, "--optimal", "--jerk", "1e99"], "jerk = '1e99' is outside its limit"),
    ],
)
def test_command__user_error__is_one_line_and_status_1(arguments, message, capsys):
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "nothing to do"),
        (["--v0", "1"], "the move needs --vm --tr --tm --length too"),
        ([*MOVE, "--jerk", "1"], "--jerk needs --optimal"),
        ([*MOVE, "--core", "big"], "invalid choice"),
    ],
)
def test_command__wrong_command_line__is_status_2(arguments, message, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert message in capsys.readouterr().err
