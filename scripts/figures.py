# SPDX-License-Identifier: Apache-2.0
"""State on each page with figures of the RTL where they were measured, and which are out of date.

`make gen` writes the statements and `make gen-check` refuses a page that states another: so no
figure passes for one of today's RTL after the RTL has changed. Measuring cures what is out of date.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from asip_asm.command import command, script_parser
from asip_asm.project import ROOT
from scripts.generated import keep_page
from sim.report.marks import between_marks
from sim.rtl.figures import statement

DATA = ROOT / "docs/data"
COMMAND = "python scripts/figures.py"
Figures = Mapping[str, Mapping[str, Any]]


def tops(*names: str) -> Figures:
    """Cores of docs/data/synthesis.json, by default all."""
    found = json.loads((DATA / "synthesis.json").read_text(encoding="utf-8"))["tops"]
    return {name: found[name] for name in names or found}


def boards() -> Figures:
    """Routed designs, by the modules of their boards."""
    found = json.loads((DATA / "boards.json").read_text(encoding="utf-8"))
    return {board["board"]["module"]: board for board in found.values()}


def alone(file: str, module: str) -> Figures:
    """Figures of one measurement on one module."""
    return {module: json.loads((DATA / file).read_text(encoding="utf-8"))}


def statements() -> dict[str, str]:
    """What each page says."""
    synth = "microtick synth --only {}"
    return {
        "README.md": statement(tops(), synth),
        "docs/platforms.md": statement(tops("asip_fast", "fpga2"), synth),
        "docs/boards.md": statement(boards(), "microtick bitstream BOARD"),
        "docs/two_processors.md": statement(
            alone("two_processors.json", "dual_asip"), "microtick dual"
        ),
        "docs/upsets.md": statement(alone("upsets.json", "asip"), "microtick upsets --full"),
    }


@command("scripts/figures.py")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 written or equal, 1 if a page differs, 2 usage."""
    parser = script_parser(__doc__, COMMAND)
    parser.add_argument(
        "--check", action="store_true", help="compare with the pages, write nothing"
    )
    options = parser.parse_args(argv)
    status = 0
    for name, text in statements().items():
        page: Path = ROOT / name
        new = between_marks(page.read_text(encoding="utf-8"), {"rtl": f"\n{text}\n\n"}, page)
        stale = f"{page}: error: its figures are of another RTL than it says; {COMMAND}"
        status |= keep_page(page, new, options.check, stale, sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
