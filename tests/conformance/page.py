# SPDX-License-Identifier: Apache-2.0
"""Write the measured tables of docs/conformance.md from build/conformance/*.json."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from asip_asm.project import ROOT
from sim.report.marks import write_between_marks
from tests.conformance import coremark, dap_sessions, gdb_suite, torture

PAGE = ROOT / "docs/conformance.md"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)


def dap_section(document: dict[str, Any]) -> str:
    """Checks by core."""
    cores = document["cores"]
    names = [check["check"] for check in next(iter(cores.values()))]
    passed = {
        core: {check["check"]: check["passed"] for check in checks}
        for core, checks in cores.items()
    }
    words = {True: "passes", False: "**fails**"}
    rows = ([name, *(words[passed[core][name]] for core in cores)] for name in names)
    return table(["check", *cores], rows)


def gdb_section(document: dict[str, Any]) -> str:
    """Files with their results, then the reasons of expected failures."""
    counted = ("PASS", "UNSUPPORTED", "UNTESTED")
    rows = []
    total = [0] * 5
    for row in document["files"]:
        counts = [row["counts"].get(kind, 0) for kind in counted]
        numbers = [*counts, len(row["explained"]), len(row["failed"])]
        total = [a + b for a, b in zip(total, numbers, strict=True)]
        rows.append([f"`{row['file'].removeprefix('gdb.base/')}`", *numbers])
    rows.append(["all", *total])
    head = ["file", "pass", "unsupported", "untested", "fail for a reason", "fail"]
    expected = gdb_suite.table()["expected"]
    reasons = (
        [f"`{file}`", reason] for file, reasons in expected.items() for reason in reasons.values()
    )
    return table(head, rows) + "\n" + table(["file", "why tests of it fail"], reasons)


def gcc_section(document: dict[str, Any]) -> str:
    """Systems with their results, then the exclusions."""
    rows = []
    reasons: dict[str, dict[str, int]] = {}
    for system, found in document["systems"].items():
        excluded = sum(found["excluded"].values())
        rows.append([system, found["passed"], excluded, found["unsupported"], len(found["failed"])])
        for reason, number in found["excluded"].items():
            reasons.setdefault(reason, {})[system] = number
    head = ["system", "pass", "excluded", "unsupported", "fail"]
    excluded = (
        [reason, *(by.get(system, 0) for system in document["systems"])]
        for reason, by in reasons.items()
    )
    text = f"Levels of optimisation: {', '.join(document['levels'])}.\n\n" + table(head, rows)
    return text + "\n" + table(["why tests are excluded", *document["systems"]], excluded)


def coremark_section(document: dict[str, Any]) -> str:
    """Systems and options with their figures."""
    rows = (
        [each["system"], f"`{each['options']}`", f"{each['per_mhz']:.3f}", each["cycles"]]
        for each in document["scores"]
    )
    head = ["system", "options", "CoreMark/MHz", f"cycles of {document['iterations']} iterations"]
    return table(head, rows)


SECTIONS = {
    "dap": (dap_sessions.RESULTS, dap_section),
    "gdb": (gdb_suite.RESULTS, gdb_section),
    "gcc": (torture.RESULTS, gcc_section),
    "coremark": (coremark.RESULTS, coremark_section),
}


def main() -> int:
    """Write the tables whose results are whole; the others stay."""
    texts = {}
    for name, (results, section) in SECTIONS.items():
        document = json.loads(results.read_text()) if results.exists() else {}
        if document and document.get("whole", True):
            texts[name] = "\n" + section(document) + "\n"
        else:
            print(f"the table {name} stays: {results.relative_to(ROOT)} is missing or a part")
    write_between_marks(PAGE, texts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
