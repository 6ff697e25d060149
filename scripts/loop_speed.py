# SPDX-License-Identifier: Apache-2.0
"""Ticks per second of `sim.Core`, tick by tick and in a batch, into docs/own_machine.md.

`python scripts/loop_speed.py` measures the page's programs, all inputs 0, and writes the
table between its marks.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from asip_asm.command import command
from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks, write_files
from sim import Core
from sim.report.marks import write_between_marks

PAGE = ROOT / "docs/own_machine.md"
SECONDS = 1.0  # of processor time for each figure
CHUNK = 200  # ticks between two looks at the clock


def rate(run: Callable[[], object]) -> float:
    """Ticks per second of processor time; `run` does CHUNK ticks."""
    run()
    chunks, begin = 0, time.process_time()
    while (spent := time.process_time() - begin) < SECONDS:
        run()
        chunks += 1
    return chunks * CHUNK / spent


def row(program: Path, backend: str) -> str:
    """Line of the table."""
    with Core(program, backend=backend) as core:
        first = core.inputs[0]
        held = np.full(CHUNK, core.read(first))
        single = rate(lambda: [core.tick() for _ in range(CHUNK)])
        batch = rate(lambda: core.batch({first: held}))
        cycles = "-" if core.cycles is None else core.cycles
        sizes = f"{len(core.inputs)} | {len(core.outputs)} | {cycles}"
    return f"| `{program.name}` | {backend} | {sizes} | {single:.0f} | {batch:.0f} |"


@command("scripts/loop_speed.py")
def main() -> int:
    """Measure and write."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rows = [
        "| program | backend | inputs | outputs | cycles | ticks/s, `tick` | ticks/s, `batch` |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as folder:
        write_files(PAGE, Path(folder))
        titles = [block.title for block in code_blocks(PAGE) if block.title]
        programs = [Path(folder) / title for title in titles if title.endswith(".s")]
        rows += [row(program, backend) for program in programs for backend in ("rtl", "iss")]
    write_between_marks(PAGE, {"speed": "\n".join(rows) + "\n"})
    print("\n".join(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
