# SPDX-License-Identifier: Apache-2.0
"""The fast bench around fp_divsqrt_folded, which executes the operations of fp_divsqrt.

It stands in the place of fp_divsqrt, in a lane of its own (`fp_lane.sv` here), with the same cases
and references; the table of operations knows one unit per operation.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from sim.fpbench import native
from sim.fpbench.directed import rows_of
from sim.fpbench.native import RTL, TOP_SOURCES, Report, Unit, sources
from sim.fpbench.quick import merged, parts, quick
from sim.harness.build import ROOT

NAME = "fp_divsqrt_folded"
SAME_AS = "fp_divsqrt"
LANE = Path(__file__).with_name("fp_lane.sv")
INTERVALS = ROOT / "rtl/gen/asip_isa_pkg.sv"  # where the lane has the unit's interval from


def lane_sources(unit: str) -> tuple[Path, ...]:
    """Lane and bench above a unit, this one or one of the fast bench."""
    return (LANE, TOP_SOURCES[1]) if unit == NAME else TOP_SOURCES


def bench_unit(
    name: str,
    rtl: Path = RTL,
    defines: Mapping[str, str] | None = None,
    lanes: int | None = None,
    top: Sequence[Path] | None = None,
) -> Unit:
    """The Verilated lanes of this unit (operations `div` and `sqrt`) or of one of the fast bench.

    Arguments as for `Unit`; `top` defaults to `lane_sources`.
    """
    above = lane_sources(name) if top is None else top
    if name != NAME:
        return Unit(name, rtl, defines, lanes, above)
    own = [path for path in sources(NAME, rtl) if path not in sources(SAME_AS, rtl)]
    return Unit(SAME_AS, rtl, defines, lanes, (INTERVALS, *own, *above))


def short_set(
    name: str,
    op: str,
    rtl: Path = RTL,
    defines: Mapping[str, str] | None = None,
    seed: int = 1,
    cases: int | None = None,
) -> Report:
    """As `quick`, with the operation executed by this unit if that is its name."""
    if name != NAME:
        return quick(op, rtl, defines, seed, cases)
    unit = bench_unit(name, rtl, defines)
    reports = [unit.run_list(op, rows_of(op))]
    for part in parts(unit, op, seed, cases):
        reports.append(unit.run(op, part.kind, part.start, part.count, part.seed, part.gaps))
    return merged(reports, "quick", seed)


def fingerprint(unit: str) -> str:
    """As `native.fingerprint`, for this unit too."""
    if unit != NAME:
        return native.fingerprint(unit)
    digest = hashlib.sha256(native.fingerprint(SAME_AS).encode())
    for path in (INTERVALS, LANE, RTL / f"{NAME}.sv"):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
