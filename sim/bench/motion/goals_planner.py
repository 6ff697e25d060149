# SPDX-License-Identifier: Apache-2.0
"""Goals of the planner of one move, in Python and on the core."""

from __future__ import annotations

import random

import numpy as np

from sim.bench.motion.goal import SEED, Counts, Features, Measured, Rows
from sim.motion.planner import check
from sim.motion.planner.core import PARAMETERS, planner_program
from sim.motion.planner.optimal import Limits, time_optimal
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.motion.planner.scurve import SCurve
from sim.robot.parameters import Robot

FEATURES = Features()

MICRO = 1e6


@FEATURES.feature(
    "S-curve classes",
    "7, fixed tr",
    "7, equal bits to rational numbers",
    "make test T=test_planner_ramp_time",
)
def classes(counts: Counts, rows: Rows) -> Measured:
    """Positions and speeds of all classes against rational integration of the jerk: equal bits."""
    rng, kinds, wrong, done = random.Random(SEED), set(), 0, 0
    for span in ("constant", "short", "cruise"):
        for share in (0.0, None, 1.0):
            for _ in range(counts.classes):
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
    return f"{wrong} of {done} states differ, {len(kinds)} classes", wrong == 0 and len(kinds) == 7


@FEATURES.feature(
    "time-optimal mode",
    "no",
    "duration within 1e-6 of Ruckig",
    "make test-full T=hundred_thousand_moves__take",
)
def ruckig(counts: Counts, rows: Rows) -> Measured:
    """Durations of the time-optimal mode against Ruckig's."""
    worst, failed, done = 0.0, 0, 0
    for kind in ("forward", "signed", "moving"):
        for move in check.random_moves(kind, counts.moves, SEED):
            reference = check.ruckig_trajectory(move)
            if reference is None:
                failed += 1
                continue
            plan = time_optimal(move.length, move.v0, move.ve, move.limits, move.a0, reverse=True)
            worst = max(worst, abs(plan.total_time / reference.duration - 1.0))
            done += 1
    return f"{worst:.1e} on {done} moves (Ruckig failed in {failed})", worst <= 1e-6


@FEATURES.feature(
    "short move, L = 120 mm, tm = 0.15 s",
    "1.2 s",
    "1.2 s; <= 0.63 s optimal",
    "make test T=short_move_of_the_paper",
)
def short_move(counts: Counts, rows: Rows) -> Measured:
    """120 mm between speeds of 100 mm/s, tm = 0.15 s: both modes."""
    paper = SCurve(100, 600, 0.6, 0.15, 120).total_time
    acceleration = 500 / 0.45
    limits = Limits(600, acceleration, acceleration / 0.15)
    ours = time_optimal(120, 100, 100, limits).total_time
    return f"{paper:.4g} s; {ours:.4g} s", round(paper, 9) == 1.2 and ours <= 0.63


@FEATURES.feature(
    "override 0-200 %, stop at any instant",
    "no",
    "within limits",
    "make test T=test_planner_override",
)
def override(counts: Counts, rows: Rows) -> Measured:
    """Moves with random overrides and stops: greatest use of a limit, by Runge-Kutta."""
    worst = 0.0
    for number in range(counts.overrides):
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
    return f"{worst:.9f} of a limit in {counts.overrides} moves", worst <= 1 + 1e-9


@FEATURES.feature(
    "planner in binary32 on the core",
    "double on ARM",
    "<= 1 um over 1 m",
    "make test T=test_planner_programs",
    simulated=True,
)
def core(counts: Counts, rows: Rows) -> Measured:
    """Planner and sampler in binary32 on the core: positions at random ticks, moves up to 1 m."""
    moves = check.random_core_moves(counts.core, SEED)
    planned = planner_program("planner_scurve").batch(moves).values
    rng = np.random.default_rng(SEED)
    names = ("vp", "am", "J", "t1", "t2", "t4", "s1", "s2", "s3")
    curves = [SCurve(*(float(moves[n][k]) for n in PARAMETERS)) for k in range(counts.core)]
    totals = np.array([curve.total_time for curve in curves])
    period = Robot.load().T_s
    ticks = np.rint(totals / period * rng.random(counts.core)).astype(np.int32)
    inputs = {"ticks": ticks, "L": moves["L"], "v0": moves["v0"]}
    inputs |= {name: planned[name] for name in names}
    got = planner_program("planner_sample").batch(inputs).values["p"]
    wanted = [
        curve.profile(int(tick) * period).position
        for curve, tick in zip(curves, ticks, strict=True)
    ]
    worst = float(np.abs(got - np.array(wanted)).max()) * MICRO
    return f"{worst:.2f} um on {counts.core} moves", worst <= 1.0
