# SPDX-License-Identifier: Apache-2.0
"""The time-optimal planner against Ruckig, against an integrator, and against hand formulas."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from sim.motion.planner.check import (
    DURATION,
    Move,
    integrate,
    log_uniform,
    random_moves,
    ruckig_trajectory,
    scale,
)
from sim.motion.planner.optimal import Limits, TooShortError, stopping_length, time_optimal
from sim.motion.planner.phases import Profile, State
from sim.motion.planner.scurve import SCurve, SCurveError
from tests.bench.seed import SEED

KINDS = ("forward", "signed", "moving")
# Rounding of sums of some ten phases, relative to the greatest of what is added.
ROUNDING = 1e-12


def plan(move: Move) -> Profile:
    return time_optimal(move.length, move.v0, move.ve, move.limits, move.a0, reverse=True)


def assert_profile_is_sound(move: Move, profile: Profile) -> None:
    """Both ends exact, both halves one profile, all limits held."""
    where = f"{move}"
    vm, am, jm = move.limits.speed, move.limits.acceleration, move.limits.jerk
    assert profile.at(0.0) == State(0.0, move.v0, move.a0), where
    assert profile.at(profile.total_time) == State(move.length, move.ve, 0.0), where
    gap = profile.mismatch
    assert abs(gap.position) <= ROUNDING * (abs(move.length) + vm * profile.total_time), where
    assert abs(gap.speed) <= ROUNDING * (vm + am * profile.total_time), where
    assert abs(gap.acceleration) <= ROUNDING * am, where
    low, high, acceleration, jerk = profile.extremes()
    least = min(-vm, move.v0 - move.a0**2 / (2 * jm))
    assert least * (1 + ROUNDING) <= low and high <= vm * (1 + ROUNDING), where
    assert acceleration <= am * (1 + ROUNDING) and jerk <= jm, where


def compare_with_ruckig(kind: str, count: int, seed: int) -> None:
    """Every move of a kind."""
    failures = 0
    for move in random_moves(kind, count, seed):
        profile = plan(move)
        assert_profile_is_sound(move, profile)
        reference = ruckig_trajectory(move)
        if reference is None:
            failures += 1
            continue
        assert profile.total_time == pytest.approx(reference.duration, rel=DURATION), (
            f"{move}: {profile.total_time!r} s, Ruckig {reference.duration!r} s (kind {kind}, "
            f"seed {seed}; SEED={seed} pytest replays it)"
        )
    print(f"{kind}: {count} moves, seed {seed}, Ruckig failed in {failures}")
    # A reference that fails often would prove nothing.
    assert failures <= count // 1000


@pytest.mark.parametrize("kind", KINDS)
def test_optimal__random_moves__take_the_time_of_ruckig(kind):
    compare_with_ruckig(kind, 2000, SEED)


@pytest.mark.full
@pytest.mark.parametrize("kind", KINDS)
def test_optimal__hundred_thousand_moves__take_the_time_of_ruckig(kind):
    compare_with_ruckig(kind, 100_000, SEED + 1)


@pytest.mark.parametrize("kind", KINDS)
def test_optimal__samples__are_those_of_ruckig_and_of_the_integrator(kind):
    for move in random_moves(kind, 150, SEED + 2):
        profile = plan(move)
        vm, am = move.limits.speed, move.limits.acceleration
        times, states = integrate(profile.start, profile.steps)
        got = np.array([profile.at(float(t)) for t in times])
        # A joint of two phases is wrong by the rounding of the time.
        late = 4 * np.spacing(profile.total_time)
        bound = ROUNDING * np.array(
            [abs(move.length) + vm * profile.total_time, vm + am * profile.total_time, am]
        ) + [0.0, 0.0, move.limits.jerk * late]
        assert np.all(np.abs(got - states) <= bound), f"{move}"
        reference = ruckig_trajectory(move)
        if reference is None:
            continue
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            position, speed, _ = (x[0] for x in reference.at_time(share * reference.duration))
            state = profile.at(share * profile.total_time)
            # Durations agree to 1e-6, and the speed changes by am times that.
            late = DURATION * profile.total_time
            assert abs(state.position - position) <= vm * late + 1e-9 * abs(move.length), f"{move}"
            assert abs(state.speed - speed) <= am * late + 1e-9 * vm, f"{move}"


def test_ruckig__limits_exactly_reached__fails_or_is_slower():
    """Negative control of the relaxed limits: exactly am and J of four-segment moves."""
    rng = random.Random(SEED)
    wrong = {0.0: 0, 1e-9: 0}
    for _ in range(400):
        vm, tr = log_uniform(rng, 0.01, 10), log_uniform(rng, 0.01, 2)
        v0 = vm * rng.random()
        curve = SCurve(v0, vm, tr, tr / 2, (v0 + vm) * tr * rng.uniform(0.55, 0.99))
        if curve.kind.value != 4:
            continue
        limits = Limits(vm, curve.peak_acceleration, curve.jerk)
        move = Move(curve.length, v0, v0, limits)
        for relaxed in wrong:
            reference = ruckig_trajectory(move, relaxed)
            slower = reference is None or reference.duration > curve.total_time * (1 + DURATION)
            wrong[relaxed] += slower
    assert wrong[1e-9] == 0 < wrong[0.0]


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_ramp_time_mode__every_class_with_jerk__is_optimal_for_its_own_limits(share):
    """Formulas (6) and (10): with their own am, J and peak speed Ruckig is no faster."""
    rng = random.Random(SEED)
    kinds = set()
    for _ in range(400):
        vm, tr = log_uniform(rng, 0.01, 10), log_uniform(rng, 0.01, 2)
        v0 = vm * rng.choice([0.0, rng.uniform(0, 0.9)])
        low, high = 2 * v0 * tr, (v0 + vm) * tr
        length = rng.choice([low + (high - low) * rng.uniform(0.05, 1), high * rng.uniform(1, 4)])
        curve = SCurve(v0, vm, tr, tr / 2 * share, length)
        kinds.add(curve.kind.value)
        limits = Limits(curve.peak_speed, curve.peak_acceleration, curve.jerk)
        move = Move(length, v0, v0, limits)
        reference = ruckig_trajectory(move)
        assert reference is not None
        assert curve.total_time == pytest.approx(reference.duration, rel=DURATION), f"{move}"
        assert plan(move).total_time == pytest.approx(curve.total_time, rel=1e-9), f"{move}"
        for time in np.linspace(0.05, 0.95, 5) * curve.total_time:
            position, speed, _ = (x[0] for x in reference.at_time(time))
            samples = curve.profile(time)
            assert samples.position == pytest.approx(position, abs=DURATION * length)
            assert samples.velocity == pytest.approx(speed, abs=DURATION * curve.peak_speed)
    assert kinds == ({6, 7} if share < 1 else {4, 5})


def test_optimal__short_move_of_the_paper__is_almost_twice_as_fast():
    curve = SCurve(100, 600, 0.6, 0.15, 120)
    am = 500 / 0.45
    profile = time_optimal(120, 100, 100, Limits(600, am, am / 0.15))
    assert curve.total_time == pytest.approx(1.2)
    assert profile.total_time <= 0.63


@pytest.mark.parametrize(
    ("length", "expected"),
    [
        # Rest to rest, J = 1, am = 1, vm = 3: 2 am^3/J^2 = 2 is the way with a pulse of am,
        # vm (vm/am + am/J) = 12 the way with vm.
        (0.002, 2 * math.cbrt(4 * 0.002)),
        (2.0, 4.0),
        (6.0, 1 + math.sqrt(1 + 4 * 6.0)),
        (12.0, 8.0),
        (15.0, 9.0),
    ],
)
def test_optimal__rest_to_rest__takes_the_time_of_the_textbook(length, expected):
    assert time_optimal(length, 0, 0, Limits(3, 1, 1)).total_time == pytest.approx(
        expected, rel=1e-14
    )


def test_optimal__same_move_from_start_on__takes_the_rest_of_the_time():
    """A plan made again at any instant from the state then must not find anything else."""
    checked = 0
    for move in random_moves("forward", 400, SEED + 3):
        profile = plan(move)
        rng = random.Random(repr(move))
        time = rng.random() * profile.total_time
        p, v, a = profile.at(time)
        slack = move.length - p - stopping_length(v, a, move.ve, move.limits)
        if slack < 1e-9 * move.length:  # rounding decides whether the way left suffices
            continue
        checked += 1
        rest = time_optimal(move.length - p, v, move.ve, move.limits, a, reverse=True)
        assert rest.total_time == pytest.approx(profile.total_time - time, rel=1e-5), f"{move}"
    assert checked > 100


def test_optimal__three_ways_to_turn_the_jerk__takes_the_soonest():
    """Speeds of both signs: the way rises, falls and rises again with the turning acceleration."""
    limits = Limits(0.6248599121601778, 1.2028413839676761, 5.120702559793734)
    move = Move(
        0.21353030259469194, -0.11321766545491185, 0.6057100762488831, limits, 1.0259459074216228
    )
    reference = ruckig_trajectory(move)
    assert reference is not None
    assert plan(move).total_time == pytest.approx(reference.duration, rel=DURATION)
    assert plan(move).total_time < 0.76


def test_optimal__degenerate_moves__are_planned():
    limits = Limits(1.0, 2.0, 5.0)
    assert time_optimal(0.0, 0.0, 0.0, limits).total_time == 0.0
    assert time_optimal(3.0, 1.0, 1.0, limits).total_time == 3.0
    direct = stopping_length(0.2, 0.0, 0.9, limits)
    assert len(time_optimal(direct, 0.2, 0.9, limits).steps) == 2  # the limit is just not reached
    for scale_ in (1e-12, 1e-3, 1e6):
        profile = time_optimal(scale_, 0.0, 0.0, limits)
        assert abs(profile.mismatch.position) <= ROUNDING * scale_
    for nudge in (-1e-15, -1e-16, 0.0, 1e-16, 1e-15):
        profile = time_optimal(direct * (1 + nudge), 0.2, 0.9, limits)
        assert profile.at(profile.total_time).position == direct * (1 + nudge)
        assert profile.total_time == pytest.approx(2 * math.sqrt(0.7 / 5.0), rel=1e-6)


def test_optimal__speed_above_its_limit__comes_down_at_once():
    limits = Limits(1.0, 2.0, 5.0)
    for v0, a0, length in (
        (1.5, 0.0, 9.0),
        (1.5, 2.0, 9.0),
        (0.9, 2.0, 9.0),
        (1.5, -1.0, 1.0),
        (0.9, 2.0, 1.16),
    ):
        profile = time_optimal(length, v0, 0.0, limits, a0)
        brake = time_optimal(99.0, v0, 1.0, limits, a0)
        for t in np.linspace(0, profile.total_time, 200):
            allowed = max(1.0, brake.at(float(t)).speed)
            assert profile.at(float(t)).speed <= allowed * (1 + ROUNDING)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1.0, 0.0, 0.0), "length = -1.0 is outside its limit: length >= 0"),
        ((math.nan, 0.0, 0.0), "length = nan is outside its limit: finite"),
        ((1.0, -0.5, 0.0), "v0 = -0.5 is outside its limit: v0 >= 0"),
        ((1.0, 0.0, -0.5), "ve = -0.5 is outside its limit: ve >= 0"),
        ((1.0, 0.0, 1.5), "ve = 1.5 is outside its limit: |ve| <= limit of speed 1.0"),
        ((1.0, 0.0, 0.0, 3.0), "a0 = 3.0 is outside its limit: |a0| <= limit of acceleration 2.0"),
    ],
)
def test_optimal__bad_parameter__is_named_with_its_limit(arguments, message):
    length, v0, ve, *rest = arguments
    with pytest.raises(SCurveError) as caught:
        time_optimal(length, v0, ve, Limits(1.0, 2.0, 5.0), *rest)
    assert str(caught.value) == f"S-curve parameter {message}"


@pytest.mark.parametrize("name", ["speed", "acceleration", "jerk"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_limits__not_positive_and_finite__are_refused(name, value):
    with pytest.raises(SCurveError, match=f"limit of {name} = "):
        Limits(**({"speed": 1.0, "acceleration": 1.0, "jerk": 1.0} | {name: value}))


def test_optimal__way_too_short__is_refused_with_the_way_needed():
    limits = Limits(1.0, 2.0, 5.0)
    with pytest.raises(TooShortError) as caught:
        time_optimal(0.1, 1.0, 0.0, limits)
    assert "length = 0.1 is too short to go from speed v0 = 1.0" in str(caught.value)
    needed = caught.value.needed
    assert time_optimal(needed, 1.0, 0.0, limits).total_time > 0.0
    assert time_optimal(0.1, 1.0, 0.0, limits, reverse=True).total_time > 0.0
    assert scale(limits) > needed
