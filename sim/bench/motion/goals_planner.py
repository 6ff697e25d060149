# SPDX-License-Identifier: Apache-2.0
"""Goals of the planner of one move, in Python and on the core."""

from __future__ import annotations

import random
from collections.abc import Iterator

import numpy as np

from sim.motion.planner import check
from sim.motion.planner.core import PARAMETERS, planner_program
from sim.motion.planner.optimal import Limits, time_optimal
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.motion.planner.scurve import SCurve
from sim.report.goals import Goal, at_most, depth, exactly
from sim.robot.parameters import Robot

SEED = 1  # of every random choice
MICRO = 1e6
FULL = "make goals T=motion RUN=full"


def rows(full: bool) -> Iterator[Goal]:
    """The planner of one move."""
    yield from classes(1000 if full else 20)
    yield from ruckig(100_000 if full else 400)
    yield from short_move()
    yield override(2000 if full else 60)
    yield core(20_000 if full else 300)


def classes(moves: int) -> Iterator[Goal]:
    """Positions and speeds of all classes against rational integration of the jerk: equal bits.

    moves: of each of nine kinds of lengths and times.
    """
    rng, kinds, wrong, done = random.Random(SEED), set(), 0, 0
    for span in ("constant", "short", "cruise"):
        for share in (0.0, None, 1.0):
            for _ in range(moves):
                vm, tr = rng.uniform(1e-3, 10), rng.uniform(1e-3, 2)
                v0 = vm * rng.uniform(0.01, 0.9)
                tm = tr / 2 * (rng.uniform(0.05, 0.95) if share is None else share)
                low, high, inside = 2 * v0 * tr, (v0 + vm) * tr, rng.uniform(0.05, 0.95)
                length = {
                    "constant": low * inside,
                    "short": low + (high - low) * inside,
                    "cruise": high * (1 + inside),
                }[span]
                plan = ramp_time_plan(v0, vm, tr, tm, length)
                kinds.add(plan.forms.kind.value)
                at = float(plan.total_time) * rng.random()
                wanted = [float(x) for x in check.exact_profile(plan, at)[:2]]
                wrong += [float(x) for x in plan.at(at)[:2]] != wanted
                done += 1
    note = f"published: with a fixed tr; {done} states"
    yield exactly("S-curve: states whose bits differ from rational numbers", wrong, 0, "", note)
    yield exactly("S-curve: classes of moves that occurred", len(kinds), 7, "", "published: 7")


def ruckig(moves: int) -> Iterator[Goal]:
    """So many moves of each of three kinds: durations of the time-optimal mode against Ruckig's."""
    worst, failed, done = 0.0, 0, 0
    for kind in ("forward", "signed", "moving"):
        for move in check.random_moves(kind, moves, SEED):
            reference = check.ruckig_trajectory(move)
            if reference is None:
                failed += 1
                continue
            plan = time_optimal(move.length, move.v0, move.ve, move.limits, move.a0, reverse=True)
            worst = max(worst, abs(plan.total_time / reference.duration - 1.0))
            done += 1
    note = f"Ruckig itself failed in {failed}"
    yield at_most("time-optimal moves: duration off Ruckig's", worst, 1e-6, "", note)
    yield depth("time-optimal moves compared with Ruckig", done, 299_000, "moves", FULL)


def short_move() -> Iterator[Goal]:
    """120 mm between speeds of 100 mm/s, tm = 0.15 s: both modes."""
    paper = SCurve(100, 600, 0.6, 0.15, 120).total_time
    acceleration = 500 / 0.45
    limits = Limits(600, acceleration, acceleration / 0.15)
    ours = time_optimal(120, 100, 100, limits).total_time
    what = "120 mm with tm = 0.15 s"
    yield exactly(f"{what}, as the paper plans", round(paper, 9), 1.2, "s", "published: 1.2 s")
    yield at_most(f"{what}, time-optimal", ours, 0.63, "s")


def override(moves: int) -> Goal:
    """So many moves with random overrides and stops: greatest use of a limit, by Runge-Kutta."""
    worst = 0.0
    for number in range(moves):
        move = check.run_with_changes(f"goal {SEED} {number}")
        steps = check.executed(move)
        _, states = check.integrate(move.at(0.0), steps, points=8)
        limits = move.limits
        worst = max(
            worst,
            float(states[:, 1].max()) / limits.speed,
            float(np.abs(states[:, 2]).max()) / limits.acceleration,
            max(abs(step.jerk) for step in steps) / limits.jerk,
        )
    what = "override of 0 to 200 %, stop at any instant: greatest use of a limit"
    return at_most(what, worst, 1 + 1e-9, "", f"{moves} moves")


def core(count: int) -> Goal:
    """Planner and sampler in binary32 on the core: positions at random ticks, moves up to 1 m."""
    moves = check.random_core_moves(count, SEED)
    planned = planner_program("planner_scurve").batch(moves).values
    rng = np.random.default_rng(SEED)
    names = ("vp", "am", "J", "t1", "t2", "t4", "s1", "s2", "s3")
    curves = [SCurve(*(float(moves[n][k]) for n in PARAMETERS)) for k in range(count)]
    totals = np.array([curve.total_time for curve in curves])
    period = Robot.load().T_s
    ticks = np.rint(totals / period * rng.random(count)).astype(np.int32)
    inputs = {"ticks": ticks, "L": moves["L"], "v0": moves["v0"]}
    inputs |= {name: planned[name] for name in names}
    got = planner_program("planner_sample").batch(inputs).values["p"]
    wanted = [
        curve.profile(int(tick) * period).position
        for curve, tick in zip(curves, ticks, strict=True)
    ]
    worst = float(np.abs(got - np.array(wanted)).max()) * MICRO
    what = "planner in binary32 on the core: position off, moves of up to 1 m"
    return at_most(what, worst, 1.0, "um", f"published: in double on an ARM; {count} moves")
