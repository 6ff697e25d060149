# SPDX-License-Identifier: Apache-2.0
"""Whole programs: look-ahead, exact stops and rests in one path, on the number grid, in bounds."""

from __future__ import annotations

import numpy as np
import pytest

from sim.motion.gcode.interpreter import parse, parse_file
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.trajectory.exact_stop import TooLongError, generate, on_number_grid
from sim.motion.trajectory.path_limits import EXACT_STOP, FEED
from sim.motion.trajectory.program import AGH, REST_AT_START, plan
from sim.robot.parameters import Robot

ROBOT = Robot.load()
REST = round(REST_AT_START / ROBOT.T_s)


def raster() -> str:
    """Rows of 200 short segments, to and fro."""
    segments = 200
    lines = ["G21 G90 G64 P0.01", "G0 X-20 Y-20 Z600", "F6000"]
    x, y, way = -20.0, -20.0, 1.0
    while len(lines) < segments + 3:
        for step in range(24):
            x += way * 40 / 24
            lines.append(f"G1 X{x:.4f} Y{y:.4f} Z{600 + 0.2 * (step * 7 % 5):.3f}")
        way, y = -way, y + 5
        lines.append(f"G1 Y{y:.4f}")
    return "\n".join([*lines[: segments + 3], "M2"])


@pytest.mark.parametrize(
    "text",
    [raster(), "G64 G1 X5 F900\nG4 P0.2\nG61 Y5 A3 C9\nG2 X0 Y0 R6\nM2"],
)
def test_plan__look_ahead__takes_its_time_on_the_grid_without_steps(text):
    program = parse(text)
    path = plan(program, ROBOT)
    rests = [dwell for _, dwell in program.dwells]
    items = [*program.moves[:1], *rests, *program.moves[1:]]
    wanted = Lookahead(items, LookaheadSettings(robot=ROBOT)).duration()
    assert path.time == pytest.approx(wanted, abs=2 * ROBOT.T_s)
    assert np.array_equal(path.position, on_number_grid(path.position))
    words = path.position.astype(np.float32).astype(np.float64)
    assert np.array_equal(path.position, words)
    jerk = np.linalg.norm(np.diff(path.acceleration[:, :3], axis=0), axis=1) / ROBOT.T_s
    assert jerk.max() <= MachineLimits.of(ROBOT).tool.jerk * 1.001
    drift = np.diff(path.position, axis=0) - path.velocity[1:] * ROBOT.T_s
    assert np.abs(drift[:, :3]).max() < 2 * 2.0**-24 + 4.8 * ROBOT.T_s**2
    assert not path.velocity[-1].any() and not path.acceleration[-1].any()


def test_plan__raster__is_faster_than_exact_stops_by_far():
    program = parse(raster())
    path = plan(program, ROBOT)
    assert path.corners.rounded > 150
    assert path.time < 10.0 < 100.0 < generate(program).t[-1]


def test_plan__a_g_h__is_the_published_path_word_for_word():
    program = parse_file(AGH)
    path, wanted = plan(program, ROBOT), generate(program)
    assert len(path) == 298_334
    for name in ("position", "velocity", "acceleration"):
        assert np.array_equal(getattr(path, name), getattr(wanted, name))
    assert np.array_equal(path.move, wanted.block)
    assert path.whole and path.limited_by == {EXACT_STOP: 1.0}


def test_plan__a_step_of_ten_micrometres__takes_about_ten_milliseconds():
    path = plan(parse("G0 X0.01\nM2"), ROBOT)
    assert len(path) - REST < 200
    assert path.position[-1, 0] == pytest.approx(10e-6, abs=2.0**-24)


def test_plan__modes_change__rest_in_between_and_every_move_is_run():
    text = "G4 P1\nG1 X1 F100\nG4 P.5\nG61.1 X2\nG4 P1\nG64 X3\nM2"
    path = plan(parse(text), ROBOT)
    assert path.corners.rest == 2.5 and path.corners.stops == 2
    assert sorted(set(path.move.tolist())) == [-1, 0, 1, 2]
    for place in (0.0, 1e-3, 2e-3):
        resting = (np.abs(path.position[:, 0] - place) < 1e-7) & ~path.velocity.any(axis=1)
        assert resting.sum() * ROBOT.T_s >= (1.0 if place != 1e-3 else 0.5)
    assert np.abs(np.diff(path.position[:, 0])).max() < 1e-6


def test_plan__first_ticks__are_those_of_the_whole():
    whole = plan(parse(raster()), ROBOT)
    for ticks in (1, REST, 5_000):
        path = plan(parse(raster()), ROBOT, ticks)
        assert len(path) == ticks and not path.whole
        assert np.array_equal(path.position, whole.position[:ticks])
    rounded = plan(parse("G64 P1 F600\nG1 X10\nY10\nX0\nM2"), ROBOT, 15_000)
    assert not rounded.whole and rounded.corners.rounded == 2
    assert plan(parse("G64 G1 X10 F0.01\nM2"), ROBOT, 3_000).velocity.any()


@pytest.mark.parametrize("mode", ["G61", "G61.1", "G64"])
def test_plan__days_of_motion__are_refused_at_their_line(mode):
    with pytest.raises(TooLongError, match=r"a\.ngc:2: error: the motion is too long"):
        plan(parse(f"{mode}\nG1 X10 F0.001\nM2", file="a.ngc"), ROBOT)


def test_plan__no_motion__is_told():
    with pytest.raises(ValueError, match="the program has no motion"):
        plan(parse("G4 P1\nM2"), ROBOT)


def test_limited_by__slow_line_and_sharp_raster__name_their_limits():
    slow = plan(parse("G1 X20 F300\nM2"), ROBOT).limited_by
    assert next(iter(slow)) == FEED and slow[FEED] > 0.95
    sharp = plan(parse(raster()), ROBOT).limited_by
    assert sum(sharp.values()) == pytest.approx(1.0)
    assert sharp["tool acceleration"] + sharp["tool jerk"] > 0.5
