# SPDX-License-Identifier: Apache-2.0
"""What the front-end is to do, feature by feature, beside what it does: measured by `make motion`.

    python -m sim.motion.goals              writes the table of the last run into docs/motion.md
    python -m sim.motion.goals --measure    measures the goals again first, with its figures

Every value comes from a run: of the module named, of the RTL, or of the figures of `make motion`.
A feature that takes too long for that has no value here; its command measures it.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import random
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

from sim.gcode.oracle import OracleError, compare_samples
from sim.harness.interpolator_rtl import InterpolatorRtl
from sim.harness.motion_rtl import CLOCK_HZ, RECORDS, MotionRtl
from sim.harness.phase_record import (
    DIRECTION,
    FIRST,
    LAST,
    UNITS_PER_HZ,
    Record,
)
from sim.lookahead import figures as lookahead_figures
from sim.lookahead import stress
from sim.lookahead.limits import MachineLimits
from sim.lookahead.planner import Lookahead
from sim.lookahead.settings import DEPTH, LookaheadSettings
from sim.model.parameters import Robot
from sim.motion.sizes import LIMITS as SIZE_LIMITS
from sim.motion.sizes import current as measured_sizes
from sim.motion.sizes import within
from sim.path.moves import Motion, Move
from sim.planner import check
from sim.planner.core import PARAMETERS, planner_program
from sim.planner.optimal import Limits, time_optimal
from sim.planner.pulse_records import (
    time_exact,
)
from sim.planner.ramp_time import ramp_time_plan
from sim.planner.scurve import SCurve

ROOT = Path(__file__).resolve().parents[2]
RESULTS, PAGE = ROOT / "build/motion/results.json", ROOT / "docs/motion.md"
BEGIN, END = "<!-- goals: written by python -m sim.motion.goals -->", "<!-- goals: end -->"
MICRO = 1e6
SEED = 1  # of every random choice here
FASTEST_TIMING = 1 | 1 << 16
LIMIT = 40_000_000  # clocks, above every move here


@dataclass(frozen=True)
class Goal:
    """A feature. ours: as measured, "" where it is not; met: None where it is not measured.

    command: what measures it, or goes deeper.
    """

    feature: str
    published: str
    goal: str
    ours: str
    met: bool | None
    command: str


Measured = tuple[str, bool]
Rows = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Counts:
    """How much is run: moves against Ruckig, random programs, odd blocks, lines, circles, lines of
    all axes, drive timings."""

    moves: int = 400
    classes: int = 20
    core: int = 300
    overrides: int = 60
    programs: int = 60
    odd: int = 1
    reach: int = 12
    radius: int = 60
    axes_lines: int = 20
    timings: int = 10


FULL = Counts(100_000, 1000, 20_000, 2000, 10_000, 1000, 64, 200, 300, 300)


# ---------------------------------------------------------------------- planner


def classes(counts: Counts) -> Measured:
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


def ruckig(counts: Counts) -> Measured:
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


def short_move(counts: Counts) -> Measured:
    """120 mm between speeds of 100 mm/s, tm = 0.15 s: both modes."""
    paper = SCurve(100, 600, 0.6, 0.15, 120).total_time
    acceleration = 500 / 0.45
    limits = Limits(600, acceleration, acceleration / 0.15)
    ours = time_optimal(120, 100, 100, limits).total_time
    return f"{paper:.4g} s; {ours:.4g} s", round(paper, 9) == 1.2 and ours <= 0.63


def override(counts: Counts) -> Measured:
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


def core(counts: Counts) -> Measured:
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


# ---------------------------------------------------------------------- hardware


def _front_end() -> MotionRtl:
    motion = MotionRtl()
    motion.write("STEP_TIMING", FASTEST_TIMING)
    motion.write("DIRECTION_TIMING", FASTEST_TIMING)
    return motion


def rest_to_rest(counts: Counts) -> Measured:
    """A move from rest to rest on the RTL: pulses and ticks off."""
    plan = ramp_time_plan("0", "200", "0.02", "0.005", "3")
    motion = _front_end()
    motion.write("IRQ_ENABLE", 3)
    begin = motion.now
    motion.run({0: time_exact(plan.phases, 1000)}, LIMIT)
    ticks = (motion.now - begin) / (CLOCK_HZ / 1e6) - float(plan.total_time) * 1e6
    off = motion.position(0) - int(plan.length * 1000)
    # Up to three ticks from the release to the first one, and from the last one to the interrupt.
    return f"{off} pulses, {ticks:.2f} us from release to interrupt", off == 0 and 0 < ticks < 3


def fastest(counts: Counts) -> Measured:
    """50 MHz: a pulse every other clock, none lost."""
    motion = _front_end()
    rate = 50_000_000
    motion.run({0: [Record(FIRST | LAST, 200, rate * UNITS_PER_HZ << 32, 0, 0)]}, LIMIT)
    at = motion.edges().pulses(0)
    clocks = sorted(set(np.diff(at).tolist()))
    apart = " or ".join(map(str, clocks))
    return f"{len(at)} pulses of 10000, {apart} clocks apart", len(at) == 10_000 and clocks == [2]


def jitter(counts: Counts) -> Measured:
    """Edges at odd rates against the ideal instants: spread on the grid of 10 ns."""
    worst = 0.0
    for rate in (16 * 123_456 + 7, 16 * 40_000 + 1, 16 * 3_333_333 + 5):
        motion = _front_end()
        ticks = min(20_000, 16 * 2_000 * 1_000_000 // rate)
        motion.run({0: [Record(FIRST | LAST, ticks, rate << 32, 0, 0)]}, LIMIT)
        at = motion.edges().pulses(0)
        ideal = (np.arange(len(at)) + 0.5) * (16 * CLOCK_HZ / rate)
        off = at - ideal
        worst = max(worst, float(np.ptp(off)) * 1e9 / CLOCK_HZ)
    return f"{worst:.2f} ns peak to peak", worst <= 10.0


def slow_pulses(counts: Counts) -> Measured:
    """Pulses of a move of up to 40 kHz on the RTL against the plan [pulses], and their number."""
    plan = ramp_time_plan("0", "200", "0.02", "0.005", "8")
    motion = _front_end()
    motion.run({0: time_exact(plan.phases, 200)}, LIMIT)
    at = motion.edges().pulses(0)
    us = CLOCK_HZ // 1_000_000
    # The first tick begins on a whole microsecond; pulse n stands for the place n - 1/2.
    offs = []
    for tick in range(int(at[0]) // us - 2000, int(at[0]) // us):
        first = plan.sample([(at[0] - tick * us) / CLOCK_HZ]).position[0] * 200 - 0.5
        offs.append((abs(float(first)), tick))
    begin = min(offs)[1] * us
    ideal = plan.sample((at - begin) / CLOCK_HZ).position * 200
    worst = float(np.abs(ideal - (np.arange(len(at)) + 0.5)).max())
    lost = int(plan.length * 200) - len(at)
    return f"{lost} lost, {worst:.3f} pulses off", lost == 0 and worst <= 0.04


def lines(counts: Counts) -> Measured:
    """Every line to ends within reach: nodes against the ideal, per axis and across."""
    rtl, reach = InterpolatorRtl(), counts.reach
    axis, across = {False: 0.0, True: 0.0}, {False: 0.0, True: 0.0}
    for u in range(-reach, reach + 1):
        for v in range(-reach, reach + 1):
            for combined in axis:
                steps = rtl.line(u, v, combined)
                if not len(steps):
                    continue
                at = np.cumsum(steps[:, :2], axis=0)
                ideal = np.arange(1, len(at) + 1)[:, None] * np.array([u, v]) / len(at)
                off = np.abs(at[:, 0] * v - at[:, 1] * u).max() / math.hypot(u, v)
                axis[combined] = max(axis[combined], float(np.abs(at - ideal).max()))
                across[combined] = max(across[combined], float(off))
    met = max(axis.values()) <= 0.5 and across[False] <= math.sqrt(0.5) and across[True] <= 0.5
    return (
        f"per axis {max(axis.values()):.4f}, across {across[False]:.4f} / {across[True]:.4f}",
        met,
    )


def circles(counts: Counts) -> Measured:
    """Full circles of every radius, both ways: nodes against the circle; closed on the start."""
    rtl, worst, closed = InterpolatorRtl(), {False: 0.0, True: 0.0}, True
    for radius in range(1, counts.radius + 1):
        for clockwise in (False, True):
            for combined in worst:
                steps = rtl.arc((radius, 0), (radius, 0), radius**2, clockwise, combined)
                at = np.cumsum(steps[:, :2], axis=0) + (radius, 0)
                closed &= tuple(at[-1]) == (radius, 0)
                off = float(np.abs(np.hypot(*at.T) - radius).max())
                worst[combined] = max(worst[combined], off)
    met = closed and worst[False] <= math.sqrt(0.5) and worst[True] < 0.5
    ends = "all close" if closed else "NOT CLOSED"
    return f"radial {worst[False]:.4f} / {worst[True]:.4f}, {ends}", met


def line_in_axes(counts: Counts) -> Measured:
    """Random lines of all axes of the front-end: nodes against the ideal, axis by axis [steps]."""
    random, apart, worst, ended = np.random.default_rng(SEED), 40, 0.0, True
    motion = _front_end()
    motion.write("IRQ_ENABLE", 3)
    motion.write("SOURCE", (1 << motion.AXES) - 1)
    motion.write("PATH_FEED", apart)
    for _ in range(counts.axes_lines):
        lengths = random.integers(-300, 301, motion.AXES)
        motion.line_in_all_axes(lengths.tolist())
        motion.wait_for_irq(LIMIT)
        nodes = np.cumsum(motion.edges().steps(motion.AXES, apart // 2)[1], axis=0)
        ended &= nodes[-1].tolist() == lengths.tolist()
        ideal = np.arange(1, len(nodes) + 1)[:, None] * lengths / np.abs(lengths).max()
        worst = max(worst, float(np.abs(nodes - ideal).max()))
    ends = "all end there" if ended else "WRONG END"
    return f"{worst:.4f} on {counts.axes_lines} lines, {ends}", ended and worst <= 0.5


def drive_times(counts: Counts) -> Measured:
    """Moves there and back without rest at random drive timing: settings with a time not kept."""
    random, wrong = np.random.default_rng(SEED), 0
    for _ in range(counts.timings):
        length, space, setup, hold = random.integers(1, 120, 4).tolist()
        motion = MotionRtl()
        motion.write("STEP_TIMING", length | space << 16)
        motion.write("DIRECTION_TIMING", setup | hold << 16)
        rate = int(16 * CLOCK_HZ / (length + space) * 0.9)
        ticks = random.integers(8, 40, RECORDS).tolist()
        flags = FIRST | LAST
        motion.run(
            {
                0: [
                    Record(flags | k % 2 * DIRECTION, t, rate << 32, 0, 0)
                    for k, t in enumerate(ticks)
                ]
            },
            LIMIT,
        )
        times = motion.edges().drive_times(0)
        turned = len(times.setup) == len(times.hold) == RECORDS - 1
        wrong += not (turned and times.kept(length, space, setup, hold))
    return f"{wrong} of {counts.timings} settings not kept", wrong == 0


def sizes(counts: Counts) -> Measured:
    """Sizes that `make motion-size` found for the present RTL. Raises KeyError without them."""
    found = measured_sizes()
    parts = [f"{found[name]['ecp5']['luts']}" for name in SIZE_LIMITS]
    plain, paths = found["motion_front_end"], found["motion_front_end, interpolators"]
    met = all(within(name, design) for name, design in found.items())
    return (
        f"{'; '.join(parts)} LUT, {plain['mhz_median']:.0f} MHz; "
        f"with lines and arcs {paths['ecp5']['luts']}, {paths['mhz_median']:.0f} MHz",
        met,
    )


# ---------------------------------------------------------------------- look-ahead


def corner_speed(counts: Counts) -> Measured:
    """90 degrees, P = 0.1 mm, 4.8 m/s2: speed of the set-point next to the corner."""
    base = LookaheadSettings()
    found = []
    for jerk_limited in (True, False):
        limits = MachineLimits.of(base.robot, jerk_limited)
        moves = lookahead_figures.without_approach(lookahead_figures.corner_program("G64 P0.1"))
        blocks = list(Lookahead(moves, replace(base, limits=limits)).setpoints())
        tool = np.concatenate([block.position[:, :3] for block in blocks])
        speed = np.concatenate([block.velocity[:, :3] for block in blocks])
        corner = np.array(moves[0].end[:3]) / 1e3
        near = np.linalg.norm(tool - corner, axis=1).argmin()
        found.append(float(np.linalg.norm(speed[near])) * 1e3)
    return f"{found[1]:.1f} mm/s; {found[0]:.1f} with limited jerk", min(found) >= 31.6


def corners(counts: Counts) -> Measured:
    """90 degrees for P of 1 to 100 um: apex of the set-points by P."""
    worst = 0.0
    for tolerance in (0.001, 0.005, 0.010, 0.025, 0.1):
        program = lookahead_figures.corner_program(f"G64 P{tolerance}")
        moves = lookahead_figures.without_approach(program)
        points = lookahead_figures.run(moves, LookaheadSettings())[0]
        near = np.linalg.norm(points - np.array(moves[0].end[:3]), axis=1).min()
        worst = max(worst, float(near) / tolerance)
    return f"{worst:.4f} P at most", worst <= 1.0


def derivatives(counts: Counts) -> Measured:
    """Velocities and accelerations of set-points against differences of their positions.

    By Taylor a central difference misses a velocity by J T^2 / 6 at most, a second difference an
    acceleration by J T / 3; here as parts of these, J the limit of the jerk.
    """
    settings, worst = LookaheadSettings(), 0.0
    period, limits = settings.period, settings.limits
    jerk = np.array([limits.tool.jerk] * 3 + [limits.table.jerk] * 2)
    for seed in range(10):
        blocks = list(Lookahead(iter(stress.random_moves(seed, 20)), settings).setpoints())
        q, v, a = (
            np.concatenate([getattr(block, name) for block in blocks])
            for name in ("position", "velocity", "acceleration")
        )
        first = np.abs((q[2:] - q[:-2]) / (2 * period) - v[1:-1]) / (jerk * period**2 / 6)
        second = np.abs(np.diff(q, 2, axis=0) / period**2 - a[1:-1]) / (jerk * period / 3)
        worst = max(worst, float(first.max()), float(second.max()))
    return f"every {period * 1e6:.0f} us; {worst:.3f} of Taylor's bound", worst <= 1.0


class _Campaign:
    """The random programs, run once for the rows that need them."""

    def __init__(self) -> None:
        self.done: dict[int, stress.Stress] = {}

    def result(self, count: int) -> stress.Stress:
        if count not in self.done:
            found = stress.Stress()
            for outcome in stress.programs(stress.FIRST, count):
                found.add(outcome)
            self.done[count] = found
        return self.done[count]


_campaign = _Campaign()


def violations(counts: Counts) -> Measured:
    """Random programs: set-points above a limit, and the worst ratio to one."""
    found = _campaign.result(counts.programs)
    over = sum(outcome.worst > stress.VIOLATION for outcome in found.broken)
    return (
        f"{over} of {found.programs} programs, {found.ticks} set-points; worst {found.worst:.4f}",
        over == 0,
    )


def random_p(counts: Counts) -> Measured:
    """The same programs: distance of path and corners beyond P."""
    found = _campaign.result(counts.programs)
    worst = max(found.path, found.corner)
    return f"{worst * 1e9:.3f} nm beyond P", worst <= stress.ROUNDING


def odd(counts: Counts) -> Measured:
    """Paths of tiny, empty, repeated and reversed moves, tiny P: stalls."""
    settings = LookaheadSettings()
    for block in range(counts.odd):
        stress.odd_block(block, settings)
    return f"0 stalls in {counts.odd * stress.BLOCK} paths", True


def spiral(count: int | None) -> Iterator[Move]:
    """Segments of some 0.3 mm, with a turn of the table; None: without end."""
    place = (30.0, 0.0, 600.0, 0.0, 0.0)
    for k in itertools.count(1) if count is None else range(1, count + 1):
        radius = 30 + 10 * math.sin(k * 0.003)
        end = (radius * math.cos(k * 0.01), radius * math.sin(k * 0.01), 600.0, 0.0, k * 0.01)
        yield Move(k, "", Motion.LINEAR, place, end, 15000.0, tolerance=0.01)
        place = end


def throughput(counts: Counts) -> Measured:
    """Segments planned per second of processor time, and cells planned per cell read."""
    count = 4000
    run = Lookahead(spiral(count), LookaheadSettings())
    begin = time.process_time()
    run.duration()
    rate = count / (time.process_time() - begin)
    work = run.planned / run.summary.cells
    return (
        f"{DEPTH} segments; {rate:.0f} segments/s; {work:.2f} plans per cell",
        DEPTH >= 256 and rate >= 2000 and work <= 4,
    )


# ---------------------------------------------------------------------- the table


def _row(rows: Rows, *names: str) -> Measured:
    """Values of figures that `make motion` has measured already. Raises KeyError."""
    found = [rows[name] for name in names]
    text = "; ".join(f"{row['ours']:.4g}{' ' if row['unit'] else ''}{row['unit']}" for row in found)
    return text, all(row["agrees"] for row in found)


def table(
    rows: Sequence[Mapping[str, Any]],
    counts: Counts,
    report: Callable[[str], None],
    hardware: bool = True,
) -> list[Goal]:
    """Measures every feature; rows: the figures of `make motion` so far; report gets its name.

    hardware: also what runs on simulated RTL.
    """
    simulated = (
        *(core, rest_to_rest, fastest, jitter, slow_pulses, drive_times),
        *(lines, circles, line_in_axes),
    )
    named = {str(row["name"]): row for row in rows}
    found = []
    for feature, published, goal, measure, command in _features(named):
        ours, met = "", None
        if measure is not None and (hardware or measure not in simulated):
            report(feature)
            try:
                ours, met = measure(counts)
            except (KeyError, OracleError) as error:  # left out of this run, or not installed
                ours = f"not run: {error}" if isinstance(error, OracleError) else ""
        found.append(Goal(feature, published, goal, ours, met, command))
    return found


def _features(
    named: Rows,
) -> list[tuple[str, str, str, Callable[[Counts], Measured] | None, str]]:
    """Feature, the paper's value, our goal, how it is measured, a command that does, or more."""

    def figures(*names: str) -> Callable[[Counts], Measured]:
        return lambda counts: _row(named, *names)

    def robot(case: str) -> Callable[[Counts], Measured]:
        name = next((n for n in named if n.startswith(f"{case}: tool error")), case)
        return figures(name)

    def times(counts: Counts) -> Measured:
        steps, smooth, stops = (
            float(named[name]["ours"])
            for name in (
                "with blending, trapezoid",
                "with blending, jerk-limited",
                "without blending, trapezoid",
            )
        )
        met = steps <= 1.52 and smooth <= 1.60 and round(stops, 1) <= 5.1
        return f"{steps:.3f} s; {smooth:.3f} s; {stops:.3f} s", met

    full = "make test-full T="
    return [
        ("S-curve classes", "7, fixed tr", "7, equal bits to rational numbers", classes,
         "make test T=test_planner_ramp_time"),
        ("time-optimal mode", "no", "duration within 1e-6 of Ruckig", ruckig,
         full + "hundred_thousand_moves__take"),
        ("short move, L = 120 mm, tm = 0.15 s", "1.2 s", "1.2 s; <= 0.63 s optimal", short_move,
         "make test T=short_move_of_the_paper"),
        ("override 0-200 %, stop at any instant", "no", "within limits", override,
         "make test T=test_planner_override"),
        ("start speed 0", "stalls by its rule", "exact count and time", rest_to_rest,
         "make test T=zero_start_speed"),
        ("planner in binary32 on the core", "double on ARM", "<= 1 um over 1 m", core,
         "make test T=test_planner_programs"),
        ("greatest pulse frequency", "format to 67 MHz", "50 MHz, none lost", fastest,
         "make test T=test_rates_above"),
        ("least pulse frequency, exact mean", "0.0625 Hz", "0.0625 Hz, count of 16 s exact", None,
         full + "sixteen_seconds"),
        ("pulse jitter", "10 ns", "<= 10 ns peak to peak", jitter,
         "make test T=test_constant_rate"),
        ("step and direction timing", "none stated", "four times kept", drive_times,
         "make test T=drive_timing; proved: make formal T=step_timing"),
        ("pulse count, position at <= 40 kHz", "not stated", "0 lost, <= 0.04 pulses", slow_pulses,
         full + "a_billion_pulses"),
        ("sizes of pulse, velocity block, front-end", "152; 2330; 3037 LUT (one axis)",
         "<= 100; <= 400; <= 3000 LUT (five axes), 100 MHz", sizes, "make motion-size"),
        ("line in steps", "half-step extrapolation", "per axis <= 0.5; across <= 0.7071 / 0.5",
         lines, "make test T=test_line__"),
        ("circle in steps", "figures only", "radial <= 0.7071 / 0.5, closes", circles,
         "make test T=test_circle__"),
        ("one line in N axes", "no", "each axis <= 0.5 step", line_in_axes,
         "make test T=line_in_all_axes; proved: make formal T=synchronised_nodes"),
        ("G-code: LinuxCNC's samples, equal moves", "LinuxCNC",
         "at least 18 of 24 equal, none different", compare_goal,
         ".venv/bin/python -m sim.gcode.oracle --samples"),
        ("84 chords, G64 steps; G64 smooth; G61", "1.5 s; -; 5 s",
         "<= 1.52 s; <= 1.60 s; 5.1 s", times, "make test T=test_chords"),
        ("G64 P: 1, 5, 10, 25, 100 um", "not exceeded", "apex <= P at 10 kHz", corners,
         "make test T=test_corner"),
        ("corner of 90 degrees, P 0.1 mm, 4.8 m/s2", "-", ">= 31.6 mm/s", corner_speed,
         "make test T=test_corner"),
        ("limits of tool, legs, table; half in five axes", "XYZ only", "0 programs above 1.001",
         violations, ".venv/bin/python -m sim.lookahead.stress --count 10000"),
        ("path and corners of random programs", "-", "within P", random_p,
         ".venv/bin/python -m sim.lookahead.stress --count 10000"),
        ("tiny, empty, repeated moves, tiny P", "-", "no stall", odd,
         ".venv/bin/python -m sim.lookahead.stress --odd --count 1000000"),
        ("set-points: position, velocity, acceleration", "1 ms",
         "10 kHz, derivatives of each other", derivatives, "make test T=test_set_points"),
        ("look-ahead", "n segments", ">= 256 segments, >= 2000/s, constant work", throughput,
         "make test T=test_stream"),
        ("G64 program on five step axes (RTL)", "-", "0 steps off at the end; <= 1 on the way",
         figures("five axes: final counts off", "five axes: steps off the plan"),
         "make test T=test_step_stream"),
        ("following error, 1st-order loop: none, v, v+a, S-curve", "2.5; < 0.1; less; -",
         "2.5; < 0.1; < 0.025; < 0.01 mm",
         figures("1st-order loop: no feed-forward", "1st-order loop: velocity",
                 "1st-order loop: velocity and acceleration",
                 "1st-order loop: velocity and acceleration, S-curve"),
         "make test T=test_drive"),
        ("current spikes", "yes", ">= 5 times lower",
         figures("1st-order loop: peak dI/dt, trapezoid over S-curve"), "make test T=test_drive"),
        ("robot on AGH, 2 m/min: law; drives", "-", "< 10 um",
         lambda counts: tuple(map(_both, robot("computed torque")(counts),
                                  robot("drives, velocity and acceleration")(counts))),
         "make motion RUN=full"),
        ("load step of 1.8 N m", "3.58 um", "within 2 times",
         figures("load step 1.8 N m; 160 Hz read as i-p"), "make test T=test_drive"),
        ("+-1 increment of 34.7 nm", "held", "held, 5 of 5 targets",
         figures("+-1 of 144 000 counts under 0.0 N m: targets met",
                 "+-1 of 144 000 counts under 1.8 N m: targets met"),
         "make test T=test_drive"),
    ]  # fmt: skip


