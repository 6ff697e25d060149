# SPDX-License-Identifier: Apache-2.0
"""Splines: evaluation against scipy, chords against the curve, moves against LinuxCNC's points."""

import random

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from sim.motion.gcode.interpreter import parse, stream
from sim.motion.gcode.oracle import curve_difference, differences, ours, rs274
from sim.motion.gcode.splines import TOLERANCE_MM
from sim.motion.geometry import nurbs
from sim.motion.geometry.nurbs import Nurbs
from sim.motion.lookahead.check import from_line
from sim.motion.lookahead.planner import Lookahead
from tests.bench.needs import needs
from tests.bench.seed import SEED
from tests.gcode.mistakes import ZERO, refused

HEAD = "G21 G90 G17 G94 G54 G98 G64\nG0 X1 Y2 F100\n"


def random_curve(rng: np.random.Generator) -> Nurbs:
    order = int(rng.integers(2, 9))
    count = int(rng.integers(order, order + 9))
    points, weights = rng.uniform(-50, 50, (count, 2)), rng.uniform(0.1, 5, count)
    return Nurbs(points, weights, order)


def of_scipy(curve: Nurbs, u: np.ndarray) -> np.ndarray:
    found = BSpline(curve.knots, curve.homogeneous, curve.order - 1)(u)
    return found[:, :2] / found[:, 2:]


def test_nurbs__random_curves__are_those_of_scipy():
    rng = np.random.default_rng(SEED)
    for _ in range(100):
        curve = random_curve(rng)
        u = np.linspace(0.0, curve.end, 40)
        mine = np.array([curve.point(value) for value in u])
        assert mine == pytest.approx(of_scipy(curve, u), abs=1e-10)


@pytest.mark.parametrize("tolerance", [TOLERANCE_MM, 0.1])
def test_nurbs__chords__miss_the_curve_by_no_more_than_the_tolerance(tolerance):
    rng = np.random.default_rng(SEED)
    for _ in range(4):
        curve = random_curve(rng)
        ends = np.array(
            [curve.homogeneous[0, :2] / curve.homogeneous[0, 2], *curve.chords(tolerance)]
        )
        points = of_scipy(curve, np.linspace(0.0, curve.end, 3000))
        for point in points:
            assert from_line(point, ends[:-1], ends[1:]).min() <= tolerance * 1.000001
        dense = of_scipy(curve, np.linspace(0.0, curve.end, 200_001))
        step = np.linalg.norm(np.diff(dense, axis=0), axis=1).max()
        assert cKDTree(dense).query(ends)[0].max() <= step  # its ends are on the curve


def random_program(seed: str) -> str:
    """Splines of each kind after each other, in mm or inches, absolute or incremental."""
    rng = random.Random(seed)
    lines = [HEAD + rng.choice(["G20\nG10 L2 P1 X1 Y-2", "G91", "G92 X3 Y4", ""])]
    before = False
    for _ in range(rng.randrange(1, 5)):
        place = lambda: f"X{rng.uniform(-20, 20):.4f} Y{rng.uniform(-20, 20):.4f}"  # noqa: E731
        way = lambda a, b: f"{a}{rng.uniform(-9, 9):.4f} {b}{rng.uniform(-9, 9):.4f}"  # noqa: E731
        kind = rng.choice(("G5", "G5", "G5.1", "G5.2"))
        if kind == "G5.1":
            lines.append(f"G5.1 {place()} {way('I', 'J')}")
        elif kind == "G5":
            onward = before and rng.random() < 0.5
            lines.append(f"G5 {place()} {'' if onward else way('I', 'J')} {way('P', 'Q')} F90")
        else:
            order = rng.randrange(3, 6)
            first = rng.choice([f"G5.2 P{rng.uniform(0.3, 3):.3f} L{order}"] * 2 + [""])
            if not first:
                first = f"G5.2 {place()} P1 L{order}"
            more = [f"{place()} P{rng.uniform(0.3, 3):.3f}" for _ in range(rng.randrange(order, 9))]
            lines += [first, *more, "G5.3"]
        before = kind == "G5"
        if rng.random() < 0.3:
            lines.append(f"G1 {place()}")
            before = False
    return "\n".join([*lines, "G90 G1 X0 Y0", "M2"]) + "\n"


@needs("rs274")
@pytest.mark.parametrize("number", [10, pytest.param(300, marks=pytest.mark.full)])
def test_splines__random_programs__are_the_curves_of_linuxcnc(number):
    for case in range(number):
        seed = f"spline {SEED} {case}"
        text = random_program(seed)
        assert differences(text) == [], f"seed {seed!r}\n{text}"


