# SPDX-License-Identifier: Apache-2.0
"""Outcomes of the campaigns that take long: each case is stored, so that a campaign resumes.

An outcome counts for the sources and Makefile that it was measured with, and for no others.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path

from asip_asm.project import BUILD, ROOT
from sim.report import cache
from sim.report.cache import Entry

HERE = Path(__file__).parent
OUTCOMES = BUILD / "outcomes/security"
SOURCES = ("asip_asm", "sim")  # folders
FILES = ("Makefile", "pyproject.toml", "requirements.lock", "scripts/bootstrap.sh")


@functools.cache
def fingerprint(module: str) -> str:
    """Changes with whatever the campaign of a module of this folder runs."""
    own = sorted(HERE.glob(f"*{module}.py"))
    return cache.fingerprint([*own, *(ROOT / name for name in (*FILES, *SOURCES))])


def resumed(module: str, key: str, measure: Callable[[], dict]) -> dict:
    """The cached outcome of a case of a campaign, else that of `measure`, which is then cached."""
    name = hashlib.sha256(key.encode()).hexdigest()[:16]
    entry = Entry(OUTCOMES / module / f"{name}.json", fingerprint(module))
    return cache.result_of(entry, measure)
