# SPDX-License-Identifier: Apache-2.0
"""GDB's own tests of remote targets, against the GDB stub of nios-run.

    python -m tests.conformance.gdb_suite                  the files of gdb_suite.toml
    python -m tests.conformance.gdb_suite break.exp        some of them

gdb_suite.toml names the files, and each failure that is expected, with its reason. Results go to
build/conformance/gdb.json.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.files import write_text
from sim.harness.nios_rtl import NiosRtl
from tests.conformance.tools import BAD, FOLDER, ToolError, dejagnu, program, runtime

RESULTS = FOLDER / "gdb.json"
TABLE = Path(__file__).with_name("gdb_suite.toml")
SYSTEM = "fpga2"
RUNNING = re.compile(r"^Running \S*/(gdb\.\w+/\S+\.exp) \.\.\.")
RESULT = re.compile(r"^([A-Z]+): (?:gdb\.\w+/\S+\.exp: )?(.*)$")


def judge(lines: Sequence[str], expected: dict[str, dict[str, str]]) -> list[dict[str, object]]:
    """A row for each file: results by kind, failures that no reason explains."""
    rows: dict[str, dict] = {}
    row: dict = {}
    for line in lines:
        if found := RUNNING.match(line):
            counts: Counter[str] = Counter()
            row = rows.setdefault(
                found[1], {"file": found[1], "counts": counts, "failed": [], "explained": []}
            )
        elif row and (found := RESULT.match(line)):
            row["counts"][found[1]] += 1
            if found[1] in BAD:
                reasons = expected.get(Path(row["file"]).name, {})
                known = next((why for text, why in reasons.items() if text in found[2]), "")
                row["explained" if known else "failed"].append(found[2])
    return list(rows.values())


def measure(files: Sequence[str]) -> list[dict[str, object]]:
    """Run these files, all by default; writes the results. Raises ToolError."""
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
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
        [f"gdb.base/{file}" for file in files or table["files"]],
        output,
        NIOS_GCC=str(gcc),
        NIOS_CFLAGS=shlex.join(code),
        # Functions that only GDB calls stay.
        NIOS_LDFLAGS=shlex.join([*link, "-Wl,--no-gc-sections"]),
        NIOS_RUN=shlex.join(map(str, run)),
    )
    rows = judge(summary.read_text(errors="replace").splitlines(), table.get("expected", {}))
    write_text(RESULTS, json.dumps({"whole": not files, "files": rows}, indent=2) + "\n")
    return rows


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
