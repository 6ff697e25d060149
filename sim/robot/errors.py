# SPDX-License-Identifier: Apache-2.0
"""Largest numerical error of a result against the double-precision reference, as in table 3, and
the ripple of forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.robot.records import OUTPUTS, TABLE_3, TrackingResult

RIPPLE_ABOVE = 1000.0  # Hz
SETTLING = 0.05  # s at either end that the ripple leaves out


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


def ripple(outputs: NDArray[np.floating], period: float) -> NDArray[np.float64]:
    """Root mean square (5,) of what is above `RIPPLE_ABOVE` in forces and torques (N, 5), one each
    period [s].

    Without the line from the first to the last, by Fourier transform of the whole record. A record
    too short to leave `SETTLING` out at both ends is checked as a whole.
    """
    values = np.asarray(outputs, np.float64)
    ticks = len(values)
    values = values - np.linspace(values[0], values[-1], ticks)
    spectrum = np.fft.rfft(values, axis=0)
    spectrum[np.fft.rfftfreq(ticks, period) < RIPPLE_ABOVE] = 0.0
    high = np.fft.irfft(spectrum, ticks, axis=0)
    skip = round(SETTLING / period)
    high = high[skip : ticks - skip] if ticks > 2 * skip else high
    return np.sqrt(np.mean(high**2, axis=0))
