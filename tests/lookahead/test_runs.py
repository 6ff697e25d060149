# SPDX-License-Identifier: Apache-2.0
"""Runs of lines as one curve: its weights, its parts, its distance from the program, its speed."""

import itertools
import math
import random
from dataclasses import replace

import numpy as np
import pytest

from sim.motion.geometry.moves import Motion, Move
from sim.motion.geometry.smoothed import PEAK, REACH, Smoothed, weights
from sim.motion.geometry.workspace import Workspace
from sim.motion.lookahead import runs
from sim.motion.lookahead.check import Deviation, demand
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.segments import Segments
from sim.motion.lookahead.settings import LookaheadSettings
from tests.bench.seed import SEED

SETTINGS = LookaheadSettings()
P = 0.02  # mm
FULL = pytest.mark.full


def moves_along(points, feed=2400.0, tolerance=P):
    """Lines through points of x, y, a, c."""
    poses = [(x, y, 600.0, a, c) for x, y, a, c in points]
    pairs = enumerate(itertools.pairwise(poses), start=1)
    return [
        Move(n, "", Motion.LINEAR, start, end, feed, tolerance=tolerance)
        for n, (start, end) in pairs
    ]


def wave(count, seed=SEED, turns=False):
    """Chords of 0.02 to 1.5 mm along a line of changing curvature, with a sharp corner at times."""
    rng = random.Random(f"wave {seed}")
    place, angle, points = [0.0, 0.0, 0.0, 0.0], 0.0, [(0.0,) * 4]
    bend = 0.0
    for k in range(count):
        bend = rng.uniform(-0.2, 0.2) if k % 9 == 0 else bend
        length = math.exp(rng.uniform(math.log(0.02), math.log(1.5)))
        angle += bend * min(1.0, length) + (rng.choice((1.2, -2.0)) if k % 31 == 30 else 0.0)
        place[0] += length * math.cos(angle)
        place[1] += length * math.sin(angle)
        if turns:
            place[2] += 0.02 * length
            place[3] -= 0.05 * length
        points.append(tuple(place))
    return points


def segments_of(moves, limits=SETTINGS.limits):
    return list(Segments(iter(moves), Workspace.of(SETTINGS.robot), None, "x", limits))


def test_weights__are_those_of_three_windows_in_turn():
    count = 1000  # of steps in a width
    x = np.arange(-4 * count, 4 * count + 1) / count
    box = np.where(np.abs(x) < 0.5, 1 / count, np.where(np.abs(x) == 0.5, 0.5 / count, 0.0))
    path = np.maximum(x, 0.0)
    for _ in range(3):
        path = np.convolve(path, box, mode="same")
    inner = np.abs(x) < 2.0
    wanted = (path - np.maximum(x, 0.0))[inner]
    assert weights(x[inner])[0] == pytest.approx(wanted, abs=3e-6)
    assert weights(np.zeros(1))[0] == pytest.approx(PEAK, abs=1e-15)


def test_weights__each_is_the_slope_of_the_one_before():
    x = np.linspace(-2.0, 2.0, 4001)
    x = x[(np.abs(x) > 1e-9) & (np.abs(np.abs(x) - 0.5) > 1e-9)]
    d = 1e-6
    for order in range(3):
        slope = (weights(x + d)[order] - weights(x - d)[order]) / (2 * d)
        assert slope == pytest.approx(weights(x)[order + 1], abs=2e-6)


def test_run__of_chords__goes_at_the_feed_throughout():
    points = [(10 * math.cos(t), 10 * math.sin(t), 0.0, 0.0) for t in np.arange(0, 3, 0.02)]
    blocks = list(Lookahead(moves_along(points), SETTINGS).setpoints())
    speed = np.linalg.norm(np.concatenate([b.velocity for b in blocks])[:, :2], axis=1)
    at_feed = np.flatnonzero(speed > 0.04 * 0.999)
    assert (speed[at_feed[0] : at_feed[-1]] > 0.04 * 0.999).all()
    assert len(at_feed) > 0.96 * len(speed)


@pytest.mark.parametrize("turns", [False, True])
def test_run__its_parts__continue_each_other(turns):
    found = segments_of(moves_along(wave(300, turns=turns)))
    joints = 0
    for a, b in itertools.pairwise(found):
        if not isinstance(a.curve, Smoothed) and not isinstance(b.curve, Smoothed):
            continue
        end, start = a.at(np.array([a.length])), b.at(np.zeros(1))
        assert end[0] == pytest.approx(start[0], abs=1e-13)
        if np.linalg.norm(end[1] - start[1]) < 0.02:
            joints += 1
            assert end[1] == pytest.approx(start[1], abs=1e-9)
            assert end[2] == pytest.approx(start[2], abs=1e-8 * np.abs(end[2]).max(initial=1.0))
    assert joints > 50
    assert sum(segment.count for segment in found if isinstance(segment.curve, Smoothed)) > 150


