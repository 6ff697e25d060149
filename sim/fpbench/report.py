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

from sim.fpbench import campaign, native
from sim.fpbench.plan import SEED, Section, Shard
from sim.fpbench.quick import merged_angles
from sim.fpbench.selfcheck import double_error
from sim.fpbench.variants import fingerprint

ROOT = native.ROOT
REPORT = ROOT / "build/fpbench/report.json"
PAGE = ROOT / "docs/arithmetic_evidence.md"
BEGIN = "<!-- campaign: written by `make fp-report` from build/fpbench -->"
END = "<!-- end of campaign -->"


@dataclass
class Total:
    """Sums over the finished shards of one operation in one section."""

    planned: int = 0
    covered: int = 0  # of the planned cases; constructed ones without a solution count here
    cases: int = 0
    mismatches: int = 0
    seconds: float = 0.0
    failures: int = 0

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
    rows, failures, angles = [], [], {}
    units: set[str] = set()
    for section in sections:
        totals: dict[str, Total] = {}
        for part in section.parts:
            total = totals.setdefault(part.op, Total())
            for shard in part.shards():
                units.add(shard.unit)
                result = campaign.finished(campaign.task_of(shard))
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
    REPORT.write_text(json.dumps(report, indent=1) + "\n")
    return REPORT


def markdown(report: Mapping) -> str:
    """Tables of the docs page: one line per section, then the errors of sine and cosine."""
    lines = [
        "| section | what | operations | cases | mismatches | covered | M cases/s |",
        "| --- | --- | --- | --- | --- | --- | --- |",
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
        result = str(wrong) if cases else "not run"
        lines.append(
            f"| {name} | {rows[0]['what']} | {shown} | {cases} | {result} | {part} | {rate} |"
        )
    if report["angles"]:
        lines += [
            "",
            "| function | operands in range | largest error | at | not rounded to nearest "
            "| symmetric pairs | other words | double reference off by, there |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
    for op, s in report["angles"].items():
        at = f"{s['worst_at']:08x} ({np.uint32(s['worst_at']).view(np.float32)} rad)"
        lines.append(
            f"| `{op}` | {s['in_range']} | {s['worst']:.6f} ulp | {at} | {s['not_nearest']} "
            f"| {s['symmetric_pairs']} | {s['beyond']} | {s['reference_error']:.1e} ulp |"
        )
    if report["angles"]:
        lines += ["", "Share of the operands by error in ulp:", ""]
        lines += histogram_lines(report["angles"])
    lines += ["", f"Processor: {report['processor']}; one core per task. Seed {report['seed']}."]
    return "\n".join(lines)


def histogram_lines(angles: Mapping[str, Mapping], group: int = 4) -> list[str]:
    """Table of the error histograms, `group` bins of 1/64 ulp to a line, up to the last in use."""
    ops = list(angles)
    lines = [
        "| error | " + " | ".join(f"`{op}`" for op in ops) + " |",
        "| --- |" + " --- |" * len(ops),
    ]
    bins = {op: angles[op]["histogram"] for op in ops}
    last = max((i for op in ops for i, n in enumerate(bins[op]) if n), default=-1)
    for low in range(0, last + 1, group):
        cells = []
        for op in ops:
            total = sum(bins[op]) or 1
            cells.append(f"{100 * sum(bins[op][low : low + group]) / total:.4f} %")
        end = f"{(low + group) / native.BINS:.4f}" if low < native.BINS else "more"
        lines.append(f"| {low / native.BINS:.4f} to {end} | " + " | ".join(cells) + " |")
    return lines


def update_page(report: Mapping, page: Path = PAGE) -> None:
    """Replace the generated block of the page; BenchError if the page has no marks for it."""
    text = page.read_text()
    if BEGIN not in text or END not in text:
        raise native.BenchError(f"{page}: no lines '{BEGIN}' and '{END}' to write between")
    head, rest = text.split(BEGIN, 1)
    page.write_text(f"{head}{BEGIN}\n\n{markdown(report)}\n\n{END}{rest.split(END, 1)[1]}")
