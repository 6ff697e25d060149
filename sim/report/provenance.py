# SPDX-License-Identifier: Apache-2.0
"""What made a result: the commit of the sources and the time of day."""

from __future__ import annotations

import datetime
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILT_FROM = ROOT / "COMMIT"  # in a wheel and a source package: the text that `commit` returned
UNKNOWN = "unknown: the sources are not in a git repository of their own"


def _own_repository() -> bool:
    """Whether the sources are the top of a repository: one that they only lie in says nothing."""
    command = ["git", "rev-parse", "--show-toplevel"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return False
    return Path(found.stdout.strip()).resolve() == ROOT


def commit() -> str:
    """Short hash of the sources' commit, whether they differ from it; or that there is none."""
    if not _own_repository():
        return BUILT_FROM.read_text(encoding="utf-8") if BUILT_FROM.is_file() else UNKNOWN
    try:
        found = subprocess.run(
            ["git", "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return UNKNOWN
    return found.replace("+", ", with changes that are not committed")


def now() -> str:
    """Date and time with its zone."""
    return datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z")
