# SPDX-License-Identifier: Apache-2.0
"""Goals of clocks and ticks, from the last `microtick synth` (build/synth.json) or docs/data.

Place and route of all seeds takes hours, so no run of the goals starts it. A figure of RTL that has
changed since, or of too few seeds, counts as not measured.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from functools import partial

from sim.bench.run.tables import synthesised
from sim.bench.shown_robots.core_goals import ROWS, Figure, figure
from sim.bench.shown_robots.job import PROGRAMS, hand_written_cycles, written_cycles
from sim.report.goals import Goal, at_least, at_most, exactly, not_measured

TICK_US = 0.80
SYSTEM_MHZ = 100
BEFORE_STREAMS = {
    "fast": (11_812, {"tracking_optimised": 111, "tracking_as_printed": 204}),
    "small": (4_882, {"tracking_optimised": 264, "tracking_as_printed": 518}),
}
"""ALUTs of a core, and cycles of a tick of its programs, before there were streams and loops."""
SYSTEMS = {"fpga1": "FPGA1, whole system", "fpga2": "FPGA2, whole system"}


def _row(top: str, found: Figure, goal: Callable[[float], Goal]) -> Goal:
    """The goal, without a verdict where the figure does not count."""
    if found.valid and found.value is not None:
        return goal(found.value)
    named = goal(found.value or 0)
    return not_measured(
        named.name, named.target, named.unit, f"microtick synth --only {top}; {found.note}"
    )


def hardware(full: bool) -> Iterator[Goal]:
    """Tick of the optimised program and area of the core `fast`."""
    document, top = synthesised(), "asip_fast"
    clock = figure(document, top, "fmax_mhz")
    cycles = hand_written_cycles()

    def tick(mhz: float) -> Goal:
        name = "optimised tick on ECP5-85-8, median of five seeds"
        time = cycles / mhz if mhz else 0
        return at_most(name, time, TICK_US, "us", f"{cycles} cycles at {mhz:g} MHz, {clock.note}")

    yield _row(top, clock, tick)
    for own, name, field, unit, target, meets in ROWS:
        if own == top and meets is operator.le:
            found = figure(document, top, field)
            yield _row(top, found, partial(at_most, name, limit=target, unit=unit, note=found.note))


def matrix(full: bool) -> Iterator[Goal]:
    """Area and clock of the core `wide`; `fast` and `small` are as before streams and loops."""
    document, top = synthesised(), "asip_wide"
    for field, name, most in (("aluts", "ALUTs", 25_307), ("dsp_18x18", "elements 18x18", 32)):
        found = figure(document, top, field)
        yield _row(
            top, found, partial(at_most, f"wide: {name}", limit=most, unit="", note=found.note)
        )
    clock = figure(document, top, "fmax_mhz")
    name = "wide: clock on ECP5-85-8, median of five seeds"
    yield _row(top, clock, partial(at_least, name, limit=125, unit="MHz", note=clock.note))
    for core, (aluts, cycles) in BEFORE_STREAMS.items():
        for program, count in cycles.items():
            taken = written_cycles(PROGRAMS / f"{program}.s", core)
            yield exactly(f"{core}: tick of {program}", taken, count, "cycles")
        top = f"asip_{core}"
        found = figure(document, top, "aluts")
        more = partial(at_most, f"{core}: ALUTs", limit=1.01 * aluts, unit="", note=found.note)
        yield _row(top, found, more)


def nios(full: bool) -> Iterator[Goal]:
    """Clocks of the two whole systems."""
    document = synthesised()
    for top, name in SYSTEMS.items():
        clock = figure(document, top, "fmax_mhz")
        named = f"{name}: clock on ECP5-85-8, median of five seeds"
        yield _row(
            top, clock, partial(at_least, named, limit=SYSTEM_MHZ, unit="MHz", note=clock.note)
        )
