# SPDX-License-Identifier: Apache-2.0
"""GDB's own tests of remote targets, against the GDB stub of nios-run.

    python -m tests.conformance.gdb_suite                  the files of gdb_suite.toml
    python -m tests.conformance.gdb_suite break.exp        some of them, the others keep results

gdb_suite.toml names the files, and each failure that is expected, with its reason. Results go to
build/conformance/gdb.json.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from asip_asm.command import command_parser
from asip_asm.files import write_text
from sim.rtl.nios_rtl import NiosRtl
from tests.conformance.tools import BAD, FOLDER, ToolError, dejagnu, program, runtime

RESULTS = FOLDER / "gdb.json"
TABLE = Path(__file__).with_name("gdb_suite.toml")
SYSTEM = "fpga2"
RUNNING = re.compile(r"^Running \S*/(gdb\.\w+/\S+\.exp) \.\.\.")
STALE = "no failure matches:"
RESULT = re.compile(r"^([A-Z]+): (?:gdb\.\w+/\S+\.exp: )?(.*)$")


def table() -> dict[str, Any]:
    """Files, and expected failures by file and text."""
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))


def judge(lines: Sequence[str]) -> list[dict[str, Any]]:
    """A row for each file: results by kind, and its failures."""
    rows: dict[str, dict[str, Any]] = {}
    row: dict[str, Any] = {}
    for line in lines:
        if found := RUNNING.match(line):
            row = rows.setdefault(
                found[1], {"file": found[1], "counts": Counter(), "failed": [], "explained": []}
            )
        elif row and (found := RESULT.match(line)):
            row["counts"][found[1]] += 1
            if found[1] in BAD:
                row["failed"].append(found[2])
    return list(rows.values())


def explain(row: dict[str, Any], expected: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """The row with its failures divided into those that the table explains, and the others.

    A pattern of the table that matches no failure is one of the others.
    """
    patterns = expected.get(Path(row["file"]).name, {})
    failures = [*row["explained"], *(t for t in row["failed"] if not t.startswith(STALE))]
    known = [text for text in failures if any(fnmatchcase(text, key) for key in patterns)]
    stale = [f"{STALE} {key}" for key in patterns if not any(fnmatchcase(t, key) for t in known)]
    return row | {"explained": known, "failed": [*(t for t in failures if t not in known), *stale]}


def measure(files: Sequence[str]) -> list[dict[str, Any]]:
    """Run these files, all by default; writes the results. Raises ToolError."""
    names = table()["files"]
    NiosRtl(SYSTEM, debug=True)  # built before GDB waits for it
    gcc = program("nios2-elf-gcc")
    output = FOLDER / "gdb"
    code, link = runtime(SYSTEM, gcc, output / "runtime")
    run = [Path(sys.executable).with_name("nios-run"), "--system", SYSTEM]
    summary = dejagnu(
        "gdb",
        {
            "GDB": f"{{{program('nios2-elf-gdb')}}}",
            # A model starts in seconds, on a busy machine in many.
            "GDBFLAGS": '{-iex "set remotetimeout 60"}',
        },
        [f"gdb.base/{file}" for file in files or names],
        output,
        PATH=f"{gcc.parent}{os.pathsep}{os.environ['PATH']}",  # strip, objcopy
        NIOS_GCC=str(gcc),
        NIOS_CFLAGS=shlex.join(code),
        # Functions that only GDB calls stay.
        NIOS_LDFLAGS=shlex.join([*link, "-Wl,--no-gc-sections"]),
        NIOS_RUN=shlex.join(map(str, run)),
    )
    expected = table()["expected"]
    rows = judge(summary.read_text(errors="replace").splitlines())
    rows = [explain(row, expected) for row in rows]
    save(rows, names, expected)
    return rows


def save(
    rows: Sequence[dict[str, Any]], files: Sequence[str], expected: Mapping[str, Mapping[str, str]]
) -> None:
    """Write rows in place of earlier ones of the same files."""
    earlier = json.loads(RESULTS.read_text())["files"] if RESULTS.exists() else []
    found = {row["file"]: row for row in [*earlier, *rows]}
    wanted = [f"gdb.base/{file}" for file in files]
    kept = [explain(found[name], expected) for name in wanted if name in found]
    document = {"whole": len(kept) == len(files), "files": kept}
    write_text(RESULTS, json.dumps(document, indent=2) + "\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status 1 if a test failed without a reason in the table."""
    parser = command_parser("python -m tests.conformance.gdb_suite", __doc__)
    parser.add_argument("files", nargs="*", metavar="FILE", help="files of gdb.base")
    try:
        rows = measure(parser.parse_args(arguments).files)
    except ToolError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for row in rows:
        counts = ", ".join(f"{n} {kind}" for kind, n in sorted(row["counts"].items()))
        print(f"{row['file']}: {counts or 'nothing'}")
        for text in row["failed"]:
            print(f"  failed: {text}")
    return int(any(row["failed"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
