# SPDX-License-Identifier: Apache-2.0
"""`microtick robots`: compile, prove and close the loop of every robot and law shown; table, JSON,
page.
"""

from __future__ import annotations

import argparse
import functools
import sys
import time
from pathlib import Path

from rich.console import Console

from asip_asm.command import command_parser, count, duration, run_command
from asip_asm.model.read import ModelError
from sim.bench.shown_robots.core_goals import core_goals
from sim.bench.shown_robots.job import SHOWN, Row, goals, run_robot
from sim.bench.shown_robots.matrix import MATRIX
from sim.bench.shown_robots.matrix import goals as matrix_goals
from sim.bench.shown_robots.page import table, write_page
from sim.core.api import CoreFault
from sim.laws.elements import RobotError
from sim.laws.prove_program import COUNT, SEED
from sim.report.goals import as_json, terminal_table, write_goals

TABLE_WIDTH = 152
REPORT = "shown_robots.json"
EPILOG = """examples:
  python -m sim.bench.shown_robots                 # all; build/shown_robots.json, build/robots.html
  python -m sim.bench.shown_robots --only iiwa14,ur5 --seconds 0.5 --inputs 1000

exit status: 0 every goal of the table is met; 1 a goal is missed, or the run has fewer inputs or
shorter motions than the goals require; 2 wrong command line
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command("robots", lambda: _robots(options))


def _robots(options: argparse.Namespace) -> int:
    known = [*SHOWN, *MATRIX]
    names = options.only.split(",") if options.only else known
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"robots: error: no robot {', '.join(unknown)}; there are {', '.join(known)}")
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    start = time.monotonic()
    for done, name in enumerate(names):
        left = (time.monotonic() - start) / done * (len(names) - done) if done else 0.0
        wait = f", about {left:.0f} s left" if done else ""
        print(f"[{done + 1}/{len(names)}] {name}{wait}", file=sys.stderr, flush=True)
        try:
            run = MATRIX.get(name) or functools.partial(run_robot, name)
            row = run(options.output, options.inputs, options.seconds, options.seed)
        except (ModelError, RobotError, CoreFault) as error:
            print(f"robots: error: {name}: {error}", file=sys.stderr)
            return 1
        rows.append(row)
        # Written after each robot: a run that is stopped loses nothing.
        robots, laws = ([row for row in rows if row.name in each] for each in (SHOWN, MATRIX))
        found = as_json(
            [*goals(robots), *matrix_goals(laws), *([] if options.only else core_goals())]
        )
        shown = {row.name: row.as_json() for row in rows}
        write_goals(options.output / REPORT, found, robots=shown)
    write_page(rows, found, options.output / "robots.html")
    console = Console(width=TABLE_WIDTH)
    console.print(table(rows))
    console.print(terminal_table(found))
    print(f"{options.output / REPORT}, {options.output / 'robots.html'}")
    return 0 if all(goal["met"] for goal in found) else 1


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    parser = command_parser(
        "python -m sim.bench.shown_robots", "Compile, prove and simulate the robots shown.", EPILOG
    )
    parser.add_argument("--only", metavar="NAMES", help=f"some of {', '.join((*SHOWN, *MATRIX))}")
    parser.add_argument("--output", type=Path, default=Path("build"), help="folder to write")
    parser.add_argument("--inputs", type=count, default=COUNT, help="inputs of each proof")
    parser.add_argument("--seconds", type=duration, help="length of the motions")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the proofs' inputs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
