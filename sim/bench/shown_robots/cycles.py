# SPDX-License-Identifier: Apache-2.0
"""Cycles of the shown robots' laws, which no change may raise."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from asip_asm.model.compiler import compile_law
from asip_asm.model.program import build
from sim.bench.shown_robots.job import OPTIONS, PROGRAMS, SHOWN, written_cycles
from sim.laws.catalogue import robot
from sim.laws.laws import OVERSHOOT, Settings, computed_torque
from sim.report.goals import Goal, at_most

MOST = {"own_printed": 163, "own_optimised": 120, "iiwa14": 231, "panda": 277, "ur5": 218}
"""Cycles of a tick of a compiled law, within the stated ranges."""
WRITTEN = {"tracking_as_printed": 204, "tracking_optimised": 111}
"""Cycles of a tick of the own robot's hand-written programs."""
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
    for name, most in WRITTEN.items():
        cycles = written_cycles(PROGRAMS / f"{name}.s")
        yield at_most(f"hand-written {name}, tick", cycles, most, "cycles")
