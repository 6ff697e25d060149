# SPDX-License-Identifier: Apache-2.0
"""Command of the fuzz campaigns: a table, and the same figures as goals in build/fuzz.json."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser
from asip_asm.pace import Pace
from sim.report.goals import Goal, as_json, at_most, depth, missed, write_goals
from tests.fuzz.campaigns import CAMPAIGNS
from tests.fuzz.engine import CPU_SECONDS, MEMORY_BYTES, Campaign, Result, replay, run_campaign

REPORT = Path("build/fuzz.json")
SHOWN = 5
OF_MODELS = ("casadi-file", "interface-file", "urdf")
QUICK, DEPTH = 300, 5000
EPILOG = """examples:
  python -m tests.fuzz                                   every campaign, all cases
  python -m tests.fuzz assembly image --cases 300        two campaigns, 300 cases each
  python -m tests.fuzz assembly --replay 4711 --seed 1   one case with its traceback

exit status: 0 every goal met, 1 a case failed, 2 wrong command line
"""


@command("python -m tests.fuzz")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    about = "Give mutated inputs to the commands: no traceback, no hang, bounded memory."
    parser = command_parser("python -m tests.fuzz", about, EPILOG)
    parser.add_argument(
        "campaign", nargs="*", help=f"campaigns (default: all): {', '.join(CAMPAIGNS)}"
    )
    parser.add_argument("--cases", type=int, metavar="N", help="cases of each (default: full set)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the mutations (default: 1)")
    parser.add_argument(
        "--replay", type=int, metavar="N", help="run only case N, and leave its files"
    )
    parser.add_argument(
        "--output", type=Path, default=REPORT, help=f"file written (default: {REPORT})"
    )
    options = parser.parse_args(arguments)
    for name in options.campaign:
        if name not in CAMPAIGNS:
            parser.error(f"no campaign '{name}'; there are {', '.join(CAMPAIGNS)}")
    chosen = [CAMPAIGNS[name] for name in options.campaign or CAMPAIGNS]
    if options.replay is not None:
        if len(chosen) != 1:
            parser.error("--replay needs the name of one campaign")
        folder = Path("build/fuzz") / f"{chosen[0].name}_{options.seed}_{options.replay}"
        print(f"files in {folder}")
        status = replay(chosen[0], options.seed, options.replay, folder)
        print(f"exit status {status}")
        return 0
    results = []
    for campaign in chosen:
        cases = options.cases or campaign.cases
        results.append(run_campaign(campaign, cases, options.seed, _progress(campaign, cases)))
    entries = as_json(goal for result in results for goal in goals(result))
    write_goals(options.output, entries, campaigns=[asdict(result) for result in results])
    Console(width=None if sys.stdout.isatty() else 120).print(table(results))
    for result in results:
        for failure in result.failures[:SHOWN]:
            print(f"\n{result.campaign} case {failure.case}: {failure.kind}\n{failure.text}")
            print(
                f"again: python -m tests.fuzz {result.campaign} --replay {failure.case} "
                f"--seed {result.seed}"
            )
    return 1 if missed(entries) else 0


def goals(result: Result) -> list[Goal]:
    """Figures of a campaign next to their targets; the notes repeat the first cases that failed."""
    cases = f"{result.campaign}: {result.cases} mutated inputs"
    peak = round(result.peak_bytes / 2**20)

    def none(what: str, *kinds: str) -> Goal:
        failed = [failure.case for failure in result.failures if failure.kind in kinds]
        replays = [
            f"python -m tests.fuzz {result.campaign} --seed {result.seed} --replay {case}"
            for case in failed[:SHOWN]
        ]
        return at_most(f"{cases}, {what}", len(failed), 0, "inputs", "; ".join(replays))

    return [
        none("tracebacks", "traceback", "status", "crash"),
        none(f"beyond {CPU_SECONDS} s", "time", "hang"),
        none("beyond the memory limit", "memory"),
        at_most(f"{cases}, peak memory", peak, MEMORY_BYTES >> 20, "MiB"),
    ]


def rows(full: bool) -> Iterator[Goal]:
    """Goals of the files that the model compiler reads: tracebacks, and how many files."""
    for name in OF_MODELS:
        campaign = CAMPAIGNS[name]
        cases = campaign.cases if full else QUICK
        result = run_campaign(campaign, cases, 1, _progress(campaign, cases))
        yield from goals(result)
        cure = "all with RUN=full"
        yield depth(f"{name}: mutated inputs", result.cases, DEPTH, "inputs", cure)


def table(results: Sequence[Result]) -> Table:
    """One row per campaign."""
    view = Table(
        *("campaign", "seed", "cases", "exit status", "tracebacks", "time", "memory"),
        *("slowest", "peak"),
    )
    for result in results:
        statuses = ", ".join(f"{k}: {n}" for k, n in sorted(result.statuses.items()))
        view.add_row(
            *(result.campaign, str(result.seed), str(result.cases), statuses),
            str(result.count("traceback", "status", "crash")),
            str(result.count("time", "hang")),
            str(result.count("memory")),
            f"{result.slowest_s:.1f} s (case {result.slowest_case})",
            f"{result.peak_bytes / 2**20:.0f} MiB",
        )
    return view


def _progress(campaign: Campaign, cases: int) -> Callable[[Result], None]:
    """Reports how far a campaign is."""
    pace = Pace(campaign.name, cases)
    return lambda result: pace.at(result.cases)


if __name__ == "__main__":
    sys.exit(main())
