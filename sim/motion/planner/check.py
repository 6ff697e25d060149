# SPDX-License-Identifier: Apache-2.0
"""Random moves for the planners, and what checks them: Ruckig, and the Runge-Kutta method."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from ruckig import InputParameter, Result, Ruckig, Trajectory

from sim.motion.planner.core import PARAMETERS
from sim.motion.planner.optimal import Limits, stopping_length
from sim.motion.planner.override import OverriddenMove
from sim.motion.planner.phases import State, Step
from sim.motion.planner.ramp_time import RampTimePlan
from sim.motion.planner.scurve import SCurve

RELAXED = 1e-9  # of Ruckig's limits of speed and acceleration: it fails at states on the limit
DURATION = 1e-6  # relative agreement of durations


@dataclass(frozen=True)
class Move:
    """One move; repr() of it is a call of `time_optimal` with these arguments."""

    length: float
    v0: float
    ve: float
    limits: Limits
    a0: float = 0.0


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    """Random number with an even distribution of its logarithm."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def random_limits(rng: random.Random) -> Limits:
    """Limits from slow and smooth to fast and hard [m, s]."""
    return Limits(
        log_uniform(rng, 0.01, 10), log_uniform(rng, 0.1, 100), log_uniform(rng, 1, 10_000)
    )


def scale(limits: Limits) -> float:
    """Length on which the greatest speed is reached from rest."""
    pulse = limits.speed / limits.acceleration + limits.acceleration / limits.jerk
    return limits.speed * pulse


def random_moves(kind: str, count: int, seed: int) -> Iterator[Move]:
    """Moves of a kind: 'forward' (speeds >= 0), 'signed' (any speeds), 'moving' (with a0).

    Lengths from 1e-4 of the distance to the greatest speed to thirty times it, more than
    what the direct change of speed needs; signed ones also less, and close to 0.
    """
    rng = random.Random(f"{kind} {seed}")
    made = 0
    while made < count:
        limits = random_limits(rng)
        vm, am = limits.speed, limits.acceleration
        a0 = 0.0
        if kind == "forward":
            v0, ve = (vm * rng.choice([0.0, 1.0, rng.random(), rng.random()]) for _ in range(2))
            if rng.random() < 0.2:
                ve = v0
        else:
            v0, ve = rng.uniform(-vm, vm), rng.uniform(-vm, vm)
        if kind == "moving":
            a0 = rng.choice([-am, am, rng.uniform(-am, am), rng.uniform(-am, am)])
            if abs(v0 + a0 * abs(a0) / (2 * limits.jerk)) > vm:
                continue
        extra = log_uniform(rng, 1e-4, 30) * scale(limits)
        if kind != "forward":
            extra = rng.choice([-extra, extra])
        length = extra
        if rng.random() < 0.8 or kind == "forward":
            length += stopping_length(v0, a0, ve, limits)
        made += 1
        yield Move(length, v0, ve, limits, a0)


def ruckig_trajectory(move: Move, relaxed: float = RELAXED) -> Trajectory | None:
    """Ruckig's trajectory of the move, None where it reports a failure."""
    inputs = InputParameter(1)
    inputs.current_position, inputs.target_position = [0.0], [move.length]
    inputs.current_velocity, inputs.target_velocity = [move.v0], [move.ve]
    inputs.current_acceleration, inputs.target_acceleration = [move.a0], [0.0]
    inputs.max_velocity = [move.limits.speed * (1 + relaxed)]
    inputs.max_acceleration = [move.limits.acceleration * (1 + relaxed)]
    inputs.max_jerk = [move.limits.jerk]
    trajectory = Trajectory(1)
    try:
        result = Ruckig(1).calculate(inputs, trajectory)
    except Exception:  # the binding's own exception types are not exported
        return None
    return trajectory if result == Result.Working else None


