# SPDX-License-Identifier: Apache-2.0
"""The page of one motor: its recorded start-up, both closed loops, a move, a step of the speed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from sim.bench.drive.axis.identify import rotor_frame
from sim.bench.drive.axis.result import Result
from sim.bench.drive.curves import over_frequency
from sim.laws.drive.clocks import LOOP_PERIOD
from sim.report import provenance
from sim.report.curves import panels
from sim.report.document import Page

LEAD = (
    "One motor with its inverter, brought up from its file: what the start-up has recorded, and "
    "the loops that follow from it. Drag to zoom, double-click to see everything."
)


def write(file: Path, tables: Sequence[Table], result: Result) -> None:
    """Write the page of this bring-up."""
    page = Page(f"Microtick: one {result.one.kind} motor", LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit()})
    page.section("Numbers", "What was found, the gains that follow, and what they reach.")
    for table in tables:
        page.table(table)
    travel, found = result.one.units[0], result.found
    page.section("Start-up", "What the identification has seen of the swings.")
    swings = found.swings
    angle = swings.counts * result.one.resolution * result.one.motor.wave + found.angle
    i_d, i_q = rotor_frame(swings.alpha, swings.beta, angle)
    u_d, u_q = rotor_frame(swings.u_alpha, swings.u_beta, angle)
    rows = [
        ("current [A]", {"d": i_d, "q": i_q}),
        ("voltage [V]", {"d": u_d, "q": u_q}),
        (f"position [{travel}]", {"position": swings.counts * result.one.resolution}),
    ]
    t = LOOP_PERIOD * np.arange(len(swings))
    page.figure(panels(t, rows), "Sensed currents, commanded voltages and counts.")
    page.section("Current loop", "Ordered to sensed current in q, by injection.")
    loop = result.current
    page.figure(over_frequency(loop.frequency, {"current": loop.closed}), _caption(loop))
    page.section("Velocity loop", "Ordered to actual speed, by injection.")
    loop = result.velocity
    page.figure(over_frequency(loop.frequency, {"velocity": loop.closed}), _caption(loop))
    if result.move is None:
        page.section("Moves", "Both loops closed. " + result.not_done["position after a move"])
    else:
        page.section("Moves", "Both loops closed, the position held.")
        record, wanted = result.move
        error = (record.counts - wanted) * result.one.resolution
        curves = {"wanted": wanted, "actual": record.counts}
        scaled = {name: rows * result.one.resolution for name, rows in curves.items()}
        rows = [(f"position [{travel}]", scaled), (f"error [{travel}]", {"error": error})]
        page.figure(panels(LOOP_PERIOD * np.arange(len(wanted)), rows), "A move.")
    actual, ordered, rise, overshoot = result.step
    rows = [(f"speed [{travel}/s]", {"actual": actual, "ordered": ordered})]
    page.figure(
        panels(LOOP_PERIOD * np.arange(len(actual)), rows),
        f"A step of the speed: 10 % to 90 % in {1e3 * rise:.2f} ms, {100 * overshoot:.0f} % over.",
    )
    page.write(file)


def _caption(loop) -> str:
    return f"-3 dB at {loop.bandwidth:.0f} Hz, phase margin {loop.margin:.0f} degrees."
