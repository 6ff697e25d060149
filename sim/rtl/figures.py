# SPDX-License-Identifier: Apache-2.0
"""Figures that were measured on the RTL: the fingerprint of that RTL, and whether it is today's.

A committed figure has the commit and the fingerprint of the sources that it depends on. A page
that shows it says which figures are of an earlier version (`python scripts/figures.py`).
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.rtl.sources import RTL, sources_of

MODULES = {
    **dict.fromkeys(("asip_fast", "asip_small", "asip_stream", "asip_wide"), "asip"),
    **dict.fromkeys(("fpga1", "fpga2"), "n2_system"),
}
"""Name of a figure -> module that it is of, where that is another one."""


def source_mark(files: Iterable[Path]) -> str:
    """Fingerprint of what decides a netlist: files without comments, white space, and latencies
    that a package states and nothing there uses."""
    digest = hashlib.sha256()
    for path in files:
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        text = re.sub(r"[^\n]*_LATENCY\s*=[^\n]*\n", "", text)
        digest.update(" ".join(text.split()).encode())
    return digest.hexdigest()[:16]


def rtl_mark(name: str, modules: Collection[str] = (), folders: Sequence[Path] = (RTL,)) -> str:
    """Fingerprint of the RTL of a figure; modules: those that its netlist has, by default all."""
    files = sources_of(MODULES.get(name, name), folders)
    if modules:
        files = [path for path in files if path.stem in modules or path.stem.endswith("_pkg")]
    return source_mark(files)


def is_present(name: str, figure: Mapping[str, Any]) -> bool:
    """Whether a figure with `rtl`, and perhaps `modules`, is of today's RTL."""
    return figure.get("rtl") == rtl_mark(name, figure.get("modules", ()))


def measured_at(figures: Mapping[str, Mapping[str, Any]]) -> str:
    """The commit of all figures, or `abc (asip_fast, asip_small), def (n2_core)`."""
    named: dict[str, list[str]] = {}
    for name, figure in figures.items():
        named.setdefault(figure.get("commit", "unknown"), []).append(name)
    if len(named) == 1:
        return next(iter(named))
    return ", ".join(f"{commit} ({', '.join(names)})" for commit, names in named.items())


def statement(figures: Mapping[str, Mapping[str, Any]], cure: str) -> str:
    """Where figures were measured, and which of them are of an earlier RTL; cure: a command that
    measures those again, with `{}` for their names."""
    text = f"Measured at commit {measured_at(figures)}."
    old = [name for name, figure in figures.items() if not is_present(name, figure)]
    if not old:
        return f"{text} The RTL is the same today."
    which = "" if len(old) == len(figures) else f" of {', '.join(old)}"
    again = cure.format(" ".join(old))
    return f"{text} **Out of date:** the RTL{which} has changed since; `{again}` measures again."
