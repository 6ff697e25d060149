# SPDX-License-Identifier: Apache-2.0
"""Figures of a step response: rise time, overshoot, settling time, as control textbooks have them
(rise from 10 to 90 % of the step, settled within 2 % of it)."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

LOW, HIGH, BAND = 0.1, 0.9, 0.02


class StepFigures(msgspec.Struct, frozen=True):
    """Times in s since the step; None for what did not happen within the record.

    overshoot: beyond the step's size, by it. final: mean of the last tenth, by the step's size."""

    amplitude: float
    rise: float | None
    peak: float | None
    overshoot: float
    settling: float | None
    final: float


def measure(values: NDArray[np.float64], amplitude: float, period: float) -> StepFigures:
    """Figures of a response (N,) that begins at the tick of the step and goes from its first value
    up by `amplitude` (of either sign, not 0); period: of a tick [s]. N >= 10.

    Crossings are interpolated between two ticks.
    """
    y = (values - values[0]) / amplitude
    begin, end = _crossing(y, LOW), _crossing(y, HIGH)
    highest = int(np.argmax(y))
    outside = np.flatnonzero(np.abs(y - 1.0) > BAND)
    settled = int(outside[-1]) + 1 if outside.size else 0
    return StepFigures(
        amplitude=amplitude,
        rise=None if begin is None or end is None else (end - begin) * period,
        peak=highest * period if y[highest] > 1.0 else None,
        overshoot=max(float(y[highest]) - 1.0, 0.0),
        settling=settled * period if settled < len(y) else None,
        final=float(y[-max(len(y) // 10, 1) :].mean()),
    )


def _crossing(y: NDArray[np.float64], level: float) -> float | None:
    """Index at which y first reaches the level, between two of its values."""
    above = np.flatnonzero(y >= level)
    if not above.size:
        return None
    k = int(above[0])
    return 0.0 if k == 0 else float(k - 1 + (level - y[k - 1]) / (y[k] - y[k - 1]))
