# SPDX-License-Identifier: Apache-2.0
"""Measure the goals of the bus, to build/bus.json, a page and a capture.

    python -m scripts.bus            minutes: short runs; rows that need long ones say so
    python -m scripts.bus --full     100 000 cycles of pysoem, 10 000 of the clocks, the whole path,
                                     100 000 chains, place and route
    python -m scripts.bus --docs     write docs/ethercat.md from build/bus.json

The file keeps the rows of producers that a run leaves out. Results of long runs are cached in
build/bus for the sources they were measured with: an interrupted run continues with the missing
row. Exit status 1 if a goal is missed.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from asip_asm.command import command, script_parser
from asip_asm.project import BUILD, ROOT
from scripts import bus_page
from scripts.bus_rows import PRODUCERS, Order
from sim.report.goals import Goal, begin_goals, merge_goals, missed, terminal_table, updated_table
from sim.report.marks import text_between, write_between_marks

RESULTS = BUILD / "bus.json"
PAGE = ROOT / "docs/ethercat.md"


def measure(order: Order, name: str, report: Callable[[str], None]) -> list[Goal]:
    """Rows of a producer; one that fails is a row that is not met."""
    rows: list[Goal] = []
    try:
        rows.extend(PRODUCERS[name](order, report))
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        report(f"  {reason}")
        rows.append(Goal(name, None, "", "measured", False, reason))
    return rows


@command("microtick bus")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = script_parser(
        __doc__, "python -m scripts.bus --full path masters", "python -m scripts.bus"
    )
    parser.add_argument(
        "producers", nargs="*", metavar="WHAT", help=f"only these: {', '.join(PRODUCERS)}"
    )
    parser.add_argument("--full", action="store_true", help="the long runs too (hours)")
    parser.add_argument("--results", type=Path, default=RESULTS, help="file written")
    parser.add_argument("--capture", type=Path, default=BUILD / "bus.pcap", help="file written")
    parser.add_argument("--docs", action="store_true", help="write docs/ethercat.md from --results")
    options = parser.parse_args(argv)
    if options.docs:
        results = json.loads(options.results.read_text(encoding="utf-8"))
        text = PAGE.read_text(encoding="utf-8")
        table = updated_table(text_between(text, "goals", PAGE.name), results)
        write_between_marks(PAGE, {"goals": table})
        return 0
    if unknown := set(options.producers) - set(PRODUCERS):
        parser.error(f"no {', '.join(sorted(unknown))}; there are {', '.join(PRODUCERS)}")
    console = Console()
    order = Order(options.full, options.capture)
    names, goals = options.producers or list(PRODUCERS), []
    if not options.producers:
        begin_goals(options.results)
    for name in names:  # written after each: a run that is stopped loses nothing
        rows = measure(order, name, console.print)
        goals = merge_goals(options.results, name, rows, list(PRODUCERS), order.full)
    view = terminal_table(goals)
    console.print(view)
    page = options.results.with_suffix(".html")
    bus_page.write(page, view, order.curves)
    console.print(f"written: {options.results}, {page}")
    return int(bool(missed(goal for goal in goals if goal["producer"] in names)))


if __name__ == "__main__":
    sys.exit(main())
