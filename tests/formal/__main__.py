# SPDX-License-Identifier: Apache-2.0
"""Run the proofs of arithmetic units and front-ends; write build/formal/report.json."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict

from asip_asm.command import command, script_parser
from asip_asm.files import write_text

try:
    import bitwuzla
except ModuleNotFoundError:
    sys.exit("python -m tests.formal: no solver is installed here; `make setup-synth` installs it")
from rich.console import Console

from sim.report import cache
from sim.report.cache import Entry
from sim.report.marks import between_marks
from tests.bench.faults import Fault, TableError
from tests.formal.catalogue import Proof
from tests.formal.engine import BUILD, PROVED, REFUTED, Verdict, plant, run
from tests.formal.netlist import ROOT, ElaborationError
from tests.formal.proofs import PROOFS

REPORT = BUILD / "report.json"
VERDICTS = BUILD / "verdicts"
PAGE = ROOT / "docs/formal.md"
COMMAND = "python -m tests.formal --only"


def load() -> dict:
    """The report of earlier runs, empty if there is none."""
    try:
        return json.loads(REPORT.read_text())
    except (FileNotFoundError, json.JSONDecodeError):
        return {"proofs": {}, "faults": {}}


def store(kind: str, name: str, entry: dict | list) -> None:
    """Replace one entry of the report, whole or not at all; others may have changed meanwhile."""
    report = load()
    report[kind][name] = entry
    REPORT.parent.mkdir(parents=True, exist_ok=True)
    write_text(REPORT, json.dumps(report, indent=1) + "\n")


def summary(entry: dict | None) -> dict:
    """Status and solver time of a report entry, `status` "proved" only if every case is."""
    if not entry:
        return {"status": "not run", "seconds": 0.0, "cases": 0, "proved": 0}
    cases = entry["cases"]
    proved = sum(case["status"] == PROVED for case in cases)
    worst = [case["status"] for case in cases if case["status"] != PROVED]
    status = "not finished" if not entry["complete"] else PROVED
    if REFUTED in worst:
        status = REFUTED
    elif worst:
        status = worst[0]
    seconds = sum(case["seconds"] for case in cases)
    return {"status": status, "seconds": seconds, "cases": len(cases), "proved": proved}


def entry_of(digest: str) -> Entry:
    """Where the verdict of a formula is cached, by the digest of formula and solver."""
    return Entry(VERDICTS / f"{digest}.json", digest)


def earlier_verdict(digest: str, limit: float, again: bool) -> Verdict | None:
    """The cached verdict of a formula, if it counts: a shorter time limit decides nothing, and
    with `again` only a proof does."""
    if (found := cache.load(entry_of(digest))) is None:
        return None
    verdict = Verdict(**found)
    decided = verdict.status in (PROVED, REFUTED) or limit <= verdict.seconds
    return verdict if decided and (verdict.status == PROVED or not again) else None


def prove(proof: Proof, console: Console, limit: float | None, again: bool) -> bool:
    """Run one proof, store its verdicts after every case; true if all cases are proved."""
    unchanged = set()

    def known(digest: str) -> Verdict | None:
        if (found := earlier_verdict(digest, limit or proof.timeout, again)) is not None:
            unchanged.add(digest)
        return found

    cases: list[dict] = []
    entry = {"cases": cases, "complete": False}  # in case this run is stopped
    console.print(f"{proof.name}: {proof.unit}, {proof.claim}")
    for verdict in run(proof, known=known, limit=limit):
        cases.append(asdict(verdict))
        earlier = " (unchanged)" if verdict.digest in unchanged else ""
        if verdict.digest and not earlier:
            cache.save(entry_of(verdict.digest), asdict(verdict))
        text = f"  {verdict.case}: {verdict.status}, {verdict.seconds:.1f} s{earlier}"
        if verdict.status != PROVED:
            text += f"\n    {verdict.note}"
        if verdict.status != PROVED or not earlier:
            console.print(text)
        store("proofs", proof.name, entry)
    entry["complete"] = True
    store("proofs", proof.name, entry)
    result = summary(entry)
    console.print(
        f"  {result['proved']} of {result['cases']} cases proved, "
        f"{result['seconds']:.1f} s of solver",
    )
    return result["status"] == PROVED


def named(fault: Fault) -> str:
    """How the report calls a fault."""
    return f"{fault.file}: {fault.right} -> {fault.wrong}"


def can_fail(proof: Proof, console: Console, limit: float | None) -> bool:
    """Plant each fault of a proof in a copy of rtl/; true if each makes a case fail."""
    entries = []
    for index, fault in enumerate(proof.faults):
        where = f"{proof.name}: {fault.file}: `{fault.right}` -> `{fault.wrong}`"
        refuted = None
        try:
            copy = plant(fault, BUILD / "faults" / f"{proof.name}{index}")
            build = BUILD / "faults" / f"{proof.name}{index}" / "netlists"
            for verdict in run(proof, rtl=copy, build=build, limit=limit):
                if verdict.status == REFUTED:
                    refuted = verdict
                    break
                if verdict.status != PROVED:
                    console.print(f"  {verdict.case}: {verdict.note}")
        except ElaborationError as error:
            console.print(f"{where}\n  {error}")
        entries.append({"fault": named(fault), "seen": bool(refuted)})
        verdict_text = f"seen by case `{refuted.case}`: {refuted.note}" if refuted else "NOT SEEN"
        console.print(f"{where}\n  {verdict_text}")
    store("faults", proof.name, entries)
    return all(entry["seen"] for entry in entries)


def table(report: dict, page: str = "") -> str:
    """The Markdown table of docs/formal.md; what the report lacks keeps its row of the page."""
    rows = {row.rpartition(" ")[0].split()[-1]: row for row in page.splitlines() if COMMAND in row}
    lines = [
        "",
        f"Solver: Bitwuzla {bitwuzla.version()}.",
        "",
        "| unit | property | inputs | status | cases | solver time | faults seen | command |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for proof in PROOFS:
        kept = rows.get(f"{proof.name}`", "")
        stated = f"| {proof.unit} | {proof.claim} | {proof.inputs} |"  # else the row is of another
        if proof.name not in report["proofs"] and kept.startswith(stated):
            lines.append(kept)
            continue
        result = summary(report["proofs"].get(proof.name))
        found = {f["fault"] for f in report["faults"].get(proof.name, []) if f["seen"]}
        seen = sum(named(fault) in found for fault in proof.faults)
        lines.append(
            f"| {proof.unit} | {proof.claim} | {proof.inputs} | {result['status']} | "
            f"{result['proved']} of {result['cases']} | {result['seconds']:.0f} s | "
            f"{seen} of {len(proof.faults)} | `{COMMAND} {proof.name}` |"
        )
    return "\n".join([*lines, "", ""])


def page_text(report: dict) -> str:
    """docs/formal.md with the table replaced."""
    page = PAGE.read_text()
    return between_marks(page, {"proofs": table(report, page)}, PAGE)


@command("python -m tests.formal")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if all is proved (or every fault seen), 1 if not, 2 for usage."""
    prog = "python -m tests.formal"
    parser = script_parser(__doc__, f"{prog} --only add compare --timeout 600", prog)
    names = [proof.name for proof in PROOFS]
    parser.add_argument(
        "--only", nargs="+", metavar="PROOF", help="only these proofs; --list names them"
    )
    parser.add_argument("--quick", action="store_true", help="only the short proofs")
    parser.add_argument("--list", action="store_true", help="list the proofs and exit")
    parser.add_argument("--timeout", type=float, metavar="S", help="seconds per case")
    parser.add_argument("--again", action="store_true", help="retry proofs that have not succeeded")
    parser.add_argument(
        "--check-can-fail",
        action="store_true",
        help="plant faults in the RTL: each proof must fail on its own",
    )
    parser.add_argument("--docs", action="store_true", help="write the table of docs/formal.md")
    options = parser.parse_args(argv)
    console = Console(markup=False, highlight=False, soft_wrap=True)
    for name in options.only or []:
        if name not in names:
            parser.error(f"no proof `{name}`; there are {', '.join(names)}")
    chosen = [p for p in PROOFS if not options.only or p.name in options.only]
    chosen = [p for p in chosen if p.quick or not options.quick]
    if options.list:
        for proof in chosen:
            console.print(f"{proof.name}: {proof.unit}: {proof.claim}")
        return 0
    if options.docs:
        PAGE.write_text(page_text(load()))
        return 0
    failures = []
    for proof in chosen:
        if options.check_can_fail:
            good = can_fail(proof, console, options.timeout)
        else:
            good = prove(proof, console, options.timeout, options.again)
        if not good:
            failures.append(proof.name)
    word = "with a fault not seen" if options.check_can_fail else "not proved"
    if failures:
        console.print(f"{word}: {', '.join(failures)}", style="red")
    return 1 if failures else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except TableError as error:
        sys.exit(str(error))
