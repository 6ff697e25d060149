# SPDX-License-Identifier: Apache-2.0
"""Cycles of the shown robots' laws, which no change may raise."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from asip_asm.model.compiler import compile_law
from asip_asm.model.law import Law
from asip_asm.model.program import build
from sim.bench.shown_robots.job import OPTIONS, PROGRAMS, SHOWN, written_cycles
from sim.laws.catalogue import robot
from sim.laws.laws import OVERSHOOT, Settings, computed_torque
from sim.report.goals import Goal, at_most

MOST = {"own_printed": 163, "own_optimised": 120, "iiwa14": 231, "panda": 277, "ur5": 218}
"""Cycles of a tick of a compiled law."""
WRITTEN = {"tracking_as_printed": 204, "tracking_optimised": 111}
"""Cycles of a tick of the own robot's hand-written programs."""
COUNTS = {"panda": 1 << 21}


def arm_law(name: str, overshoot: float) -> Law:
    """Computed torque of a shown arm, right over so many times its stated ranges."""
    settings = Settings(counts=COUNTS.get(name, Settings().counts), overshoot=overshoot)
    return computed_torque(robot(name), settings)


def rows(full: bool) -> Iterator[Goal]:
    """Cycles of each law; of the arms over the stated ranges, and with the default options."""
    with tempfile.TemporaryDirectory() as folder:

        def cycles(law: Law) -> int:
            return build(compile_law(law, OPTIONS), Path(folder) / "law.s").cycles

        for name, most in MOST.items():
            if name.startswith("own"):
                yield at_most(f"{name}, tick", cycles(SHOWN[name].law()), most, "cycles")
                continue
            stated, default = (cycles(arm_law(name, times)) for times in (1.0, OVERSHOOT))
            yield at_most(f"{name}, tick, stated ranges (--overshoot 1)", stated, most, "cycles")
            yield at_most(f"{name}, tick, default options", default, most, "cycles")
    for name, most in WRITTEN.items():
        yield at_most(
            f"hand-written {name}, tick", written_cycles(PROGRAMS / f"{name}.s"), most, "cycles"
        )