def _both(a: Any, b: Any) -> Any:
    return f"{a}; {b}" if isinstance(a, str) else a and b


def compare_goal(counts: Counts) -> Measured:
    """LinuxCNC's sample programs through both interpreters."""
    found = compare_samples()
    return found.text, found.goal_met


def printed(goals: Sequence[Goal]) -> Table:
    """The goals for people."""
    shown = Table(
        title="Motion front-end: goals",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
        caption="What each part is to reach: as the papers have it, as this project wants it, and "
        "what this run has measured, with the command for what takes too long for it.",
        caption_justify="left",
    )
    for title in ("feature", "published", "goal", "ours", ""):
        shown.add_column(title)
    for goal in goals:
        verdict = {True: "met", False: "[red]NOT MET[/]", None: ""}[goal.met]
        ours = goal.ours or f"see {goal.command}"
        shown.add_row(goal.feature, goal.published, escape(goal.goal), escape(ours), verdict)
    return shown


def document(goals: Sequence[Goal]) -> list[dict[str, Any]]:
    """For results.json."""
    return [asdict(goal) for goal in goals]


def markdown(entries: Sequence[Mapping[str, Any]]) -> str:
    """The goals of results.json as a table of the page, between its marks."""
    verdict = {True: "met", False: "**not met**", None: ""}
    lines = [
        BEGIN,
        "",
        "| feature | published | goal | ours | | more |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for entry in entries:
        cells = [
            entry["feature"],
            entry["published"],
            entry["goal"],
            entry["ours"] or "not in this run",
        ]
        lines.append(f"| {' | '.join(cells)} | {verdict[entry['met']]} | `{entry['command']}` |")
    return "\n".join([*lines, "", END])


def with_table(page: str, entries: Sequence[Mapping[str, Any]]) -> str:
    """The page with its table replaced. Raises ValueError if it has no marks."""
    if page.count(BEGIN) != 1 or page.count(END) != 1:
        raise ValueError(f"the page has no marks {BEGIN} and {END}")
    before, rest = page.split(BEGIN)
    return before + markdown(entries) + rest.split(END)[1]


def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m sim.motion.goals",
        description="Write the table of goals of the last `make motion` into docs/motion.md.",
        epilog="example: python -m sim.motion.goals --results build/motion/results.json",
    )
    parser.add_argument("--results", type=Path, default=RESULTS, help="results of make motion")
    parser.add_argument("--page", type=Path, default=PAGE, help="page with the marks")
    parser.add_argument("--measure", action="store_true", help="measure the goals again")
    arguments = parser.parse_args(argv)
    try:
        results = json.loads(arguments.results.read_text(encoding="utf-8"))
        if arguments.measure:
            counts = FULL if results["full"] else Counts()
            found = table(results["figures"], counts, lambda name: None)
            results["goals"] = document(found)
            text = json.dumps(results, indent=2) + "\n"
            arguments.results.write_text(text, encoding="utf-8")
        entries = results["goals"]
        page = with_table(arguments.page.read_text(encoding="utf-8"), entries)
        arguments.page.write_text(page, encoding="utf-8")
    except OSError as error:
        sys.stderr.write(f"{error.filename}: error: {error.strerror}; run make motion first\n")
        return 1
    except (KeyError, TypeError, ValueError) as error:
        sys.stderr.write(f"{parser.prog}: error: {error}; run make motion again\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
