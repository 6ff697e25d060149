# SPDX-License-Identifier: Apache-2.0
"""Write every page with measured figures: `make docs`.

Some are measured at once, in a minute or so each. Others come from what a long campaign has left in
build; where that is missing or only a part of it, the page stays as it is and the command says what
makes the results. A page's writer can also be called by itself (`--list` shows them).
docs/own_c_program.md is written by `microtick nios-sw`, which has the cross compiler,
docs/upsets.md by `microtick upsets --full` itself, from shards that only it reads.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asip_asm.command import command, script_parser
from asip_asm.project import BUILD, ROOT
from scripts.figures import main as state_figures


@dataclass(frozen=True)
class Page:
    """A page, the arguments of Python that write it, and what it is written from.

    results: a file of a campaign that `cure` makes; whole: whether it holds all of the campaign.
    """

    name: str
    writer: str
    results: Path | None = None
    cure: str = ""
    whole: Callable[[Any], bool] = bool

    def missing(self) -> str:
        """Why the page cannot be written now, empty if it can."""
        if self.results is None:
            return ""
        place = self.results.relative_to(ROOT)
        try:
            document = json.loads(self.results.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return f"no {place}; {self.cure} makes it"
        return "" if self.whole(document) else f"{place} is a part; {self.cure} makes the whole"


def all_proofs(report: dict[str, Any]) -> bool:
    """Whether every proof has a verdict, and every one's faults."""
    from tests.formal.proofs import PROOFS

    names = {proof.name for proof in PROOFS}
    return names <= set(report["proofs"]) and names <= set(report["faults"])


def all_cases(report: dict[str, Any]) -> bool:
    """Whether every section of the campaign is covered."""
    return all(row["covered"] == row["planned"] for row in report["rows"])


def all_platforms(results: dict[str, Any]) -> bool:
    """Whether the main job took the whole path on every platform."""
    return len(results["platforms"]) == 3 and results["path"]["whole"]


def all_depths(results: dict[str, Any]) -> bool:
    """Whether every goal that was measured was measured to its full depth."""
    return all(goal["met"] is not None for goal in results["goals"] if goal["value"] is not None)


def all_goals(results: dict[str, Any]) -> bool:
    """Whether every goal was measured, and to its full depth."""
    return all(goal["met"] is not None for goal in results["goals"])


PAGES = (
    Page("docs/latency.md", "scripts/latency_table.py"),
    Page("docs/scaling.md", "scripts/scaling.py"),
    Page("docs/units.md", "scripts/units_page.py"),
    Page("docs/own_machine.md", "scripts/loop_speed.py"),
    Page("docs/nios_core.md", "-m sim.rtl.n2_lockstep_cycles"),
    Page("docs/numerics.md", "-m sim.bench.run.random_robots --docs"),
    Page("docs/conformance.md", "-m tests.conformance.page"),
    Page("docs/ethercat_application.md", "-m sim.bus.device_run --docs"),
    *(
        Page(name, "scripts/readme.py results", BUILD / "results.json", "make run", all_platforms)
        for name in ("README.md", "docs/index.md")
    ),
    *(
        Page(name, "scripts/readme.py synthesis", BUILD / "synth.json", "microtick synth")
        for name in ("README.md", "docs/platforms.md")
    ),
    Page(
        "docs/platforms.md",
        "-m sim.bench.platforms --docs",
        BUILD / "side_by_side.json",
        "microtick side-by-side",
    ),
    Page(
        "docs/two_processors.md",
        "-m sim.bench.dual --docs",
        BUILD / "dual/results.json",
        "microtick dual",
        lambda results: results["complete"] and results["whole_path"],
    ),
    Page(
        "docs/your_robot.md",
        "-m scripts.goals matrix --docs",
        BUILD / "matrix.json",
        "make goals T=matrix RUN=full",
        all_depths,
    ),
    Page(
        "docs/motion.md",
        "-m scripts.goals motion --docs",
        BUILD / "motion.json",
        "make goals T=motion RUN=full",
        all_goals,
    ),
    Page(
        "docs/drive.md",
        "-m scripts.drive --docs",
        BUILD / "drive.json",
        "microtick drive --full",
        lambda results: results.get("whole", False),
    ),
    Page(
        "docs/law.md",
        "-m sim.bench.drive.speed --docs",
        BUILD / "speed.json",
        "python -m sim.bench.drive.speed --full",
        lambda results: results["whole"],
    ),
    Page(
        "docs/ethercat.md",
        "-m scripts.bus --docs",
        BUILD / "bus.json",
        "microtick bus --full",
        lambda results: results.get("whole", False),
    ),
    Page(
        "docs/ethercat.md",
        "-m scripts.goals linuxcnc --docs",
        BUILD / "linuxcnc.json",
        "make goals T=linuxcnc RUN=full",
        lambda results: any(goal.get("producer") == "machine" for goal in results["goals"]),
    ),
    Page(
        "docs/formal.md",
        "-m tests.formal --docs",
        BUILD / "formal/report.json",
        "microtick formal, python -m tests.formal --check-can-fail",
        all_proofs,
    ),
    Page(
        "docs/arithmetic_evidence.md",
        "-m sim.core.fpbench report",
        BUILD / "fpbench/report.json",
        "microtick fp campaign",
        all_cases,
    ),
)


def write(page: Page) -> bool:
    """Write one page; whether it went well. Says what it does."""
    reason = page.missing()
    if reason:
        print(f"{page.name} stays: {reason}", flush=True)
        return True
    print(f"{page.name}: python {page.writer}", flush=True)
    return subprocess.run([sys.executable, *page.writer.split()], cwd=ROOT).returncode == 0


@command("scripts/measured_pages.py")
def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit status, 1 if a writer failed."""
    prog = "python scripts/measured_pages.py"
    parser = script_parser("Write the pages with measured figures.", f"{prog} latency units", prog)
    stems = [Path(page.name).stem for page in PAGES]
    parser.add_argument(
        "pages",
        nargs="*",
        metavar="PAGE",
        help=f"pages to write: {', '.join(dict.fromkeys(stems))} (all)",
    )
    parser.add_argument(
        "--list", action="store_true", help="list pages and their writers, and exit"
    )
    options = parser.parse_args(arguments)
    for name in options.pages:
        if name not in stems:
            parser.error(f"no page `{name}`; there are {', '.join(stems)}")
    chosen = [p for p in PAGES if not options.pages or Path(p.name).stem in options.pages]
    if options.list:
        for page in chosen:
            print(f"{page.name}: python {page.writer}; {page.missing() or 'can be written'}")
        return 0
    failed = [page.name for page in chosen if not write(page)]
    state_figures([])
    if failed:
        print(f"not written: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
