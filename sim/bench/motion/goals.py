# SPDX-License-Identifier: Apache-2.0
"""What the front-end is to do, feature by feature, and what `microtick motion` measured of it.

    python -m sim.bench.motion.goals            writes the table of the last run into docs/motion.md
    python -m sim.bench.motion.goals --measure  measures the goals again first, with its figures

Every value comes from a run: of the module named, of the RTL, or of the figures of
`microtick motion`. A feature that takes too long for that has no value here; its command
measures it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich import box
from rich.markup import escape
from rich.table import Table

from asip_asm.command import command
from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.bench.motion import goals_drive, goals_lookahead, goals_planner, goals_rtl
from sim.bench.motion.goal import FULL, Counts, Goal
from sim.motion.gcode.oracle import OracleError
from sim.report.marks import write_between_marks

FEATURES = [
    *goals_planner.FEATURES,
    *goals_rtl.FEATURES,
    *goals_lookahead.FEATURES,
    *goals_drive.FEATURES,
]
RESULTS, PAGE = ROOT / "build/motion/results.json", ROOT / "docs/motion.md"


def table(
    rows: Sequence[Mapping[str, Any]],
    counts: Counts,
    report: Callable[[str], None],
    hardware: bool = True,
) -> list[Goal]:
    """Measures every feature; rows: the figures of `microtick motion` so far; report gets its name.

    hardware: also what runs on simulated RTL.
    """
    named = {str(row["name"]): row for row in rows}
    found = []
    for row in FEATURES:
        ours, met = "", None
        if row.check is not None and (hardware or not row.simulated):
            report(row.name)
            try:
                ours, met = row.check(counts, named)
            except (KeyError, OracleError) as error:  # left out of this run, or not installed
                ours = f"not run: {error}" if isinstance(error, OracleError) else ""
        found.append(Goal(row.name, row.published, row.goal, ours, met, row.command))
    return found


def printed(goals: Sequence[Goal]) -> Table:
    """The goals for people."""
    shown = Table(
        title="Motion front-end: goals",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
        caption="What each part is to reach: as the papers have it, as this project wants it, and "
        "what this run has measured, with the command for what takes too long for it.",
        caption_justify="left",
    )
    for title in ("feature", "published", "goal", "ours", ""):
        shown.add_column(title)
    for goal in goals:
        verdict = {True: "met", False: "[red]NOT MET[/]", None: ""}[goal.met]
        ours = goal.ours or f"see {goal.command}"
        shown.add_row(goal.feature, goal.published, escape(goal.goal), escape(ours), verdict)
    return shown


def document(goals: Sequence[Goal]) -> list[dict[str, Any]]:
    """For results.json."""
    return [asdict(goal) for goal in goals]


def markdown(entries: Sequence[Mapping[str, Any]]) -> str:
    """The goals of results.json as a table of the page."""
    verdict = {True: "met", False: "**not met**", None: ""}
    lines = [
        "",
        "| feature | published | goal | ours | | more |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for entry in entries:
        cells = [
            entry["feature"],
            entry["published"],
            entry["goal"],
            entry["ours"] or "not in this run",
        ]
        lines.append(f"| {' | '.join(cells)} | {verdict[entry['met']]} | `{entry['command']}` |")
    return "\n".join([*lines, "", ""])


@command("python -m sim.bench.motion.goals")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m sim.bench.motion.goals",
        description="Write the table of goals of the last `microtick motion` into docs/motion.md.",
        epilog="example: python -m sim.bench.motion.goals --results build/motion/results.json",
    )
    parser.add_argument("--results", type=Path, default=RESULTS, help="results of microtick motion")
    parser.add_argument("--page", type=Path, default=PAGE, help="page with the marks")
    parser.add_argument("--measure", action="store_true", help="measure the goals again")
    arguments = parser.parse_args(argv)
    try:
        results = json.loads(arguments.results.read_text(encoding="utf-8"))
        if arguments.measure:
            counts = FULL if results["full"] else Counts()
            found = table(results["figures"], counts, lambda name: None)
            results["goals"] = document(found)
            text = json.dumps(results, indent=2) + "\n"
            write_text(arguments.results, text)
        write_between_marks(arguments.page, {"goals": markdown(results["goals"])})
    except OSError as error:
        sys.stderr.write(f"{error.filename}: error: {error.strerror}; run microtick motion first\n")
        return 1
    except (KeyError, TypeError, ValueError) as error:
        sys.stderr.write(f"{parser.prog}: error: {error}; run microtick motion again\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
