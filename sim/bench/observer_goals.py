# SPDX-License-Identifier: Apache-2.0
"""Observer of 24 states: rows of `make goals T=matrix`."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sim.laws.observer import build_observer, observer, prove_observer, recording, watch
from sim.report.goals import Goal, at_most, depth, exactly

MOST = {"wide": 200, "stream": 300}
"""Cycles of a tick."""
COUNT, QUICK = 10_000, 500
WATCHED = {False: 1000, True: 10_000}
SECONDS = 60.0  # of one processor
RATIO = 1.001
LARGEST = 10.0
"""Error of the estimates by the size of the states, per cent: the plant is nonlinear."""
CURE = "make goals T=matrix RUN=full"


def rows(full: bool) -> Iterator[Goal]:
    """Cycles, bits, certificate, and errors of estimates of a nonlinear plant."""
    system = observer()
    for configuration, most in MOST.items():
        name = f"observer 24/5/3 on {configuration}"
        begin = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            built = build_observer(system, Path(folder) / "observer.s", configuration)
        seconds = time.process_time() - begin
        yield at_most(f"{name}, tick", built.cycles, most, "cycles")
        yield at_most(f"{name}, compiling", seconds, SECONDS, "s of a processor")
        proof = prove_observer(system, built, COUNT if full else QUICK)
        other = "runs whose cycles are not those announced"
        yield exactly(f"{name}, {other}", proof.other_cycles, 0, "")
        yield exactly(f"{name}, words unlike the interpreter's", proof.unequal, 0, "")
        note = f"{proof.error:.2g} m; the bound holds in every tick"
        yield at_most(f"{name}, error by its certified bound", proof.share, 1, "1", note)
        yield depth(f"{name}, ticks tried", proof.ticks, COUNT, "1", CURE)
        ticks = WATCHED[full]
        seen = watch(system, built.image, ticks)
        size = float(np.sqrt((recording(ticks)[0] ** 2).mean()))
        note = f"{1000 * seen.double:.3g} mm in doubles, {ticks} ticks of a nonlinear chain"
        yield at_most(f"{name}, estimate's error by that in doubles", seen.core / seen.double,
                      RATIO, "1", note)  # fmt: skip
        yield at_most(
            f"{name}, estimate's error by the states", 100 * seen.core / size, LARGEST, "%"
        )