def integrate(
    start: State[float], steps: Sequence[Step], points: int = 16
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (n,) and states (n, 3) of the jerk schedule by the classical Runge-Kutta method."""
    y = np.array(start, dtype=np.float64)
    time, times, states = 0.0, [0.0], [y]
    for duration, jerk in steps:
        h = duration / points

        def slope(y, jerk=jerk):
            return np.array([y[1], y[2], jerk])

        for k in range(points):
            k1 = slope(y)
            k2 = slope(y + h / 2 * k1)
            k3 = slope(y + h / 2 * k2)
            k4 = slope(y + h * k3)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            times.append(time + duration * (k + 1) / points)
            states.append(y)
        time += duration
    return np.array(times), np.array(states)


def random_overridden(rng: random.Random) -> OverriddenMove:
    """A move without a change yet, with random limits, feed, end speeds and length."""
    limits = random_limits(rng)
    feed = limits.speed * rng.uniform(0.1, 1.2)
    top = min(feed, limits.speed)
    v0, ve = (top * rng.choice([0.0, rng.random()]) for _ in range(2))
    length = stopping_length(v0, 0.0, ve, limits) + log_uniform(rng, 1e-3, 30) * scale(limits)
    return OverriddenMove(length, feed, limits, v0, ve)


def run_with_changes(seed: str) -> OverriddenMove:
    """A random move with up to seven changes at random instants, run to its end.

    Raises RuntimeError if the state jumps at a change or the move never ends.
    """
    rng = random.Random(seed)
    move = random_overridden(rng)
    for _ in range(rng.randrange(1, 8)):
        left = move.end_time - move.changes[-1]
        time = move.changes[-1] + left * rng.random() * rng.choice([0.1, 1.0, 1.1])
        before = move.at(time)
        move.set_override(time, rng.choice([0.0, rng.uniform(0, 2), rng.uniform(0, 2)]))
        if time < move.end_time and move.at(time) != before:
            raise RuntimeError(f"the change at {time!r} jumps (seed {seed!r})")
    if not move.finished_at_length:
        move.set_override(move.end_time + 0.1, 1.0)
    if not move.finished_at_length:
        raise RuntimeError(f"the move does not end (seed {seed!r})")
    return move


def executed(move: OverriddenMove) -> list[Step]:
    """Jerk over time as run, changes included, without a state in it."""
    steps: list[Step] = []
    for index, profile in enumerate(move.profiles):
        last = index + 1 == len(move.profiles)
        left = profile.total_time if last else move.changes[index + 1] - move.changes[index]
        for duration, jerk in profile.steps:
            part = min(duration, left)
            steps.append(Step(part, jerk))
            left -= part
        if not last and left > 0.0:  # at rest after a stop
            steps.append(Step(left, 0.0))
    return steps


def random_core_moves(count: int, seed: int) -> dict[str, np.ndarray]:
    """Moves of up to 1 m in all seven classes as binary32, one array per parameter."""
    rng = np.random.default_rng(seed)

    def log_uniform(low: float, high: float) -> np.ndarray:
        return np.exp(rng.uniform(math.log(low), math.log(high), count)).astype(np.float32)

    vm, tr = log_uniform(0.005, 5), log_uniform(0.005, 1)
    share = np.select([rng.random(count) < 0.3], [0.0], rng.random(count)).astype(np.float32)
    v0 = vm * share
    kind = rng.integers(3, size=count)
    jerk_share = np.select([kind == 0, kind == 1], [0.0, 1.0], rng.random(count))
    tm = np.float32(0.5) * tr * jerk_share.astype(np.float32)
    span = rng.choice([0.2, 0.9, 1.0, 1.6], count) * log_uniform(0.3, 3)
    length = np.minimum(1.0, (v0 + vm) * tr * span).astype(np.float32)
    return dict(zip(PARAMETERS, (v0, vm, tr, tm, length), strict=True))


def exact_profile(curve: SCurve | RampTimePlan, time: float) -> tuple[Fraction, Fraction, Fraction]:
    """Position, speed, acceleration by rational integration of the jerk phase by phase.

    Only the set parameters are used; speeds and positions are never closed forms.
    """
    v0, vm, tr, tm, length = (
        Fraction(x) for x in (curve.v0, curve.vm, curve.tr, curve.tm, curve.length)
    )
    if length <= 2 * v0 * tr:
        return v0 * Fraction(time), v0, Fraction(0)
    peak = min(vm, length / tr - v0)
    cruise = (length - (v0 + peak) * tr) / peak
    am = (peak - v0) / (tr - tm)
    signs = (1, 0, -1, 0, -1, 0, 1)
    times = (tm, tr - 2 * tm, tm, cruise, tm, tr - 2 * tm, tm)
    zero = Fraction(0)
    starts = (zero, am, am, zero, zero, -am, -am)
    position, speed, acceleration, left = Fraction(0), v0, Fraction(0), Fraction(time)
    for sign, duration, start in zip(signs, times, starts, strict=True):
        step = min(left, duration)
        jerk = sign * am / tm if tm else Fraction(0)
        position += step * (speed + step * (start / 2 + step * jerk / 6))
        speed += step * (start + jerk * step / 2)
        acceleration = start + jerk * step
        left -= step
        if left <= 0:
            break
    return position, speed, acceleration
