# SPDX-License-Identifier: Apache-2.0
"""Look-ahead planner: path times, corners, limits by differences, streaming, odd programs."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from sim.bench.motion.goals_lookahead import spiral
from sim.motion.gcode.interpreter import stream
from sim.motion.gcode.table_frame import from_machine
from sim.motion.geometry.curves import to_si
from sim.motion.geometry.moves import Motion, Move
from sim.motion.lookahead import limits as lookahead_limits
from sim.motion.lookahead import stress
from sim.motion.lookahead.check import Deviation, demand, from_line
from sim.motion.lookahead.figures import chord_program, corner_program, without_approach
from sim.motion.lookahead.joints import INNER_TOLERANCE
from sim.motion.lookahead.limits import MARGIN, MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.segments import OutsideError
from sim.motion.lookahead.settings import DEPTH, LookaheadSettings
from sim.motion.lookahead.speed import Cell, SpeedPlanner, Stop
from sim.motion.lookahead.stress import VIOLATION, program, programs, random_moves
from sim.motion.planner import check as planner_check
from sim.motion.planner.optimal import Limits
from sim.robot.parameters import Robot
from tests.lookahead.programs import distance_to_polyline, sampled

ROBOT = Robot.load()
SMOOTH = LookaheadSettings(robot=ROBOT)
STEPS = LookaheadSettings(robot=ROBOT, limits=MachineLimits.of(ROBOT, jerk_limited=False))
BLENDS = [replace(settings, only_blends=True) for settings in (SMOOTH, STEPS)]


def moves_of(text: str):
    return list(stream(text.splitlines()))


def violations(moves, settings) -> dict:
    found = demand(Lookahead(iter(moves), settings).setpoints(), ROBOT, settings.period)
    ratios = found.ratios(settings.limits)
    return {
        key: (ratio, found.lines.get(key))
        for key, ratio in ratios.items()
        if not ratio <= VIOLATION and (settings.limits.jerk_limited or key[1] != "jerk")
    }


# Path times


@pytest.mark.parametrize(("settings", "longest"), [(SMOOTH, 1.60), (STEPS, 1.52)])
def test_chords__blended__keep_the_feed(settings, longest):
    moves = without_approach(chord_program("G64 P0.025"))
    ideal = 0.362 / 0.25 + 0.25 / 4.8
    assert 0.999 * ideal < Lookahead(moves, settings).duration() <= longest


def test_chords__exact_stop__takes_the_time_of_84_moves_from_rest_to_rest():
    moves = without_approach(chord_program("G61"))
    way = math.dist(moves[0].start, moves[0].end) / 1e3
    each = 2 * math.sqrt(way / (4.8 * MARGIN))
    assert Lookahead(moves, STEPS).duration() == pytest.approx(84 * each, rel=1e-3)


@pytest.mark.parametrize("way", [0.001, 0.01, 0.3, 4.3, 40.0, 250.0])
def test_one_line__jerk_limited__is_as_fast_as_ruckig(way):
    limits = Limits(0.25 / MARGIN, 4.8 / MARGIN, 1000.0 / MARGIN)
    free = Limits(100.0, 1e4, 1e8)
    settings = replace(SMOOTH, limits=MachineLimits(limits, free, free))
    end = (way / 2, 0.0, 600.0, 0.0, 0.0)
    move = Move(1, "", Motion.RAPID, (-way / 2, 0.0, 600.0, 0.0, 0.0), end)
    alone = planner_check.Move(way / 1e3, 0.0, 0.0, Limits(0.25, 4.8, 1000.0))
    best = planner_check.ruckig_trajectory(alone)
    found = Lookahead([move], settings).duration()
    if way >= 1.0:  # the acceleration limit is reached
        assert found == pytest.approx(best.duration, rel=1e-6)
    else:  # the window is that of the full acceleration
        assert best.duration <= found * (1 + 1e-6) <= 2.5 * best.duration + 3 * 4.8e-3


# Corners


@pytest.mark.parametrize("settings", BLENDS, ids=["smooth", "steps"])
@pytest.mark.parametrize("angle", [30.0, 90.0, 150.0])
@pytest.mark.parametrize("tolerance", [0.001, 0.005, 0.010, 0.025, 0.1])
def test_corner__each_tolerance__is_kept_by_the_set_points_and_used(settings, angle, tolerance):
    moves = without_approach(corner_program(f"G64 P{tolerance}", angle))
    joints = []
    points, run = sampled(moves, settings, joints)
    tool = points.position[:, :3] * 1e3
    corners = np.array([moves[0].start[:3], moves[0].end[:3], moves[1].end[:3]])
    assert distance_to_polyline(tool, corners).max() <= tolerance
    assert 0.8 * tolerance <= joints[0].apex * 1e3 <= tolerance
    assert run.summary.blends == 1
    # The set-point next to the corner lies at most half a period's way next to the apex.
    if joints[0].speed * settings.period < tolerance / 1e3:
        assert np.linalg.norm(tool - corners[1], axis=1).min() <= tolerance


@pytest.mark.parametrize("settings", BLENDS, ids=["smooth", "steps"])
def test_corner__ninety_degrees__is_passed_at_31_6_mm_per_s(settings):
    moves = without_approach(corner_program("G64 P0.1"))
    points, _ = sampled(moves, settings)
    near = np.linalg.norm(points.position[:, :3] * 1e3 - (31.0, 0.0, 600.0), axis=1).argmin()
    assert np.linalg.norm(points.velocity[near, :3]) >= 31.6e-3


def test_corner__of_tool_and_table__is_rounded_in_both():
    text = "G64 P0.02\nG1 X10 A5 F6000\nX20 A0 C10\nM2"
    joints = []
    points, _ = sampled(moves_of(text), SMOOTH, joints)
    assert joints[0].angle > 0.3
    tilt = np.degrees(points.position[:, 3])
    assert 4.95 < tilt.max() < 5.0
    assert np.isclose(points.velocity[:, 3], 0.0).sum() < len(points) / 2


# Limits


@pytest.mark.quick("0-3-smooth", "25-256-steps")
@pytest.mark.parametrize("settings", [SMOOTH, STEPS], ids=["smooth", "steps"])
@pytest.mark.parametrize("depth", [3, DEPTH])
@pytest.mark.parametrize("first", range(0, 50, 25))
def test_random_programs__quick__keep_every_limit_and_p(settings, first, depth):
    settings = replace(settings, depth=depth)
    for seed in range(first, first + 25):
        outcome = program(seed, settings, 12)
        assert outcome.kept, f"random_moves({seed}, 12), depth {depth}: {outcome}"


@pytest.mark.parametrize(("seed", "depth"), [(4170, 2)])
def test_random_programs__once_broken__keep_every_limit_and_p(seed, depth):
    """4170: the final part of a plan lasted less than the shortest phase."""
    outcome = program(seed, replace(SMOOTH, depth=depth))
    assert outcome.kept, outcome


@pytest.mark.full
@pytest.mark.parametrize("first", range(1000, 11000, 500))
def test_random_programs__ten_thousand__keep_every_limit_and_p(first):
    for outcome in programs(first, 500, ROBOT):
        assert outcome.kept, (
            f"python -m sim.motion.lookahead.stress --first {outcome.seed} --count 1"
        )


@pytest.mark.parametrize("seed", [1000, 1048, 1051])
def test_deviation__p_of_the_run_doubled__is_seen_at_corners_and_on_the_path(seed):
    """Negative control: the check sees a run that uses twice the P of the program."""
    moves = [replace(move, tolerance=0.005) for move in random_moves(seed, 40)]
    assert any(move.motion.is_arc for move in moves)
    for factor, kept in ((1.0, True), (2.0, False)):
        away = Deviation(moves)
        run = [replace(move, tolerance=0.005 * factor) for move in moves]
        for _ in away.watched(Lookahead(iter(run), SMOOTH).setpoints()):
            pass
        assert (away.corner <= 0.0) == (away.path <= 0.0) == kept


def test_from_line__beside_behind_the_ends_and_of_no_length():
    start, end = np.array([1.0, 0.0]), np.array([5.0, 0.0])
    points = np.array([[2.0, 3.0], [-2.0, 4.0], [8.0, -4.0]])
    assert from_line(points, start, end).tolist() == [3.0, 5.0, 5.0]
    assert from_line(points, start, start).tolist() == pytest.approx([10**0.5, 5.0, 65**0.5])
    ends = np.array([[5.0, 0.0], [1.0, 9.0]])
    assert from_line(np.array([2.0, 3.0]), np.array([start, start]), ends).tolist() == [3.0, 1.0]


def test_deviation__corner_never_reached__is_seen():
    moves = random_moves(1000, 40)
    away = Deviation(moves)
    for _ in away.watched(Lookahead(iter(moves[:20]), SMOOTH).setpoints()):
        pass
    assert away.corner > 1e-6 and away.corner_line > 20


def test_deviation__two_moves_of_one_line__are_refused():
    with pytest.raises(ValueError, match="the lines of the moves do not ascend"):
        Deviation(moves_of("G81 X1 Z590 R599 F100\nM2"))


def test_stress_command__limit_broken__names_the_program_and_fails(monkeypatch, capsys):
    assert stress.main(["--first", "1000", "--count", "1"]) == 0
    assert "0 violations" in capsys.readouterr().out
    monkeypatch.setattr(lookahead_limits, "MARGIN", 1.01)
    assert stress.main(["--first", "1000", "--count", "1"]) == 1
    assert "program 1000: " in capsys.readouterr().out
    with pytest.raises(SystemExit):
        stress.main(["--count", "0"])


@pytest.mark.parametrize("quantity", ["speed", "acceleration", "jerk"])
@pytest.mark.parametrize("group", ["tool", "leg", "table"])
def test_limits__of_one_kind_lowered__are_kept_and_would_be_broken_without(group, quantity):
    moves = moves_of("G64 P0.05\nG1 X20 A10 F15000\nY20 C30\nX0 A0\nY0 Z610\nM2")
    found = demand(Lookahead(moves, SMOOTH).setpoints(), ROBOT, SMOOTH.period)
    lower = getattr(SMOOTH.limits, group)
    lower = replace(lower, **{quantity: found.greatest[group, quantity] / 2})
    settings = replace(SMOOTH, limits=replace(SMOOTH.limits, **{group: lower}))
    assert found.ratios(settings.limits)[group, quantity] == pytest.approx(2.0)
    assert not violations(moves, settings)


def test_set_points__velocity_and_acceleration__are_derivatives_of_the_position():
    points, _ = sampled(random_moves(7, 40), SMOOTH)
    period = SMOOTH.period
    central = (points.position[2:] - points.position[:-2]) / (2 * period)
    second = np.diff(points.position, 2, axis=0) / period**2
    # Taylor: a central difference misses by at most jerk T^2 / 6, a second one by jerk T.
    jerk = np.array([1000.0] * 3 + [5000.0] * 2)
    assert (np.abs(central - points.velocity[1:-1]) <= jerk * period**2).all()
    assert (np.abs(second - points.acceleration[1:-1]) <= 2 * jerk * period).all()


# Streams


@pytest.mark.parametrize("seed", range(4))
def test_stream__any_depth__gives_the_same_motion(seed):
    moves = random_moves(seed, 80)
    cells = list(Lookahead(iter(moves), SMOOTH)._cells())
    window = SMOOTH.limits.window

    def duration(depth: int) -> float:
        planner = SpeedPlanner(window, 1.0, depth)
        return sum(stretch.duration for stretch in planner.run(iter(cells)))

    assert [duration(depth) for depth in (5, 30, 100)] == pytest.approx(
        [duration(10**6)] * 3, rel=1e-12
    )
    # Other batches may round the speed limits differently, by the resolution of their search.
    short = Lookahead(iter(moves), replace(SMOOTH, depth=7)).duration()
    assert short == pytest.approx(duration(10**6), rel=2.0**-16)


def test_stream__usual_depth__brakes_for_an_end_more_than_256_segments_ahead():
    """Segments of 0.02 mm: from the feed of 0.25 m/s a stop takes more than 300 of them."""
    way = 0.02
    moves = [
        Move(k, "", Motion.LINEAR, (x, 0.0, 600.0, 0.0, 0.0), (x + way, 0.0, 600.0, 0.0, 0.0), 15e3)
        for k, x in enumerate((np.arange(2000) * way - 20).tolist(), start=1)
    ]
    limits = replace(MachineLimits.of(ROBOT, jerk_limited=False), leg=Limits(10.0, 100.0, 1e5))
    points, _ = sampled(moves, replace(STEPS, limits=limits))
    speed = np.linalg.norm(points.velocity[:, :3], axis=1)
    assert speed.max() == pytest.approx(0.25, rel=2e-3)
    left = moves[-1].end[0] / 1e3 - points.position[:, 0]
    ahead = np.searchsorted(-left, -256 * way / 1e3)
    # As fast there as a stop in the way left allows: nothing was held back, nothing came too late.
    assert speed[ahead] == pytest.approx(math.sqrt(2 * 4.8 * MARGIN * left[ahead]), rel=1e-3)
    assert 0.25**2 / (2 * 4.8) > 256 * way / 1e3


def test_stream__depth_of_one_stretch__would_stop_without_look_ahead():
    cells = [Cell(1e-4, 0.25, 4.0)] * 1000
    stops = [item for cell in cells for item in (cell, Stop(0.0))]
    planner = SpeedPlanner(SMOOTH.limits.window, 1.0, 10)
    with_stops = sum(s.duration for s in planner.run(iter(stops)))
    planner = SpeedPlanner(SMOOTH.limits.window, 1.0, 10)
    assert with_stops > 20 * sum(s.duration for s in planner.run(iter(cells)))


def test_stream__endless_program__gives_set_points_with_bounded_memory():
    run = Lookahead(spiral(None), SMOOTH)
    held = 0
    for points in run.setpoints():
        held = max(held, len(run._elements))
        if points.first > 30_000:
            break
    assert run.summary.moves < 6000
    assert held < 16 * DEPTH


@pytest.mark.parametrize("count", [1000, 2000])
def test_stream__twice_the_moves__are_twice_the_work(count):
    run = Lookahead(spiral(count), SMOOTH)
    run.duration()
    assert run.summary.cells <= run.planned <= 4 * run.summary.cells


# Odd programs

ODD = {
    "zero-length and repeated": "G64 P0.01\nG1 X1 F15000\nX1\nX1 Y0\nX2\nX2\nM2",
    "reversals": "G64 P0.01\nG1 X1 F15000\nX0\nX1\nX0.5\nX2\nM2",
    "tiny tolerance": "G64 P0.0000001\nG1 X1 F15000\nY1\nX0\nY0\nM2",
    "no tolerance": "G64 P0\nG1 X1 F15000\nY1\nM2",
    "tiny moves": "G64 P0.01\nG1 X.00001 F15000\nY.00001\nX.00002 Y0\nX1\nX1.00001\nM2",
    "no move": "M2",
    "one tiny move": "G64 G1 X.0000001 F15000\nM2",
    "arcs tangent to lines": "G64 P.02\nG1 X10 F15000\nG3 X10 Y10 J5\nG1 X0\nG2 X-5 Y15 J5\nM2",
    "arcs off their circle": "G64 P.02\nG1 X10 F15000\nG3 X10.001 Y10 J5\nG1 X0\nM2",
    "helix and table": "G64 P.01\nG0 X30\nG3 I-30 Z610 C90 F15000\nG3 I-30 Z620 C180\nG1 Y20\nM2",
    "arcs of turned planes": (
        "G64 P.02\nG10 L2 P1 R30\nG18 G1 X10 F15000\nG2 X18 Z604 I5 K0 Y2\nG1 Z610\nG19 G3 Y6 R4\n"
        "G1 Y9\nM2"
    ),
    "table alone": "G64 P.01\nG1 A10 F3000\nC20\nA0 C0\nG0 A5\nM2",
    "slow": "G64 P.01\nG1 X.01 F.5\nY.01\nM2",
    "dwells": "G4 P.01\nG4 P0\nG64 G1 X1 F15000\nG4 P.02\nG4 P.03\nX2\nY1\nG4 P.05\nM2",
    "merged": "G64 P.02 Q.01\nG1 X.1 Y.005 F15000\nX.2 Y0\nX.3 Y.005\nX.4 Y-.004\nX.5\nY5\nM2",
    "table frame": "G64 P.01\nG43.4\nG0 X30\nG1 Y10 F6000\nA20 C30\nG3 X20 Y0 R10\nG49 G1 X0\nM2",
}


@pytest.mark.parametrize("settings", [SMOOTH, STEPS], ids=["smooth", "steps"])
@pytest.mark.parametrize("name", ODD)
def test_odd_program__any__ends_exactly_within_the_limits(name, settings):
    items = moves_of(ODD[name])
    moves = [item for item in items if isinstance(item, Move)]
    if not moves:
        assert list(Lookahead(items, settings).setpoints()) == []
        return
    points, run = sampled(items, settings)
    assert np.isfinite(points.position).all()
    assert points.position[0] == pytest.approx(to_si(moves[0].start), abs=1e-12)
    assert points.position[-1] == pytest.approx(to_si(moves[-1].end), abs=1e-12)
    stops = 0.02 * (len(moves) + 1)
    ways = [np.abs(to_si(m.end) - to_si(m.start)).max() for m in moves]
    slowest = min(1.0, *((m.feed or 1e5) / 60e3 for m in moves))
    assert run.summary.duration <= 0.2 + stops + sum(5 * way / slowest for way in ways)
    assert not violations(items, settings)


@pytest.mark.full
def test_odd_paths__a_thousand__never_stall_nor_lose_a_part_of_their_way():
    assert stress.odd_block(0, SMOOTH) > 0.0


@pytest.mark.full
@pytest.mark.parametrize("first", range(1000, 2000, 20))
def test_odd_paths__a_million__never_stall_nor_lose_a_part_of_their_way(first):
    for block in range(first, first + 20):
        stress.odd_block(block, SMOOTH)


@pytest.mark.full
def test_odd_paths__machine_slower_than_the_bound_allows__is_a_stall(monkeypatch, capsys):
    tool = replace(SMOOTH.limits.tool, speed=1e-3)
    slow = replace(SMOOTH, limits=replace(SMOOTH.limits, tool=tool))
    monkeypatch.setattr(stress, "LookaheadSettings", lambda: slow)
    assert stress.main(["--odd", "--first", "0", "--count", "1"]) == 1
    assert re.search("error: odd block 0: .* s expected", capsys.readouterr().out)


def test_dwell__between_moves__rests_for_its_time():
    points, _ = sampled(moves_of("G64 G1 X5 F6000\nG4 P0.25\nX10\nM2"), SMOOTH)
    resting = (points.velocity == 0.0).all(axis=1) & np.isclose(points.position[:, 0], 0.005)
    assert resting.sum() * SMOOTH.period == pytest.approx(0.25, abs=2 * SMOOTH.period)


def test_merged__lines_within_q__are_one_line_within_q():
    items = moves_of(ODD["merged"])
    points, run = sampled(items, SMOOTH)
    assert run.summary.blends + run.summary.turns + run.summary.stops == 1
    corners = np.array([items[0].start[:3], *(move.end[:3] for move in items)])
    off = distance_to_polyline(points.position[:, :3] * 1e3, corners)
    assert 0.001 < off.max() <= 0.01 + 0.02


def test_table_frame__lines_while_the_table_turns__are_straight_on_the_work_piece():
    text = "G64 P0.005\nG43.4\nG1 X20 Y5 F3000\nX-20 Y10 Z605 A25 C60\nX0 Y-10 A-10 C0\nM2"
    points, _ = sampled(moves_of(text), SMOOTH)
    mm = points.position * ([1e3] * 3 + [math.degrees(1)] * 2)
    part = np.array([from_machine(tuple(pose.tolist()), (0, 0, 520))[:3] for pose in mm[::10]])
    corners = np.array([(0, 0, 600), (20, 5, 600), (-20, 10, 605), (0, -10, 605)])
    off = distance_to_polyline(part, corners)
    assert off.max() <= 0.005 + 0.0005 + INNER_TOLERANCE * 1e3
    speed = np.linalg.norm(np.diff(part, axis=0), axis=1) / (10 * SMOOTH.period)
    assert speed.max() == pytest.approx(50.0, rel=5e-3)
    assert np.ptp(points.position[:, 3]) > 0.5


def test_workspace__left_by_a_line_or_an_arc__names_the_line():
    flat, turned = "G1 X145 F100\nG3 Y20 R10\nM2", "G18 G1 X145 F100\nG2 Z620 R10\nM2"
    texts = "G1 X10 F100\nX200\nM2", flat, *(f"G10 L2 P1 R{r}\n{turned}" for r in (90, 179))
    for line, text in zip((2, 2, 3, 3), texts, strict=True):
        with pytest.raises(OutsideError, match=f"part.ngc:{line}: error: the move leaves"):
            Lookahead(moves_of(text), SMOOTH, file="part.ngc").duration()


@pytest.mark.parametrize(
    ("end", "text"),
    [
        ("A14000", "got A = 14000.0000 degree; expected -180 to 180 degree"),
        ("C-10801", "got C = -10801.0000 degree; expected -10800 to 10800 degree"),
    ],
)
def test_travel_of_the_table__left__names_the_line_and_the_travel(end, text):
    with pytest.raises(OutsideError, match=f"part.ngc:3: error: .*{text}"):
        Lookahead(moves_of(f"G1 A180 F1000000\nA0\n{end}\nM2"), SMOOTH, file="part.ngc").duration()


@pytest.mark.parametrize("change", [{"rapid": -1.0}, {"depth": 1}])
def test_settings__outside_their_limits__are_refused_by_name(change):
    with pytest.raises(ValueError, match=f"{next(iter(change))} = "):
        LookaheadSettings(robot=ROBOT, **change)
