# SPDX-License-Identifier: Apache-2.0
"""The table of planted faults (faults.toml), and a model that holds all, one chosen at a time.

A model with both cores takes half a minute to build, so there is one: a fault is an expression
`(chosen == id ? wrong : right)`, and `chosen` comes from the environment when a model is made.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from sim.harness import build, dual_rtl
from sim.harness.build import ROOT
from tests.mutants.faults import TableError, write_if_changed

TABLE = Path(__file__).with_name("faults.toml")
RTL = ROOT / "rtl/dual"
COPY = ROOT / "build/dual/planted"
HARNESS = Path(__file__).with_name("planted_harness.cpp")
VARIABLE = "PLANTED_FAULT"
FIELDS = {"id": int, "file": str, "breaks": str, "right": str, "wrong": str, "found": str}
CHOICE = f"""
  import "DPI-C" function int planted_fault();  // {VARIABLE} of the environment, else 0
  int chosen;
  initial chosen = planted_fault();
"""


@dataclass(frozen=True)
class Fault:
    """One entry; `place` holds `right` once."""

    number: int
    file: str
    breaks: str
    place: str
    right: str
    wrong: str
    found: str


def load(path: Path = TABLE) -> list[Fault]:
    """The faults in the order of the table. Raises TableError for the first wrong entry."""
    text = path.read_text(encoding="utf-8")
    lines = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() == "[[fault]]"]
    faults: dict[int, Fault] = {}
    for line, entry in zip(lines, tomllib.loads(text)["fault"], strict=True):
        where = f"{path}:{line}: error: fault {entry.get('id', '?')}"
        for name, kind in FIELDS.items():
            if not isinstance(entry.get(name), kind):
                raise TableError(f"{where}: needs {name}, {kind.__name__}")
        if unknown := entry.keys() - FIELDS.keys() - {"place"}:
            raise TableError(f"{where}: unknown {', '.join(sorted(unknown))}")
        if entry["id"] in faults or entry["id"] < 1:
            raise TableError(f"{where}: the number is used twice or below 1; give another one")
        place = entry.get("place", entry["right"])
        count = (RTL / entry["file"]).read_text().count(place)
        if count != 1 or place.count(entry["right"]) != 1:
            raise TableError(
                f"{where}: its place stands {count} times in {entry['file']}, with `right` "
                f"{place.count(entry['right'])} times in it, not once; adapt it to the unit"
            )
        faults[entry["id"]] = Fault(
            entry["id"],
            *(entry[name] for name in ("file", "breaks")),
            place,
            *(entry[name] for name in ("right", "wrong", "found")),
        )
    return list(faults.values())


def planted(text: str, faults: Sequence[Fault]) -> str:
    """`text` of one module with its faults; without a choice it does what it did."""
    edits = []
    for fault in faults:
        start = text.index(fault.place) + fault.place.index(fault.right)
        edits.append((start, fault.right, fault))
    edits.sort(key=lambda edit: (edit[0], edit[2].number))
    pieces, end = [], 0
    for (start, right), group in groupby(edits, key=lambda edit: edit[:2]):
        if start < end:
            raise TableError(f"{TABLE}: error: two faults overlap at {right!r}; give both the same")
        choices = "".join(f"chosen == {e[2].number} ? ({e[2].wrong}) : " for e in group)
        pieces += [text[end:start], f"({choices}({right}))"]
        end = start + len(right)
    head, ports, body = "".join([*pieces, text[end:]]).partition("\n);\n")
    return head + ports + CHOICE + body


def sources(faults: Sequence[Fault], original: Sequence[Path]) -> list[Path]:
    """The files of a model, those with faults replaced by copies that hold them."""
    COPY.mkdir(parents=True, exist_ok=True)
    paths = []
    for path in original:
        mine = [fault for fault in faults if RTL / fault.file == path]
        if mine:
            write_if_changed(COPY / path.name, planted(path.read_text(), mine))
        paths.append(COPY / path.name if mine else path)
    return paths


def build_with_faults(
    top: str,
    original: Sequence[Path],
    harness: Path,
    parameters: Mapping[str, int] | None = None,
    jobs: int = 1,
) -> Path:
    """In place of `build.build_library` in `dual_rtl`: the model with all faults of the table."""
    return build.build_library(
        top,
        sources(load(), original),
        HARNESS,
        parameters,
        jobs,
        headers=[harness],
        harness_flags=[f"-I{Path(dual_rtl.__file__).parent}"],
    )
