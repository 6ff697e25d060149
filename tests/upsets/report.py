# SPDX-License-Identifier: Apache-2.0
"""Tables and goals of the campaign of upsets: build/upsets.json and docs/upsets.md."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from sim.report.goals import Goal, as_json, at_most, depth, not_measured, write_goals
from sim.report.marks import between_marks
from sim.report.provenance import commit
from sim.rtl.figures import rtl_mark
from tests.upsets.area import ORDERS
from tests.upsets.campaign import WRONG
from tests.upsets.model import EFFECTS, LATER, TICKS
from tests.upsets.plan import BLOCKS, KINDS, SEED

OUTPUT = BUILD / "upsets.json"
PAGE = ROOT / "docs/upsets.md"
DATA = ROOT / "docs/data/upsets.json"
AREAS = {
    "resilient": "area of redundancy",
    "record": "area of redundancy and the plausibility record",
}
FULL = "RUN=full measures it"
LEAST, LEAST_NETLIST = 20_000, 4000  # injections
LARGE = 0.01
"""Error of an output that counts as large, as a part of its limit."""


def wilson(hits: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Confidence interval of a share: the score interval of Wilson (1927), 95 % by default."""
    if n == 0:
        return 0.0, 1.0
    share, square = hits / n, z * z / n
    centre = (share + square / 2) / (1 + square)
    half = z * math.sqrt(share * (1 - share) / n + square / n / 4) / (1 + square)
    return max(0.0, centre - half), min(1.0, centre + half)


