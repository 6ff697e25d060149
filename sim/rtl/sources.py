# SPDX-License-Identifier: Apache-2.0
"""Which RTL files a module needs, for simulation, lint, proof and synthesis."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from asip_asm.project import ROOT

RTL = ROOT / "rtl"


@cache
def _used(text: str) -> list[str]:
    """Names in a file before `::`, and those that may be of an instantiated module."""
    text = re.sub(r"//[^\n]*", "", text)
    used = re.findall(r"\b(\w+)(?=::)", text) + re.findall(
        r"^\s*(\w+)\s+(?:#\s*\(|\w+\s*\()", text, re.M
    )
    return list(dict.fromkeys(used))


def sources_of(top: str, folders: Sequence[Path] = (RTL,)) -> list[Path]:
    """Files that `top` needs: packages named `p::` and modules instantiated, packages first.

    Files are found by name (one module per file, same name), in their text: the package that is
    installed comes without slang, and a name that is no file's is passed over. Raises
    FileNotFoundError for a top without a file.
    """
    files = {path.stem: path for folder in folders for path in sorted(folder.rglob("*.sv"))}
    if top not in files:
        raise FileNotFoundError(f"no file {top}.sv below {', '.join(map(str, folders))}")
    order: list[str] = []

    def visit(name: str) -> None:
        if name in order:
            return
        for other in _used(files[name].read_text()):
            if other in files and other != name:
                visit(other)
        order.append(name)

    visit(top)
    packages = [name for name in order if name.endswith("_pkg")]
    return [files[name] for name in packages + [n for n in order if n not in packages]]
