# SPDX-License-Identifier: Apache-2.0
"""Planted faults of arithmetic, custom instructions and core that the cocotb tests alone find.

The faults are those of tests/mutants and of faults.toml here. Those that are expressions are built
into one model, where a plusarg selects one; the others get a build each. The tests
of the module that should find a fault run until the first one fails. Verdicts are cached in
build/cocotb/verdicts.

    .venv/bin/python -m tests.cocotb.planted              all faults, then what was not found
    .venv/bin/python -m tests.cocotb.planted asip 3-fp_add  faults whose name contains a word
"""

from __future__ import annotations

import functools
import re
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from asip_asm.command import script_parser
from asip_asm.project import BUILD
from sim.cocotb import golden
from sim.cocotb.runner import Simulation, outcomes
from sim.report import cache
from sim.report.cache import Entry
from sim.report.goals import Goal, at_least, exactly, not_measured
from sim.rtl import runtime
from sim.rtl.sources import sources_of
from tests.bench import faults as table
from tests.bench.faults import BY_MACRO, BY_NUMBER, RTL, Fault, plant, write_if_changed
from tests.cocotb import test_asip, test_custom, test_units
from tests.cocotb.bench import Run
from tests.mutants import faults as units

OWN = Path(__file__).with_name("faults.toml")
FOLDER = BUILD / "cocotb/planted"
VERDICTS = BUILD / "cocotb/verdicts"
FINDERS = test_units.RUNS | test_custom.RUNS | test_asip.RUNS
LEAST = 90  # % of the faults


CHOICE = """
  int chosen;
  initial if (!$value$plusargs("FAULT=%d", chosen)) chosen = 0;
"""
CONSTANT = re.compile(r"^\d+'")
STATEMENT = re.compile(r"\n| <?= |\bbegin\b|^\s*(\|\||&&|[-+|,=])|[^)\]}\w]$|^(?=.* \? )(?!.* : )")


@dataclass(frozen=True)
class Case:
    """A fault of a table, and the runs of tests/cocotb, by name, that should find it."""

    name: str
    fault: Fault
    runs: tuple[str, ...]
    table: str

    @property
    def shared(self) -> bool:
        """Whether the fault is an expression, so that it can be one of many in a model."""
        if self.table == "own":
            return True
        right, wrong = self.fault.right, self.fault.wrong
        whole = all(not STATEMENT.search(text) and closed(text) for text in (right, wrong))
        return whole and not self.fault.alone and not CONSTANT.search(right)


def closed(text: str) -> bool:
    """Whether every bracket of the text has its partner in it."""
    return all(text.count(opening) == text.count(end) for opening, end in ("()", "[]", "{}"))


def bare(fault: Fault) -> Fault:
    """The fault without the end of its statement."""
    texts = {name: getattr(fault, name).strip() for name in ("right", "wrong")}
    if all(text.endswith(";") for text in texts.values()):
        texts = {name: text[:-1].rstrip() for name, text in texts.items()}
        return replace(fault, place=fault.place or fault.right, **texts)
    return fault


@functools.cache
def cases() -> tuple[Case, ...]:
    """All faults, those of the arithmetic units first. Raises TableError."""
    found = []
    for fault in units.load():
        found.append(Case(f"units-{fault}", bare(fault), (fault.unit,), "units"))
    for fault in table.load(OWN):
        if unknown := set(fault.found) - FINDERS.keys():
            raise fault.error(f"found: no run {', '.join(unknown)}; there are {', '.join(FINDERS)}")
        found.append(Case(f"own-{fault}", bare(fault), fault.found, "own"))
    return tuple(found)


def write_copies() -> None:
    """The files with all expressions that are faults, and for the others with a macro each."""
    files = {(case.table, case.fault.file) for case in cases()}
    for name, file in files:
        mine = [c for c in cases() if (c.table, c.fault.file) == (name, file)]
        text = (RTL / file).read_text()
        shared = plant(text, [c.fault for c in mine if c.shared], BY_NUMBER)
        head, ports, body = shared.partition("\n);\n")
        write_if_changed(copy_of(name, "shared", file), head + ports + CHOICE + body)
        alone = plant(text, [c.fault for c in mine if not c.shared], BY_MACRO)
        write_if_changed(copy_of(name, "alone", file), alone)


def copy_of(name: str, kind: str, file: str) -> Path:
    """Where a copy is."""
    return FOLDER / name / kind / file


