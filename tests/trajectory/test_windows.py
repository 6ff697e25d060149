# SPDX-License-Identifier: Apache-2.0
"""Windows of long paths: as planned, found at the hardest moments, joined to a path that runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.motion.gcode.interpreter import parse, stream
from sim.motion.geometry.moves import from_line
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.paths import cam_part
from sim.motion.trajectory import program, windows
from sim.motion.trajectory.exact_stop import TooLongError
from sim.motion.trajectory.path_limits import FEED, LimitMeter
from sim.motion.trajectory.program import plan, plan_stream
from sim.motion.trajectory.ticks import FIELDS, run_in, run_out, transit
from sim.robot.parameters import Robot

ROBOT = Robot.load()
PERIOD = ROBOT.T_s
LIMITS = MachineLimits.of(ROBOT)
REST = 1000


def part(count: int):
    return stream("".join(cam_part(count)).splitlines(), "part.ngc", robot=ROBOT)


@pytest.fixture(scope="module")
def whole():
    """A part of some 20 s, with every tick."""
    return plan_stream(part(4000), "part.ngc", ROBOT)


@pytest.fixture
def few(monkeypatch):
    """What is simulated in one run is shorter than that part, as are windows."""
    monkeypatch.setattr(program, "MOST_TICKS", 140_000)
    monkeypatch.setattr(windows, "WINDOW", 0.2)
    monkeypatch.setattr(windows, "RUN_IN", 0.1)
    monkeypatch.setattr(windows, "MOST_EVEN", 4)


def assert_runs(path):
    """Positions, velocities and accelerations belong together at every tick.

    A run-in interpolates between positions on the grid, and is on the grid itself.
    """
    jerk = np.array([LIMITS.tool.jerk] * 3 + [LIMITS.table.jerk] * 2)
    step = np.diff(path.position, axis=0) / PERIOD - (path.velocity[1:] + path.velocity[:-1]) / 2
    grid = 2 * np.array([2.0**-24] * 3 + [2.0**-22] * 2) / PERIOD
    assert (np.abs(step) <= grid + jerk * PERIOD**2).all()
    change = np.diff(path.velocity, axis=0) / PERIOD - (
        (path.acceleration[1:] + path.acceleration[:-1]) / 2
    )
    assert (np.abs(change) <= 2 * jerk * PERIOD).all()


def test_long_path__its_windows__are_ticks_of_the_plan_and_run_from_rest_to_rest(whole, few):
    path = plan_stream(part(4000), "part.ngc", ROBOT)
    assert len(path) < len(whole) - 20_000 and path.whole
    assert path.time == whole.time and path.count == whole.count
    assert path.limited_by == whole.limited_by
    assert vars(replace(path.corners, slowest=[])) == vars(replace(whole.corners, slowest=[]))
    covered = np.zeros(len(path), dtype=bool)
    for place in path.windows:
        own = slice(place.tick, place.tick + place.ticks)
        planned = slice(place.planned, place.planned + place.ticks)
        covered[own] = True
        for name in FIELDS[:-1]:
            assert np.array_equal(getattr(path, name)[own], getattr(whole, name)[planned])
        lines = [path.moves[n].line if n >= 0 else 0 for n in path.move[own]]
        assert lines == [whole.moves[n].line if n >= 0 else 0 for n in whole.move[planned]]
    assert (path.move[~covered] == -1).all() and not path.drawing[~covered].any()
    assert path.windows[0].planned == 0
    last = path.windows[-1]
    assert last.planned + last.ticks == len(whole)
    assert not path.velocity[[0, -1]].any() and not path.acceleration[[0, -1]].any()
    assert_runs(path)


def test_long_path__its_hardest_moments__are_in_windows(whole, few):
    path = plan_stream(part(4000), "part.ngc", ROBOT)
    meter = LimitMeter(ROBOT, LIMITS, PERIOD)
    count = len(whole)
    values = whole.position, whole.velocity, whole.acceleration
    still = np.zeros(count, dtype=bool)
    ratios = meter.see(values, np.full(count, np.inf), still, still)
    places = [(p.planned, p.planned + p.ticks) for p in path.windows]
    for name, ratio in zip(meter.names, ratios, strict=True):
        if name == FEED:
            continue
        inside = max(ratio[begin:end].max() for begin, end in places)
        assert inside >= ratio.max() / windows.HARDER
        assert any(f"largest {name}" in p.why for p in path.windows)


def test_seconds__are_those_of_the_whole(whole):
    path = plan_stream(part(4000), "part.ngc", ROBOT, seconds=(7.0, 7.5))
    (place,) = path.windows
    assert place.planned == REST + 70_000 and place.ticks == 5_000 and not path.whole
    assert place.tick + place.ticks == len(path)
    own = slice(place.planned, place.planned + place.ticks)
    for name in FIELDS[:-1]:
        assert np.array_equal(getattr(path, name)[place.tick :], getattr(whole, name)[own])
    assert_runs(path)
    begin = plan_stream(part(4000), "part.ngc", ROBOT, seconds=(0.0, 0.2))
    assert begin.windows[0].tick == 0 and len(begin) == REST + 2000
    assert np.array_equal(begin.position, whole.position[: REST + 2000])
    end = plan_stream(part(4000), "part.ngc", ROBOT, seconds=(whole.time - 0.3, 1000.0 / 8))
    assert end.whole and np.array_equal(end.position[-2000:], whole.position[-2000:])


def test_windows_that_cannot_be__are_refused_with_a_cure(few):
    with pytest.raises(
        ValueError, match=r"part.ngc: error: the path takes .* s; got a window from 100"
    ):
        plan_stream(part(10), "part.ngc", ROBOT, seconds=(100.0, 101.0))
    with pytest.raises(ValueError, match=r"--seconds 0:30 is outside its limit"):
        plan_stream(part(10), "part.ngc", ROBOT, seconds=(0.0, 30.0))
    with pytest.raises(ValueError, match=r"200000 ticks are too many .* without --ticks"):
        plan_stream(part(4000), "part.ngc", ROBOT, ticks=200_000)
    turns = "G64 G1 X1 F600\nG0\n" + "C1500\nC-1500\n" * 2 + "M2"
    with pytest.raises(TooLongError, match=r"too far apart .*\n.*--seconds 0:10"):
        plan(parse(turns, robot=ROBOT), ROBOT)


@pytest.mark.parametrize("mode", ["G61", "G61.1", "G64 P0.01"])
def test_long_rests_and_slow_moves__become_windows(mode, few):
    text = f"{mode} G1 X1 F600\nG4 P20\nX1.5 F1.5\nY5 F600\nM2"
    path = plan(parse(text, robot=ROBOT), ROBOT)
    assert path.windows and path.time > 40.0 and path.corners.rest == 20.0
    assert [move.line for move in path.moves] == [1, 3, 4]
    assert_runs(path)


def test_from_line__begins_at_rest_where_its_move_begins():
    text = "G64 P0.01 G1 X5 F900\nY5\nG4 P0.1\nX9\nY9\nM2"
    moves = parse(text, "a.ngc", robot=ROBOT)
    items = [*moves.moves[:2], moves.dwells[0][1], *moves.moves[2:]]
    path = plan_stream(from_line(items, 4, "a.ngc"), "a.ngc", ROBOT)
    assert path.count == 2 and [move.line for move in path.moves] == [4, 5]
    assert path.position[0, :2] == pytest.approx([5e-3, 5e-3], abs=1e-7)
    assert list(from_line(items, 1, "a.ngc")) == items
    with pytest.raises(ValueError, match=r"a.ngc: error: no move is in line 6 .* is in line 5"):
        list(from_line(items, 6, "a.ngc"))


def test_memory__does_not_grow_with_the_part(few, monkeypatch):
    monkeypatch.setattr(windows, "HARDER", np.inf)
    monkeypatch.setattr(program, "MOST_TICKS", 60_000)
    held = []
    forget = program._Motion.forget

    def forgetting(motion, number):
        forget(motion, number)
        held.append(len(motion.moves))

    monkeypatch.setattr(program._Motion, "forget", forgetting)
    path = plan_stream(part(5_000), "part.ngc", ROBOT)
    assert len(held) > 10 and max(held) < 2_000 < 5_000 <= path.count
    assert len(path.moves) < 2_000


def test_run_in_and_out__mirror_each_other_and_end_in_rest(whole):
    planned = whole.part(REST + 30_000, REST + 32_501)
    assert planned.velocity.any()
    start, end = run_in(planned, PERIOD), run_out(planned, PERIOD)
    assert len(start) == len(end) == 5_000
    assert np.array_equal(start.position[0], planned.position[0])
    assert np.array_equal(end.position[-1], planned.position[-1])
    for ticks, edge in ((start, 0), (end, -1)):
        assert not ticks.velocity[edge].any() and not ticks.acceleration[edge].any()


@pytest.mark.parametrize("way", [(0.1, -0.02, 0.05, 0.0, 0.0), (1e-4, 0, 0, 0.5, -3.0), (0,) * 5])
def test_transit__keeps_the_limits_of_tool_and_table(way):
    start = np.array([0.0, 0.0, 0.6, 0.0, 0.0])
    found = transit(start, start + np.array(way), LIMITS, PERIOD)
    if not any(way):
        assert len(found) == 0
        return
    for columns, bound in ((slice(0, 3), LIMITS.tool), (slice(3, 5), LIMITS.table)):
        size = np.linalg.norm if columns.start == 0 else np.max
        values = [found.velocity, found.acceleration, np.diff(found.acceleration, axis=0) / PERIOD]
        for value, limit in zip(values, vars(bound).values(), strict=True):
            assert size(np.abs(value[:, columns]), axis=1).max() <= 0.501 * limit
