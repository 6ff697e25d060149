# SPDX-License-Identifier: Apache-2.0
"""Planted faults of arithmetic units, custom instructions and core that the cocotb tests alone find.

The faults are those of tests/mutants and of faults.toml here. Each is built into the module whose
cocotb tests should find it, and the tests run until the first one fails. Verdicts are cached by
what they depend on in build/cocotb/planted.json.

    .venv/bin/python -m tests.cocotb.planted              all faults, then what was not found
    .venv/bin/python -m tests.cocotb.planted asip 3-fp_add  faults whose name contains a word
"""

from __future__ import annotations

import hashlib
import json
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from asip_asm.files import write_text
from asip_asm.project import BUILD
from sim.cocotb import golden
from sim.cocotb.runner import Simulation, outcomes
from sim.goals import Goal, at_least, not_measured
from sim.harness import runtime
from sim.harness.sources import sources_of
from tests.bench import faults as table
from tests.bench.faults import BY_MACRO, RTL, Fault
from tests.cocotb import test_asip, test_custom, test_units
from tests.cocotb.bench import Run
from tests.mutants import faults as units

OWN = Path(__file__).with_name("faults.toml")
FOLDER = BUILD / "cocotb/planted"
REPORT = BUILD / "cocotb/planted.json"
FINDERS = test_units.RUNS | test_custom.RUNS | test_asip.RUNS
LEAST = 90  # % of the faults
JOBS = 1


@dataclass(frozen=True)
class Case:
    """A fault and the run of tests/cocotb, by its name, that should find it."""

    name: str
    fault: Fault
    run: str
    copy: Path  # of rtl, with the fault's macro


def cases() -> list[Case]:
    """All faults, those of the arithmetic units first. Raises TableError."""
    found = []
    for fault in units.load():
        found.append(Case(f"units-{fault}", fault, fault.unit, FOLDER / "units"))
    for fault in table.load(OWN):
        for run in fault.found:
            if run not in FINDERS:
                raise fault.error(f"found: no run '{run}'; there are {', '.join(FINDERS)}")
            found.append(Case(f"{run}-{fault}", fault, run, FOLDER / "own"))
    return found


def write_copies() -> None:
    """The sources with all faults, each behind its macro."""
    units.write_copy(units.load(), FOLDER / "units/fpu")
    for part in ("asip", "custom"):
        mine = [fault for fault in table.load(OWN) if fault.file.startswith(part)]
        table.copy(FOLDER / "own" / part, mine, BY_MACRO, part)


def sources(case: Case, run: Run) -> list[Path]:
    """Files of the run's module; the one with the fault is the copy."""
    original = RTL / case.fault.file
    changed = case.copy / case.fault.file
    return [changed if path == original else path for path in sources_of(run.top)]


def fingerprint(case: Case) -> str:
    """Hash of all that the verdict depends on."""
    run = FINDERS[case.run]
    digest = hashlib.sha256(repr((case.fault, run.parameters, run.only)).encode())
    digest.update(runtime.toolchain().encode())
    names = {getattr(value, "__module__", "") or "" for value in vars(run.bench).values()}
    drivers = [sys.modules[name] for name in sorted(names) if name.startswith("sim.cocotb.")]
    files = [Path(module.__file__) for module in (run.bench, golden, *drivers)]
    files += sources_of(run.top)
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def finder(case: Case) -> str:
    """Name of the first test that fails with the fault; empty if all pass."""
    run = FINDERS[case.run]
    folder = FOLDER / case.name
    macro = f"-D{case.fault.macro}"
    simulation = Simulation(run.top, sources(case, run), folder, run.parameters, (macro,))
    try:
        results = run.start(simulation, COCOTB_MAX_FAILURES="1")
        bad = [name for name, why in outcomes(results).items() if why]
    except AssertionError:  # An assertion of the RTL ended the simulation.
        bad = ["an assertion in the RTL"]
    shutil.rmtree(simulation.build_folder, ignore_errors=True)
    shutil.rmtree(folder, ignore_errors=True)
    return bad[0] if bad else ""


def judged(chosen: Sequence[Case], known: dict[str, dict]) -> Iterator[tuple[Case, dict]]:
    """Verdicts, the cached ones first."""
    marks = {case.name: fingerprint(case) for case in chosen}
    old = [c for c in chosen if known.get(c.name, {}).get("mark") == marks[c.name]]
    yield from ((case, known[case.name]) for case in old)
    with ThreadPoolExecutor(JOBS) as pool:
        tasks = {pool.submit(finder, case): case for case in chosen if case not in old}
        for task in as_completed(tasks):
            case = tasks[task]
            yield case, {"mark": marks[case.name], "by": task.result()}


def campaign(words: Sequence[str] = ()) -> dict[str, dict]:
    """Verdict of each fault by its name; written after each one, so that a stop loses nothing."""
    write_copies()
    known = json.loads(REPORT.read_text()) if REPORT.exists() else {}
    chosen = [c for c in cases() if not words or any(word in c.name for word in words)]
    found = {}
    for case, verdict in judged(chosen, known):
        known[case.name] = found[case.name] = verdict
        print(f"{case.name}: {verdict['by'] or 'NOT FOUND: ' + case.fault.breaks}", flush=True)
        REPORT.parent.mkdir(parents=True, exist_ok=True)
        write_text(REPORT, json.dumps(known, indent=1) + "\n")
    return found


def share(verdicts: Mapping[str, dict]) -> float:
    """Percent of the faults that were found."""
    return 100 * sum(bool(v["by"]) for v in verdicts.values()) / len(verdicts)


def rows(full: bool) -> Iterator[Goal]:
    """The goal."""
    name = "planted faults found by cocotb tests alone"
    if not full:
        yield not_measured(name, f">= {LEAST}", "%", "make goals T=hardware RUN=full")
        return
    verdicts = campaign()
    lost = [name for name, verdict in verdicts.items() if not verdict["by"]]
    yield at_least(name, share(verdicts), LEAST, "%", ", ".join(lost))


def main(words: Sequence[str]) -> int:
    """Command line; exit 1 if a fault is not found."""
    verdicts = campaign(words)
    print(f"{sum(bool(v['by']) for v in verdicts.values())} of {len(verdicts)} found")
    return int(any(not v["by"] for v in verdicts.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