def sources(case: Case, run: Run) -> list[Path]:
    """Files of the run's module: copies for those with faults, or for the one with the fault."""
    paths = []
    for path in sources_of(run.top):
        file = str(path.relative_to(RTL))
        if case.shared:
            wanted = any(
                c.shared and (c.table, c.fault.file) == (case.table, file) for c in cases()
            )
        else:
            wanted = file == case.fault.file
        paths.append(copy_of(case.table, "shared" if case.shared else "alone", file)
                     if wanted else path)  # fmt: skip
    return paths


def entry(case: Case) -> Entry:
    """Where the verdict is cached: for RTL, tests, golden model, tools and the fault itself."""
    paths: list[Path] = []
    for run in (FINDERS[name] for name in case.runs):
        names = {getattr(value, "__module__", "") or "" for value in vars(run.bench).values()}
        drivers = [sys.modules[name] for name in sorted(names) if name.startswith("sim.cocotb.")]
        paths += [Path(module.__file__) for module in (run.bench, golden, *drivers)]
        paths += sources_of(run.top)
    choices = [(FINDERS[name].parameters, FINDERS[name].only) for name in case.runs]
    of = cache.fingerprint(paths, case, runtime.toolchain(), choices)
    return Entry(VERDICTS / f"{case.name}.json", of)


def finder(case: Case) -> str:
    """Name of the first test that fails with the fault; empty if all pass."""
    return next(filter(None, (finder_in(case, name) for name in case.runs)), "")


def finder_in(case: Case, name: str) -> str:
    """The same in one run."""
    run, folder = FINDERS[name], FOLDER / case.name
    flags = () if case.shared else (f"-D{case.fault.macro}",)
    simulation = Simulation(run.top, sources(case, run), folder, run.parameters, flags)
    plusargs = [f"+FAULT={case.fault.number}"]
    try:
        results = run.start(simulation, plusargs, COCOTB_MAX_FAILURES="1")
        bad = [f"{name} {test}" for test, why in outcomes(results).items() if why]
    except AssertionError:  # An assertion of the RTL ended the simulation.
        bad = [f"{name}: an assertion in the RTL"]
    if not case.shared:
        shutil.rmtree(simulation.build_folder, ignore_errors=True)
    shutil.rmtree(folder, ignore_errors=True)
    return bad[0] if bad else ""


def campaign(words: Sequence[str] = ()) -> dict[str, str]:
    """Test that finds each fault, by the fault's name; empty for a fault that no test finds."""
    write_copies()
    chosen = [c for c in cases() if not words or any(word in c.name for word in words)]
    found = {}
    for case in chosen:
        by = found[case.name] = cache.result_of(entry(case), functools.partial(finder, case))
        print(f"{case.name}: {by or 'NOT FOUND: ' + case.fault.breaks}", flush=True)
    return found


def unsound() -> list[str]:
    """Tests that fail in the models of many faults although no fault was selected."""
    bad = []
    for name, run in FINDERS.items():
        case = next((c for c in cases() if c.shared and name in c.runs), None)
        if case:
            folder = FOLDER / f"control-{name}"
            simulation = Simulation(run.top, sources(case, run), folder, run.parameters)
            found = outcomes(run.start(simulation))
            bad += [f"{name} {test}" for test, why in found.items() if why]
    return bad


def rows(full: bool) -> Iterator[Goal]:
    """The goals."""
    name = "planted faults found by cocotb tests alone"
    if not full:
        yield not_measured(name, f">= {LEAST}", "%", "make goals T=hardware RUN=full")
        return
    verdicts = campaign()
    lost = [name for name, by in verdicts.items() if not by]
    share = 100 * (1 - len(lost) / len(verdicts))
    yield at_least(name, share, LEAST, "%", ", ".join(lost))
    bad = unsound()
    name = "cocotb tests that fail in those models without a fault"
    yield exactly(name, len(bad), 0, "tests", ", ".join(bad))


def main(words: Sequence[str] | None = None) -> int:
    """Command line; exit 1 if a fault is not found."""
    parser = script_parser(__doc__, "python -m tests.cocotb.planted asip fp_add")
    parser.add_argument("words", nargs="*", help="faults whose name contains one of them; all")
    verdicts = campaign(parser.parse_args(words).words)
    print(f"{sum(map(bool, verdicts.values()))} of {len(verdicts)} found")
    return int(not all(verdicts.values()))


if __name__ == "__main__":
    sys.exit(main())
