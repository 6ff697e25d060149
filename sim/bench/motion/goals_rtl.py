# SPDX-License-Identifier: Apache-2.0
"""Goals of the RTL: pulse generators, step lines, interpolators, sizes."""

from __future__ import annotations

import math

import numpy as np

from sim.bench.motion.goal import SEED, Counts, Feature, Features, Measured, Rows
from sim.bench.motion.sizes import LIMITS as SIZE_LIMITS
from sim.bench.motion.sizes import current as measured_sizes
from sim.bench.motion.sizes import within
from sim.motion.planner.pulse_records import time_exact
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.rtl.interpolator_rtl import InterpolatorRtl
from sim.rtl.motion_rtl import CLOCK_HZ, RECORDS, MotionRtl
from sim.rtl.phase_record import DIRECTION, FIRST, LAST, UNITS_PER_HZ, Record

FEATURES = Features()

LIMIT = 40_000_000  # clocks, above every move here


def _front_end() -> MotionRtl:
    motion = MotionRtl()
    motion.set("STEP_TIMING", length=1, space=1)
    motion.set("DIRECTION_TIMING", setup=1, hold=1)
    return motion


@FEATURES.feature(
    "start speed 0",
    "stalls by its rule",
    "exact count and time",
    "make test T=zero_start_speed",
    simulated=True,
)
def rest_to_rest(counts: Counts, rows: Rows) -> Measured:
    """A move from rest to rest on the RTL: pulses and ticks off."""
    plan = ramp_time_plan("0", "200", "0.02", "0.005", "3")
    motion = _front_end()
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    begin = motion.now
    motion.run({0: time_exact(plan.phases, 1000)}, LIMIT)
    ticks = (motion.now - begin) / (CLOCK_HZ / 1e6) - float(plan.total_time) * 1e6
    off = motion.position(0) - int(plan.length * 1000)
    # Up to three ticks from the release to the first one, and from the last one to the interrupt.
    return f"{off} pulses, {ticks:.2f} us from release to interrupt", off == 0 and 0 < ticks < 3


@FEATURES.feature(
    "greatest pulse frequency",
    "format to 67 MHz",
    "50 MHz, none lost",
    "make test T=test_rates_above",
    simulated=True,
)
def fastest(counts: Counts, rows: Rows) -> Measured:
    """50 MHz: a pulse every other clock, none lost."""
    motion = _front_end()
    rate = 50_000_000
    motion.run({0: [Record(FIRST | LAST, 200, rate * UNITS_PER_HZ << 32, 0, 0)]}, LIMIT)
    at = motion.edges().pulses(0)
    clocks = sorted(set(np.diff(at).tolist()))
    apart = " or ".join(map(str, clocks))
    return f"{len(at)} pulses of 10000, {apart} clocks apart", len(at) == 10_000 and clocks == [2]


FEATURES.append(
    Feature(
        "least pulse frequency, exact mean",
        "0.0625 Hz",
        "0.0625 Hz, count of 16 s exact",
        "make test-full T=sixteen_seconds",
        None,
    )
)


@FEATURES.feature(
    "pulse jitter",
    "10 ns",
    "<= 10 ns peak to peak",
    "make test T=test_constant_rate",
    simulated=True,
)
def jitter(counts: Counts, rows: Rows) -> Measured:
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


@FEATURES.feature(
    "step and direction timing",
    "none stated",
    "four times kept",
    "make test T=drive_timing; proved: microtick formal --only step_timing",
    simulated=True,
)
def drive_times(counts: Counts, rows: Rows) -> Measured:
    """Moves there and back without rest at random drive timing: settings with a time not kept."""
    random, wrong = np.random.default_rng(SEED), 0
    for _ in range(counts.timings):
        length, space, setup, hold = random.integers(1, 120, 4).tolist()
        motion = MotionRtl()
        motion.set("STEP_TIMING", length=length, space=space)
        motion.set("DIRECTION_TIMING", setup=setup, hold=hold)
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


@FEATURES.feature(
    "pulse count, position at <= 40 kHz",
    "not stated",
    "0 lost, <= 0.04 pulses",
    "make test-full T=a_billion_pulses",
    simulated=True,
)
def slow_pulses(counts: Counts, rows: Rows) -> Measured:
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


@FEATURES.feature(
    "sizes of pulse, velocity block, front-end",
    "152; 2330; 3037 LUT (one axis)",
    "<= 100; <= 400; <= 3000 LUT (five axes), 100 MHz",
    "microtick motion-size",
)
def sizes(counts: Counts, rows: Rows) -> Measured:
    """Sizes by `microtick motion-size` of the present RTL. Raises KeyError without them."""
    found = measured_sizes()
    parts = [f"{found[name]['ecp5']['luts']}" for name in SIZE_LIMITS]
    plain, paths = found["motion_front_end"], found["motion_front_end, interpolators"]
    met = all(within(name, design) for name, design in found.items())
    return (
        f"{'; '.join(parts)} LUT, {plain['mhz_median']:.0f} MHz; "
        f"with lines and arcs {paths['ecp5']['luts']}, {paths['mhz_median']:.0f} MHz",
        met,
    )


@FEATURES.feature(
    "line in steps",
    "half-step extrapolation",
    "per axis <= 0.5; across <= 0.7071 / 0.5",
    "make test T=test_line__",
    simulated=True,
)
def lines(counts: Counts, rows: Rows) -> Measured:
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


@FEATURES.feature(
    "circle in steps",
    "figures only",
    "radial <= 0.7071 / 0.5, closes",
    "make test T=test_circle__",
    simulated=True,
)
def circles(counts: Counts, rows: Rows) -> Measured:
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


@FEATURES.feature(
    "one line in N axes",
    "no",
    "each axis <= 0.5 step",
    "make test T=line_in_all_axes; proved: microtick formal --only synchronised_nodes",
    simulated=True,
)
def line_in_axes(counts: Counts, rows: Rows) -> Measured:
    """Random lines of all axes of the front-end: nodes against the ideal, axis by axis [steps]."""
    random, apart, worst, ended = np.random.default_rng(SEED), 40, 0.0, True
    motion = _front_end()
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    motion.write("SOURCE", (1 << motion.AXES) - 1)
    motion.set("PATH_FEED", period=apart)
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
