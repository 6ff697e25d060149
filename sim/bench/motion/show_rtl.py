# SPDX-License-Identifier: Apache-2.0
"""Figure 12 of the S-curve paper on the motion front-end as RTL, in both velocity modes.

The move and its 10 pulses per mm are the paper's. Figures: pulses counted on the step line,
duration from the release of the records to the interrupt, and the speed of the last interval of
pulses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from sim.motion.planner.figures import FIGURE_12, PULSES_PER_MM, Result, printed
from sim.motion.planner.pulse_records import pulse_counted, time_exact
from sim.motion.planner.ramp_time import RampTimePlan, ramp_time_plan
from sim.report import pictures
from sim.rtl.motion_rtl import CLOCK_HZ, MotionError, MotionRtl

MODES = {"time-exact": time_exact, "pulse-counted": pulse_counted}
TICK_CLOCKS = CLOCK_HZ // 1_000_000
CHUNK = 5_000_000  # clocks between two progress calls
FILE = "scurve_fig12_rtl.svg"
# Estimated from the paper's rule without this RTL: phases end at the ceilings of their
# displacements and rates change after a pulse only, so the move ends early and too fast. How the
# speed at the entry of a phase was set for the estimate is not recorded; here: the planned one.
ESTIMATE = {"duration": "0.8605", "speed": "15.85"}


@dataclass(frozen=True)
class Move:
    """A move that was run: seconds, and seconds of each pulse since the release."""

    seconds: float
    pulses: np.ndarray

    @property
    def last_speed(self) -> float:
        """Speed in the last interval of pulses [mm/s]."""
        return float(1.0 / (self.pulses[-1] - self.pulses[-2]) / PULSES_PER_MM)


def figure_12() -> RampTimePlan:
    """The plan of the move, mm and s."""
    return ramp_time_plan(**FIGURE_12)


def ticks() -> int:
    """Ticks of 1 us that the move is planned for."""
    return round(figure_12().total_time * 1_000_000)


def run(mode: str, progress: Callable[[int], None] = lambda ticks: None) -> Move:
    """Run the move in one of MODES. Raises MotionError if it does not end within twice its time."""
    plan = figure_12()
    motion = MotionRtl()
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    begin = motion.now
    motion.put({0: MODES[mode](plan.phases, PULSES_PER_MM)})
    limit = begin + 2 * ticks() * TICK_CLOCKS
    while True:
        try:
            clocks = motion.wait_for_irq(CHUNK)
        except MotionError:
            progress(CHUNK // TICK_CLOCKS)
            if motion.now > limit:
                raise
            continue
        progress(clocks // TICK_CLOCKS)
        break
    if motion.status("underrun") or motion.status("overrun"):
        raise MotionError(f"{mode}: the front-end reports an underrun or overrun")
    pulses = (motion.edges().pulses(0) - begin) / CLOCK_HZ
    return Move((motion.now - begin) / CLOCK_HZ, pulses)


def last_speed_of_plan(plan: RampTimePlan) -> float:
    """Mean speed [mm/s] between the places of the last two pulses, which represent n - 1/2."""
    count = plan.length * PULSES_PER_MM
    times = []
    for place in (count - Fraction(3, 2), count - Fraction(1, 2)):
        low, high = Fraction(0), plan.total_time
        for _ in range(40):
            middle = (low + high) / 2
            early = plan.at(middle).position * PULSES_PER_MM < place
            low, high = (middle, high) if early else (low, middle)
        times.append(low)
    return float(1 / (times[1] - times[0]) / PULSES_PER_MM)


def results(moves: dict[str, Move]) -> list[Result]:
    """Figures next to the plan's (derived from the paper) and the estimate for its rule."""
    plan = figure_12()
    wanted = {
        "time-exact": (f"{float(plan.total_time):.4f}", f"{last_speed_of_plan(plan):.2f}"),
        "pulse-counted": (ESTIMATE["duration"], ESTIMATE["speed"]),
    }
    found = []
    for mode, move in moves.items():
        source = "derived" if mode == "time-exact" else "estimate"
        duration, speed = wanted[mode]
        for name, unit, published, kind, ours in (
            ("pulses", "", str(plan.length * PULSES_PER_MM), "derived", float(len(move.pulses))),
            ("duration", "s", duration, source, move.seconds),
            ("final speed", "mm/s", speed, source, move.last_speed),
        ):
            agrees = printed(published, ours)
            found.append(
                Result("12 RTL", f"{mode}: {name}", unit, published, kind, ours, agrees, FILE)
            )
    return found


def draw(moves: dict[str, Move], output: Path) -> None:
    """Speed of the pulses and their distance from the plan."""
    plt = pictures.pyplot("rtl")
    plan = figure_12()
    figure, rows = plt.subplots(2, 1, figsize=(8, 6), sharex=True)
    for mode, move in moves.items():
        middle = (move.pulses[1:] + move.pulses[:-1]) / 2
        rows[0].plot(middle, 1 / np.diff(move.pulses) / PULSES_PER_MM, lw=0.9, label=mode)
        # pulse n represents n - 1/2
        ideal = plan.sample(move.pulses).position * PULSES_PER_MM
        rows[1].plot(move.pulses, np.arange(len(ideal)) + 0.5 - ideal, lw=0.9, label=mode)
    t = np.linspace(0.0, float(plan.total_time), 400)
    rows[0].plot(t, plan.sample(t).velocity, "k--", lw=0.7, label="plan")
    rows[0].set(ylabel="speed [mm/s]", title="Move of figure 12 from the step line of the RTL")
    rows[1].set(ylabel="pulses ahead of the plan", xlabel="time [s]")
    for axis in rows:
        axis.grid(alpha=0.3)
        axis.legend()
    pictures.save(figure, output / FILE)
