# SPDX-License-Identifier: Apache-2.0
"""Goals of damaged models: a copy of a built library, with flipped bits or a piece cut off."""

from __future__ import annotations

import contextlib
import io
import random
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from sim.report.goals import Goal, at_least, exactly
from sim.rtl.asip_rtl import AsipRtl
from sim.rtl.runtime import MODELS, seal, sealed

DAMAGES = 100


def damaged(data: bytes, rng: random.Random) -> bytes:
    """A flipped bit, or a piece cut off the end."""
    if rng.random() < 0.5:
        return data[: rng.randrange(len(data))]
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]


def rows(full: bool) -> Iterator[Goal]:
    """Every damage must be found before the library is loaded, and be reported."""
    AsipRtl()
    model = max(MODELS.glob("asip*/lib*.so"), key=lambda file: file.stat().st_mtime)
    rng, unseen, mute = random.Random(1), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(shutil.copy(model, folder))
        seal(file)
        data = file.read_bytes()
        if not sealed(file):
            raise RuntimeError(f"{model}: a whole file counts as damaged")
        for _ in range(DAMAGES):
            file.write_bytes(damaged(data, rng))
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                unseen += sealed(file)
            mute += f"{file} is damaged" not in said.getvalue()
    yield at_least("caches.damages", DAMAGES, 100, "files")
    yield exactly("caches.damages_unseen", unseen, 0, "files")
    yield exactly("caches.damages_without_message", mute, 0, "files")
