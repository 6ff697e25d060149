# SPDX-License-Identifier: Apache-2.0
"""Measure what the workbench is to reach: debug block, debugger, scope.

    make workbench                 every row in its quick form
    make workbench RUN=full        to full depth
    make workbench T="scope area"  producers whose name has one of the words

Rows go to the terminal and, as `goals`, to build/workbench.json; rows of producers left out keep
what the file had. Exit 1 if a goal is not met.

A producer is a function `rows(full: bool) -> Iterator[sim.debug.row.Row]`; add its place to
PRODUCERS.
"""

from __future__ import annotations

import importlib
import json
import logging
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict

from rich.console import Console

from asip_asm.command import command_parser
from asip_asm.project import ROOT
from scripts.goal_table import goal_view
from sim.debug.row import Row

OUTPUT = ROOT / "build/workbench.json"
PRODUCERS: dict[str, str] = {
    "same runs": "tests.debug.rows:same_runs",
    "halted runs": "tests.debug.rows:halted_runs",
    "live parameters": "tests.debug.rows:live_parameters",
    "scope": "tests.debug.rows:scope",
    "area": "scripts.workbench_area:rows",
    "formal": "scripts.workbench_area:proofs",
    "asip-scope": "sim.scope.goals:rows",
    "nios-gdb": "tests.gdb.goals:rows",
    "asip-dbg": "tests.debugger.goals:rows",
}
"""Name -> "module:function"."""


def measure(name: str, full: bool) -> list[Row]:
    """Rows of a producer; one that fails is a row that is not met."""
    module, _, function = PRODUCERS[name].partition(":")
    try:
        return list(getattr(importlib.import_module(module), function)(full))
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return [Row(name, None, "", "measured", False, reason)]


def wanted(words: Sequence[str]) -> list[str]:
    """Names of the producers that one of the words is in. Raises ValueError if there are none."""
    found = [name for name in PRODUCERS if not words or any(word in name for word in words)]
    if not found:
        raise ValueError(f"no row with {' or '.join(words)}; there are {', '.join(PRODUCERS)}")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = command_parser("make workbench", __doc__)
    parser.add_argument("words", nargs="*", help="only producers whose name has one of these")
    parser.add_argument("--full", action="store_true", help="to full depth")
    options = parser.parse_args(arguments)
    console = Console(stderr=True, soft_wrap=True)
    try:
        names = wanted(options.words)
    except ValueError as error:
        console.print(f"error: {error}", style="red", markup=False)
        return 2
    logging.getLogger("asip_asm").setLevel(logging.ERROR)  # warnings on random programs
    kept = json.loads(OUTPUT.read_text())["goals"] if OUTPUT.exists() else []
    found: dict[str, list[dict]] = {}
    for goal in kept:
        found.setdefault(goal["producer"], []).append(goal)
    for n, name in enumerate(names, 1):
        begun = time.monotonic()
        console.print(f"[{n}/{len(names)}] {name} ...", end=" ", markup=False)
        found[name] = [asdict(row) | {"producer": name} for row in measure(name, options.full)]
        console.print(f"{time.monotonic() - begun:.0f} s", markup=False)
    goals = [goal for name in PRODUCERS for goal in found.get(name, [])]
    OUTPUT.parent.mkdir(exist_ok=True)
    OUTPUT.write_text(json.dumps({"full": options.full, "goals": goals}, indent=2) + "\n")
    Console().print(goal_view(goals))
    missed = [goal["name"] for goal in goals if not goal["met"] and goal["producer"] in names]
    if missed:
        console.print(f"not met: {', '.join(missed)}", style="red", markup=False)
    return int(bool(missed))


if __name__ == "__main__":
    sys.exit(main())
