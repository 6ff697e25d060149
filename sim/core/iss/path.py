# SPDX-License-Identifier: Apache-2.0
"""A tracking program run over a recorded path by the instruction-set model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.interface import program_interface
from sim.core.iss.core import Iss
from sim.core.iss.isa import Fault
from sim.robot.parameters import Robot
from sim.robot.records import (
    COUNTS,
    EXPORT_OF_ROW,
    OUTPUTS,
    SET_POINTS,
    STAMPS,
    TRACKING_PROGRAMS,
    SetPoints,
    checked_counts,
)


class PathFault(RuntimeError):
    """A run of the program ended with a fault; the text names tick, cause and bundle."""


@dataclass(frozen=True)
class PathRun:
    """Values (N,) float64 by row of table 3, output and further export; totals over all ticks.

    flags: exceptions {nv, dz, of, uf, nx} raised in any tick; operations and table1: executed in
    one tick (programs without branches: the same in every tick).
    """

    rows: dict[str, NDArray[np.float64]]
    flags: int
    operations: Counter[str]
    table1: dict[str, int]
    bundles: int


def preset(image: Mapping[str, Any], robot: Robot, counts: Sequence[int]) -> dict[str, float]:
    """States before the first tick: the first counts are also the counts of the tick before."""
    names = {state["name"] for state in image["states"]}
    inputs = dict(zip(COUNTS, counts, strict=True))
    values: dict[str, float] = {}
    for program in TRACKING_PROGRAMS:
        values |= program_interface(program).first_states(inputs, robot.values())
    return {name: float(np.float32(values[name])) for name in values if name in names}


def run_path(
    image: Mapping[str, Any],
    robot: Robot,
    path: SetPoints,
    counts: ArrayLike,
    exports: Sequence[str] = (),
    **options: Any,
) -> PathRun:
    """Run a tracking program over N ticks from the start state of the law.

    counts: (N, 5) integers, with stamps (N, 10); exports: further names to record; options: as for
    `Iss`. Raises PathFault at the first fault.
    """
    stamps = [entry["name"] for entry in image["inputs"] if entry["name"] in STAMPS]
    counts = checked_counts(counts, len(path), len(COUNTS) + len(stamps))
    iss = Iss(image, **options)
    iss.set_state(preset(image, robot, counts[0, : len(COUNTS)].tolist()))
    names = (*SET_POINTS, *COUNTS, *stamps)
    read = EXPORT_OF_ROW | {name: name for name in exports}
    recorded: dict[str, list[float]] = {name: [] for name in (*read, *OUTPUTS)}
    flags = 0
    for tick, (words, counted) in enumerate(
        zip(path.words().tolist(), counts.tolist(), strict=True)
    ):
        iss.set_inputs(dict(zip(names, words + counted, strict=True)))
        result = iss.run()
        if result.fault is not Fault.NONE:
            raise PathFault(f"tick {tick}: {result.fault.name} at bundle {result.fault_bundle}")
        flags |= result.flags
        for name, export in read.items():
            recorded[name].append(iss.read(export))
        for name, value in result.outputs.items():
            recorded[name].append(value)
    return PathRun(
        rows={name: np.array(values) for name, values in recorded.items()},
        flags=flags,
        operations=result.counts,
        table1=result.table1,
        bundles=result.bundles,
    )
