# SPDX-License-Identifier: Apache-2.0
"""Check that the short set finds every planted fault; write build/mutants/report.json."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, command_parser
from sim.core.fpbench import operations
from sim.core.fpbench.native import BenchError, flag_text
from sim.core.fpbench.variants import bench_unit
from sim.report import cache
from sim.rtl.build import BuildError
from tests.bench.faults import TableError
from tests.mutants.campaign import REPORT, Verdict, run, verdict_of
from tests.mutants.faults import COPY, TABLE, Fault, load, write_copy

console = Console(highlight=False, width=None if sys.stdout.isatty() else 200)


def choose(faults: Sequence[Fault], names: Sequence[str]) -> list[Fault]:
    """The faults named by number, macro, file or unit; all without names."""
    if not names:
        return list(faults)
    found = []
    for name in names:
        number = name.removeprefix("FAULT_")
        match = [
            fault
            for fault in faults
            if (number.isdecimal() and fault.number == int(number))
            or name in (fault.name, Path(fault.name).stem)
        ]
        if not match:
            raise TableError(f"no fault '{name}'; give a number, a macro FAULT_<nn> or a file")
        found += match
    return [fault for fault in faults if fault in found]


def table(faults: Sequence[Fault], verdicts: dict[int, Verdict]) -> Table:
    """One row per fault."""
    view = Table("macro", "file", "fault", "caught", "first failing case")
    for fault in faults:
        verdict = verdicts.get(fault.number)
        state = "not run" if verdict is None else "yes" if verdict.caught else "NO"
        case = verdict.case if verdict else ""
        view.add_row(fault.macro, fault.name, fault.breaks, state, case)
    return view


def show(fault: Fault, report: Path) -> int:
    """The first failing case of a fault, on the faulty unit."""
    found = cache.load(verdict_of(fault, report)) or {"case": ""}
    words = dict(word.split("=") for word in found["case"].split()[2:] if "=" in word)
    if "OP" not in words:
        raise TableError(f"{fault.macro}: no failing case yet; run `python -m tests.mutants`")
    op = words["OP"]
    operands = [int(words[name], 16) for name in "ABC"[: operations()[op][1]]]
    result = bench_unit(fault.unit, COPY, {fault.macro: ""}).run_list(op, [operands])
    console.print(f"{fault.macro}: {fault.name}: {fault.breaks}", soft_wrap=True)
    for bad in result.failures:
        got, want = flag_text(bad.got_flags), flag_text(bad.want_flags)
        console.print(f"{bad.arguments}: got {bad.got:08x} {got}, want {bad.want:08x} {want}")
    if not result.failures:
        console.print("this case alone passes: the fault needs its neighbours in the pipeline")
    return 0


@command("python -m tests.mutants")
def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; 0 all caught, 1 a fault not caught, RTL that fails or a user error, 2 usage."""
    prog = "python -m tests.mutants"
    parser = command_parser(prog, __doc__, f"examples: {prog} --only 4 fp_add; {prog} --show 4")
    parser.add_argument("--only", nargs="+", default=[], metavar="FAULT", help="number or file")
    parser.add_argument("--show", metavar="FAULT", help="the failing case of one fault, and stop")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--table", type=Path, default=TABLE, help="another table of faults")
    parser.add_argument(
        "--report", type=Path, default=REPORT, help="file of the verdicts, read and written"
    )
    options = parser.parse_args(argv)
    try:
        faults = load(options.table)
        chosen = choose(faults, [options.show] if options.show else options.only)
        write_copy(faults)
        if options.show:
            return show(chosen[0], options.report)
        console.print(f"{len(chosen)} of {len(faults)} planted faults, {options.jobs} processes")
        verdicts, sounds, problems = run(
            faults, chosen, options.jobs, console.print, options.report
        )
    except (TableError, BenchError, BuildError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    except KeyboardInterrupt:
        console.print("stopped; the verdicts are saved, and the same command continues from here")
        return 130
    console.print(table(chosen, verdicts))
    for problem in problems:
        console.print(f"not run: {problem}", soft_wrap=True, markup=False)
    units = {fault.unit for fault in chosen}
    checked = [entry for op, entry in sounds.items() if operations()[op][0] in units]
    for entry in checked:
        if not entry.good:
            console.print(f"the RTL itself fails: {entry.first}", soft_wrap=True)
    caught = sum(verdicts[f.number].caught for f in chosen if f.number in verdicts)
    cases = sum(entry.cases for entry in checked)
    console.print(
        f"{caught} of {len(chosen)} faults caught; without a fault {len(checked)} operations, "
        f"{cases} cases: {'good' if all(entry.good for entry in checked) else 'FAIL'}"
    )
    console.print(f"written: {options.report}", soft_wrap=True)
    good = caught == len(chosen) and not problems and all(entry.good for entry in checked)
    return int(not good)


if __name__ == "__main__":
    raise SystemExit(main())