def gather(results: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Counts of one core: by block and kind of place, in all, its cases."""
    blocks: dict[str, dict[str, int]] = {}
    for result in results:
        for block, row in result["counts"].items():
            total = blocks.setdefault(block, dict.fromkeys(EFFECTS, 0))
            for effect, n in row.items():
                total[effect] += n
    order = [*BLOCKS, *(kind.name for kind in KINDS if kind.memory)]
    blocks = {name: blocks[name] for name in order if name in blocks}
    flip_flops = [row for name, row in blocks.items() if name in BLOCKS]
    rows = {
        "all flip-flops": {e: sum(row[e] for row in flip_flops) for e in EFFECTS},
        **blocks,
        "everything": {e: sum(row[e] for row in blocks.values()) for e in EFFECTS},
    }
    return {
        "injections": sum(result["injections"] for result in results),
        "unsafe": sum(result["unsafe"] for result in results),
        "rows": rows,
        "cases": [case for result in results for case in result["cases"]],
    }


def cost_goals(cycles: Mapping[str, int], memory: Mapping[str, int]) -> list[Goal]:
    """What redundancy costs in time, and how soon a wrong bit of a memory is known."""
    once, twice = cycles["plain"], cycles["resilient"]
    missed = memory["injections"] - memory["found"]
    return [
        at_most("cycles per tick, redundancy on / off", twice / once, 2.1, "", f"{twice} / {once}"),
        at_most(
            "ticks until a wrong bit of program memory or bank K is known",
            math.inf if missed else memory["ticks"],
            2,
            "ticks",
            f"{memory['injections']} bits, {missed} not found",
        ),
    ]


def area_goals(luts: Mapping[str, float] | None) -> list[Goal]:
    """What redundancy, alone and with the plausibility record, costs in LUTs of ECP5."""
    rows = []
    for core, name in AREAS.items():
        if luts is None:
            note = "python -m tests.upsets --area measures it"
            rows.append(not_measured(name, "<= 8", "%", note))
            continue
        more = luts[core] - luts["plain"]
        note = f"{more:g} LUTs on {luts['plain']:g}, ECP5, medians of {len(ORDERS)} mappings"
        rows.append(at_most(name, 100 * more / luts["plain"], 8, "%", note))
    return rows


def goals(core: Mapping[str, Any] | None, name: str, least: int) -> list[Goal]:
    """Effects of upsets on a core, or None if it was not run, against their targets.

    least: injections.
    """
    if core is None:
        return [not_measured(f"injections, {name}", f">= {least}", "cases", FULL)]
    total, n = core["rows"]["everything"], core["injections"]
    wrong = sum(total[effect] for effect in WRONG)
    low, high = wilson(wrong, n)
    large = sum(case["error"] > LARGE for case in core["cases"])
    stuck = total["locked up"] + total["run lost"]
    note = f"{wrong} of {n}, 95 %: {100 * low:.3f} to {100 * high:.3f}"
    return [
        at_most(f"silently wrong outputs, {name}", 100 * wrong / n, 0.1, "%", note),
        at_most(f"wrong by more than 1 % of the limit, {name}", large, 0, "cases"),
        at_most(f"lock-ups, {name}", stuck, 0, "cases", "runs that never end among them"),
        at_most(f"unsafe outputs after a fault, {name}", core["unsafe"], 0, "cases"),
        depth(f"injections, {name}", n, least, "cases", FULL),
    ]


def write(cores: Mapping[str, Mapping[str, Any]], rows: Sequence[Goal], how_deep: str) -> None:
    """build/upsets.json."""
    more = {"commit": commit(), "depth": how_deep, "seed": SEED, "cores": dict(cores)}
    write_goals(OUTPUT, as_json(rows), **more)


def _cell(hits: int, n: int) -> str:
    if hits == 0:
        return f"0 (< {100 * wilson(0, n)[1]:.2g})"
    bounds = (100 * bound for bound in wilson(hits, n))
    low, high = (f"{bound:.2g}" if bound < 10 else f"{bound:.0f}" for bound in bounds)
    return f"{100 * hits / n:.3g} ({low}-{high})"


def table(core: Mapping[str, Any]) -> list[str]:
    """The core's table in Markdown: percent with the interval of 95 %."""
    shown = [e for e in EFFECTS if any(row[e] for row in core["rows"].values())]
    lines = [f"| where | n | {' | '.join(shown)} |", f"| --- |{' --- |' * (len(shown) + 1)}"]
    for name, row in core["rows"].items():
        n = sum(row.values())
        if n:
            cells = " | ".join(_cell(row[effect], n) for effect in shown)
            lines.append(f"| {name} | {n} | {cells} |")
    return lines


def update_page(cores: Mapping[str, Mapping[str, Any]], rows: Sequence[Goal]) -> None:
    """Put the tables between the marks of the page."""
    figures = {"commit": commit(), "rtl": rtl_mark("asip")}
    write_text(DATA, json.dumps(figures, indent=2) + "\n")
    lines = [""]
    for name, core in cores.items():
        errors = sorted(case["error"] for case in core["cases"] if case["effect"] in WRONG)
        large = sum(error > LARGE for error in errors)
        size = (
            f"{large} of them by more than 1 % of the output's limit, the worst by "
            f"{max(errors):.3g} times the limit"
            if errors
            else "so none by more than 1 % of an output's limit"
        )
        lines += [
            f"Core `{name}`: {core['injections']} injections, seed {SEED}, {TICKS} ticks, {LATER} "
            "watched after each. Percent, in brackets the interval of 95 % confidence (Wilson).",
            "",
            *table(core),
            "",
            f"Runs with outputs silently wrong: {len(errors)}, {size}. "
            f"Outputs that were not the safe values after a fault: {core['unsafe']}.",
            "",
        ]
    lines += ["| goal | value | target | met |", "| --- | --- | --- | --- |"]
    for row in rows:
        value = "not measured" if row.value is None else f"{row.value:.5g} {row.unit}"
        note = f" ({row.note})" if row.note else ""
        lines.append(
            f"| {row.name} | {value}{note} | {row.target} | {'yes' if row.met else 'no'} |"
        )
    text = PAGE.read_text(encoding="utf-8")
    texts = {"campaign": "\n".join([*lines, "", ""])}
    PAGE.write_text(between_marks(text, texts, PAGE), encoding="utf-8")
