# SPDX-License-Identifier: Apache-2.0
"""Table and page of `microtick robots`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from rich.table import Table

from asip_asm.isa import default_isa
from sim.bench.shown_robots.job import Row
from sim.report.curves import framed, panels
from sim.report.document import Page

LEAD = (
    "Each robot's law was compiled from symbolic expressions into a program of the core, compared "
    "bit by bit with an own interpreter and with double precision, and then ran on the core's RTL "
    "against a simulated robot."
)


def table(rows: Sequence[Row]) -> Table:
    """The figures, a row per robot."""
    found = Table(title="Robots and laws on the core")
    for heading in (
        "robot", "core", "operations", "cycles", "bound", "as written", "µs", "error/bound",
        "inputs", "bits", "ticks", "worst axis", "error", "to double",
    ):  # fmt: skip
        found.add_column(heading, justify="left" if heading in ("robot", "core") else "right")
    for row in rows:
        data = row.as_json()
        loop = data["closed_loop"]
        worst = loop["axes"][loop["worst_axis"]]
        found.add_row(
            row.name,
            data["configuration"],
            str(data["core_operations"]),
            str(data["cycles"]),
            str(data["bound_cycles"]),
            "-" if row.plain_cycles is None else str(row.plain_cycles),
            f"{data['microseconds']:.3f}",
            f"{data['worst_fraction_of_bound']:.3f}",
            str(data["inputs_tried"]),
            "equal" if data["bits_equal"] else "[red]differ[/]",
            str(loop["ticks"]),
            loop["worst_axis"],
            f"{worst['rms_error']:.2g} {worst['unit']}",
            f"{loop['ratio_to_double']:.4f}",
        )
    found.caption = (
        f"Time at {default_isa().clock_mhz} MHz. As written: without --reassociate and "
        "--reciprocal. Error: root mean square of the tracking error with the program on the core, "
        "behind the start of the motion; to double: by that of the same law in double precision; "
        "of the axis where this is largest."
    )
    return found


def write_page(rows: Sequence[Row], goals: Sequence[dict[str, Any]], file: Path) -> None:
    """The page with table, goals and a plot of each closed loop."""
    page = Page("Microtick: any robot, any law", LEAD)
    missed = [goal["name"] for goal in goals if not goal["met"]]
    if missed:
        page.alarm("Goals that are not met:", missed)
    page.table(table(rows))
    page.figure(_bars(rows), "Cycles of a tick next to the largest lower bound of the schedule.")
    for row in rows:
        page.section(row.name, row.about or row.built.compiled.law.doc)
        t = np.arange(row.loop.ticks) / row.rate
        errors, outputs = row.loop.core.errors, row.loop.core.outputs
        double = row.loop.double.errors
        ports = row.built.compiled.law.of_kind("output")
        names = row.outputs or [port.name for port in ports]
        axes = [f"{name} [{unit}]" for name, unit in row.loop.axes.items()]
        curves = [
            ("error", dict(zip(axes, errors.T, strict=True))),
            ("core less double", dict(zip(axes, (errors - double).T, strict=True))),
            ("outputs", {n: o for n, o in zip(names, outputs.T, strict=True)}),
        ]
        page.figure(panels(t, curves), "Tracking errors on the core, how far the run in double "
                    "precision is from them, and the outputs.")  # fmt: skip
        page.text("program, as the compiler wrote it", row.built.compiled.text)
        page.text("report of the assembler", row.built.report.render())
    page.write(file)


def _bars(rows: Sequence[Row]) -> go.Figure:
    names = [row.name for row in rows]
    figure = go.Figure()
    figure.add_bar(x=names, y=[row.built.cycles for row in rows], name="cycles")
    figure.add_bar(x=names, y=[row.built.bound_cycles for row in rows], name="lower bound")
    return framed(figure, 320)
