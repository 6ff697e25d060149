# SPDX-License-Identifier: Apache-2.0
"""The page of `microtick bus`: the table, and the tool on its path over the bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from rich.table import Table

from sim.report import provenance
from sim.report.curves import box, framed, panels
from sim.report.document import Page

TITLE = "Microtick: five axes on the bus"
LEAD = (
    "An EtherCAT-compatible slave in RTL, its application on the Nios II core and the law on the "
    "ASIP, every clock of them, driven by pysoem. Drag to zoom, double-click to see everything."
)
PERIOD = 1e-4  # of a control tick [s]
POINTS = 4_000


def write(file: Path, table: Table, curves: Path | None) -> None:
    """Write the page of these rows; curves: what sim.bus.path_run has saved."""
    page = Page(TITLE, LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit()})
    page.section("Numbers", "What was to be reached, and what this run has measured.")
    page.table(table)
    if curves is not None and curves.exists():
        with np.load(curves) as found:
            _path(page, found["wanted"], found["tool"], found["wanted_table"], found["table"])
    page.write(file)


def _path(
    page: Page, wanted: np.ndarray, tool: np.ndarray, wanted_table: np.ndarray, table: np.ndarray
) -> None:
    page.section("Path", "Targets each millisecond in CSP, interpolated to 10 kHz by the device.")
    seconds = PERIOD * np.arange(len(tool))
    error = 1e6 * (tool - wanted)
    size = {"tool": np.linalg.norm(error, axis=1)}
    parts = {name: error[:, n] for n, name in enumerate("xyz")}
    angles = 1e6 * (table - wanted_table)
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
