# SPDX-License-Identifier: Apache-2.0
"""Goals of hostile files and of damaged models."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

from sim.report.goals import Goal, at_least, exactly
from tests.security.hostile_files import CASES, LEAST, observe


def rows(full: bool) -> Iterator[Goal]:
    """Every hostile file; the quick form and the full one are the same."""
    executed, read = [], []
    with tempfile.TemporaryDirectory() as folder:
        for n, case in enumerate(CASES):
            seen = observe(case, Path(folder) / str(n))
            executed += [case.name] if seen.executed else []
            read += [case.name] if seen.read or seen.shown else []
    yield at_least("files.hostile", len(CASES), LEAST, "files")
    yield exactly("files.commands_executed", len(executed), 0, "files", json.dumps(executed))
    yield exactly("files.canaries_read", len(read), 0, "files", json.dumps(read))
