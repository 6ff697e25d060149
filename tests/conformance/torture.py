# SPDX-License-Identifier: Apache-2.0
"""GCC's own execution tests on FPGA1, FPGA2 and QEMU, run by GCC's own harness under DejaGnu.

    python -m tests.conformance.torture                    every system, -O0, -O2 and -Os
    python -m tests.conformance.torture fpga2 --only "20000112-1.c pr*.c"

tests/conformance/exclusions.toml names each test that is not expected to pass, and why. Results go
to build/conformance/torture.json.
"""

from __future__ import annotations

import fnmatch
import json
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


def judge(system: str, summary: Path) -> Outcome:
    """Compare a summary with the table of exclusions."""
    fates: dict[tuple[str, str], set[str]] = {}
    for result, text in results(summary):
        # That a test compiles without a message is no verdict on its execution.
        if result == "PASS" and "execut" not in text:
            continue
        fates.setdefault(test_and_level(text), set()).add(result)
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


def measure(systems: Sequence[str], only: str = "", jobs: int = 2) -> dict[str, Outcome]:
    """Run the tests on these systems and write the results. Raises ToolError."""

    def one(system: str) -> Outcome:
        return judge(system, execute(system, only, FOLDER / f"torture-{system}"))

    suite("gcc")  # once, before systems ask for it side by side
    with ThreadPoolExecutor(jobs) as pool:
        found = dict(zip(systems, pool.map(one, systems), strict=True))
    document = {
        "levels": LEVELS,
        "whole": not only and set(systems) == set(MACHINES),
        "systems": {name: vars(outcome) for name, outcome in found.items()},
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
