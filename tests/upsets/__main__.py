# SPDX-License-Identifier: Apache-2.0
"""Invert single bits of the core's registers and memories during ticks, and record the effect.

    microtick upsets                 quick form, to build/upsets.json and docs/upsets.md
    microtick upsets --full          full depth; continues a run that was stopped
    python -m tests.upsets --core plain --replay "4 157 TOP.asip.u_run.u_control.state_q.1"

A line of --replay is: tick, clock in the tick, register or memory[word], bit. Every case of
build/upsets.json has its own. Exit 1 if a goal is not met.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable, Sequence

from rich.console import Console

from asip_asm.command import command, command_parser
from asip_asm.project import ROOT
from sim.core.fpbench import campaign as runner
from sim.report import cache
from sim.report.goals import as_json, missed, terminal_table
from tests.upsets import area, campaign, report
from tests.upsets.model import EFFECTS
from tests.upsets.plan import SEED, SHARD, upset_of


def replay(core: str, line: str, console: Console) -> int:
    """One injection again, in words."""
    model = campaign.model_of(core)
    try:
        upset = upset_of(model.sites, line)
    except ValueError as error:
        console.print(f"error: {error}", style="red")
        return 2
    (outcome,) = model.inject(upset)
    console.print(
        f"{EFFECTS[outcome['effect']]}, cause {outcome['cause']}, known or gone "
        f"{outcome['ticks']} ticks later, largest error {outcome['worst']:.3g} of the limit"
    )
    return 0


def progress(core: str, shards: int, console: Console) -> Callable[[object, dict], None]:
    """Says after each shard how far the campaign is."""
    begun, done = time.monotonic(), itertools.count(1)

    def finish(task: object, result: dict) -> None:
        n = next(done)
        rest = (time.monotonic() - begun) / n * (shards - n)
        text = f"core '{core}': {n} of {shards} shards, about {rest:.0f} s left"
        console.print(text)

    return finish


def inject(depth: str, jobs: int, scheduler: str | None, console: Console) -> dict | None:
    """Every shard that is not finished; results by core, None if one failed."""
    cores: dict[str, dict] = {}
    for core in campaign.SHARDS[depth]:
        console.print(f"core '{core}': building the model ...")
        tasks = list(campaign.tasks_of(core, depth))
        waiting = [task for task in tasks if cache.load(task) is None]
        console.print(
            f"core '{core}': {len(tasks)} shards of {SHARD} injections, seed {SEED}; "
            f"{len(tasks) - len(waiting)} finished before"
        )
        failures: list[str] = []
        runner.run(
            waiting,
            progress(core, len(waiting), console),
            lambda task, text, failures=failures: failures.append(f"{task.key}: {text}"),
            jobs,
            scheduler,
            campaign.execute,
        )
        for failure in failures:
            console.print(f"error: {failure}", style="red")
        if failures:
            return None
        cores[core] = report.gather([cache.load(task) for task in tasks])
    return cores


@command("microtick upsets")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = command_parser("microtick upsets", __doc__)
    parser.add_argument("--full", action="store_true", help="to full depth")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    parser.add_argument("--scheduler", help="address of a Dask scheduler in place of processes")
    parser.add_argument("--core", choices=campaign.CORES, default="plain", help="for --replay")
    parser.add_argument("--area", action="store_true", help="measure the area with Yosys (minutes)")
    parser.add_argument("--replay", metavar="LINE", help="one injection of the report again")
    options = parser.parse_args(arguments)
    console = Console(stderr=True, soft_wrap=True, markup=False, highlight=False)
    if options.area:
        area.measure()
        return 0
    if options.replay:
        return replay(options.core, options.replay, console)
    depth = "full" if options.full else "quick"
    cores = inject(depth, options.jobs, options.scheduler, console)
    if cores is None:
        return 1
    rows = report.goals(cores["resilient"], "core 'resilient'", report.LEAST)
    netlist = cores.get(campaign.NETLIST)
    rows += report.goals(netlist, "flip-flops of the netlist", report.LEAST_NETLIST)
    rows += report.cost_goals(campaign.cost(), campaign.memory_ticks(5 if options.full else 1))
    rows += report.area_goals(area.measured())
    report.write(cores, rows, depth)
    if options.full:
        report.update_page(cores, rows)
    goals = as_json(rows)
    Console().print(terminal_table(goals))
    page = ", docs/upsets.md" if options.full else "; --full writes docs/upsets.md"
    console.print(f"written: {report.OUTPUT.relative_to(ROOT)}{page}")
    return int(bool(missed(goals)))


if __name__ == "__main__":
    sys.exit(main())
