# SPDX-License-Identifier: Apache-2.0
"""A tracking program run over a recorded path by the instruction-set model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.iss.core import TABLE_1, Iss
from sim.iss.isa import Fault
from sim.model.parameters import Robot
from sim.model.records import OUTPUTS, TABLE_3, SetPoints, checked_counts

SET_POINT_INPUTS = (
    *("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az"),
    *("alpha", "gamma", "w_alpha", "w_gamma", "eps_alpha", "eps_gamma"),
)
"""Inputs of the tracking programs in the order of `SetPoints`; count1..count5 follow."""

EXPORT_OF_ROW = dict(
    zip(
        TABLE_3,
        (
            *("l1", "l2", "l3", "alpha", "gamma"),
            *("v1", "v2", "v3", "w_alpha", "w_gamma"),
            *("acc1", "acc2", "acc3", "eps_alpha", "eps_gamma"),
        ),
        strict=True,
    )
)
"""Row of table 3 -> export; 'a1' cannot be an export, it names a register."""


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
    values: dict[str, float] = {}
    for axis, count in enumerate(counts):
        single = np.float32(count)
        values[f"count{axis + 1}_before"] = float(single)
        position = np.float32(count * robot.resolution[axis])
        values[f"position{axis + 1}_before"] = float(position)
    return {name: value for name, value in values.items() if name in names}


def run_path(
    image: Mapping[str, Any],
    robot: Robot,
    path: SetPoints,
    counts: ArrayLike,
    exports: Sequence[str] = (),
    **options: Any,
) -> PathRun:
    """Run a tracking program over N ticks from the start state of the law.

    counts: (N, 5) integers; exports: further names to record; options: as for `Iss`. Raises
    PathFault at the first fault.
    """
    counts = checked_counts(counts, len(path))
    iss = Iss(image, **options)
    iss.set_state(preset(image, robot, counts[0].tolist()))
    names = (*SET_POINT_INPUTS, *(f"count{axis}" for axis in range(1, 6)))
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
    empty = dict.fromkeys(TABLE_1, 0)
    return PathRun(
        rows={name: np.array(values) for name, values in recorded.items()},
        flags=flags,
        operations=result.counts if len(path) else Counter(),
        table1=result.table1 if len(path) else empty,
        bundles=result.bundles if len(path) else 0,
    )
