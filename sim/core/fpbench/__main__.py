# SPDX-License-Identifier: Apache-2.0
"""Test the arithmetic units with the fast bench, one case or millions."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from asip_asm.command import command_parser, run_command
from asip_asm.files import write_text
from sim.core.fpbench import campaign, plan, report
from sim.core.fpbench.native import (
    LANES,
    RTL,
    BenchError,
    Mismatch,
    Unit,
    flag_text,
    operations,
    unit_of,
)
from sim.core.fpbench.quick import quick
from sim.core.fpbench.selfcheck import selfcheck
from sim.report import cache
from sim.report.marks import MarksError
from sim.rtl.build import BuildError

BENCH_REPORT = report.REPORT.with_name("bench.json")
console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def word(text: str) -> int:
    """A 32-bit word in hexadecimal, with or without 0x."""
    try:
        value = int(text, 16)
    except ValueError:
        value = -1
    if not 0 <= value < 1 << 32:
        raise argparse.ArgumentTypeError(f"'{text}' is not a word of up to 8 hexadecimal digits")
    return value


def shown(op: str, bits: int, operand: bool) -> str:
    """A word and what it means there: an integer for integer operands and results, else a float."""
    unit = unit_of(op)
    integer = op in ("iadd", "isub") or unit == ("fp_i2f" if operand else "fp_f2i")
    if integer:
        return f"{bits:08x}  {bits if op == 'u2f' else int(np.uint32(bits).view(np.int32))}"
    return f"{bits:08x}  {float(np.uint32(bits).view(np.float32))!r}"


def case(arguments: argparse.Namespace) -> int:
    """Run one case and show all of it."""
    op, operands = arguments.op, tuple(arguments.operands)
    unit = Unit(unit_of(op), arguments.rtl)
    count = operations()[op][1]
    if len(operands) != count:
        names = " ".join("ABC"[:count])
        raise BenchError(f"operation '{op}' takes {count} operands ({names}), not {len(operands)}")
    result, bits, flags = unit.answers(op, [operands])
    got_bits, got_flags = want_bits, want_flags = int(bits[0]), int(flags[0])
    if result.failures:
        want_bits, want_flags = result.failures[0].want, result.failures[0].want_flags
    elif result.angles and result.angles.in_range:  # within the bound, perhaps not the nearest
        want_bits = int(np.float32(unit.exact(op, operands[0])).view(np.uint32))
    for name, bits in zip("ABC", operands, strict=False):
        console.print(f"{name}     {shown(op, bits, operand=True)}")
    console.print(f"got   {shown(op, got_bits, operand=False)}  flags {flag_text(got_flags)}")
    console.print(f"want  {shown(op, want_bits, operand=False)}  flags {flag_text(want_flags)}")
    if result.angles and result.angles.in_range:
        console.print(f"error {result.angles.worst:.6f} ulp")
    if result.protocol:
        console.print(f"FAIL: {result.protocol}")
    else:
        console.print("FAIL" if result.failures else "PASS")
    return int(not result.good)


def bench(arguments: argparse.Namespace) -> int:
    """The short set of every operation, with rates."""
    ops = arguments.op or list(operations())
    table = Table("operation", "cases", "mismatches", "M cases/s", title=f"seed {arguments.seed}")
    results = []
    for op in ops:
        with console.status(f"{op} ({unit_of(op)})"):
            result = quick(op, arguments.rtl, seed=arguments.seed, cases=arguments.cases)
        results.append(result)
        table.add_row(op, str(result.cases), str(result.mismatches), f"{result.rate / 1e6:.2f}")
    console.print(table)
    lines = [str(f) for r in results for f in r.failures]
    lines += [f"{r.op}: {r.protocol}" for r in results if r.protocol]
    for line in lines:
        console.print(line, soft_wrap=True)
    BENCH_REPORT.parent.mkdir(parents=True, exist_ok=True)
    rows = [r.as_json() | {"rate": r.rate} for r in results]
    write_text(BENCH_REPORT, json.dumps(rows, indent=1) + "\n")
    console.print(f"written: {BENCH_REPORT.relative_to(report.ROOT)}")
    return int(not all(r.good for r in results))


def check_reference(arguments: argparse.Namespace) -> int:
    """Host arithmetic against SoftFloat."""
    total, wrong = 0, list[Mismatch]()
    for name in arguments.units:
        cases, mismatches = selfcheck(Unit(name), arguments.seed, arguments.cases)
        total += cases
        wrong += mismatches
    for mismatch in wrong[:16]:
        console.print(f"host differs from SoftFloat: {mismatch}", soft_wrap=True)
    console.print(f"host reference against SoftFloat: {total} cases, {len(wrong)} differ")
    return int(bool(wrong))


def size(op: str, kind: str) -> int:
    """Cases of a kind; the table is the same in every unit's library, so the smallest one does."""
    return Unit("fp_add").size(op, kind)


