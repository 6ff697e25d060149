# SPDX-License-Identifier: Apache-2.0
"""Draw figures 3, 12 and 15 of the S-curve paper, our numbers next to those of the paper."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from rich.table import Table

from asip_asm.files import write_text
from sim.motion.planner.optimal import Limits, time_optimal
from sim.motion.planner.ramp_time import RampTimePlan, ramp_time_plan
from sim.report import pictures

POINTS = 1201
PULSES_PER_MM = 10  # value of figure 12
FIGURE_3 = {"v0": "100", "vm": "600", "tr": "0.6"}
FIGURE_3_TM = ("0", "0.15", "0.3")
FIGURE_3_LENGTHS = ("800", "300", "100")
FIGURE_12 = {"v0": "15", "vm": "200", "tr": "0.4", "tm": "0.1", "length": "100"}
FIGURE_15 = {"v0": "30", "vm": "300", "tr": "0.4"}
FIGURE_15_RUNS = (("0", "200"), ("0.1", "80"), ("0.2", "20"))
RESULTS_FILE = "planner_figures.json"


@dataclass(frozen=True)
class Result:
    """One number of a figure. `published` is as printed; `source`: by whom, "stated" in the paper's

    text, "derived" by hand from its formulas where the text gives the figure only. `agrees` if
    ours, rounded to the digits printed, is the same.
    """

    figure: str
    name: str
    unit: str
    published: str
    source: str
    ours: float
    agrees: bool
    file: str


# tm: am, J (None: no jerk phase), S1, S2, S3 of the paths of 800 mm and of 300 mm.
TABLE_3 = {
    "800": {
        "0": ("833.33", None, "0", "210", "0"),
        "0.15": ("1111.11", "7407.41", "19.1667", "105", "85.8333"),
        "0.3": ("1666.67", "5555.56", "55", "0", "155"),
    },
    "300": {
        "0": ("500", None, "0", "150", "0"),
        "0.15": ("666.67", "4444.44", "17.5", "75", "57.5"),
        "0.3": ("1000", "3333.33", "45", "0", "105"),
    },
}
SEGMENTS_3 = {
    "800": {"0": "3", "0.15": "7", "0.3": "5"},
    "300": {"0": "2", "0.15": "6", "0.3": "4"},
    "100": {"0": "1", "0.15": "1", "0.3": "1"},
}
TOTAL_3 = {"800": "1.8333", "300": "1.2", "100": "1"}
DURATIONS_12 = ("0.1", "0.2", "0.1", "0.07", "0.1", "0.2", "0.1")
DISPLACEMENTS_12 = ("2.5278", "21.5", "18.9722", "14", "18.9722", "21.5", "2.5278")
TOTAL_15 = {"200": "1.0267", "80": "0.8", "20": "0.6667"}


def printed(text: str, value: Fraction | float) -> bool:
    """Whether a value is the one printed, to its last digit."""
    digits = len(text.partition(".")[2])
    return abs(Fraction(value) - Fraction(text)) <= Fraction(1, 2 * 10**digits)


Row = tuple[str, str, str, str, Fraction | int]
"""Of a figure's numbers: name, unit, source, published, ours."""


def _numbers_of_figure_3() -> Iterator[Row]:
    """Critical lengths, peak speeds, times, accelerations, jerks and displacements."""
    for length in FIGURE_3_LENGTHS:
        for tm in FIGURE_3_TM:
            plan = ramp_time_plan(**FIGURE_3, tm=tm, length=length)
            forms = plan.forms
            case = f"L={length} tm={tm}"
            if length == "300":
                yield f"{case} L_alpha", "mm", "stated", "420", forms.cruise_critical_length
                yield f"{case} v'm", "mm/s", "stated", "400", forms.peak_speed
            if length == "100":
                yield f"{case} L_beta", "mm", "stated", "120", forms.acceleration_critical_length
            yield f"{case} segments", "", "stated", SEGMENTS_3[length][tm], forms.kind.value
            source = "stated" if length == "100" else "derived"
            yield f"{case} total time", "s", source, TOTAL_3[length], plan.total_time
            if length == "100":
                continue
            am, jerk, *displacements = TABLE_3[length][tm]
            yield f"{case} am", "mm/s2", "derived", am, forms.peak_acceleration
            if jerk is not None:
                yield f"{case} J", "mm/s3", "derived", jerk, forms.jerk
            for k, published in enumerate(displacements):
                yield f"{case} S{k + 1}", "mm", "derived", published, forms.displacements[k]
            if length == "800":
                yield f"{case} T4", "s", "derived", "0.6333", forms.durations[3]
                yield f"{case} S4", "mm", "derived", "380", forms.displacements[3]


def _numbers_of_figure_12() -> Iterator[Row]:
    """Phases of the simulated move."""
    plan = ramp_time_plan(**FIGURE_12)
    forms = plan.forms
    yield "segments", "", "derived", "7", forms.kind.value
    yield "L_alpha", "mm", "derived", "86", forms.cruise_critical_length
    yield "am", "mm/s2", "derived", "616.667", forms.peak_acceleration
    yield "J", "mm/s3", "derived", "6166.67", forms.jerk
    yield "total time", "s", "derived", "0.87", plan.total_time
    yield "pulses", "", "derived", "1000", plan.length * PULSES_PER_MM
    for k in range(7):
        yield f"T{k + 1}", "s", "derived", DURATIONS_12[k], forms.durations[k]
        yield f"S{k + 1}", "mm", "derived", DISPLACEMENTS_12[k], forms.displacements[k]


