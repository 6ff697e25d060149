# SPDX-License-Identifier: Apache-2.0
"""Cached results of campaigns and measurements: a file each, with a fingerprint of its causes.

A file is JSON: {"fingerprint", "checksum", "result"}. A result counts only for the fingerprint that
it was saved with. The fingerprint covers the files and choices that its user names, by name and
content: the user states there everything that the result depends on. The checksum covers the
result. A file that is damaged is reported and counts as missing. A file is replaced in one step, so
a reader never sees half of it, and holds the result of the last fingerprint alone.

Built models and netlists are no results: sim/rtl/runtime.py and sim/rtl/build.py have those.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from asip_asm.files import write_text
from asip_asm.project import ROOT

DIGITS = 16
"""Hexadecimal digits of fingerprints and checksums."""


class Cached(Protocol):
    """What has a cached result: a task of a campaign, or an `Entry`."""

    @property
    def path(self) -> Path:
        """File of the result."""
        ...

    @property
    def fingerprint(self) -> str:
        """Fingerprint of everything that the result depends on."""
        ...


@dataclass(frozen=True)
class Entry:
    """A result that is not one of a campaign's tasks."""

    path: Path
    fingerprint: str


def fingerprint(places: Iterable[Path], *choices: object) -> str:
    """Fingerprint of files, each once, by name and content, and of choices, by their `repr`.

    places: files, and folders for all files below them. Compiled Python is left out. Raises
    FileNotFoundError for a place that does not exist.
    """
    digest = hashlib.sha256(repr(choices).encode())
    files: set[Path] = set()
    for place in places:
        files.update(place.rglob("*") if place.is_dir() else [place])
    for path in sorted(files):
        if not path.is_dir() and path.suffix != ".pyc":
            content = hashlib.sha256(path.read_bytes()).digest()
            digest.update(os.path.relpath(path, ROOT).encode() + b"\0" + content)
    return digest.hexdigest()[:DIGITS]


def load(cached: Cached) -> Any:
    """The result of that fingerprint; None if there is none or the file is damaged."""
    try:
        stored = json.loads(cached.path.read_text(encoding="utf-8"))
        found, checksum, result = (stored[key] for key in ("fingerprint", "checksum", "result"))
        intact = checksum == _checksum(result)
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError):
        intact = False
    if not intact:
        print(f"{cached.path}: damaged, so its result does not count", file=sys.stderr)
        return None
    return result if found == cached.fingerprint else None


def save(cached: Cached, result: Any) -> None:
    """Write a result, of JSON's types and never None, in place of an earlier one."""
    content = {
        "fingerprint": cached.fingerprint,
        "checksum": _checksum(result),
        "result": result,
    }
    cached.path.parent.mkdir(parents=True, exist_ok=True)
    write_text(cached.path, json.dumps(content, indent=1) + "\n")


def result_of(cached: Cached, measure: Callable[[], Any]) -> Any:
    """The cached result, else that of `measure`, saved and read back."""
    if (found := load(cached)) is None:
        save(cached, measure())
        found = load(cached)
    return found


def _checksum(result: Any) -> str:
    return hashlib.sha256(json.dumps(result).encode()).hexdigest()[:DIGITS]
