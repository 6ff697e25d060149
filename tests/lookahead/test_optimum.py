# SPDX-License-Identifier: Apache-2.0
"""The least time of a path by IPOPT, against motions whose least time is known."""

import pytest

from sim.motion.gcode.interpreter import parse
from sim.motion.lookahead.optimum import groups_of, least_time, main
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings

SETTINGS = LookaheadSettings()


def both(text):
    """Times of a program with one rest at its end, ours and the least."""
    (moves,) = groups_of(parse(f"G21 G90 G64 P0.05\n{text}\nM2"))
    return Lookahead(moves, SETTINGS).duration(), least_time(moves, SETTINGS)


def test_line__from_rest_to_rest__is_the_s_curve_of_the_planner():
    planned, least = both("G1 X30 F2400")
    assert least == pytest.approx(planned, rel=2e-3)


def test_corner__has_a_least_time_near_that_of_the_planner():
    planned, least = both("G1 X20 F2400\nY20")
    assert 0.97 * planned < least < planned * 1.002


def test_wider_corridor__takes_less_time():
    def least(tolerance):
        text = f"G21 G90 G64 P{tolerance}\nG1 X5 F2400\nY5\nX10\nM2"
        (moves,) = groups_of(parse(text))
        return least_time(moves, SETTINGS)

    assert least(0.2) < least(0.02) - 0.005


def test_command__tolerance_outside__is_refused(capsys):
    assert main(["--path", "hexagon", "--tolerance", "0"]) == 1
    assert "--tolerance 0 is outside its limit" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["--tolerance", "0.05"])
    assert "name it with --path" in capsys.readouterr().err