def _numbers_of_figure_15() -> Iterator[Row]:
    """Critical lengths and times of the hardware runs; tm and L are not in the text, see runs."""
    for tm, length in FIGURE_15_RUNS:
        plan = ramp_time_plan(**FIGURE_15, tm=tm, length=length)
        forms = plan.forms
        case = f"L={length} tm={tm}"
        yield f"{case} L_alpha", "mm", "derived", "132", forms.cruise_critical_length
        yield f"{case} L_beta", "mm", "derived", "24", forms.acceleration_critical_length
        yield f"{case} total time", "s", "derived", TOTAL_15[length], plan.total_time


def numbers() -> list[Result]:
    """Those of all figures."""
    of_figures = {
        "3": _numbers_of_figure_3(),
        "12": _numbers_of_figure_12(),
        "15": _numbers_of_figure_15(),
    }
    results = []
    for figure, rows in of_figures.items():
        for name, unit, source, published, ours in rows:
            agrees, file = printed(published, ours), f"scurve_fig{figure}.svg"
            results.append(Result(figure, name, unit, published, source, float(ours), agrees, file))
    return results


def figures(output: Path) -> list[Result]:
    """Draw the figures into `output` (PNG and SVG), write their numbers as JSON, return them."""
    output.mkdir(parents=True, exist_ok=True)
    results = numbers()
    plt = pictures.pyplot("planner")
    for number, draw in ((3, _draw_3), (12, _draw_12), (15, _draw_15)):
        pictures.save(draw(plt), output / f"scurve_fig{number}.svg")
    document = [asdict(result) for result in results]
    write_text(output / RESULTS_FILE, json.dumps(document, indent=2) + "\n")
    return results


def results_table(results: list[Result]) -> Table:
    """The numbers for people."""
    table = Table(title="figures of the S-curve paper")
    for name in ("figure", "number", "unit", "published", "source", "ours", ""):
        table.add_column(name, justify="right" if name in ("published", "ours") else "left")
    for result in results:
        table.add_row(
            result.figure,
            result.name,
            result.unit,
            result.published,
            result.source,
            f"{result.ours:.8g}",
            "agrees" if result.agrees else "DIFFERS",
        )
    return table


def _curve(plan: RampTimePlan) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, positions and speeds."""
    times = np.linspace(0.0, float(plan.total_time), POINTS)
    samples = plan.sample(times)
    return times, samples.position, samples.velocity


def _draw_3(plt):
    figure, rows = plt.subplots(3, 1, figsize=(8, 9))
    for axis, length in zip(rows, FIGURE_3_LENGTHS, strict=True):
        for tm in FIGURE_3_TM:
            times, _, speed = _curve(ramp_time_plan(**FIGURE_3, tm=tm, length=length))
            axis.plot(times, speed, label=f"tm = {tm} s")
        am = 500 / 0.45
        fastest = time_optimal(float(length), 100.0, 100.0, Limits(600.0, am, am / 0.15))
        times = np.linspace(0.0, fastest.total_time, POINTS)
        axis.plot(
            times,
            fastest.sample(times).velocity,
            "k--",
            lw=0.8,
            label="time-optimal, limits of tm = 0.15 s",
        )
        axis.set(ylabel="speed [mm/s]", title=f"L = {length} mm", ylim=(0, 650))
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    rows[-1].set_xlabel("time [s]")
    return figure


def _draw_12(plt):
    plan = ramp_time_plan(**FIGURE_12)
    times, position, speed = _curve(plan)
    figure, rows = plt.subplots(4, 1, figsize=(8, 9), sharex=True)
    rows[0].plot(times, position)
    rows[0].set_ylabel("displacement [mm]")
    rows[1].plot(times, speed)
    rows[1].set_ylabel("speed [mm/s]")
    joints = np.cumsum([0.0, *(float(x) for x in plan.forms.durations)])
    rows[2].step(joints, [*range(1, 8), 7], where="post")
    rows[2].set_ylabel("phase")
    # Ideal pulse train: one pulse at each whole pulse of way.
    whole = np.arange(1, int(plan.length * PULSES_PER_MM) + 1)
    edges = np.interp(whole / PULSES_PER_MM, position, times)
    rows[3].eventplot(edges, lineoffsets=0.5, linelengths=1.0, linewidths=0.3)
    rows[3].set(ylabel="pulses", yticks=[], xlabel="time [s]")
    for axis in rows[:3]:
        axis.grid(alpha=0.3)
    rows[0].set_title("vs = 15, vm = 200 mm/s, tr = 0.4 s, tm = 0.1 s, L = 100 mm")
    return figure


def _draw_15(plt):
    figure, axis = plt.subplots(figsize=(8, 4))
    for tm, length in FIGURE_15_RUNS:
        times, _, speed = _curve(ramp_time_plan(**FIGURE_15, tm=tm, length=length))
        axis.plot(times, speed, label=f"L = {length} mm, tm = {tm} s")
    axis.set(xlabel="time [s]", ylabel="speed [mm/s]", title="vs = 30, vm = 300 mm/s, tr = 0.4 s")
    axis.grid(alpha=0.3)
    axis.legend()
    return figure