def test_run__its_length__is_that_of_its_curve():
    curves = [s.curve for s in segments_of(moves_along(wave(120))) if isinstance(s.curve, Smoothed)]
    for curve in curves:
        s = np.linspace(0.0, curve.length, 501)
        points, first, _ = curve.evaluate(s)
        assert np.linalg.norm(first, axis=1) == pytest.approx(1.0, abs=1e-9)
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert chords == pytest.approx(curve.length, rel=1e-4)
        assert curve.parameter(curve.ends) == pytest.approx(curve.places, abs=1e-12)


@pytest.mark.parametrize("together", [3, 17])
def test_run__does_not_depend_on_how_many_lines_are_one_curve(monkeypatch, together):
    moves = moves_along(wave(150))
    whole = Lookahead(moves, SETTINGS).duration()
    monkeypatch.setattr(runs, "TOGETHER", together)
    assert Lookahead(moves, SETTINGS).duration() == pytest.approx(whole, rel=1e-4)


@pytest.mark.parametrize("tolerance", [0.002, P, 0.3])
@pytest.mark.parametrize(
    "seed", [SEED, *(pytest.param(SEED + n, marks=FULL) for n in range(1, 30))]
)
def test_run__any_lines__within_limits_and_p_and_not_longer_than_stops(seed, tolerance):
    turns = bool(seed % 2)
    points = wave(120, seed, turns)
    moves = moves_along(points, tolerance=tolerance)
    deviation = Deviation(moves)
    run = Lookahead(moves, SETTINGS)
    found = demand(deviation.watched(run.setpoints()), SETTINGS.robot, SETTINGS.period)
    what = f"wave(120, {seed}, {turns}), P {tolerance}"
    assert max(found.ratios(SETTINGS.limits).values()) <= 1.001, what
    assert max(deviation.path, deviation.corner) <= 1e-12, what
    stops = Lookahead(moves_along(points, tolerance=0.0), SETTINGS).duration()
    assert run.summary.duration <= stops, what


def test_run__table_that_turns_more_and_more__is_one_run_at_the_feed_of_the_tool():
    # The way in path space of a millimetre of the tool grows from 1 to 1.2 mm.
    turn = [4 * (k / 150) ** 2 for k in range(150)]
    points = [(0.2 * k, 2 * math.sin(k / 40), 0.0, turn[k]) for k in range(150)]
    moves = moves_along(points, feed=1200.0, tolerance=0.01)
    deviation = Deviation(moves)
    run = Lookahead(moves, SETTINGS)
    blocks = list(deviation.watched(run.setpoints()))
    assert (run.summary.blends, run.summary.turns) == (0, 0)
    assert max(demand(blocks, SETTINGS.robot, SETTINGS.period).ratios(SETTINGS.limits).values()) < 1
    assert max(deviation.path, deviation.corner) <= 0.0
    tool = np.linalg.norm(np.concatenate([b.velocity[:, :3] for b in blocks]), axis=1)
    assert tool.max() <= 0.02 * (1 + 1e-9)
    assert np.median(tool) >= 0.02 * 0.998


def test_run__sharp_corner_in_it__is_rounded_within_p_of_the_program():
    points = [(0.1 * k, 0.0, 0.0, 0.0) for k in range(8)]
    points += [(0.7, 0.1 * k, 0.0, 0.0) for k in range(1, 8)]
    moves = moves_along(points)
    deviation = Deviation(moves)
    for _ in deviation.watched(Lookahead(moves, SETTINGS).setpoints()):
        pass
    assert -1e-3 * P < max(deviation.path, deviation.corner) <= 0.0


def test_run__shorter_than_the_width__meets_both_its_ends():
    points = [(0.0, 0.0, 0.0, 0.0), (0.05, 0.0, 0.0, 0.0), (0.1, 0.01, 0.0, 0.0)]
    moves = moves_along([(0.0, 0.1, 0.0, 0.0), *points, (0.1, 1.0, 0.0, 0.0)], 15000.0, 1.0)
    (curve,) = (s for s in segments_of(moves) if isinstance(s.curve, Smoothed))
    found = curve.at(np.array([0.0, curve.length]))[0][:, :2] * 1e3
    assert found == pytest.approx(np.array([points[0][:2], points[-1][:2]]), abs=1e-12)


def test_run__only_where_p_is_given_and_the_jerk_is_limited():
    points = [(10 * math.cos(t), 10 * math.sin(t), 0.0, 0.0) for t in np.arange(0, 1, 0.02)]
    steps = replace(SETTINGS.limits, jerk_limited=False)
    for tolerance, limits in ((0.0, SETTINGS.limits), (math.inf, SETTINGS.limits), (P, steps)):
        found = segments_of(moves_along(points, tolerance=tolerance), limits)
        assert not any(isinstance(segment.curve, Smoothed) for segment in found)
    assert REACH * runs.width_of(segments_of(moves_along(points[:2]))[0], SETTINGS.limits) < 1e-3
