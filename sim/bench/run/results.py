# SPDX-License-Identifier: Apache-2.0
"""What `make run` measures: cycles, operation counts, numerical errors, tracking errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.bench.run.bounds import bounds
from sim.core.closed_loop import Recording, tracking_error
from sim.core.controller import EXPORTED, PASSED_ON, LawTicks
from sim.robot import tracking
from sim.robot.errors import max_abs_error, ripple
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS, SET_POINTS, TABLE_3, SetPoints, TrackingResult

CLOCK_MHZ = default_isa().clock_mhz
SMALLEST = 1e-300  # bound of an output that must be exact
# Key of a program of FPGA3 among the errors.
FPGA3_COLUMNS = {
    "as_printed": "fpga3",
    "optimised": "fpga3_optimised",
    "observer": "fpga3_observer",
    "stamps": "fpga3_stamps",
}
OPERATION_CLASSES = ("add_sub", "mul", "div", "sqrt", "sin", "float_int", "sat")


@dataclass(frozen=True)
class ProgramRun:
    """One program's measurements: the image, what it did, bundles issued per address in `runs`,
    clock cycles simulated; touched: what somebody did to the loop while it ran."""

    image: Image
    recording: Recording
    issued: NDArray[np.uint64]
    runs: int
    cycles: int
    touched: tuple[str, ...] = ()


def timing(cycles: NDArray[np.uint32], clock_mhz: int = CLOCK_MHZ) -> dict[str, float]:
    """Cycles of the shortest and longest tick and the longest in microseconds."""
    longest = int(cycles.max())
    return {
        "clock_mhz": clock_mhz,
        "cycles_min": int(cycles.min()),
        "cycles_max": longest,
        "time_us": longest / clock_mhz,
    }


def operations(run: ProgramRun) -> dict[str, float]:
    """Operations executed per tick in the classes of table 1, counted from the bundles issued."""
    isa = default_isa()
    totals = dict.fromkeys(OPERATION_CLASSES, 0)
    for times, sources in zip(run.issued.tolist(), run.image.sources, strict=True):
        for source in sources:
            for kind, count in isa.operations[source.op].counts.items():
                totals[kind] += times * count
    return {
        kind: total // run.runs if total % run.runs == 0 else total / run.runs
        for kind, total in totals.items()
    }


def rtl_rows(path: SetPoints, ticks: LawTicks) -> dict[str, NDArray[np.float32]]:
    """Every row of table 3 and the outputs as the program gave them."""
    rows = {name: ticks.exported[:, i] for i, name in enumerate(EXPORTED)}
    words = path.words().astype(np.float32)
    rows |= {row: words[:, SET_POINTS.index(name)] for row, name in PASSED_ON.items()}
    return rows | {name: ticks.outputs[:, i] for i, name in enumerate(OUTPUTS)}


def row_errors(reference: TrackingResult, path: SetPoints, ticks: LawTicks) -> dict[str, float]:
    """Largest absolute error of each row against the double-precision reference."""
    return {
        name: float(np.max(np.abs(values.astype(np.float64) - reference.row(name))))
        for name, values in rtl_rows(path, ticks).items()
    }


@dataclass(frozen=True)
class Comparison:
    """References on the counts that one run saw.

    reference: double precision on the unrounded set-points; rounded: the same on set-points rounded
    to binary32, so what the rounding of the inputs alone does. counts: for a program with
    observers.
    """

    reference: TrackingResult
    rounded: TrackingResult
    rounded_path: SetPoints
    counts: NDArray[np.int32] | None = None


def compare(
    robot: Robot, path: SetPoints, counts: NDArray[np.int32], speed: str = "difference"
) -> Comparison:
    """Evaluate the references; speed: one of `observer.SPEEDS`."""
    rounded = SetPoints.from_words(path.words().astype(np.float32).astype(np.float64))
    return Comparison(
        tracking.run(robot, path, counts, speed),
        tracking.run(robot, rounded, counts, speed),
        rounded,
        None if speed == "difference" else counts,
    )


def worst_of_bound(
    robot: Robot,
    comparison: Comparison,
    ticks: LawTicks,
    is_optimised: bool,
    at: NDArray[np.int64] | None = None,
) -> dict[str, float]:
    """Per output the largest error as a fraction of its derived bound at the same tick.

    The error is that of the arithmetic: against double precision on the same binary32 set-points.
    at: numbers of the ticks, by default all.
    """
    at = np.arange(len(comparison.rounded_path)) if at is None else at
    found = bounds(
        robot, comparison.rounded_path, comparison.rounded, is_optimised, comparison.counts
    )
    limit = found.output[at]
    error = np.abs(ticks.outputs.astype(np.float64) - comparison.rounded.output[at])
    worst = (error / np.maximum(limit, SMALLEST)).max(axis=0)
    return dict(zip(OUTPUTS, worst.tolist(), strict=True))


def results(
    robot: Robot,
    path: SetPoints,
    runs: Mapping[str, ProgramRun],
    comparisons: Mapping[str, Comparison],
    common: Comparison,
    single: TrackingResult,
) -> dict[str, Any]:
    """The content of build/results.json, except for FPGA1 and FPGA2.

    runs: the programs of FPGA3 with the comparison of each on the counts that it saw; common, and
    single, the printed formulas in float32 (the PC column): on those of the first run.
    """
    desired = tracking.joint_path(robot, path)[0]
    inputs = max_abs_error(common.reference, common.rounded)
    pc = max_abs_error(common.reference, single)
    rows = (*TABLE_3, *OUTPUTS)
    errors = {row: {"pc_float32": pc[row], "set_point_rounding": inputs[row]} for row in rows}
    deviations = {}
    for name, run in runs.items():
        found = row_errors(comparisons[name].reference, path, run.recording.ticks)
        for row in rows:
            errors[row][FPGA3_COLUMNS[name]] = found[row]
        deviations[name] = tracking_error(robot, path, desired, run.recording)
    data: dict[str, Any] = {"ticks": len(path), "platforms": {}, "errors": errors, "nios": {}}
    data |= {"tracking": {}, "worst_fraction_of_bound": {}}
    if not runs:
        return data
    data["platforms"]["fpga3"] = {
        name: timing(run.recording.ticks.cycles) for name, run in runs.items()
    }
    data["operations"] = {name: operations(run) for name, run in runs.items()}
    data["worst_fraction_of_bound"] = {
        name: worst_of_bound(robot, comparisons[name], run.recording.ticks, name != "as_printed")
        for name, run in runs.items()
    }
    data["ripple"] = {
        name: dict(
            zip(OUTPUTS, ripple(run.recording.ticks.outputs, robot.T_s).tolist(), strict=True)
        )
        for name, run in runs.items()
    }
    data["tracking"] = {
        "max_leg_error_m": max(d.leg for d in deviations.values()),
        "max_tool_error_m": max(d.tool for d in deviations.values()),
        "max_table_error_rad": max(d.table for d in deviations.values()),
        **{name: vars(deviation) for name, deviation in deviations.items()},
    }
    return data
