# SPDX-License-Identifier: Apache-2.0
"""Runs the cases of a campaign in forked processes with limits on time and memory.

Case n of a seed is always the same. Cases run in batches; a process that dies or hangs costs one
case, the next batch goes on after it. A case fails if the tool raises anything but SystemExit,
shows a traceback, returns no exit status of 0 to 9, uses more than `CPU_SECONDS` of processor time,
hangs for `WALL_SECONDS`, or maps `MEMORY_BYTES` of address space more than it began with. After
`HANGS` hangs a campaign ends: the rest of its cases would take a minute each.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

CPU_SECONDS = 10
WALL_SECONDS = 60
MEMORY_BYTES = 1 << 30
FILE_BYTES = 1 << 28
HANGS = 3
BATCH = 100
STATUSES = range(10)


@dataclass(frozen=True)
class Campaign:
    """`run(rng)` makes one input in the working directory, which is empty, gives it to the tool and
    returns the exit status. `cases`: of the full set. `prepare` runs once.
    """

    name: str
    cases: int
    run: Callable[[Random], int | None]
    prepare: Callable[[], object] = lambda: None


@dataclass(frozen=True)
class Failure:
    """A case that failed: kind 'traceback', 'status', 'time', 'hang', 'memory' or 'crash'."""

    case: int
    kind: str
    text: str


@dataclass
class Result:
    """Failures of a campaign and what its cases took at most."""

    campaign: str
    seed: int
    cases: int = 0
    failures: list[Failure] = field(default_factory=list)
    slowest_s: float = 0.0
    slowest_case: int = -1
    peak_bytes: int = 0
    statuses: dict[str, int] = field(default_factory=dict)

    def count(self, *kinds: str) -> int:
        """Failures of these kinds."""
        return sum(failure.kind in kinds for failure in self.failures)


def generator(campaign: Campaign, seed: int, case: int) -> Random:
    """The generator of one case."""
    return Random(f"{campaign.name} {seed} {case}")


def run_campaign(
    campaign: Campaign, cases: int, seed: int, progress: Callable[[Result], None] = lambda _: None
) -> Result:
    """Run cases 0 .. cases-1 of the seed, or up to the last of `HANGS` hangs."""
    campaign.prepare()
    result = Result(campaign.name, seed)
    while result.cases < cases and result.count("hang") < HANGS:
        last = min(result.cases + BATCH, cases)
        _run_batch(campaign, range(result.cases, last), result)
        progress(result)
    return result


def replay(campaign: Campaign, seed: int, case: int, folder: Path) -> int | None:
    """Run one case in this process, without limits; its files stay in the folder."""
    campaign.prepare()
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(folder):
        return _status(campaign, generator(campaign, seed, case))


def _status(campaign: Campaign, rng: Random) -> int | None:
    """Exit status of the tool; argparse leaves by SystemExit."""
    try:
        return campaign.run(rng)
    except SystemExit as stop:
        if isinstance(stop.code, int | None):
            return stop.code or 0
        print(stop.code, file=sys.stderr)
        return 1


def _run_batch(campaign: Campaign, cases: range, result: Result) -> None:
    """Add the outcomes of the cases to the result, up to the first that kills the process."""
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        reader, writer = os.pipe()
        pid = os.fork()
        if pid == 0:
            os.close(reader)
            _child(campaign, result.seed, cases, Path(name), writer)
        os.close(writer)
        for outcome in _outcomes(reader):
            _take(result, outcome)
            result.cases += 1
        os.close(reader)
        done = result.cases == cases.stop
        if not done:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        _, status, usage = os.wait4(pid, 0)
        result.peak_bytes = max(result.peak_bytes, usage.ru_maxrss * 1024)
        if not done:
            number = os.waitstatus_to_exitcode(status)
            kind = {-signal.SIGPROF: "time", -signal.SIGKILL: "hang"}.get(number, "crash")
            text = {
                "time": f"more than {CPU_SECONDS} s of processor time",
                "hang": f"stood still for {WALL_SECONDS} s",
            }.get(kind, f"the process ended with {number}")
            result.failures.append(Failure(result.cases, kind, text))
            result.cases += 1


def _outcomes(reader: int) -> Iterator[dict[str, Any]]:
    """Outcomes that a child reports, until it ends or is silent for too long."""
    text = b""
    while select.select([reader], [], [], WALL_SECONDS)[0]:
        block = os.read(reader, 1 << 16)
        if not block:
            return
        text += block
        *lines, text = text.split(b"\n")
        yield from map(json.loads, lines)


def _take(result: Result, outcome: dict[str, Any]) -> None:
    if outcome["seconds"] > result.slowest_s:
        result.slowest_s, result.slowest_case = outcome["seconds"], outcome["case"]
    if outcome["kind"]:
        result.failures.append(Failure(outcome["case"], outcome["kind"], outcome["text"]))
    else:
        status = str(outcome["status"])
        result.statuses[status] = result.statuses.get(status, 0) + 1


def _child(campaign: Campaign, seed: int, cases: range, folder: Path, writer: int) -> None:
    """Run the cases and report each; never returns."""
    os.setsid()
    most = _address_space() + MEMORY_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    shown = folder / "shown"
    output = os.open(shown, os.O_RDWR | os.O_CREAT)
    os.dup2(output, 1)
    os.dup2(output, 2)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)
    try:
        for case in cases:
            os.ftruncate(output, 0)
            os.lseek(output, 0, os.SEEK_SET)
            outcome = _run_case(campaign, seed, case, folder / "case")
            outcome["case"] = case
            if not outcome["kind"]:
                os.lseek(output, 0, os.SEEK_SET)
                if b"Traceback (most recent call last)" in os.read(output, 1 << 20):
                    text = shown.read_text(encoding="utf-8", errors="replace")
                    outcome |= {"kind": "traceback", "text": text[-2000:]}
            os.write(writer, json.dumps(outcome).encode() + b"\n")
    finally:
        os._exit(0)


def _address_space() -> int:
    """Bytes that this process has mapped: a fork of a large one has them before its first case."""
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
    return int(pages) * resource.getpagesize()


def _run_case(campaign: Campaign, seed: int, case: int, folder: Path) -> dict[str, Any]:
    """Outcome of a case: kind '' if the tool behaved."""
    folder.mkdir()
    before = resource.getrusage(resource.RUSAGE_SELF)
    kind, text, status = "", "", None
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
    try:
        with contextlib.chdir(folder):
            status = _status(campaign, generator(campaign, seed, case))
        sys.stdout.flush()
        sys.stderr.flush()
        if status not in STATUSES:
            kind, text = "status", f"exit status {status!r}"
    except MemoryError:
        kind, text = "memory", f"more than {MEMORY_BYTES >> 20} MiB: {_last_lines()}"
    except BaseException:
        kind, text = "traceback", _last_lines()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    after = resource.getrusage(resource.RUSAGE_SELF)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    shutil.rmtree(folder, ignore_errors=True)
    return {"kind": kind, "text": text, "status": status, "seconds": seconds}


def _last_lines() -> str:
    return traceback.format_exc(limit=-4, chain=False)[-2000:]
