# SPDX-License-Identifier: Apache-2.0
"""Goals of the G-code reader against LinuxCNC's interpreter: `make goals T=linuxcnc`.

PROGRAMS=FOLDER names a folder of public programs, which the user supplies; without it, there are no
rows about them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from sim.motion.gcode.oracle import OracleError, Samples, compare_files, compare_samples, find
from sim.report.goals import Goal, at_least, at_most, exactly, not_measured

FETCH = "fetch LinuxCNC: .venv/bin/python -m sim.motion.gcode.oracle"
NAMED = 12  # programs of a note
ENDINGS = {".ngc", ".nc", ".gcode", ".tap", ".cnc"}


def _named(programs: Iterable[str]) -> str:
    """The names of the first programs; the command of FETCH gives the reasons."""
    names = sorted(programs)
    return ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")


def samples(full: bool) -> Iterator[Goal]:
    """LinuxCNC's own sample programs."""
    try:
        found = compare_samples()
    except OracleError:
        yield not_measured("LinuxCNC samples with equal moves", ">= 22", "programs", FETCH)
        return
    equal = found.moving & set(found.equal)
    refused = found.moving & found.refused.keys()
    note = f"of {len(found.moving)} that move; refused: {_named(refused)}"
    yield at_least("LinuxCNC samples with equal moves", len(equal), 22, "programs", note)
    yield exactly(
        "LinuxCNC samples with different moves",
        len(found.different),
        0,
        "programs",
        _named(found.different),
    )


def programs(full: bool) -> Iterator[Goal]:
    """The programs of the folder PROGRAMS."""
    folder = os.environ.get("PROGRAMS", "")
    if not folder:
        return
    files = sorted(path for path in Path(folder).rglob("*") if path.suffix.lower() in ENDINGS)
    if not files:
        raise ValueError(f"PROGRAMS={folder}: no file ends in {' '.join(sorted(ENDINGS))}")
    if find() is None:
        yield not_measured("public programs with different moves", "0", "programs", FETCH)
        return
    yield from rows_of(compare_files(files), len(files))


def rows_of(found: Samples, count: int) -> Iterator[Goal]:
    """Rows of a comparison of so many public programs."""
    yield at_least("public programs compared", count, 500, "programs")
    different, refused = found.different, found.refused
    yield exactly(
        "public programs with different moves", len(different), 0, "programs", _named(different)
    )
    yield at_most(
        "public programs that rs274 alone runs", len(refused), 10, "programs", _named(refused)
    )
