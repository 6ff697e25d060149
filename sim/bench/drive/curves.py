# SPDX-License-Identifier: Apache-2.0
"""Frequency responses as figures, for the pages of the drives."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from sim.report.curves import panels


def over_frequency(frequency: NDArray, closed: dict[str, NDArray], *more: tuple) -> go.Figure:
    """Size and phase of closed loops by their names, and more rows."""
    size = {name: 20 * np.log10(np.abs(loop)) for name, loop in closed.items()}
    phase = {name: np.degrees(np.unwrap(np.angle(loop))) for name, loop in closed.items()}
    rows = [("size [dB]", size), ("phase [degrees]", phase), *more]
    figure = panels(frequency, rows, "frequency [Hz]")
    figure.update_xaxes(type="log")
    return figure
