# SPDX-License-Identifier: Apache-2.0
"""Curves over many ticks as interactive figures: thinned out so that every peak stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

POINTS = 6_000  # of a curve at most
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
PANEL_HEIGHT, FRAME_HEIGHT = 150, 110  # px
INK = "#1a1a1a"
GRID = "#dddddd"
FLATTEST = 0.1  # least side of the box around points in space, by its largest


def envelope(values: NDArray, most: int = POINTS) -> NDArray[np.int64]:
    """Indices (M <= most + 2) that keep the smallest and largest value of every interval.

    values (N,), N > 0. The intervals are of equal length; first and last index stay.
    """
    n = len(values)
    if n <= most:
        return np.arange(n)
    step = -(-2 * n // most)
    rows = np.pad(values, (0, -n % step), mode="edge").reshape(-1, step)
    begin = np.arange(len(rows)) * step
    extremes = np.concatenate([begin + rows.argmin(axis=1), begin + rows.argmax(axis=1)])
    return np.unique(np.concatenate([[0], np.minimum(extremes, n - 1), [n - 1]]))


def box(points: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower and upper corner (3,) of a box around points (N, 3) with some air, flat on no side."""
    low, high = points.min(axis=0), points.max(axis=0)
    least = max(FLATTEST * float((high - low).max()), 1e-3)
    half = np.maximum(high - low, least) * 0.55
    return (low + high) / 2 - half, (low + high) / 2 + half


def panels(
    x: NDArray,
    rows: Sequence[tuple[str, Mapping[str, NDArray]]],
    x_title: str = "time [s]",
    hidden: Sequence[str] = (),
) -> go.Figure:
    """Panels below each other with one x axis: title of the y axis, and curves (N,) by name.

    A name has one colour and one entry of the legend; `hidden` ones are drawn when clicked there.
    """
    names = list(dict.fromkeys(name for _, curves in rows for name in curves))
    figure = make_subplots(rows=len(rows), cols=1, shared_xaxes=True, vertical_spacing=0.03)
    listed: set[str] = set()
    for row, (title, curves) in enumerate(rows, start=1):
        figure.update_yaxes(title_text=title, row=row, col=1)
        for name, values in curves.items():
            kept = envelope(values)
            figure.add_scatter(
                x=x[kept].astype(np.float32),
                y=values[kept].astype(np.float32),
                name=name,
                legendgroup=name,
                showlegend=len(names) > 1 and name not in listed,
                visible="legendonly" if name in hidden else True,
                line={"color": COLOURS[names.index(name) % len(COLOURS)], "width": 1},
                row=row,
                col=1,
            )
            listed.add(name)
    figure.update_xaxes(title_text=x_title, row=len(rows), col=1)
    return framed(figure, FRAME_HEIGHT + PANEL_HEIGHT * len(rows))


def framed(figure: go.Figure, height: int) -> go.Figure:
    """The figure in the common look: dark text on white, legend above, nothing clipped."""
    axis = {"gridcolor": GRID, "linecolor": INK, "zeroline": False, "automargin": True}
    figure.update_xaxes(**axis, title_standoff=4)
    figure.update_yaxes(**axis, title_standoff=6)
    figure.update_layout(
        template="none",
        height=height,
        font={"family": "system-ui, sans-serif", "size": 13, "color": INK},
        paper_bgcolor="white",
        plot_bgcolor="white",
        margin={"l": 60, "r": 15, "t": 45, "b": 50},
        legend={"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom", "xanchor": "left"},
        hovermode="closest",
    )
    return figure
