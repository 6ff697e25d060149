# SPDX-License-Identifier: Apache-2.0
"""The fast bench around a unit that executes the operations of another one.

It takes the place of that unit, in a lane of its own (`fp_lane.sv` here), with the same cases
and references; the table of operations knows one unit per operation.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from sim.core.fpbench import native
from sim.core.fpbench.native import RTL, TOP_SOURCES, Unit, sources
from sim.rtl.build import ROOT

VARIANTS = {"fp_divsqrt_folded": "fp_divsqrt", "fp_sincos_overlapped": "fp_sincos"}
LANE = Path(__file__).with_name("fp_lane.sv")
INTERVALS = ROOT / "rtl/gen/asip_isa_pkg.sv"  # where the lane has the unit's interval from


def lane_sources(unit: str) -> tuple[Path, ...]:
    """Lane and bench above a unit, one of these or one of the fast bench."""
    return (LANE, TOP_SOURCES[1]) if unit in VARIANTS else TOP_SOURCES


def bench_unit(
    name: str,
    rtl: Path = RTL,
    defines: Mapping[str, str] | None = None,
    lanes: int | None = None,
    top: Sequence[Path] | None = None,
) -> Unit:
    """The Verilated lanes of one of these units or of one of the fast bench.

    Arguments as for `Unit`; `top` defaults to `lane_sources`.
    """
    above = lane_sources(name) if top is None else top
    if name not in VARIANTS:
        return Unit(name, rtl, defines, lanes, above)
    own = [path for path in sources(name, rtl) if path not in sources(VARIANTS[name], rtl)]
    return Unit(VARIANTS[name], rtl, defines, lanes, (INTERVALS, *own, *above))


def fingerprint(unit: str) -> str:
    """As `native.fingerprint`, for these units too."""
    if unit not in VARIANTS:
        return native.fingerprint(unit)
    digest = hashlib.sha256(native.fingerprint(VARIANTS[unit]).encode())
    own = [path for path in sources(unit) if path not in sources(VARIANTS[unit])]
    for path in (INTERVALS, LANE, *own):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
