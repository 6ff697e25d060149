# SPDX-License-Identifier: Apache-2.0
"""The page of a run of LinuxCNC against the machine, and its figures in lines of text."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sim.bus import path_page
from sim.bus.linuxcnc.config import DEGREE, MM, TABLE_AXES
from sim.bus.linuxcnc.result import Run
from sim.report import provenance
from sim.report.curves import panels
from sim.report.document import Page

TITLE = "Microtick: LinuxCNC drives the machine"
LEAD = (
    "LinuxCNC 2.9, unmodified, plays a program. pysoem hands the targets of its servo thread to "
    "the slave in RTL each millisecond. Drag to zoom, double-click to see everything."
)
AXES = "XYZAC"


def facts(report: Mapping[str, Any]) -> dict[str, str]:
    """What is measured, in words."""
    linear = MM * max(report["following"][:TABLE_AXES])
    angular = DEGREE * max(report["following"][TABLE_AXES:])
    found = {
        "program": f"{report['program']}, {report['periods'] / 1000:g} s in LinuxCNC",
        "tool error": f"{1e6 * report['tool_error']:.3f} um",
        "table error": f"{1e6 * report['table_error']:.1f} urad",
        "LinuxCNC's following error": f"{linear:.4f} mm, {angular:.4f} degrees",
        "faults by following errors": str(report["following_faults"]),
        "servo periods lost": str(report["lost"]),
        "longest control pass": f"{report['longest_pass']} of 10000 cycles",
        "slave at the end": f"AL state {report['al_state']:02X}, code {report['al_code']:04X}",
        "statuswords at the end": " ".join(f"{word:04X}" for word in report["statuswords"]),
    }
    if "off_program" in report:
        found["LinuxCNC's targets from our own path"] = f"{1e6 * report['off_program']:.3f} um"
    if after := report["after_fault"]:
        brakes = after["brakes_after"]
        found |= {
            "fault": after["kind"],
            "the robot stands after": f"{after['stands_after'] / 10:g} ms, "
            f"{MM * after['distance']:.3f} mm",
            "brakes closed after": "never" if brakes is None else f"{brakes / 10:g} ms",
            "LinuxCNC": after["linuxcnc"],
            "error codes": " ".join(f"{code:04X}" for code in report["error_codes"]),
        }
    found |= {f"message {n}": text for n, text in enumerate(report["messages"], start=1)}
    return found


def summary(report: Mapping[str, Any]) -> str:
    """The facts for a terminal."""
    return "\n".join(f"{name:38}{value}" for name, value in facts(report).items())


def write(file: Path, report: Mapping[str, Any], run: Run) -> None:
    """Write the page."""
    page = Page(TITLE, LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit(), **facts(report)})
    page.section(
        "LinuxCNC's targets", "One in each servo period of 1 ms, and what it sees of them."
    )
    log = run.log[run.frames()[0] :]
    seconds = np.arange(len(log)) / 1000
    units = np.array([MM] * TABLE_AXES + [DEGREE] * (len(AXES) - TABLE_AXES))
    target, away = log["target"] * units, (log["target"] - log["position"]) * units
    groups = ((slice(0, TABLE_AXES), "mm"), (slice(TABLE_AXES, None), "degrees"))
    rows = []
    for what, values in (("target", target), ("following", away)):
        for axes, unit in groups:
            curves = dict(zip(AXES[axes], values.T[axes], strict=True))
            rows.append((f"{what} [{unit}]", curves))
    page.figure(panels(seconds, rows), "From the begin of the program until LinuxCNC is off.")
    path_page.show(page, run.curves(), "LinuxCNC's targets, interpolated to 10 kHz by the device.")
    page.write(file)
