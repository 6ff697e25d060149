# SPDX-License-Identifier: Apache-2.0
"""Goals of the RTL: pulse generators, step lines, interpolators, sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from sim.bench.motion.goals_planner import SEED
from sim.bench.motion.sizes import FRONT_END_MHZ
from sim.bench.motion.sizes import LIMITS as SIZE_LIMITS
from sim.bench.motion.sizes import current as measured_sizes
from sim.motion.planner.pulse_records import time_exact
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.report.goals import Goal, at_least, at_most, exactly, not_measured
from sim.rtl.interpolator_rtl import InterpolatorRtl
from sim.rtl.motion_rtl import CLOCK_HZ, RECORDS, MotionRtl
from sim.rtl.phase_record import DIRECTION, FIRST, LAST, UNITS_PER_HZ, Record

LIMIT = 40_000_000  # clocks, above every move here
HALF_DIAGONAL = math.sqrt(0.5)


def rows(full: bool) -> Iterator[Goal]:
    """Pulse generators, lines, arcs and sizes, on simulated RTL."""
    yield from rest_to_rest()
    yield from fastest()
    yield jitter()
    yield drive_times(300 if full else 10)
    yield from slow_pulses()
    yield from sizes()
    yield from lines(64 if full else 12)
    yield from circles(200 if full else 60)
    yield from line_in_axes(300 if full else 20)


def _front_end() -> MotionRtl:
    motion = MotionRtl()
    motion.set("STEP_TIMING", length=1, space=1)
    motion.set("DIRECTION_TIMING", setup=1, hold=1)
    return motion


def rest_to_rest() -> Iterator[Goal]:
    """A move from rest to rest on the RTL: pulses and ticks off."""
    plan = ramp_time_plan("0", "200", "0.02", "0.005", "3")
    motion = _front_end()
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    begin = motion.now
    motion.run({0: time_exact(plan.phases, 1000)}, LIMIT)
    ticks = (motion.now - begin) / (CLOCK_HZ / 1e6) - float(plan.total_time) * 1e6
    off = motion.position(0) - int(plan.length * 1000)
    # Up to three ticks from the release to the first one, and from the last one to the interrupt.
    yield exactly("move from rest to rest: pulses off", off, 0, "", "published: it stalls")
    late = 0.0 if 0 < ticks < 3 else ticks
    note = f"{ticks:.2f} us from release to interrupt, more than 0 and less than 3 wanted"
    yield exactly("move from rest to rest: time out of its bounds", late, 0, "us", note)


def fastest() -> Iterator[Goal]:
    """50 MHz: a pulse every other clock, none lost."""
    motion = _front_end()
    rate = 50_000_000
    motion.run({0: [Record(FIRST | LAST, 200, rate * UNITS_PER_HZ << 32, 0, 0)]}, LIMIT)
    at = motion.edges().pulses(0)
    clocks = sorted(set(np.diff(at).tolist()))
    note = "published: a format for up to 67 MHz"
    yield exactly("pulses at 50 MHz, of 10 000", len(at), 10_000, "", note)
    yield exactly("pulses at 50 MHz: greatest distance", max(clocks), 2, "clocks")
    yield exactly("pulses at 50 MHz: least distance", min(clocks), 2, "clocks")


def jitter() -> Goal:
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
    return at_most("pulse jitter, peak to peak", worst, 10.0, "ns", "published: 10 ns")


def drive_times(settings: int) -> Goal:
    """Moves there and back without rest at random drive timing: settings with a time not met."""
    random, wrong = np.random.default_rng(SEED), 0
    for _ in range(settings):
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
    what = "step and direction: settings of the four times that are not observed"
    return exactly(
        what, wrong, 0, "", f"of {settings}; proved: microtick formal --only step_timing"
    )


def slow_pulses() -> Iterator[Goal]:
    """Pulses of a move of up to 40 kHz on the RTL against the plan [pulses], and their number."""
    plan = ramp_time_plan("0", "200", "0.02", "0.005", "8")
    motion = _front_end()
    motion.run({0: time_exact(plan.phases, 200)}, LIMIT)
    at = motion.edges().pulses(0)
    us = CLOCK_HZ // 1_000_000
    # The first tick begins on a whole microsecond; pulse n is at the place n - 1/2.
    offs = []
    for tick in range(int(at[0]) // us - 2000, int(at[0]) // us):
        first = plan.sample([(at[0] - tick * us) / CLOCK_HZ]).position[0] * 200 - 0.5
        offs.append((abs(float(first)), tick))
    begin = min(offs)[1] * us
    ideal = plan.sample((at - begin) / CLOCK_HZ).position * 200
    worst = float(np.abs(ideal - (np.arange(len(at)) + 0.5)).max())
    lost = int(plan.length * 200) - len(at)
    yield exactly("move of up to 40 kHz: pulses lost", lost, 0, "")
    yield at_most("move of up to 40 kHz: off the plan", worst, 0.04, "pulses")


def sizes() -> Iterator[Goal]:
    """Sizes by `microtick motion-size` of the present RTL."""
    published = {"pulse_generator": 152, "velocity_control": 2330, "motion_front_end": 3037}
    try:
        found = measured_sizes()
    except KeyError as error:
        cure = str(error.args[0])
        for name, (luts, _) in SIZE_LIMITS.items():
            yield not_measured(f"{name}, LUTs on ECP5", f"<= {luts}", "", cure)
        yield not_measured("motion_front_end, clock", f">= {FRONT_END_MHZ}", "MHz", cure)
        return
    for name, (luts, registers) in SIZE_LIMITS.items():
        size = found[name]["ecp5"]
        yield at_most(f"{name}, LUTs", size["luts"], luts, "", f"published: {published[name]}")
        if registers is not None:
            yield at_most(f"{name}, registers", size["registers"], registers, "")
        yield exactly(f"{name}, multipliers", size["multipliers"], 0, "")
    for name, design in found.items():
        if "mhz_median" in design:
            note = f"{design['ecp5']['luts']} LUTs, five axes"
            yield at_least(f"{name}, clock", design["mhz_median"], FRONT_END_MHZ, "MHz", note)


def lines(reach: int) -> Iterator[Goal]:
    """Every line to ends within reach: nodes against the ideal, per axis and across."""
    rtl = InterpolatorRtl()
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
    note = f"every line to ends within {reach} steps; published: extrapolation of half a step"
    yield at_most("line: off the ideal in an axis", max(axis.values()), 0.5, "steps", note)
    yield at_most("line: across, one axis at a time", across[False], HALF_DIAGONAL, "steps")
    yield at_most("line: across, combined steps", across[True], 0.5, "steps")


def circles(largest: int) -> Iterator[Goal]:
    """Full circles of every radius, both ways: nodes against the circle; closed on the start."""
    rtl, worst, opened = InterpolatorRtl(), {False: 0.0, True: 0.0}, 0
    for radius in range(1, largest + 1):
        for clockwise in (False, True):
            for combined in worst:
                steps = rtl.arc((radius, 0), (radius, 0), radius**2, clockwise, combined)
                at = np.cumsum(steps[:, :2], axis=0) + (radius, 0)
                opened += tuple(at[-1]) != (radius, 0)
                off = float(np.abs(np.hypot(*at.T) - radius).max())
                worst[combined] = max(worst[combined], off)
    note = f"radii of up to {largest} steps"
    yield exactly("circles that do not close", opened, 0, "", note)
    yield at_most("circle: off, one axis at a time", worst[False], HALF_DIAGONAL, "steps")
    yield at_most("circle: off, combined steps", worst[True], 0.5, "steps")


def line_in_axes(count: int) -> Iterator[Goal]:
    """Random lines of all axes of the front-end: nodes against the ideal, axis by axis [steps]."""
    random, apart, worst, wrong = np.random.default_rng(SEED), 40, 0.0, 0
    motion = _front_end()
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    motion.write("SOURCE", (1 << motion.AXES) - 1)
    motion.set("PATH_FEED", period=apart)
    for _ in range(count):
        lengths = random.integers(-300, 301, motion.AXES)
        motion.line_in_all_axes(lengths.tolist())
        motion.wait_for_irq(LIMIT)
        nodes = np.cumsum(motion.edges().steps(motion.AXES, apart // 2)[1], axis=0)
        wrong += nodes[-1].tolist() != lengths.tolist()
        ideal = np.arange(1, len(nodes) + 1)[:, None] * lengths / np.abs(lengths).max()
        worst = max(worst, float(np.abs(nodes - ideal).max()))
    note = f"of {count}; proved: microtick formal --only synchronised_nodes"
    yield exactly("lines of all axes with a wrong end", wrong, 0, "", note)
    yield at_most("line of all axes: off the ideal in an axis", worst, 0.5, "steps")