@needs("rs274")
def test_splines__one_number_changed__is_seen():
    text = HEAD + "G5 X10 Y0 I5 J8 P-5 Q3\nM2\n"
    mine, theirs = ours(text)[1][1], rs274(text.replace("J8", "J8.01"))[1][1]
    chords, points = np.reshape(mine[1:], (-1, 2)), np.reshape(theirs[1:], (-1, 2))
    assert curve_difference(chords, points) is not None
    assert curve_difference(chords[:-1], np.reshape(rs274(text)[1][1][1:], (-1, 2))) is not None


@pytest.mark.parametrize("mode", ["G64 P.01", "G61"])
def test_splines__through_look_ahead__run_through_near_the_curve_at_their_feed(mode):
    feed, curve = 1500.0, Nurbs([(0, 0), (20, 30), (40, -30), (60, 0)], [1.0] * 4, 4)
    text = f"{mode}\nG5 X60 Y0 I20 J30 P-20 Q-30 F{feed}\nM2"
    plan = Lookahead(stream(text.splitlines()), joints=[])
    parts = list(plan.setpoints())
    places = np.concatenate([part.position for part in parts])[:, :2] * 1e3
    speeds = np.linalg.norm(np.concatenate([part.velocity for part in parts])[:, :3], axis=1) * 6e4
    assert plan.summary.stops == 0
    near = cKDTree(of_scipy(curve, np.linspace(0.0, curve.end, 100_001)))
    assert near.query(places)[0].max() < 0.001
    fast = np.flatnonzero(speeds > 0.99 * feed)
    assert speeds[fast[0] : fast[-1]].min() > 0.99 * feed
    assert fast[-1] - fast[0] > 0.98 * len(speeds) - 300


def test_splines__in_coordinates_of_the_table__turn_with_it():
    moves = parse("G43.4\nG0 A10 C90\nG1 X0 Y0 Z600 F9\nG5.1 X5 Y5 I5 J0\nM2").moves
    plain = parse("G0 X0 Y0\nG5.1 X5 Y5 I5 J0 F9\nM2").moves
    assert len(moves) - 1 >= len(plain) - 1
    assert moves[-1].end[3:] == (10.0, 90.0)
    assert moves[-1].end[:3] != pytest.approx((0.0, 0.0, 600.0))


def test_splines__inverse_time__is_the_time_of_the_whole_curve():
    moves = parse("G93 G5.1 X5 Y5 I5 J0 F2\nM2", start=ZERO).moves
    length = sum(np.hypot(m.end[0] - m.start[0], m.end[1] - m.start[1]) for m in moves)
    assert {round(move.feed, 9) for move in moves} == {round(2 * length, 9)}


REFUSED = {
    "G5 X1 Y1 P1 Q1": "G5 without I and J",
    "G5 X1 Y1 I1 P1 Q1": "G5 without I and J",
    "G5 X1 Y1 I1 J1 P1": "G5 without P and Q",
    "G5 I1 J1 P1 Q1": "G5 without a position",
    "G5 X1 I1 J1 P1 Q1\nG1 X3\nG5 X9 P1 Q1": "G5 without I and J",
    "G5.1 X1 Y1 I1": "G5.1 without I and J",
    "G5.1 X1 Y1 I1 J1 Z3": "Z does not belong to G5.1",
    "G18 G5.1 X1 Y1 I1 J1": "G5.1 outside of the plane XY",
    "G5.3": "G5.3 without G5.2",
    "G5.2 X1 Y1 P1\nG5.3": "2 control points for a NURBS of order 3",
    "G5.2 X1 Y1 P1 L2": "the order of the NURBS is 2",
    "G5.2 X1 Y1 P1 L99": "the order of the NURBS is 99",
    "G5.2 X1 Y1\nX2 Y2 P1\nG5.3": "a control point without a positive weight",
    "G5.2 X1 Y1 P1\nX2 P1": "a control point needs X and Y",
    "G5.2 X1 Y1 P1\nG1 X2": "G1 between G5.2 and G5.3",
    "G5.2 X1 Y1 P1\nG55": "G55 between G5.2 and G5.3",
    "G5.2 X1 Y1 P1": "M2 between G5.2 and G5.3",
    "G5.1 X9999999 Y0 I5000000 J9999999": "the curve needs more than 100000 chords",
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED)
def test_splines__what_is_not_defined__is_refused_by_name(text):
    assert REFUSED[text] in str(refused(f"F100\n{text}\nM2", start=ZERO))


def test_nurbs__beyond_its_limit__stops(monkeypatch):
    monkeypatch.setattr(nurbs, "MAX_CHORDS", 10)
    with pytest.raises(nurbs.TooManyChordsError):
        Nurbs([(0, 0), (10, 10), (20, 0)], [1.0] * 3, 3).chords(1e-6)
