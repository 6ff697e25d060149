# SPDX-License-Identifier: Apache-2.0
"""Check the types of asip_asm, sim and scripts with mypy, by the settings in pyproject.toml.

There is no error in asip_asm and scripts. In sim there are still some; no folder of it may have
more than `LEFT` allows. Exit status 1 with the errors of each
folder that has more.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence

from asip_asm.command import command
from asip_asm.project import ROOT

LEFT: Mapping[str, int] = {
    "sim/bench": 92,
    "sim/bus": 19,
    "sim/cocotb": 69,
    "sim/core": 51,
    "sim/debug": 60,
    "sim/laws": 58,
    "sim/moved.py": 4,
    "sim/motion": 177,
    "sim/report": 2,
    "sim/robot": 10,
    "sim/rtl": 23,
}
"""Errors by file or folder when the check was introduced. Lower them, never raise one."""
ERROR = re.compile(r"((?:[\w]+/)+[\w.]+):\d+: error: ")


def folder_of(file: str) -> str:
    """Package of a file; of sim its room; a file of `LEFT` counts by itself."""
    if file in LEFT:
        return file
    package, *rest = file.split("/")
    return f"{package}/{rest[0]}" if package == "sim" else package


def by_folder(lines: Sequence[str]) -> dict[str, list[str]]:
    """The errors of mypy's output by their folder. Raises ValueError for one without a file."""
    found: dict[str, list[str]] = defaultdict(list)
    for line in lines:
        match = ERROR.match(line)
        if match:
            found[folder_of(match[1])].append(line)
        elif "error: " in line:
            raise ValueError(line)
    return found


def findings(found: Mapping[str, Sequence[str]], left: Mapping[str, int]) -> list[str]:
    """The errors of each folder that has more than it may have, with a line that says so."""
    lines = []
    for folder, errors in sorted(found.items()):
        if len(errors) > left.get(folder, 0):
            lines += [*errors, f"{folder}: {len(errors)} errors, {left.get(folder, 0)} allowed"]
    return lines


@command("scripts/lint_types.py")
def main() -> int:
    """Run mypy; returns the exit status."""
    mypy = [sys.executable, "-m", "mypy", "--no-error-summary", "--hide-error-context"]
    done = subprocess.run(mypy, cwd=ROOT, capture_output=True, text=True)
    try:
        found = by_folder(done.stdout.splitlines())
    except ValueError as error:
        print(f"mypy: {error}", file=sys.stderr)
        return 1
    if done.returncode > 1 or (done.returncode and not found):
        print(done.stdout + done.stderr, file=sys.stderr)
        return 1
    lines = findings(found, LEFT)
    for line in lines:
        print(line, file=sys.stderr)
    if not lines:
        print(
            f"types: {sum(map(len, found.values()))} errors left, of {sum(LEFT.values())} allowed"
        )
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main())
