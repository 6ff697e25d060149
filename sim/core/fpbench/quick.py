# SPDX-License-Identifier: Apache-2.0
"""The short set of one operation: directed cases, level 1, constructed hard cases, random ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sim.core.fpbench.directed import rows_of
from sim.core.fpbench.native import RTL, SHOWN, AngleStatistics, Report, Unit, unit_of

RANDOM_CASES = 2_000_000  # at full rate; a quarter as many again with gaps
ITERATIVE_CASES = 150_000  # sine and cosine take one operation per some thirty clocks
HARD_CASES = 200_000
SUMMED = ("cases", "mismatches", "cycles", "seconds")


def quick(
    op: str,
    rtl: Path = RTL,
    defines: Mapping[str, str] | None = None,
    seed: int = 1,
    cases: int | None = None,
) -> Report:
    """Run the short set of an operation on the RTL in `rtl` and return one report of everything.

    `rtl` is a folder with the files of rtl/fpu, for example a copy with a planted fault; `defines`
    are macros for it; `cases` is the number of random cases at full rate. The set passed if
    `report.good`; `report.failures` holds the first mismatches as pasteable lines, and a fault of
    the handshake (latency, lost or surplus results) is the text `report.protocol`. RTL that does
    not compile raises `sim.rtl.build.BuildError`.
    """
    return run_parts(Unit(unit_of(op), rtl, defines), op, seed, cases)


def run_parts(unit: Unit, op: str, seed: int = 1, cases: int | None = None) -> Report:
    """The short set on a unit that is built."""
    reports = [unit.run_list(op, rows_of(op))] if rows_of(op) else []
    for part in parts(unit, op, seed, cases):
        reports.append(unit.run(op, part.kind, part.start, part.count, part.seed, part.gaps))
    return merged(reports, "quick", seed)


@dataclass(frozen=True)
class Part:
    """A piece of the short set, with the arguments of `Unit.run`."""

    kind: str
    start: int
    count: int
    seed: int
    gaps: bool = False


def parts(unit: Unit, op: str, seed: int = 1, cases: int | None = None) -> list[Part]:
    """The short set of an operation after its directed cases; `cases` as for `quick`."""
    if cases is None:
        cases = ITERATIVE_CASES if unit.name == "fp_sincos" else RANDOM_CASES
    found = [Part("level1", 0, unit.size(op, "level1"), seed)]
    if unit.name == "fp_sincos":
        found.append(Part("level2", 0, unit.size(op, "level2"), seed))
    if size := unit.size(op, "hard"):
        stride = size // 4
        found += [Part("hard", k * stride, min(HARD_CASES, stride), seed) for k in range(4)]
    found.append(Part("random", 0, cases, seed))
    found.append(Part("random", 0, max(1, cases // 4), seed + 1, gaps=True))
    return found


def merged(parts: list[Report], kind: str, seed: int) -> Report:
    """One report of several of the same operation."""
    return Report(
        op=parts[0].op,
        kind=kind,
        **{name: sum(getattr(p, name) for p in parts) for name in SUMMED},
        protocol=next((p.protocol for p in parts if p.protocol), ""),
        failures=[f for p in parts for f in p.failures][:SHOWN],
        angles=merged_angles([p.angles for p in parts if p.angles]),
        seed=seed,
    )


def merged_angles(parts: list[AngleStatistics]) -> AngleStatistics | None:
    """Sums, and the worst error with where it is; None without parts."""
    if not parts:
        return None
    worst = max(parts, key=lambda p: p.worst)
    counted = ("in_range", "beyond", "symmetric_pairs", "not_nearest")
    return AngleStatistics(
        **{name: sum(getattr(p, name) for p in parts) for name in counted},
        worst=worst.worst,
        worst_at=worst.worst_at,
        histogram=[sum(bins) for bins in zip(*(p.histogram for p in parts), strict=True)],
    )
