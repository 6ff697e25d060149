# SPDX-License-Identifier: Apache-2.0
"""GCC's own execution tests on FPGA1, FPGA2 and QEMU, run by GCC's own harness under DejaGnu.

    python -m tests.conformance.torture                    every system, -O0, -O2 and -Os
    python -m tests.conformance.torture fpga2 --only "20000112-1.c pr*.c"

tests/conformance/exclusions.toml names each test that is not expected to pass, and why. Results go
to build/conformance/torture.json. With --only they replace those of the same files in the last run
of all files, if that was on the same RTL.
"""

from __future__ import annotations

import fnmatch
import json
import os
import shlex
import sys
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.files import write_text
from sim.rtl.figures import rtl_mark
from tests.conformance.machine import MACHINES
from tests.conformance.tools import (
    BAD,
    FOLDER,
    ToolError,
    dejagnu,
    program,
    results,
    runtime,
    suite,
)

RESULTS = FOLDER / "torture.json"
EXCLUSIONS = Path(__file__).with_name("exclusions.toml")
LEVELS = ("-O0", "-O2", "-Os")
RTL = "fpga2"  # n2_system, which both systems are
STACK = 32 * 1024  # bytes that a test may ask for, of 64 KiB of data


@dataclass
class Outcome:
    """Tests of one system by their fate; a test is a file at one level of optimisation."""

    passed: int = 0
    unsupported: int = 0  # by GCC's own conditions
    excluded: Counter[str] = field(default_factory=Counter)  # reason -> tests
    failed: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)  # exclusions of tests that pass


def execute(system: str, only: str, output: Path) -> Path:
    """Run GCC's harness; its summary. Raises ToolError."""
    gcc = program("nios2-elf-gcc")
    code, link = runtime(system, gcc, output / "runtime")
    levels = " ".join(f"{{ {level} }}" for level in LEVELS)
    site = {"GCC_UNDER_TEST": f"{{{gcc}}}", "TORTURE_OPTIONS": f"[list {levels}]"}
    names = (f"{name}.exp" for name in ("execute", "ieee", "builtins"))
    return dejagnu(
        "gcc",
        site,
        [f"{name}={only}" if only else name for name in names],
        output,
        PATH=f"{gcc.parent}{os.pathsep}{os.environ['PATH']}",  # objdump
        NIOS_CFLAGS=shlex.join(code),
        NIOS_LDFLAGS=shlex.join(link),
        NIOS_STACK=str(STACK),
        NIOS_MACHINE=shlex.join([sys.executable, "-m", "tests.conformance.machine", system]),
    )


def test_and_level(text: str) -> tuple[str, str]:
    """Test and level of optimisation of a line of the summary."""
    test = text.split()[0].rstrip(",:").removeprefix("gcc.c-torture/execute/")
    return test, next((level for level in LEVELS if level in text.split()), "")


def exclusions() -> list[dict[str, object]]:
    """Groups of excluded tests: reason, tests, and where they apply."""
    return tomllib.loads(EXCLUSIONS.read_text(encoding="utf-8")).get("group", [])


def reason_of(test: str, system: str, level: str, groups: Sequence[Mapping]) -> str:
    """Why a test is excluded on a system at a level, empty if it is not."""
    for group in groups:
        if system in group.get("systems", MACHINES) and level in group.get("levels", LEVELS):
            if any(fnmatch.fnmatchcase(test, pattern) for pattern in group["tests"]):
                return group["reason"]
    return ""


def fates_of(summary: Path) -> dict[tuple[str, str], set[str]]:
    """Results of each test at each level."""
    fates: dict[tuple[str, str], set[str]] = {}
    for result, text in results(summary):
        # That a test compiles without a message is no verdict on its execution.
        if result == "PASS" and "execut" not in text:
            continue
        fates.setdefault(test_and_level(text), set()).add(result)
    return fates


def judge(system: str, *summaries: Path) -> Outcome:
    """Compare summaries with the table of exclusions; a later one replaces results of its tests."""
    fates: dict[tuple[str, str], set[str]] = {}
    for summary in summaries:
        fates |= fates_of(summary)
    outcome, groups = Outcome(), exclusions()
    for (test, level), found in sorted(fates.items()):
        bad = found.intersection(BAD)
        reason = reason_of(test, system, level, groups)
        if reason:
            outcome.excluded[reason] += 1
            if not bad and "PASS" in found:
                outcome.unused.append(f"{test} {level}")
        elif bad:
            outcome.failed.append(f"{test} {level}")
        elif "PASS" in found:
            outcome.passed += 1
        else:
            outcome.unsupported += 1
    return outcome


def folder(system: str, part: bool = False) -> Path:
    """Where the harness works: in a folder for runs of all files, or of some."""
    return FOLDER / f"torture-{system}{'-part' if part else ''}"


def last_whole(system: str) -> list[Path]:
    """The summary of the last run of all files, if it ended and was on today's RTL."""
    summary, mark = folder(system) / "gcc.sum", folder(system) / "rtl.txt"
    same = mark.exists() and mark.read_text() == rtl_mark(RTL)
    ended = summary.exists() and "=== gcc Summary ===" in summary.read_text(errors="replace")
    return [summary] if same and ended else []


def measure(systems: Sequence[str], only: str = "", jobs: int = 2) -> dict[str, Outcome]:
    """Run the tests on these systems and write the results. Raises ToolError."""
    suite("gcc")  # once, before systems ask for it side by side

    def one(system: str) -> Outcome:
        place = folder(system, part=bool(only))
        place.mkdir(parents=True, exist_ok=True)
        write_text(place / "rtl.txt", rtl_mark(RTL))
        summary = execute(system, only, place)
        return judge(system, *(last_whole(system) if only else ()), summary)

    with ThreadPoolExecutor(jobs) as pool:
        found = dict(zip(systems, pool.map(one, systems), strict=True))
    others = {s: judge(s, *last) for s in MACHINES if s not in found and (last := last_whole(s))}
    known = {s: (found | others)[s] for s in MACHINES if s in found or s in others}
    document = {
        "levels": LEVELS,
        "whole": all(last_whole(system) for system in MACHINES),
        "systems": {name: vars(outcome) for name, outcome in known.items()},
    }
    write_text(RESULTS, json.dumps(document, indent=2) + "\n")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status 1 if a test failed that no exclusion names."""
    parser = command_parser("python -m tests.conformance.torture", __doc__)
    parser.add_argument("systems", nargs="*", metavar="SYSTEM", help=", ".join(MACHINES))
    parser.add_argument("--only", default="", help="patterns of file names")
    parser.add_argument("--jobs", type=int, default=2, help="systems at a time")
    options = parser.parse_args(arguments)
    unknown = set(options.systems).difference(MACHINES)
    if unknown:
        parser.error(f"no system {', '.join(sorted(unknown))}; there are {', '.join(MACHINES)}")
    try:
        found = measure(options.systems or MACHINES, options.only, options.jobs)
    except ToolError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for system, outcome in found.items():
        print(
            f"{system}: {outcome.passed} passed, {len(outcome.failed)} failed, "
            f"{outcome.excluded.total()} excluded, {outcome.unsupported} unsupported"
        )
        for name in outcome.failed:
            print(f"  failed: {name}")
        for name in outcome.unused:
            print(f"  excluded, yet passes: {name}")
    return int(any(outcome.failed for outcome in found.values()))


if __name__ == "__main__":
    sys.exit(main())
