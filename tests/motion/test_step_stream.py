# SPDX-License-Identifier: Apache-2.0
"""Planned paths as phase records: against exact sums, and end to end through the front-end RTL."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from sim.bench.motion import show_path, step_stream
from sim.bench.motion.step_stream import AXES, AxisEncoder, PathEncoder, Steps, joints, published
from sim.motion.gcode.interpreter import stream
from sim.motion.lookahead.planner import Lookahead, Setpoints
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.lookahead.stress import random_moves
from sim.motion.planner.phases import Phase, State
from sim.motion.planner.pulse_records import PulseRecordError, pulse_counted
from sim.robot.parameters import Robot
from sim.rtl.motion_rtl import MotionError
from sim.rtl.phase_record import FRACTION, HIGHEST_RATE, LAST, TICK, UNITS_PER_HZ, Record

ROBOT = Robot.load()
SETTINGS = LookaheadSettings(robot=ROBOT)
# Every axis turns round at least once, in a tenth of a second.
SHORT = "G64 P0.01\nG1 X.8 A.2 C.3 F9000\nG3 X0 Y.8 I-.8 A-.1 C0\nG1 X.2 Y0 Z600.5 A.1 C.2\nM2\n"


def encoded(blocks: list[Setpoints], steps: Steps) -> tuple[PathEncoder, list[list[Record]]]:
    encoder = PathEncoder(ROBOT, SETTINGS.period, steps)
    axes: list[list[Record]] = [[] for _ in AXES]
    for parts in encoder.run(iter(blocks)):
        for axis, part in zip(axes, parts, strict=True):
            axis += part
    return encoder, axes


def planned(blocks: list[Setpoints], steps: Steps) -> tuple[np.ndarray, np.ndarray]:
    """Joints [steps] from the start at every microsecond, and their last place."""
    found = [joints(ROBOT, block, steps) for block in blocks]
    place, speed = (np.concatenate(values) for values in zip(*found, strict=True))
    times = np.arange(len(place)) * SETTINGS.period
    fine = np.arange(1, round(times[-1] * 1e6) + 1) * 1e-6
    return CubicHermiteSpline(times, place - place[0], speed)(fine), place[-1] - place[0]


@pytest.mark.quick("steps0-0", "steps1-1")
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("steps", [Steps(), Steps(leg=5e4, table=900.0, every=20)])
def test_records__random_paths__every_count_within_a_step_of_the_joint(seed, steps):
    blocks = list(Lookahead(iter(random_moves(seed, 5)), SETTINGS).setpoints())
    encoder, axes = encoded(blocks, steps)
    wanted, end = planned(blocks, steps)
    for n, records in enumerate(axes):
        count, place = published(records)
        assert len(count) == len(wanted)
        # Half a step of rounding, half a step at a change of direction.
        assert np.abs(count - wanted[:, n]).max() <= 1.0, (seed, AXES[n])
        assert count[-1] == round(end[n]) == encoder.axes[n].count
        assert abs(place[-1] - count[-1]) < 0.5
        assert [bool(record.flags & LAST) for record in records] == [False] * (len(records) - 1) + [
            True
        ]


def test_records__path_without_a_change_of_direction__within_half_a_step_and_a_hundredth():
    moves = list(stream("G64 P.01\nG1 X10 F9000\nX20 Y1\nM2\n".splitlines()))
    blocks = list(Lookahead(iter(moves), SETTINGS).setpoints())
    steps = Steps(leg=2e6)
    _, axes = encoded(blocks, steps)
    wanted, _ = planned(blocks, steps)
    ways = np.diff(wanted[:, :3], axis=0)
    straight = np.flatnonzero(np.abs(ways).sum(axis=0) - np.abs(ways.sum(axis=0)) < 1e-3)
    assert len(straight)
    for n in straight:
        _, place = published(axes[n])
        # The cubics of 1 ms miss the path by J h^3 / 96 at a step J of the jerk.
        assert np.abs(place - wanted[:, n])[:-1000].max() <= 2e6 * 2 * 2000 * 1e-9 / 96 + 1e-3


def test_records__blocks_of_any_size__are_the_same():
    whole = _joined(Lookahead(iter(random_moves(3, 4)), SETTINGS).setpoints())
    cut = [1, 2, 13, 300]
    parts = [_slice(whole, a, b) for a, b in zip([0, *cut], [*cut, len(whole)], strict=True)]
    assert encoded([whole], Steps())[1] == encoded(parts, Steps())[1]


def _joined(blocks) -> Setpoints:
    blocks = list(blocks)
    names = ("position", "velocity", "acceleration", "line", "move")
    return Setpoints(0, *(np.concatenate([getattr(b, name) for b in blocks]) for name in names))


def _slice(points: Setpoints, first: int, end: int) -> Setpoints:
    names = ("position", "velocity", "acceleration", "line", "move")
    return Setpoints(first, *(getattr(points, name)[first:end] for name in names))


def test_axis__turning_back_inside_a_step__waits_and_goes_back_from_the_middle():
    axis = AxisEncoder("leg 1", 100.0)
    records = axis.records(1000, 100.0, 0.0, 100.4, 0.0)
    assert (axis.count, axis.place) == (0, pytest.approx(0.4, abs=1e-3))
    records += axis.records(1000, 100.4, 0.0, 100.1, 0.0)  # not yet after the count: it waits
    assert records[-1].velocity == 0 and axis.sign == 1
    records += axis.records(1000, 100.1, 0.0, 98.2, 0.0, last=True)
    count, _ = published(records)
    assert axis.count == count[-1] == -2
    assert len(count) == 3000 and np.abs(np.diff(count)).max() == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"leg": 0.0}, "leg = 0.0 is outside its limit: leg > 0"),
        ({"every": 0}, "every = 0 is outside its limit: every > 0"),
        ({"every": 2.5}, "every = 2.5 is not a whole number"),
    ],
)
def test_steps__outside_their_limits__are_refused_by_name(change, message):
    with pytest.raises(PulseRecordError, match=message):
        Steps(**change)


def test_phase__the_least_part_beyond_the_highest_rate__is_refused():
    unit = UNITS_PER_HZ * FRACTION  # of a rate; its smallest part is lost in a double
    slope = 4
    for beyond in (0, 1):
        speed = HIGHEST_RATE + Fraction(beyond - 8 * slope, unit)
        start = State(Fraction(0), speed, Fraction(slope, unit) / TICK)
        phase = Phase(8 / Fraction(HIGHEST_RATE), Fraction(0), start)
        with pytest.raises(PulseRecordError, match="phase 1: rates") if beyond else nullcontext():
            assert pulse_counted([phase], 1)[0].count == 8


def test_encoder__what_the_hardware_cannot_do__is_refused_by_axis():
    axis = AxisEncoder("tilt", 0.0)
    with pytest.raises(PulseRecordError, match=r"tilt: .* steps/s are more than 50000000"):
        axis.records(1000, 0.0, 100.0, 1e5, 100.0)
    with pytest.raises(PulseRecordError, match=r"tilt: acceleration .* is not below"):
        axis.records(5, 0.0, 0.0, 40.0, 20.0)
    with pytest.raises(PulseRecordError, match="period = 2.5e-06 s is not a whole number"):
        PathEncoder(ROBOT, 2.5e-6)
    with pytest.raises(PulseRecordError, match="period = nan s is not a whole number"):
        PathEncoder(ROBOT, math.nan)


# ---------------------------------------------------------------------- end to end


def test_rtl__short_g64_program__counts_exact_and_steps_by_the_plan():
    clocks: list[int] = []
    run = show_path.run(SHORT, Steps(leg=5e5), progress=clocks.append)
    assert run.counted == run.wanted
    assert run.deviation.max() <= show_path.BOUND
    assert all(turns > 0 for turns in run.reversals)
    assert sum(clocks) == pytest.approx((len(run.points) - 1) * run.period * 1e8, rel=0.01)
    # The commanded path is the programmed one except for P and the steps' size (legs, 2 um).
    assert 0.0 < run.tool_error() < 4e-6
    assert run.beyond_p() < 4e-6
    rows = {row.name: row for row in show_path.results(run)}
    assert all(row.agrees for row in rows.values())
    assert rows["five axes: steps sent"].ours > 3000
    # The start is known to the tick: with any other one the steps are farther from their places.
    late = [_farthest(run, shift) for shift in (-1e-6, 0.0, 1e-6)]
    assert late[1] == min(late)


def _farthest(run: show_path.PathRun, shift: float) -> float:
    """Mean distance of leg 2 from the place its steps represent, all times later by shift [s]."""
    times = np.arange(len(run.points)) * run.period
    place, speed = joints(run.robot, run.points, run.steps)
    at, count = run.edges[1]
    plan = CubicHermiteSpline(times, place[:, 1] - place[0, 1], speed[:, 1])
    middle = count - np.diff(count, prepend=0) / 2
    return float(np.abs(middle - plan(np.clip(at + shift, 0, times[-1]))).mean())


@pytest.mark.full
def test_rtl__one_record_a_thousandth_faster__is_seen(monkeypatch):
    """Negative control: what the encoder believes and what the hardware does must be the same."""
    record = AxisEncoder._record
    made: list[str] = []

    def faster(self, flags, ticks, velocity, slope, jerk):
        if ticks > 100:  # a thousandth of a shorter one may be no step
            made.append(self.name)
        right = record(self, flags, ticks, velocity, slope, jerk)
        if self.name == "leg 2" and ticks > 100 and made.count("leg 2") == 40:
            return replace(right, velocity=right.velocity + (1 << 52))
        return right

    monkeypatch.setattr(step_stream.AxisEncoder, "_record", faster)
    run = show_path.run(SHORT, Steps(leg=5e5))
    assert run.counted[0] == run.wanted[0]
    assert run.counted[1] != run.wanted[1]
    assert not all(row.agrees for row in show_path.results(run))


def test_rtl__rings_not_refilled_in_time__is_an_error(monkeypatch):
    monkeypatch.setattr(show_path, "CHUNK", 2_000_000)
    with pytest.raises(MotionError, match="records ran out inside the path: underrun"):
        show_path.run(SHORT, Steps(leg=5e5))
