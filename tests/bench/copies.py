# SPDX-License-Identifier: Apache-2.0
"""What a copy of the project may take from this checkout's build folder instead of making it."""

from __future__ import annotations

from pathlib import Path

from asip_asm.project import BUILD


def share_models(build: Path, *patterns: str) -> None:
    """Link models of this checkout into another build folder, by their names below build/model.

    "verilated-*" is Verilator's run-time library. A name has the hash of all that goes in, so that
    none is taken for another one.
    """
    folder = build / "model"
    folder.mkdir(parents=True, exist_ok=True)
    for pattern in patterns:
        for built in BUILD.glob(f"model/{pattern}"):
            (folder / built.name).symlink_to(built)
