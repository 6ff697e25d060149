# SPDX-License-Identifier: Apache-2.0
"""Waves: with WAVES=1 every model writes an FST, in a build of its own; without it none can.

Files go to the folder that WAVES_FOLDER of the environment names, else to build/waves. A test gets
a folder of its own (tests/conftest.py). See docs/verification.md.
"""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

from asip_asm.project import BUILD

_libraries: list[ctypes.CDLL] = []


def wanted() -> bool:
    """Whether WAVES of the environment asks for waves."""
    return os.environ.get("WAVES", "") not in ("", "0")


def folder() -> Path:
    """Where waves go now; it is made if need be."""
    path = Path(os.environ.setdefault("WAVES_FOLDER", str(BUILD / "waves")))
    path.mkdir(parents=True, exist_ok=True)
    return path


def flags() -> list[str]:
    """Options for Verilator; macro WAVES guards `$dumpfile` in a bench of SystemVerilog."""
    return ["--trace-fst", "-DWAVES"] if wanted() else []


def new_file(top: str) -> Path:
    """Where a simulation started now writes its waves."""
    taken = len(list(folder().glob(f"{top}-*.fst")))
    return folder() / f"{top}-{taken + 1}.fst"


def load_model(library: Path) -> ctypes.CDLL:
    """A model of `build_library` in this process."""
    loaded = ctypes.CDLL(str(library))
    if wanted():
        folder()
        if loaded not in _libraries:
            _libraries.append(loaded)
    return loaded


def close() -> None:
    """End the files that are being written; what the models do later goes to new ones."""
    for library in _libraries:
        library.bench_close_waves()
