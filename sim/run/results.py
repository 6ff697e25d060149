# SPDX-License-Identifier: Apache-2.0
"""What `make run` measures: cycles, operation counts, numerical errors, tracking errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.model import float32, tracking
from sim.model.errors import max_abs_error
from sim.model.parameters import Robot
from sim.model.records import OUTPUTS, TABLE_3, SetPoints, TrackingResult
from sim.run.bounds import bounds
from sim.run.closed_loop import Recording, tracking_error
from sim.run.controller import EXPORTED, PASSED_ON, SET_POINTS, Ticks

CLOCK_MHZ = default_isa().clock_mhz
SMALLEST = 1e-300  # bound of an output that must be exact
OPERATION_CLASSES = ("add_sub", "mul", "div", "sqrt", "sin", "float_int", "sat")


@dataclass(frozen=True)
class ProgramRun:
    """One program's measurements: the image, what it did, bundles issued per address in `runs`."""

    image: Image
    recording: Recording
    issued: NDArray[np.uint64]
    runs: int


def timing(cycles: NDArray[np.uint32]) -> dict[str, float]:
    """Cycles of the shortest and longest tick and the longest in microseconds."""
    longest = int(cycles.max())
    return {
        "clock_mhz": CLOCK_MHZ,
        "cycles_min": int(cycles.min()),
        "cycles_max": longest,
        "time_us": longest / CLOCK_MHZ,
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


def rtl_rows(path: SetPoints, ticks: Ticks) -> dict[str, NDArray[np.float32]]:
    """Every row of table 3 and the outputs as the program gave them."""
    rows = {name: ticks.exported[:, i] for i, name in enumerate(EXPORTED)}
    words = path.words().astype(np.float32)
    rows |= {row: words[:, SET_POINTS.index(name)] for row, name in PASSED_ON.items()}
    return rows | {name: ticks.outputs[:, i] for i, name in enumerate(OUTPUTS)}


def row_errors(reference: TrackingResult, path: SetPoints, ticks: Ticks) -> dict[str, float]:
    """Largest absolute error of each row against the double-precision reference."""
    return {
        name: float(np.max(np.abs(values.astype(np.float64) - reference.row(name))))
        for name, values in rtl_rows(path, ticks).items()
    }


@dataclass(frozen=True)
class Comparison:
    """References on the counts of the as-printed run.

    reference: double precision on the unrounded set-points; rounded: the same on set-points rounded
    to binary32, so what the rounding of the inputs alone does; single: the printed formulas in
    float32, the PC column.
    """

    reference: TrackingResult
    rounded: TrackingResult
    single: TrackingResult
    rounded_path: SetPoints


def compare(robot: Robot, path: SetPoints, counts: NDArray[np.int32]) -> Comparison:
    """Evaluate the references."""
    rounded = SetPoints.from_words(path.words().astype(np.float32).astype(np.float64))
    return Comparison(
        tracking.run(robot, path, counts),
        tracking.run(robot, rounded, counts),
        float32.run(robot, path, counts),
        rounded,
    )


def worst_of_bound(
    robot: Robot,
    comparison: Comparison,
    ticks: Ticks,
    is_optimised: bool,
    at: NDArray[np.int64] | None = None,
) -> dict[str, float]:
    """Per output the largest error as a fraction of its derived bound at the same tick.

    The error is that of the arithmetic: against double precision on the same binary32 set-points.
    at: numbers of the ticks, by default all.
    """
    at = np.arange(len(comparison.rounded_path)) if at is None else at
    limit = bounds(robot, comparison.rounded_path, comparison.rounded, is_optimised).output[at]
    error = np.abs(ticks.outputs.astype(np.float64) - comparison.rounded.output[at])
    worst = (error / np.maximum(limit, SMALLEST)).max(axis=0)
    return dict(zip(OUTPUTS, worst.tolist(), strict=True))


def results(
    robot: Robot,
    path: SetPoints,
    as_printed: ProgramRun,
    optimised: ProgramRun,
    optimised_replay: Ticks,
    comparison: Comparison,
    simulation: dict[str, float],
) -> dict[str, Any]:
    """The content of build/results.json."""
    desired = tracking.joint_path(robot, path)[0]
    single = max_abs_error(comparison.reference, comparison.single)
    printed = row_errors(comparison.reference, path, as_printed.recording.ticks)
    better = row_errors(comparison.reference, path, optimised_replay)
    inputs = max_abs_error(comparison.reference, comparison.rounded)
    deviations = {
        name: tracking_error(robot, path, desired, run.recording)
        for name, run in (("as_printed", as_printed), ("optimised", optimised))
    }
    return {
        "ticks": len(path),
        "platforms": {
            "fpga3": {
                "as_printed": timing(as_printed.recording.ticks.cycles),
                "optimised": timing(
                    np.concatenate([optimised.recording.ticks.cycles, optimised_replay.cycles])
                ),
            }
        },
        "operations": {"as_printed": operations(as_printed), "optimised": operations(optimised)},
        "errors": {
            row: {
                "pc_float32": single[row],
                "fpga3": printed[row],
                "fpga3_optimised": better[row],
                "set_point_rounding": inputs[row],
            }
            for row in (*TABLE_3, *OUTPUTS)
        },
        "worst_fraction_of_bound": {
            "as_printed": worst_of_bound(robot, comparison, as_printed.recording.ticks, False),
            "optimised": worst_of_bound(robot, comparison, optimised_replay, True),
        },
        "tracking": {
            "max_leg_error_m": max(d.leg for d in deviations.values()),
            "max_tool_error_m": max(d.tool for d in deviations.values()),
            "max_table_error_rad": max(d.table for d in deviations.values()),
            **{name: vars(deviation) for name, deviation in deviations.items()},
        },
        "simulation": simulation,
    }
