# SPDX-License-Identifier: Apache-2.0
"""The planner and the sampler on the Verilated core: asip_asm/programs/planner_*.s."""

from __future__ import annotations

from pathlib import Path

from sim.core.api import Core

PROGRAMS = Path(__file__).parents[3] / "asip_asm/programs"
PARAMETERS = ("v0", "vm", "tr", "tm", "L")
ERRORS = (
    "no error",
    "not 0 < vm < 1e30",
    "not 0 <= v0 <= vm",
    "not 0 < tr < 1e30",
    "not 0 <= tm <= tr/2",
    "not 0 < L < 1e30",
    "acceleration, jerk or cruise time is not below 1e30",
)


def planner_program(name: str, configuration: str = "fast") -> Core:
    """One of the planner's programs on its own core, configuration 'fast' or 'small'."""
    return Core(PROGRAMS / f"{name}.s", configuration=configuration)
