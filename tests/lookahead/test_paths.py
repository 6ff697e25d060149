# SPDX-License-Identifier: Apache-2.0
"""Corners never cost time: paths with G64 P against G61, turns, and what joined lines may miss."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim.motion.gcode.interpreter import parse
from sim.motion.geometry.turn import Turn
from sim.motion.lookahead.check import Deviation, demand
from sim.motion.lookahead.paths import PATHS, TOLERANCES, path_time, walk
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from tests.bench.seed import SEED
from tests.lookahead.programs import distance_to_polyline, sampled

SETTINGS = LookaheadSettings()
FULL = pytest.mark.full


def test_paths__are_twenty():
    assert len(PATHS) == 20


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("tolerances", [TOLERANCES[2:5:2], pytest.param(TOLERANCES, marks=FULL)])
def test_paths__rounded_corners__never_take_longer_than_stops(name, tolerances):
    stops = path_time(name, "G61", SETTINGS)
    for tolerance in tolerances:
        assert path_time(name, f"G64 P{tolerance:g}", SETTINGS) <= stops


@pytest.mark.parametrize(
    "seed", [SEED, *(pytest.param(SEED + n, marks=FULL) for n in range(1, 20))]
)
def test_paths__random_ones_that_no_weight_was_chosen_on__never_take_longer(monkeypatch, seed):
    for least, most, table in ((1, 20, False), (0.01, 5, False), (0.05, 0.5, False), (1, 20, True)):
        what = seed, 40, least, most, table
        program = walk(*what)
        monkeypatch.setitem(PATHS, "walk", lambda program=program: program)
        stops = path_time("walk", "G61", SETTINGS)
        for tolerance in TOLERANCES[1:6:2]:
            time = path_time("walk", f"G64 P{tolerance:g}", SETTINGS)
            assert time <= stops, f"walk{what}, P{tolerance:g}"


@pytest.mark.parametrize(
    ("name", "tolerance", "most"),
    [
        ("A-G-H", 0.01, 11.93),
        ("raster, 12 lines of 20 mm, 2 mm apart", 0.05, 6.90),
        ("raster, 30 lines of 8 mm, 0.1 mm apart", 0.05, 6.74),  # blends gain by twos only
        ("circle, chords of 1 and 0.02 mm", 0.02, 1.69),
        ("circle, chords of 0.1 mm", 0.02, 1.69),
    ],
)
def test_paths__of_known_times__reach_them(name, tolerance, most):
    assert path_time(name, f"G64 P{tolerance}", SETTINGS) <= most


def corner(degrees: float, control: str = "G64 P0.01", length: float = 10.0):
    angle = math.radians(degrees)
    place = f"X{length + length * math.cos(angle):.9f} Y{length * math.sin(angle):.9f}"
    return parse(f"{control} G1 X{length} F2400\n{place}\nM2").moves


@pytest.mark.parametrize("degrees", [60.0, 90.0, 130.0, 180.0])
def test_turn__of_a_corner__keeps_limits_and_p_and_saves_the_rest(degrees):
    moves = corner(degrees)
    away = Deviation(moves)
    run = Lookahead(moves, SETTINGS)
    ratios = demand(away.watched(run.setpoints()), SETTINGS.robot, SETTINGS.period).ratios(
        SETTINGS.limits
    )
    assert (run.summary.turns, run.summary.blends, run.summary.stops) == (1, 0, 0)
    assert max(ratios.values()) <= 1.0
    assert max(away.path, away.corner) <= 0.0
    stops = Lookahead(corner(degrees, "G61"), SETTINGS).duration()
    saved = stops - run.summary.duration
    window = SETTINGS.limits.window
    part = min(1.0, 0.5 / math.cos(math.radians(degrees) / 2)) if degrees < 180 else 1.0
    lost = (1 - part) * window
    slow = part * SETTINGS.limits.tool.acceleration * window / 2
    assert saved == pytest.approx(window - 2 * lost * (1 - slow / 0.04), rel=0.05)


def test_turn__of_a_corner__is_the_average_of_stopping_there_and_going_on():
    """The motion without a limit of the jerk, averaged as a vector over the window, by sums."""
    moves, window = corner(90.0), SETTINGS.limits.window
    fine = replace(SETTINGS.robot, T_s=2e-5)
    points, run = sampled(moves, replace(SETTINGS, robot=fine))
    at = points.position[:, :2] - np.array(moves[0].end[:2]) / 1e3
    middle = np.argmin(np.linalg.norm(at, axis=1))
    times = (np.arange(len(at)) - middle) * 2e-5
    rate = points.acceleration[np.argmin(np.abs(times + window / 2)), 0]
    inner = np.abs(times) <= window / 2
    grid = np.linspace(-window, window, 200_001)
    way = rate / 2 * grid**2
    before, after = np.where(grid < 0, way, 0.0), np.where(grid > 0, -way, 0.0)
    for column, values in ((0, before), (1, after)):
        sums = np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(grid))])
        ends = np.interp(times[inner] + window / 2, grid, sums)
        mean = (ends - np.interp(times[inner] - window / 2, grid, sums)) / window
        assert at[inner, column] == pytest.approx(mean, abs=1e-7)
    assert run.summary.turns == 1


def test_turn__by_its_length__has_derivatives_and_apex():
    u1, u2 = np.eye(5)[0], np.array([0.6, 0.0, 0.8, 0.0, 0.0])
    turn = Turn(np.full(5, 0.5), u1, u2, 2e-5)
    s = np.linspace(0.0, 4e-5, 4001)
    q, d1, d2 = turn.at(s)
    assert q[0] == pytest.approx(turn.corner - 2e-5 * u1, abs=1e-15)
    assert q[-1] == pytest.approx(turn.end, abs=1e-15)
    assert (d1[0], d1[-1]) == (pytest.approx(u1), pytest.approx(u2))
    for value, slope in ((q, d1), (d1, d2)):
        step = (value[2:] - value[:-2]) / (s[2:] - s[:-2])[:, None]
        assert step == pytest.approx(slope[1:-1], abs=1e-4 * np.abs(slope).max())
    away = np.linalg.norm(q - turn.corner, axis=1)
    assert away.min() == pytest.approx(turn.apex, rel=1e-6)


@pytest.mark.parametrize("name", ["A-G-H", "random lines of 1 to 20 mm", "star of 7 points"])
def test_turns__do_not_depend_on_how_many_moves_are_known(name):
    moves = parse(f"G21 G90 G64 P0.01\n{PATHS[name]()}\nM2").moves
    runs = [Lookahead(moves, replace(SETTINGS, depth=depth)) for depth in (2, 3, 256)]
    times = [run.duration() for run in runs]
    assert times == pytest.approx([times[-1]] * 3, abs=1e-9)
    assert len({(run.summary.turns, run.summary.blends) for run in runs}) == 1
    assert runs[0].summary.turns > 0


@pytest.mark.parametrize("tolerance", [0.005, 0.05])
@pytest.mark.parametrize("name", [name for name in PATHS if name.startswith("circle")])
def test_joined_lines__and_their_blends__together_stay_within_p(name, tolerance):
    moves = parse(f"G21 G90 G64 P{tolerance}\n{PATHS[name]()}\nM2").moves
    points = sampled(moves, SETTINGS)[0].position[::5, :3] * 1e3
    corners = np.array([moves[0].start[:3], *(move.end[:3] for move in moves)])
    assert distance_to_polyline(points, corners).max() <= tolerance
