# SPDX-License-Identifier: Apache-2.0
"""The fast bench around fp_divsqrt_folded, which executes the operations of fp_divsqrt.

It stands in the place of fp_divsqrt, in a lane of its own (`fp_lane.sv` here), with the same cases
and references; the table of operations knows one unit per operation.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from sim.fpbench.native import RTL, TOP_SOURCES, Unit, sources
from sim.harness.build import ROOT

NAME = "fp_divsqrt_folded"
SAME_AS = "fp_divsqrt"
LANE = Path(__file__).with_name("fp_lane.sv")
INTERVALS = ROOT / "rtl/gen/asip_isa_pkg.sv"  # where the lane has the unit's interval from


def top_sources(rtl: Path = RTL) -> tuple[Path, ...]:
    """What stands above the building blocks of fp_divsqrt: this unit, its lane, the bench."""
    own = [path for path in sources(NAME, rtl) if path not in sources(SAME_AS, rtl)]
    return (INTERVALS, *own, LANE, TOP_SOURCES[1])


def folded_unit(
    rtl: Path = RTL, defines: Mapping[str, str] | None = None, lanes: int | None = None
) -> Unit:
    """The Verilated lanes of the folded unit; operations `div` and `sqrt`, arguments as `Unit`."""
    return Unit(SAME_AS, rtl, defines, lanes, top_sources(rtl))
