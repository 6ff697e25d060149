# SPDX-License-Identifier: Apache-2.0
"""Look-ahead planner on odd geometry: nearly full circles, moves below a tick, five-axis feeds."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from sim.motion.geometry.blend import SCALE
from sim.motion.geometry.curves import to_si
from sim.motion.geometry.moves import Motion, Move, Plane
from sim.motion.lookahead.check import ROUNDING, Deviation, demand
from sim.motion.lookahead.figures import chord_program, without_approach
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.segments import OutsideError
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.lookahead.stress import VIOLATION
from sim.motion.planner.optimal import Limits
from sim.robot.parameters import Robot
from tests.lookahead.programs import sampled

ROBOT = Robot.load()
SETTINGS = LookaheadSettings(robot=ROBOT)
HOME = (0.0, 0.0, 600.0, 0.0, 0.0)


def lines(*ends, feed: float, tolerance: float, start=HOME) -> list[Move]:
    starts = [start, *ends[:-1]]
    return [
        Move(number, "", Motion.LINEAR, begin, end, feed, tolerance=tolerance)
        for number, (begin, end) in enumerate(zip(starts, ends, strict=True), 1)
    ]


def arc(start, end, feed: float, motion: Motion = Motion.ARC_CCW, centre=(0.0, 0.0)) -> Move:
    """In the plane of x and y."""
    return Move(1, "", motion, start, end, feed, Plane.XY, centre)


# Nearly full circles: the end is a rounding, or a hundredth of a mm, before the start, with the
# radii different by what the reader accepts.
@pytest.mark.parametrize(
    "end", [(math.nextafter(50.0, 0.0), 1e-13), (49.999, -0.01), (50.001, 0.01)]
)
@pytest.mark.parametrize("motion", [Motion.ARC_CCW, Motion.ARC_CW])
def test_arc__nearly_a_full_turn__stays_on_its_circle(end, motion):
    turn = arc((50.0, 0.0, 600.0, 0.0, 0.0), (*end, 600.0, 0.0, 0.0), 3e4, motion)
    points, _ = sampled([turn], SETTINGS)
    radius = np.hypot(points.position[:, 0], points.position[:, 1]) * 1e3
    assert np.abs(radius - 50.0).max() <= 0.0011  # mm, the difference of the radii
    assert points.position[-1] == pytest.approx(to_si(turn.end), abs=1e-15)


def test_arc__short_with_ends_off_by_the_tolerance__is_a_true_circle():
    short = arc((50.0, 0.0, 600.0, 0.0, 0.0), (0.0, 50.0015, 600.0, 0.0, 0.0), 3e3)
    points, _ = sampled([short], SETTINGS)
    x, y = points.position[:, 0] * 1e3, points.position[:, 1] * 1e3
    # Least squares: x^2 + y^2 = 2 a x + 2 b y + c
    a, b, c = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones_like(x)]), x * x + y * y)[0]
    radius = math.sqrt(c + a * a + b * b)
    assert np.abs(np.hypot(x - a, y - b) - radius).max() < 1e-9
    assert np.abs(np.hypot(x, y) - 50.0).max() < 0.002


def test_feed__of_the_tool__holds_in_a_blend_between_turns_of_the_table():
    # Path space turns by 120 degrees; in the middle of the blend only the tool moves.
    moves = lines(
        (10.0, 0.0, 600.0, 10.0, 0.0), (20.0, 0.0, 600.0, 0.0, 0.0), feed=600, tolerance=5
    )
    points, run = sampled(moves, replace(SETTINGS, only_blends=True))
    assert run.summary.blends == 1
    speed = np.linalg.norm(np.diff(points.position[:, :3], axis=0), axis=1) / SETTINGS.period
    assert speed.max() <= 0.01 * (1 + 1e-9)


def test_feed__of_the_table__holds_behind_a_tiny_move_of_the_tool():
    moves = lines((5e-5, 0.0, 600.0, 0.0, 0.0), (5e-5, 0.0, 600.0, 0.0, 9.0), feed=60, tolerance=1)
    points, _ = sampled(moves, SETTINGS)
    rate = np.abs(np.diff(points.position[:, 4])) / SETTINGS.period
    assert rate.max() <= math.radians(1.0) * (1 + 1e-6)  # F60: one degree per second


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_corner__of_a_move_below_100_nm__is_within_p(tolerance):
    ends = (1.0, 0.0, 600.0, 0.0, 0.0), (1.0, 9e-5, 600.0, 0.0, 0.0), (2.0, -1.0, 600.0, 0.0, 0.0)
    moves = lines(*ends, feed=15000, tolerance=tolerance)
    deviation = Deviation(moves)
    blocks = list(deviation.watched(iter([sampled(moves, SETTINGS)[0]])))
    corner = to_si(ends[1])
    away = np.linalg.norm((blocks[0].position - corner) * SCALE, axis=1).min()
    assert away <= tolerance / 1e3 + ROUNDING
    assert max(deviation.path, deviation.corner) <= ROUNDING


@pytest.mark.parametrize("motion", [Motion.ARC_CCW, Motion.ARC_CW])
def test_workspace__circle_a_tenth_of_a_mm_too_large__is_refused(motion):
    # Starts next to the axes, so that no point of an equal division is outermost.
    angle = math.pi / 64
    for radius, inside in ((149.99, True), (150.1, False)):
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        place = (x, y, 600.0, 0.0, 0.0)
        circle = arc(place, place, 3e4, motion)
        if inside:
            Lookahead([circle], SETTINGS).duration()
        else:
            with pytest.raises(OutsideError, match=r"got [xy] = -?150.1000 mm"):
                Lookahead([circle], SETTINGS).duration()


# Odd limits


def test_limits__jerk_of_the_tool_raised__is_never_slower():
    moves = without_approach(chord_program("G64 P0.025", 12))
    times = []
    for jerk in (1e2, 1e3, 1e4, 1e6, 1e9, 1e12):
        limits = replace(MachineLimits.of(ROBOT), tool=Limits(0.25, 4.8, jerk))
        settings = replace(SETTINGS, limits=limits)
        times.append(Lookahead(moves, settings).duration())
        found = demand(Lookahead(moves, settings).setpoints(), settings.robot, settings.period)
        assert max(found.ratios(limits).values()) <= VIOLATION
    assert all(after <= 1.01 * before for before, after in pairwise(times)), times


def test_limits__speed_allowed_below_the_resolution_of_its_search__is_found():
    # Acceleration within 99 s on a circle of 0.1 um: the jerk allows R / (0.9 * 99 s), less than
    # 2^-16 of what the other limits do.
    table = MachineLimits.of(ROBOT).table
    limits = MachineLimits(Limits(1e3, 1e4, 101.0), Limits(1e3, 1e4, 1e4), table)
    circle = arc(HOME, HOME, 1e6, centre=(0.0, 1e-4))
    time = Lookahead([circle], replace(SETTINGS, limits=limits)).duration()
    assert math.isfinite(time) and time > 2 * math.pi * 0.9 * 99


# The examiner itself


def test_deviation__full_circle_and_moves_below_a_tick__are_no_violation():
    full = Move(1, "", Motion.ARC_CW, HOME, HOME, 15000.0, Plane.XY, (7.0, 1.0), 0.01)
    short = lines(
        *((0.002 * k, 0.0, 600.0, 0.0, 0.0) for k in range(1, 200)), feed=15000, tolerance=0.01
    )
    moves = [full, *(replace(move, line=move.line + 1) for move in short)]
    points, _ = sampled(moves, SETTINGS)
    assert len(np.unique(points.line)) < len(moves)
    deviation = Deviation(moves)
    list(deviation.watched(iter([points])))
    assert max(deviation.path, deviation.corner) <= ROUNDING
    # and a micrometre next to it is one
    deviation = Deviation(moves)
    position = points.position.copy()
    position[100:120, 2] += 1.1e-5
    list(deviation.watched(iter([replace(points, position=position)])))
    assert deviation.path == pytest.approx(1e-6, rel=0.01)
