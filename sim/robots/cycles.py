# SPDX-License-Identifier: Apache-2.0
"""Cycles of the shown robots' laws, which no change may raise."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from asip_asm.model.compiler import compile_law
from asip_asm.model.program import build
from sim.goals import Goal, at_most
from sim.robots.catalogue import robot
from sim.robots.job import OPTIONS, SHOWN
from sim.robots.laws import OVERSHOOT, Settings, computed_torque

MOST = {"own_printed": 204, "own_optimised": 111, "iiwa14": 231, "panda": 277, "ur5": 218}
"""Cycles of a tick within the stated ranges."""
COUNTS = {"panda": 1 << 21}


def rows(full: bool) -> Iterator[Goal]:
    """Cycles of each, and in the note those of a law that is right over twice the stated ranges."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "law.s"
        for name, most in MOST.items():
            cycles = build(compile_law(SHOWN[name].law(), OPTIONS), file).cycles
            note = ""
            if not name.startswith("own"):
                settings = replace(Settings(), counts=COUNTS.get(name, Settings().counts))
                law = computed_torque(robot(name), settings)
                more = build(compile_law(law, OPTIONS), file).cycles
                note = f"{more} cycles over {OVERSHOOT:g} times the stated ranges (--overshoot)"
            yield at_most(f"{name}, tick", cycles, most, "cycles", note)
