# SPDX-License-Identifier: Apache-2.0
"""The page of `microtick bus`: the table, and the tool on its path over the bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from sim.bus import path_page
from sim.bus.path_run import Curves
from sim.report import provenance
from sim.report.document import Page

TITLE = "Microtick: five axes on the bus"
LEAD = (
    "An EtherCAT-compatible slave in RTL, its application on the Nios II core and the law on the "
    "ASIP, every clock of them, driven by pysoem. Drag to zoom, double-click to see everything."
)


def write(file: Path, table: Table, curves: Path | None) -> None:
    """Write the page of these rows; curves: what sim.bus.path_run has saved."""
    page = Page(TITLE, LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit()})
    page.section("Numbers", "What was to be reached, and what this run has measured.")
    page.table(table)
    if curves is not None and curves.exists():
        with np.load(curves) as found:
            path_page.show(
                page,
                Curves(**found),
                "Targets each millisecond in CSP, interpolated to 10 kHz by the device.",
            )
    page.write(file)
