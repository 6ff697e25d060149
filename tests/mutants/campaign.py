# SPDX-License-Identifier: Apache-2.0
"""Runs the short set against the planted faults.

All faults of a unit are simulated together, each in a lane of its own next to one without fault,
and every case goes to every lane, one build per unit. The first cases of the short set decide
nearly every fault; what they leave, and what breaks the handshake, is built alone with its macro
and gets all of it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.core.fpbench import Mismatch, Unit, operations, quick
from sim.core.fpbench.directed import rows_of
from sim.core.fpbench.native import RTL
from sim.core.fpbench.quick import parts, run_parts
from sim.core.fpbench.variants import bench_unit, fingerprint, lane_sources
from sim.report import cache
from sim.report.cache import Entry
from sim.rtl.build import BuildError
from sim.rtl.processes import processes
from tests.mutants.faults import BUILD, COPY, Fault, write_lanes

REPORT = BUILD / "report.json"
SHORT_SET = ROOT / "sim/core/fpbench/quick.py"
SEED = 1
BLOCK = 16384  # rows that the bench takes through the lanes without a break
SHARED_CASES = {"fp_sincos": 4_000}  # random cases in shared simulation
DEFAULT_SHARED_CASES = 100_000


@dataclass(frozen=True)
class Verdict:
    """What became of one fault. `case` is the first failing case or what went wrong."""

    number: int
    caught: bool
    case: str
    after: int  # cases up to the end of the block that found it
    alone: bool


@dataclass(frozen=True)
class Sound:
    """The short set of one operation on the RTL itself."""

    op: str
    good: bool
    cases: int
    first: str


def verdict_of(fault: Fault, report: Path) -> Entry:
    """Where a verdict is cached: for RTL and bench of the unit, the fault, and the short set."""
    choices = (
        fault.number,
        fault.file,
        fault.place,
        fault.ops,
        fault.right,
        fault.wrong,
        fault.alone,
    )
    sizes = (SEED, SHARED_CASES, DEFAULT_SHARED_CASES)
    rows = [rows_of(op) for op in fault.ops]
    of = cache.fingerprint([SHORT_SET], fingerprint(fault.unit), choices, sizes, rows)
    return Entry(report.with_suffix("") / f"{fault.number}.json", of)


def blocks(unit: Unit, op: str, rows: int) -> Iterator[np.ndarray]:
    """Operands of the short set in blocks of up to `rows`, without the part that has gaps."""
    if directed := rows_of(op):
        words = np.zeros((len(directed), 3), np.uint32)
        words[:, : operations()[op][1]] = directed
        yield words
    cases = SHARED_CASES.get(unit.name, DEFAULT_SHARED_CASES)
    for part in parts(unit, op, SEED, cases):
        if part.gaps:
            continue
        # In one call: random cases are a function of where a run starts.
        words = unit.operands(op, part.kind, part.start, part.count, part.seed)
        for start in range(0, len(words), rows):
            yield words[start : start + rows]


def wrong_lanes(unit: Unit, op: str, words: np.ndarray, lanes: int) -> tuple[np.ndarray, ...]:
    """(wrong, bits, flags), each of shape (cases, lanes): what each lane made of each case."""
    rows = np.repeat(words, lanes, axis=0)
    report, bits, flags = unit.answers(op, rows)
    if report.protocol:
        raise BuildError(f"{op}: {report.protocol}; mark the fault that does so `alone = true`")
    shape = (len(words), lanes)
    bits, flags = bits.reshape(shape), flags.reshape(shape)
    if unit.name != "fp_sincos":
        want, want_flags = unit.reference(op, words)
        wrong = (bits != want[:, None]) | (flags != want_flags[:, None])
        return wrong, bits, flags
    # The check of sine and cosine shows no more than 16 failures: ask it case by case, and only
    # where a lane differs from the one without fault.
    wrong = np.zeros(shape, bool)
    differs = (bits != bits[:, :1]) | (flags != flags[:, :1])
    for lane in range(1, lanes):
        for row in np.flatnonzero(differs[:, lane]):
            failures = unit.run_list(op, rows[row * lanes : (row + 1) * lanes]).failures
            got = {(failure.got, failure.got_flags) for failure in failures}
            wrong[row, lane] = (int(bits[row, lane]), int(flags[row, lane])) in got
            if wrong[row, lane]:
                break
    return wrong, bits, flags


def shared(unit_name: str, faults: Sequence[Fault]) -> list[Verdict]:
    """Verdicts of the faults of one unit that a shared simulation finds.

    Raises BuildError if the lane without fault fails or the handshake breaks.
    """
    lanes = len(faults) + 1
    top = write_lanes(unit_name, faults, lane_sources(unit_name))
    unit = bench_unit(unit_name, COPY, lanes=lanes, top=top)
    found: dict[int, Verdict] = {}
    for op in dict.fromkeys(op for fault in faults for op in fault.ops):
        done = 0
        for words in blocks(unit, op, BLOCK // lanes):
            open_lanes = [
                lane
                for lane, fault in enumerate(faults, 1)
                if op in fault.ops and fault.number not in found
            ]
            if not open_lanes:
                break
            wrong, bits, flags = wrong_lanes(unit, op, words, lanes)
            done += len(words)
            count = operations()[op][1]
            for lane in [0, *open_lanes]:
                if not wrong[:, lane].any():
                    continue
                row = int(np.argmax(wrong[:, lane]))
                operands = tuple(int(word) for word in words[row, :count])
                got, got_flags = int(bits[row, lane]), int(flags[row, lane])
                case = f"microtick fp case {Mismatch(op, operands, got, 0, got_flags, 0).arguments}"
                if lane == 0:
                    raise BuildError(f"the RTL without a fault fails: {case}")
                fault = faults[lane - 1]
                found[fault.number] = Verdict(fault.number, True, case, done, False)
    return list(found.values())


def alone(fault: Fault) -> Verdict:
    """Verdict of one fault, built with its macro, by the whole short set of its operations."""
    done, unit = 0, bench_unit(fault.unit, COPY, {fault.macro: ""})
    for op in fault.ops:
        report = run_parts(unit, op, SEED)
        done += report.cases
        if not report.good:
            case = report.protocol or f"microtick fp case {report.failures[0].arguments}"
            return Verdict(fault.number, True, case, done, True)
    return Verdict(fault.number, False, "not found", done, True)


def batch(unit: str, faults: Sequence[Fault]) -> list[Verdict]:
    """Verdicts of all faults of a unit."""
    together = [fault for fault in faults if not fault.alone]
    verdicts = shared(unit, together) if together else []
    found = {verdict.number for verdict in verdicts}
    return verdicts + [alone(fault) for fault in faults if fault.number not in found]


def sound_of(op: str, report: Path) -> Entry:
    """Where the run of an operation on the RTL itself is cached."""
    of = cache.fingerprint([SHORT_SET], fingerprint(operations()[op][0]), SEED, rows_of(op))
    return Entry(report.with_suffix("") / f"{op}.json", of)


def sound(ops: Sequence[str]) -> list[Sound]:
    """The short set of operations of one unit on the RTL itself."""
    results = []
    for op in ops:
        report = quick(op, RTL, seed=SEED)
        first = report.protocol or (str(report.failures[0]) if report.failures else "")
        results.append(Sound(op, report.good, report.cases, first))
    return results


def store(
    faults: Sequence[Fault], verdicts: dict[int, Verdict], sounds: dict[str, Sound], path: Path
) -> None:
    """Write the report: every fault with a verdict, in order, and the runs without fault."""
    texts = {
        fault.number: {
            "macro": fault.macro,
            "file": fault.name,
            "unit": fault.unit,
            "ops": list(fault.ops),
            "breaks": fault.breaks,
        }
        for fault in faults
    }
    rows = [texts[n] | asdict(verdicts[n]) for n in sorted(verdicts) if n in texts]
    data = {
        "seed": SEED,
        "total": len(faults),
        "caught": sum(row["caught"] for row in rows),
        "faults": rows,
        "sound": [asdict(entry) for entry in sounds.values()],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(data, indent=1) + "\n")


def run(
    faults: Sequence[Fault],
    chosen: Sequence[Fault],
    jobs: int,
    told: Callable[[str], None],
    path: Path,
) -> tuple[dict[int, Verdict], dict[str, Sound], list[str]]:
    """Check the chosen faults and the RTL itself; cached verdicts that still count are taken.

    path: file of the report; the cache is the folder of its name next to it. `faults` is the whole
    table, already written to COPY. Returns the verdicts, the runs without fault, and what could not
    be run.
    """
    # Taken before the run: if a source changes meanwhile, the next run does not find the verdict.
    of_faults = {fault.number: verdict_of(fault, path) for fault in faults}
    of_ops = {op: sound_of(op, path) for op in operations()}
    verdicts = {n: Verdict(**v) for n, entry in of_faults.items() if (v := cache.load(entry))}
    sounds = {op: Sound(**s) for op, entry in of_ops.items() if (s := cache.load(entry))}
    problems: list[str] = []
    with processes(jobs) as pool:
        tasks = {}
        for unit in dict.fromkeys(fault.unit for fault in chosen):
            mine = [each for each in chosen if each.unit == unit and each.number not in verdicts]
            if mine:
                tasks[pool.submit(batch, unit, mine)] = f"{unit}: {len(mine)} faults"
            ops = [op for op, (owner, _) in operations().items() if owner == unit]
            if ops := [op for op in ops if op not in sounds]:
                tasks[pool.submit(sound, ops)] = f"{unit}: no fault, {len(ops)} ops"
        for task in as_completed(tasks):
            try:
                for result in task.result():
                    if isinstance(result, Verdict):
                        verdicts[result.number] = result
                        cache.save(of_faults[result.number], asdict(result))
                    else:
                        sounds[result.op] = result
                        cache.save(of_ops[result.op], asdict(result))
                store(faults, verdicts, sounds, path)
                told(f"  {tasks[task]}: done")
            except BuildError as error:
                problems.append(f"{tasks[task]}: {error}")
                told(f"  {tasks[task]}: not run")
    return verdicts, sounds, problems
