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
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from tests.conformance.machine import MACHINES

FOLDER = BUILD / "conformance"
RESULTS = FOLDER / "torture.json"
EXCLUSIONS = Path(__file__).with_name("exclusions.toml")
BOARDS = Path(__file__).with_name("boards")
LEVELS = ("-O0", "-O2", "-Os")
STACK = 32 * 1024  # bytes that a test may ask for, of 64 KiB of data
RUNTIME = {
    "rtl": ("crt0.S", "exception_entry.S", "io.c", "syscalls.c"),
    "qemu": (
        "crt0.S", "exception_entry.S", "exit_semihost.S", "syscalls.c", "exceptions_none.c"
    ),
}  # fmt: skip
LINE = re.compile(r"^([A-Z]+): (\S+)(?:\s+(.*?))?$")
FAILED = ("FAIL", "UNRESOLVED", "ERROR", "XPASS")


class ToolError(RuntimeError):
    """A tool is missing; the message says how to get it."""


@dataclass
class Outcome:
    """Tests of one system by their fate; a test is a file at one level of optimisation."""

    passed: int = 0
    unsupported: int = 0  # by GCC's own conditions
    excluded: Counter[str] = field(default_factory=Counter)  # reason -> tests
    failed: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)  # exclusions of tests that pass


def run(command: Sequence[str | Path], **options: object) -> str:
    """Standard output of a command that must succeed."""
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


def prefix() -> Path:
    """Folder of the cross compiler. Raises ToolError without it."""
    found = Path(run([ROOT / "scripts/nios_toolchain.sh", "--prefix"]).strip())
    if not (found / "bin/nios2-elf-gcc").exists():
        raise ToolError("no cross compiler; make nios-toolchain builds it")
    return found


def compiler_options(kind: str) -> list[str]:
    """Options of nios-gcc: those of a system, `link`, or what QEMU can execute."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    name = "fpga2" if kind == "qemu" else kind
    words = run(["make", "-s", "-C", ROOT / "nios_sw", f"options-{name}"], env=environment).split()
    return [w for w in words if not (kind == "qemu" and w.startswith("-mcustom-"))]


def runtime(system: str, gcc: Path, folder: Path) -> tuple[list[str], list[str]]:
    """Options of the compiler and of the linker, for programs of a system."""
    code = [*compiler_options(system), f"-I{ROOT / 'nios_sw/include'}"]
    folder.mkdir(parents=True, exist_ok=True)
    objects = []
    for name in RUNTIME["qemu" if system == "qemu" else "rtl"]:
        objects.append(str(folder / f"{Path(name).stem}.o"))
        run([gcc, *code, "-O2", "-c", ROOT / "nios_sw/lib" / name, "-o", objects[-1]])
    places = [f"-L{ROOT / 'nios_sw/link'}", f"-L{ROOT / 'nios_sw/link/gen'}"]
    return code, [*compiler_options("link"), *places, *objects]


def execute(system: str, only: str, output: Path) -> None:
    """Run GCC's harness; the summary is output/gcc.sum."""
    gcc = prefix() / "bin/nios2-elf-gcc"
    tests = Path(run([ROOT / "scripts/nios_toolchain.sh", "--tests"]).strip())
    code, link = runtime(system, gcc, output / "runtime")
    site = [
        f"set srcdir {{{tests}/gcc/testsuite}}",
        f"set tmpdir {{{output}}}",
        "set target_triplet nios2-unknown-elf",
        "set target_alias nios2-elf",
        f"set GCC_UNDER_TEST {{{gcc}}}",
        "set TORTURE_OPTIONS [list " + " ".join(f"{{ {level} }}" for level in LEVELS) + "]",
        f"set boards_dir {{{BOARDS}}}",
        'set tool gcc',
    ]
    write_text(output / "site.exp", "\n".join(site) + "\n")
    machine = [sys.executable, "-m", "tests.conformance.machine", system]
    environment = os.environ | {
        "NIOS_CFLAGS": shlex.join(code),
        "NIOS_LDFLAGS": shlex.join(link),
        "NIOS_STACK": str(STACK),
        "NIOS_MACHINE": shlex.join(machine),
        "PYTHONPATH": str(ROOT),
    }
    command = ["runtest", "--tool", "gcc", "--target_board=nios"]
    for name in ("execute", "ieee", "builtins"):
        command.append(f"{name}.exp" + (f"={only}" if only else ""))
    with open(output / "runtest.out", "wb") as log:
        # The exit status 1 says only that some tests failed.
        done = subprocess.run(command, cwd=output, env=environment, stdout=log, stderr=log)
    if done.returncode > 1 or not (output / "gcc.sum").exists():
        raise ToolError(f"runtest failed, see {output}/runtest.out")


def results(summary: Path) -> Iterator[tuple[str, str, str, str]]:
    """Lines of a summary: result, test, level of optimisation, what was tried."""
    for line in summary.read_text(encoding="utf-8", errors="replace").splitlines():
        if found := LINE.match(line):
            test = found[2].rstrip(",:").removeprefix("gcc.c-torture/execute/")
            rest = found[3] or ""
            level = next((level for level in LEVELS if level in rest.split()), "")
            yield found[1], test, level, rest


def exclusions() -> list[dict[str, object]]:
    """Groups of excluded tests: reason, tests, and where they apply."""
    return tomllib.loads(EXCLUSIONS.read_text(encoding="utf-8"))["group"]


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
    for result, test, level, _ in results(summary):
        fates.setdefault((test, level), set()).add(result)
    outcome, groups = Outcome(), exclusions()
    for (test, level), found in sorted(fates.items()):
        bad = found.intersection(FAILED)
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
        output = FOLDER / f"torture-{system}"
        output.mkdir(parents=True, exist_ok=True)
        execute(system, only, output)
        return judge(system, output / "gcc.sum")

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
