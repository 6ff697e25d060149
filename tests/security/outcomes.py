# SPDX-License-Identifier: Apache-2.0
"""Outcomes of the campaigns that take long: each case is stored, so that a campaign resumes.

An outcome counts for the sources and Makefile that it was measured with, and for no others.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

from asip_asm.project import BUILD, ROOT
from sim.core.fpbench import campaign

HERE = Path(__file__).parent
OUTCOMES = BUILD / "outcomes/security"
SOURCES = ("asip_asm", "sim")  # folders
FILES = ("Makefile", "pyproject.toml", "requirements.lock", "scripts/bootstrap.sh")


@cache
def fingerprint(module: str) -> str:
    """Changes with whatever the campaign of a module of this folder runs."""
    own = sorted(HERE.glob(f"*{module}.py"))
    folders = [file for name in SOURCES for file in (ROOT / name).rglob("*.*")]
    return campaign.mark_of([*own, *(ROOT / name for name in FILES), *folders])


def resumed(module: str, key: str, measure: Callable[[], dict]) -> dict:
    """The stored outcome of a case of a campaign, else that of `measure`, which is then stored."""
    name = hashlib.sha256(key.encode()).hexdigest()[:16]
    return campaign.kept(OUTCOMES / module / f"{name}-{fingerprint(module)}.json", measure)
