# SPDX-License-Identifier: Apache-2.0
"""The page of `microtick drive`: pictures of steps, frequency responses, reversals, harmonics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from rich.table import Table

from sim.bench.drive.chain import CONTROL_PERIOD
from sim.bench.drive.curves import over_frequency
from sim.bench.drive.goals import Shown
from sim.bench.drive.plant import AXES, NAMES
from sim.bench.drive.position import SHOWN
from sim.bench.drive.sample import Sample
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.report import provenance
from sim.report.curves import envelope, framed, panels
from sim.report.document import Page

TITLE = "Microtick: motor drives in closed loop"
LEAD = (
    "Five motors from encoder edges to gate edges: current loops at 100 kHz, a tracking law at "
    "10 kHz, inverters with dead time, friction. Drag to zoom, double-click to see everything."
)
PERIOD = HALF_PERIOD * CLOCK  # of a half period [s]
TICK = CONTROL_PERIOD * CLOCK  # of the control law [s]
AROUND = 0.06  # shown around a reversal [s]


def write(file: Path, table: Table, shown: Shown) -> None:
    """Write the page of these measurements."""
    page = Page(TITLE, LEAD)
    page.facts({"date": provenance.now(), "commit": provenance.commit()})
    page.section("Numbers", "What was to be reached, and what this run has measured.")
    page.table(table)
    page.section("Current loops", "Brakes closed, dead time and noise on.")
    t = 1e6 * PERIOD * (np.arange(len(shown.loops.step)) - 10)
    curves = {name: shown.loops.step[:, n] for n, name in enumerate(NAMES)}
    page.figure(
        panels(t, [("i_q [A]", curves)], "time [us]"),
        "Step of the ordered current, RTL at every clock: means of half periods.",
    )
    page.figure(_bode(shown), "Closed current loops: ordered to actual i_q.")
    page.section("Position loops", "Tracking law with friction feed-forward, averaged inverters.")
    page.figure(
        _positions(shown),
        "Desired to actual joint. Alone: set-points without speed and acceleration, the loop "
        "itself. Below, the error as a share of the motion with set-points as a path has them.",
    )
    page.section("Path", "Errors of the joints with and without friction in the law.")
    page.figure(_whole(shown), "Friction feed-forward: errors along the path of this run.")
    for n, unit, scale in ((2, "um", 1e6), (4, "urad", 1e6)):
        page.figure(*_reversal(shown, n, unit, scale))
    page.section("Chain", "Every clock of the RTL on the path of reversals.")
    halves, begin = _around_reversal(shown.samples["feed-forward"])
    page.figure(
        panels(
            begin + PERIOD * np.arange(len(halves)),
            [
                ("i_q [A]", {name: halves["i_q"][:, n] for n, name in enumerate(NAMES)}),
                ("duty, leg 1", {k: halves["duty"][:, 0, i] for i, k in enumerate("abc")}),
            ],
        ),
        "Currents and duty around a reversal of leg 1, or from the start: means of half periods.",
    )
    for n, unit, scale in ((0, "um", 1e6), (3, "urad", 1e6)):
        laws = {kind: scale * piece.error[:, n] for kind, piece in shown.samples.items()}
        laws["feed-forward, averaged"] = scale * shown.samples["feed-forward"].averaged_error[:, n]
        t = TICK * np.arange(len(laws["feed-forward"]))
        page.figure(panels(t, [(f"error [{unit}]", laws)]), f"{NAMES[n]} on the RTL.")
    page.figure(_harmonics(shown), "Spectrum of the currents' error in the chain: i_d of all axes.")
    page.write(file)


def _around_reversal(sample: Sample) -> tuple[NDArray[np.void], float]:
    """Half periods, and the time of the first [s]."""
    near = np.flatnonzero(sample.near[:, 0])
    first = round(max(0.0, near[0] * TICK - AROUND / 2) / PERIOD) if near.size else 0
    return sample.rtl.halves[first : first + round(2 * AROUND / PERIOD)], first * PERIOD


def _bode(shown: Shown) -> go.Figure:
    loops = shown.loops.responses
    closed = {name: loop.closed for name, loop in zip(NAMES, loops, strict=True)}
    return over_frequency(loops[0].frequency, closed)


def _positions(shown: Shown) -> go.Figure:
    found = shown.positions
    names = [NAMES[n] for n in SHOWN]
    alone = {name: found.alone[:, k] for k, name in enumerate(names)}
    error = {name: 20 * np.log10(np.abs(1 - found.fed[:, k])) for k, name in enumerate(names)}
    return over_frequency(found.frequency, alone, ("error [dB]", error))


def _whole(shown: Shown) -> go.Figure:
    law = shown.laws["feed-forward", 1.0]
    t = TICK * np.arange(len(law.error))
    rows = [
        ("legs [um]", {name: 1e6 * law.error[:, n] for n, name in enumerate(NAMES[:3])}),
        ("tool [um]", {"tool": 1e6 * law.tool}),
        ("table [urad]", {NAMES[n]: 1e6 * law.error[:, n] for n in (3, 4)}),
    ]
    return panels(t, rows)


def _reversal(shown: Shown, n: int, unit: str, scale: float) -> tuple[go.Figure, str]:
    """Around the greatest error without friction in the law."""
    plain = shown.laws["none", 1.0].error[:, n]
    worst = 500 + int(np.abs(plain[500:]).argmax())
    ticks = round(AROUND / TICK)
    part = slice(max(0, worst - ticks), worst + ticks)
    t = TICK * np.arange(len(plain))[part]
    curves = {
        kind if share == 1.0 else f"{kind}, {share:g} of the friction": scale * law.error[part, n]
        for (kind, share), law in shown.laws.items()
    }
    figure = panels(t, [(f"error [{unit}]", curves)])
    return figure, f"{NAMES[n]}: around its largest error without friction in the law."


def _harmonics(shown: Shown) -> go.Figure:
    i_d = shown.samples["feed-forward"].rtl.halves["i_d"][1000:]
    window = np.hanning(len(i_d))[:, None]
    spectrum = np.abs(np.fft.rfft((i_d - i_d.mean(axis=0)) * window, axis=0)) * 4 / len(i_d)
    frequency = np.fft.rfftfreq(len(i_d), PERIOD)
    figure = go.Figure()
    for n in range(AXES):
        keep = envelope(spectrum[1:, n]) + 1
        figure.add_scatter(x=frequency[keep], y=1e3 * spectrum[keep, n], name=NAMES[n])
    figure.update_xaxes(type="log", title="frequency [Hz]")
    figure.update_yaxes(title="amplitude [mA]")
    return framed(figure, 380)
