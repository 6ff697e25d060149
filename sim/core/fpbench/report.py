# SPDX-License-Identifier: Apache-2.0
"""Report of the campaign: `build/fpbench/report.json` and the generated block of the docs page."""

from __future__ import annotations

import json
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.files import write_text
from sim.core.fpbench import campaign, native
from sim.core.fpbench.plan import SEED, Section, Shard
from sim.core.fpbench.quick import merged_angles
from sim.core.fpbench.selfcheck import double_error
from sim.core.fpbench.variants import fingerprint
from sim.report import cache
from sim.report.marks import write_between_marks
from sim.report.provenance import commit

ROOT = native.ROOT
REPORT = ROOT / "build/fpbench/report.json"
PAGE = ROOT / "docs/arithmetic_evidence.md"
GROUP = 4  # bins of a histogram to a column


@dataclass
class Total:
    """Sums over the finished shards of one operation in one section."""

    planned: int = 0
    covered: int = 0  # of the planned cases; constructed ones without a solution count here
    cases: int = 0
    mismatches: int = 0
    seconds: float = 0.0

    def add(self, shard: Shard, result: Mapping | None) -> None:
        """Count a shard, finished or not."""
        self.planned += shard.count
        if result is None:
            return
        self.covered += shard.count
        self.cases += result["cases"]
        self.mismatches += result["mismatches"] + bool(result["protocol"])
        self.seconds += result["seconds"]


def collect(sections: Sequence[Section]) -> dict:
    """Everything that is stored for the present RTL, as the JSON report."""
    rows, failures = [], []
    angles: dict[str, list[native.AngleStatistics]] = {}
    units: set[str] = set()
    for section in sections:
        totals: dict[str, Total] = {}
        for part in section.parts:
            total = totals.setdefault(part.op, Total())
            for shard in part.shards():
                units.add(shard.unit)
                result = cache.load(campaign.task_of(shard))
                total.add(shard, result)
                if result is None:
                    continue
                failures += result["failures"]
                if result["protocol"]:
                    failures.append(f"{part.op}: {result['protocol']}")
                if result["angles"]:
                    statistics = native.AngleStatistics(**result["angles"])
                    by = f" of {part.instead}" if part.instead else ""
                    angles.setdefault(part.op + by, []).append(statistics)
        rows += [
            {"section": section.name, "what": section.what, "op": op, **vars(total)}
            for op, total in totals.items()
        ]
    return {
        "seed": SEED,
        "processor": processor(),
        "fingerprints": {unit: fingerprint(unit) for unit in sorted(units)},
        "rows": rows,
        "failures": failures,
        "angles": {op: _with_reference_error(op, parts) for op, parts in angles.items()},
    }


def _with_reference_error(op: str, parts: list[native.AngleStatistics]) -> dict:
    """Merged statistics, and the error of the double reference at the worst operand (MPFR, ulp)."""
    total = vars(merged_angles(parts))
    error = double_error(native.Unit("fp_sincos"), op.split()[0], total["worst_at"])
    return total | {"reference_error": error}


def processor() -> str:
    """Name of the processor."""
    try:
        match = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    except OSError:
        match = None
    return match[1] if match else platform.processor() or platform.machine()


def write(report: Mapping) -> Path:
    """Store the report; returns where."""
    REPORT.parent.mkdir(parents=True, exist_ok=True)
    write_text(REPORT, json.dumps(report, indent=1) + "\n")
    return REPORT


def markdown(report: Mapping, old: str = "") -> str:
    """Tables of the docs page: one line per section, then the errors of sine and cosine.

    A section or function that has no results here keeps its line of the page as it was, `old`,
    with the commit there.
    """
    here = commit()
    lines = [
        "| section | what | operations | cases | mismatches | covered | M cases/s | commit |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name in dict.fromkeys(row["section"] for row in report["rows"]):
        rows = [row for row in report["rows"] if row["section"] == name]
        ops = [row["op"] for row in rows]
        shown = ", ".join(f"`{op}`" for op in ops) if len(ops) <= 5 else f"{len(ops)} operations"
        cases, planned = (sum(row[k] for row in rows) for k in ("cases", "planned"))
        covered, seconds = (sum(row[k] for row in rows) for k in ("covered", "seconds"))
        wrong = sum(row["mismatches"] for row in rows)
        part = "all" if covered == planned else f"{100 * covered / planned:.1f} %"
        rate = f"{cases / seconds / 1e6:.2f}" if seconds else "-"
        result = f"{wrong} | {part} | {rate} | {here}" if cases else "not run | 0.0 % | - | -"
        line = f"| {name} | {rows[0]['what']} | {shown} | {cases} | {result} |"
        lines.append(line if cases else _kept(name, old) or line)
    angles = report["angles"]
    errors = {
        f"`{op}`": f"| `{op}` | {s['in_range']} | {s['worst']:.6f} ulp | {_angle(s['worst_at'])} "
        f"| {s['not_nearest']} | {s['symmetric_pairs']} | {s['beyond']} "
        f"| {s['reference_error']:.1e} ulp |"
        for op, s in angles.items()
    }
    lines += [
        "",
        "| function | operands in range | largest error | at | not rounded to nearest "
        "| symmetric pairs | other words | double reference off by, there |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
        *_merged(old.partition("| function |")[2].partition("\n\n")[0], errors),
        "",
        "Share of the operands, percent, by error in ulp:",
        "",
        *histogram_lines(angles, old.partition("| up to |")[2]),
    ]
    lines += ["", f"Processor: {report['processor']}; one core per task. Seed {report['seed']}."]
    return "\n".join(lines)


def _angle(word: int) -> str:
    return f"{word:08x} ({np.uint32(word).view(np.float32)} rad)"


def _kept(name: str, old: str) -> str:
    """The line of a table that begins with the name, '' if there is none."""
    return next((line for line in old.splitlines() if line.startswith(f"| {name} |")), "")


def _merged(old: str, new: Mapping[str, str]) -> list[str]:
    """Lines of functions (`name`): those of the old table, in its order, replaced by the new."""
    names = [line.split(" |")[0][2:] for line in old.splitlines() if line.startswith("| `")]
    return [new.get(name) or _kept(name, old) for name in dict.fromkeys([*names, *new])]


def histogram_lines(angles: Mapping[str, Mapping], old: str = "") -> list[str]:
    """Table of the error histograms, GROUP bins of 1/64 ulp to a column, up to 9/16 ulp, then
    all others; functions without results keep their line of `old`.
    """
    shown = 9 * GROUP
    ends = [f"{end / native.BINS:.4f}" for end in range(GROUP, shown + 1, GROUP)]
    rows = {}
    for op, statistics in angles.items():
        bins = statistics["histogram"]
        total = sum(bins) or 1
        parts = [bins[low : low + GROUP] for low in range(0, shown, GROUP)] + [bins[shown:]]
        shares = " | ".join(f"{100 * sum(part) / total:.4f}" for part in parts)
        rows[f"`{op}`"] = f"| `{op}` | {shares} |"
    head = [f"| up to | {' | '.join(ends)} | more |", "| --- |" + " --- |" * (len(ends) + 1)]
    return [*head, *_merged(old, rows)]


def update_page(report: Mapping, page: Path = PAGE) -> None:
    """Replace the generated block of the page. Raises MarksError if it has no marks for it."""
    text = page.read_text(encoding="utf-8")
    old = text.partition("<!-- campaign:")[2].partition("<!-- end of campaign -->")[0]
    write_between_marks(page, {"campaign": f"\n{markdown(report, old)}\n\n"})