def run_campaign(arguments: argparse.Namespace) -> int:
    """Everything that is not finished yet."""
    selected = plan.chosen(plan.sections(size), arguments.section, arguments.extended)
    tasks = [
        campaign.task_of(shard)
        for section in selected
        for part in section.parts
        for shard in part.shards()
    ]
    open_tasks = [task for task in tasks if cache.load(task) is None]
    cases = sum(task.shard.count for task in open_tasks)
    console.print(
        f"campaign: {len(tasks)} shards, {len(tasks) - len(open_tasks)} finished before and "
        f"skipped, {len(open_tasks)} to run ({cases:.3g} cases), seed {plan.SEED}"
    )
    for section in selected:
        console.print(f"  {section.name}: {section.what}")
    units = list(dict.fromkeys(unit_of(task.shard.op) for task in open_tasks))
    if check_reference(argparse.Namespace(seed=arguments.seed, cases=12_000, units=units)):
        return 1
    not_run: Counter[str] = Counter()
    columns = (
        TextColumn("{task.description:<36}"),
        BarColumn(),
        TextColumn("{task.percentage:.1f} %"),
        TimeRemainingColumn(),
    )
    try:
        # Elsewhere than on a terminal `finish` prints lines.
        with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
            bar_task = bar.add_task("campaign", total=cases)

            def finish(task: campaign.Task, result: dict) -> None:
                bar.update(bar_task, advance=task.shard.count, description=task.shard.name[:36])
                rate = result["cases"] / max(result["seconds"], 1e-9) / 1e6
                if not console.is_terminal:
                    console.print(
                        f"  {task.shard.name}: {result['cases']} cases, "
                        f"{result['mismatches']} mismatches, {rate:.2f} M/s"
                    )
                if result["mismatches"] or result["protocol"]:
                    for line in [*result["failures"][:4], result["protocol"]]:
                        console.print(line, soft_wrap=True)

            def fail(task: campaign.Task, text: str) -> None:
                if text not in not_run:
                    console.print(f"not run: {task.shard.name}: {text}", soft_wrap=True)
                not_run[text] += 1

            campaign.run(open_tasks, finish, fail, arguments.jobs, arguments.scheduler)
    except KeyboardInterrupt:
        console.print("stopped; finished shards are kept, the same command goes on from here")
        return 130
    summary = report.collect(plan.sections(size))
    path = report.write(summary)
    console.print(
        f"written: {path.relative_to(report.ROOT)}; `microtick fp report` puts it into docs"
    )
    # Shards that were finished before count too: a mismatch never gets lost by resuming.
    chosen_names = {section.name for section in selected}
    rows = [row for row in summary["rows"] if row["section"] in chosen_names]
    if not_run:
        console.print(f"{not_run.total()} shards did not run; the same command tries again")
    return int(bool(not_run) or any(row["mismatches"] for row in rows))


def make_report(arguments: argparse.Namespace) -> int:
    """report.json and the docs page from the stored shards."""
    summary = report.collect(plan.sections(size))
    path = report.write(summary)
    report.update_page(summary, arguments.page)
    console.print(f"written: {path.relative_to(report.ROOT)}, {os.path.relpath(arguments.page)}")
    return 0


def parser() -> argparse.ArgumentParser:
    """The command line."""
    example = "example: python -m sim.core.fpbench case mul 00ffffff 3f000000"
    top = command_parser("python -m sim.core.fpbench", __doc__, example)
    seed = int(os.environ.get("SEED", "1"))
    commands = top.add_subparsers(dest="command", required=True)

    def command(
        example: str, purpose: str, run: Callable[[argparse.Namespace], int]
    ) -> argparse.ArgumentParser:
        """Parser of the command that the example begins with."""
        epilog = f"example: {top.prog} {example}"
        added = commands.add_parser(example.split()[0], help=purpose, epilog=epilog)
        added.set_defaults(run=run)
        return added

    purpose = "one case with operands, result, flags and verdict"
    one = command("case mul 00ffffff 3f000000", purpose, case)
    one.add_argument("op", help="operation, such as mul")
    one.add_argument("operands", type=word, nargs="+", help="operand words in hexadecimal")
    one.add_argument("--rtl", type=Path, default=RTL, help="folder with the files of rtl/fpu")

    purpose = "the short set of every operation, with rates"
    short = command("bench --op mul --op div --cases 10000000", purpose, bench)
    short.add_argument("--op", action="append", help="only this operation (repeatable)")
    short.add_argument("--cases", type=int, help="random cases per operation")
    short.add_argument("--seed", type=int, default=seed)
    short.add_argument("--rtl", type=Path, default=RTL, help="folder with the files of rtl/fpu")

    purpose = "the host's arithmetic against SoftFloat"
    check = command("selfcheck --cases 100000", purpose, check_reference)
    check.add_argument("--cases", type=int, default=12_000, help="random cases per operation")
    check.add_argument("--seed", type=int, default=seed)
    check.set_defaults(units=list(LANES))

    purpose = "exhaustive, random, hard and cross-product cases; resumes"
    long = command('campaign --jobs 2 --section "square root"', purpose, run_campaign)
    long.add_argument("--jobs", type=int, default=2, help="processes of the local cluster")
    long.add_argument("--scheduler", help="address of a Dask scheduler instead of a local cluster")
    long.add_argument(
        "--section", action="append", default=[], help="only this section (repeatable)"
    )
    long.add_argument("--extended", action="store_true", help="the sections of many hours too")
    long.add_argument("--seed", type=int, default=seed, help="of the self-check only")

    page = command("report", "report.json and the docs page from what has run", make_report)
    page.add_argument("--page", type=Path, default=report.PAGE)
    return top


def main(words: list[str] | None = None) -> int:
    """Entry point; 0 good, 1 mismatches or a user error, 2 usage."""
    arguments = parser().parse_args(words)
    errors = (BenchError, BuildError, MarksError)
    return run_command("fpbench", lambda: arguments.run(arguments), *errors)


if __name__ == "__main__":
    raise SystemExit(main())
