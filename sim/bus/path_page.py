# SPDX-License-Identifier: Apache-2.0
"""The part of a page that shows the tool and the table on a path over the bus."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from sim.bus.path_run import Curves
from sim.report.curves import box, framed, panels
from sim.report.document import Page

PERIOD = 1e-4  # of a control tick [s]
POINTS = 4_000


def show(page: Page, curves: Curves, sentence: str) -> None:
    """Errors over time, and the tool in space."""
    page.section("Path", sentence)
    tool = curves.tool
    seconds = PERIOD * np.arange(len(tool))
    error = 1e6 * (tool - curves.wanted)
    size = {"tool": np.linalg.norm(error, axis=1)}
    parts = {name: error[:, n] for n, name in enumerate("xyz")}
    angles = 1e6 * (curves.table - curves.wanted_table)
    turned = {name: angles[:, n] for n, name in enumerate(("tilt", "rotation"))}
    rows = [("distance [um]", size), ("error [um]", parts), ("table [urad]", turned)]
    page.figure(
        panels(seconds, rows),
        "Exact tool and table against the path that the master sends, 2.6 ms later.",
    )
    step = max(1, len(tool) // POINTS)
    figure = go.Figure()
    figure.add_scatter3d(
        **dict(zip("xyz", 1e3 * tool[::step].T, strict=True)), mode="lines", name="tool"
    )
    low, high = box(1e3 * tool)
    scene = {
        f"{name}axis": {"range": [low[n], high[n]], "title": f"{name} [mm]"}
        for n, name in enumerate("xyz")
    }
    figure.update_layout(scene={**scene, "aspectmode": "data"})
    page.figure(framed(figure, 520), "The tool on its path.", square=True)
