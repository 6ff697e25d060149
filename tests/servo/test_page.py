# SPDX-License-Identifier: Apache-2.0
"""The page of the drives: every picture that it should have, from measurements made up here."""

from __future__ import annotations

import numpy as np
import pytest
from rich.table import Table

from sim.bench.drive import page
from sim.bench.drive.chain import HALF
from sim.bench.drive.goals import LAWS, Loops, Shown
from sim.bench.drive.position import PositionLoops
from sim.bench.drive.recording import Recording
from sim.bench.drive.response import Response
from sim.bench.drive.sample import Sample
from sim.bench.drive.whole import Whole
from sim.core.closed_loop import Tracking
from sim.robot.records import SetPoints

TICKS = 2000
PICTURES = (
    "Step of the ordered current",
    "Closed current loops",
    "Desired to actual joint",
    "errors along the path of this run",
    "leg 3: around its largest error",
    "rotation: around its largest error",
    "Currents and duty around a reversal",
    "leg 1 on the RTL",
    "tilt on the RTL",
    "Spectrum of the currents' error",
)


@pytest.mark.parametrize("reverses", [True, False])
def test_page__has_every_picture(tmp_path, reverses):
    random = np.random.default_rng(1)
    frequency = np.geomspace(200, 2e4, 20)
    closed = 1 / (1 + 2j * frequency / 1e4)
    loops = Loops(random.normal(size=(130, 5)), [Response(frequency, closed, 5e3, 60.0)] * 5)
    columns = np.stack([closed] * 3, axis=1)
    path = SetPoints.from_words(np.zeros((TICKS, 15)))
    error, tool = 1e-6 * random.normal(size=(TICKS, 5)), np.full(TICKS, 1e-6)
    law = Whole(error, tool, Tracking(1e-6, 1e-6, 1e-5), 1e-6, 1e-5)
    near = np.zeros((TICKS, 5), dtype=bool)
    near[1000:1100] = reverses
    none = [np.array(0)] * 6
    halves = np.zeros(10 * TICKS, dtype=HALF)
    rtl = Recording(error, error[:, :3], error.astype(np.float32), halves, *none)
    sample = Sample(error, error, tool, near, rtl, error[0])
    shown = Shown(
        loops,
        PositionLoops(frequency, columns, columns),
        path,
        dict.fromkeys(LAWS, law),
        {"feed-forward": sample},
    )
    table = Table("goal")
    table.add_row("a row of the goals")
    page.write(tmp_path / "drive.html", table, shown)
    text = (tmp_path / "drive.html").read_text(encoding="utf-8").replace("&#x27;", "'")
    for picture in (*PICTURES, "a row of the goals"):
        assert text.count(picture) == 1, picture
