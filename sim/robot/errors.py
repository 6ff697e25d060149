# SPDX-License-Identifier: Apache-2.0
"""Largest numerical error of a result against the double-precision reference, as in table 3."""

from __future__ import annotations

import numpy as np

from sim.robot.records import OUTPUTS, TABLE_3, TrackingResult


def max_abs_error(reference: TrackingResult, result: TrackingResult) -> dict[str, float]:
    """Row name -> largest absolute difference over all ticks, SI units, NaN if any value is NaN.

    Rows: `records.TABLE_3`, then `records.OUTPUTS`. Raises ValueError for other tick counts.
    """
    ours, theirs = np.shape(reference.output), np.shape(result.output)
    if ours != theirs:
        raise ValueError(f"result has the shape {theirs}, the reference {ours}")
    return {
        name: float(
            np.max(np.abs(result.row(name).astype(np.float64) - reference.row(name)), initial=0.0)
        )
        for name in TABLE_3 + OUTPUTS
    }
