# SPDX-License-Identifier: Apache-2.0
"""Goals of the workbench about asip-scope: what it shows of a core with its debug block."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.assemble import assemble
from asip_asm.files import write_text
from sim.debug.backend import open_block
from sim.debug.model import DebugRtl
from sim.debug.scope.block_source import BlockSource
from sim.debug.scope.source import Applied, Block, Commit
from sim.report.goals import Goal, exactly

PROGRAM = """
.program "two gains"
.input   x
.param   K = 1.0
.param   L = 1.0
.output  y, safe = 0.0
.output  z, safe = 0.0
        fmul    first, K, x
        fmul    second, L, x
        fsat    y, first, -1e30, 1e30
        fsat    z, second, -1e30, 1e30
        halt
"""
QUICK, FULL = 200, 10_000  # changes of gains
RUNS = 8  # between two changes


def rows(full: bool) -> Iterator[Goal]:
    """Words shown against words that the runs gave, and changes of two gains together."""
    changes = FULL if full else QUICK
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "two_gains.s"
        write_text(file, PROGRAM)
        image = assemble(file)
    model = DebugRtl(image.configuration)
    model.load(image)
    source = BlockSource(lambda: open_block(model), image, ["y", "z", "x", "cycles"], 1e-4)
    rng = np.random.default_rng(1)
    shown: list[list[float]] = []
    given: list[NDArray[np.float32]] = []
    applied: list[Applied] = []
    for change in range(1, changes + 1):
        value = float(np.float32(rng.normal()))
        source.send(Commit(change, {"K": value, "L": value}))
        while not (applied and applied[-1].version == change):
            event = source.wait()
            applied += [event] if isinstance(event, Applied) else []
        data = rng.normal(size=(RUNS, 1)).astype(np.float32)
        runs = model.run(model.input_addresses(["x"]), data, model.output_addresses(["y", "z"]))
        given.append(np.hstack([runs.words.view(np.float32), data]))
        while len(shown) < change * RUNS:
            event = source.wait()
            shown += event.values.tolist() if isinstance(event, Block) else []
    model.close()
    words, wanted = np.array(shown), np.concatenate(given)
    differ = int((words[:, :3] != wanted).sum())
    torn = int((words[:, 0] != words[:, 1]).sum())
    note = f"{changes} changes, {len(words)} runs"
    yield exactly("asip-scope: words shown that differ from the run's", differ, 0, "words", note)
    yield exactly("asip-scope: runs with one of two gains changed", torn, 0, "runs", note)
