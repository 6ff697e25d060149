# SPDX-License-Identifier: Apache-2.0
"""Override and stop at random instants: limits at every instant, exact end, an own integrator."""

from __future__ import annotations

import random

import numpy as np
import pytest

from sim.motion.planner.check import executed, integrate, random_overridden, run_with_changes
from sim.motion.planner.optimal import Limits, stopping_length, transition
from sim.motion.planner.override import OverriddenMove
from sim.motion.planner.phases import State
from sim.motion.planner.scurve import SCurveError
from tests.bench.seed import SEED

ROUNDING = 1e-12
LIMITS = Limits(2.0, 5.0, 40.0)


@pytest.mark.parametrize("block", range(4))
def test_override__random_changes__hold_all_limits_at_every_instant(block):
    for number in range(75):
        seed = f"override {SEED} {block} {number}"
        move = run_with_changes(seed)
        limits = move.limits
        times, states = integrate(move.at(0.0), executed(move), points=8)
        total = float(times[-1])
        position, speed, acceleration = states.T
        where = f"seed {seed!r}"
        # Errors of speed grow with the changes, and the position with their time.
        slack = 1e3 * ROUNDING * limits.speed
        assert speed.max() <= limits.speed + slack and speed.min() >= -slack, where
        assert np.abs(acceleration).max() <= limits.acceleration * (1 + 1e3 * ROUNDING), where
        assert max(abs(step.jerk) for step in executed(move)) <= limits.jerk, where
        way = move.length + limits.speed * total
        assert np.all(np.diff(position) >= -1e3 * ROUNDING * way), where
        got = np.array([move.at(float(t)) for t in times])
        assert np.all(np.abs(got[:, 0] - position) <= 1e3 * ROUNDING * way), where
        # No plan hides a way that it does not run.
        for profile in move.profiles:
            run_at_most = move.length + limits.speed * profile.total_time
            assert abs(profile.mismatch.position) <= ROUNDING * run_at_most, where
        end = move.at(move.end_time)
        assert end.position == move.length and end.acceleration == 0.0, where


def test_override__every_change__is_followed_as_fast_as_the_limits_allow():
    """Speed stays below the new limit, or below the fastest way down to it."""
    for number in range(200):
        rng = random.Random(f"limit {SEED} {number}")
        move = random_overridden(rng)
        time = move.end_time * rng.uniform(0, 0.7)
        override = rng.uniform(0.05, 2)
        state = move.at(time)
        move.set_override(time, override)
        limit = move.speed_limit(override)
        if move.profiles[-1].end.speed > limit:  # not enough way to come down
            continue
        down = transition(state.speed, state.acceleration, limit, move.limits)
        times, states = integrate(state, down)
        allowed = np.maximum(limit, states[:, 1])
        got = np.array([move.at(time + float(t)).speed for t in times])
        # An instant before a change of jerk is as good as one after it.
        slack = ROUNDING * 1e3 * move.limits.speed
        assert np.all(got <= allowed + slack), f"move {number}, SEED={SEED}"
        later = [move.at(time + float(times[-1]) + k * move.end_time / 50).speed for k in range(50)]
        assert max(later) <= limit + slack, f"move {number}, SEED={SEED}"


def test_override__unchanged__does_not_change_the_time():
    for number in range(200):
        rng = random.Random(f"same {SEED} {number}")
        move = random_overridden(rng)
        total = move.end_time
        for share in sorted(rng.random() for _ in range(5)):
            move.set_override(share * total, 1.0)
        assert move.end_time == pytest.approx(total, rel=1e-6), f"move {number}, SEED={SEED}"


def test_override__doubled_and_halved__are_faster_and_slower():
    times = []
    for override in (0.5, 1.0, 2.0):
        move = OverriddenMove(3.0, 0.5, LIMITS)
        move.set_override(1.0, override)
        assert max(move.at(t).speed for t in np.linspace(1.5, 2.5, 101)) == pytest.approx(
            0.5 * override
        )
        times.append(move.end_time)
    assert times == sorted(times, reverse=True)


def test_override__machine_limit__is_never_passed():
    move = OverriddenMove(20.0, 1.5, LIMITS)
    move.set_override(0.2, 2.0)
    assert max(move.at(t).speed for t in np.linspace(0, move.end_time, 999)) == LIMITS.speed


def test_stop__at_any_instant__rests_on_the_path_and_goes_on():
    for share in np.linspace(0.02, 0.98, 25):
        move = OverriddenMove(3.0, 1.0, LIMITS)
        time = float(share) * move.end_time
        state = move.at(time)
        way = stopping_length(state.speed, state.acceleration, 0.0, LIMITS)
        move.stop(time)
        rest = move.at(move.end_time + 5.0)
        assert (rest.speed, rest.acceleration) == (0.0, 0.0)
        assert rest.position == pytest.approx(min(3.0, state.position + way), abs=1e-7)
        if not move.finished_at_length:
            move.set_override(move.end_time + 1.0, 0.7)
        assert move.at(move.end_time) == State(3.0, 0.0, 0.0)


def test_stop__too_late_for_the_way_left__ends_at_the_slowest_speed_possible():
    move = OverriddenMove(3.0, 1.0, LIMITS, ve=1.0)
    move.stop(move.end_time - 0.1)  # a stop takes 0.16
    end = move.profiles[-1].end
    assert end.position == 3.0 and 0.0 < end.speed < 1.0
    steps = move.profiles[-1].steps
    assert steps[0].jerk == -LIMITS.jerk  # braking from the first instant


def test_override__end_of_the_move__changes_nothing():
    move = OverriddenMove(1.0, 1.0, LIMITS)
    move.set_override(move.end_time + 1.0, 0.5)
    assert len(move.profiles) == 1 and move.at(99.0) == State(1.0, 0.0, 0.0)


@pytest.mark.parametrize("override", [5e-324, 1e-200, 9e-6])
def test_override__next_to_nothing__stops_within_the_limits(override):
    move = OverriddenMove(1.0, 1.0, LIMITS, v0=0.5)
    move.set_override(0.1, override)
    assert move.end_time < 1.0 and move.at(1.0).speed == 0.0
    assert move.at(1.0).position < move.length
    move.set_override(1.0, 1.0)
    assert move.at(move.end_time) == State(1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("time", "override", "message"),
    [
        (1.0, 2.1, "override = 2.1 is outside its limit: 0 <= override <= 2"),
        (1.0, -0.1, "override = -0.1 is outside its limit: 0 <= override <= 2"),
        (1.0, float("nan"), "override = nan is outside its limit: 0 <= override <= 2"),
        (-1.0, 1.0, "t = -1.0 is outside its limit: t >= last change = 0.0"),
    ],
)
def test_override__outside_its_range__is_refused(time, override, message):
    move = OverriddenMove(3.0, 1.0, LIMITS)
    with pytest.raises(SCurveError, match="S-curve parameter") as caught:
        move.set_override(time, override)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("feed", "ve", "message"), [(0.0, 0.0, "feed > 0"), (1.0, 1.5, "ve <= feed = 1.0")]
)
def test_move__bad_feed_or_end_speed__is_refused(feed, ve, message):
    with pytest.raises(SCurveError, match=message):
        OverriddenMove(3.0, feed, LIMITS, ve=ve)
