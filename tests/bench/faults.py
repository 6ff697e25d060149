# SPDX-License-Identifier: Apache-2.0
"""Planted faults: the one form of their tables, and copies of the sources that hold them.

A table is a TOML file. Each [[fault]] gives

    id       number, from 1
    file     source below rtl/, or one of C or Python: `nios_sw/...`, `sim/...`
    breaks   what is wrong then, in words
    found    who must find it: tests, operations or proofs, as the table's own test names them
    right    text that is in the file, or in `place`, exactly once, and cuts no word or number
    wrong    text in its place
    place    (optional) text that is in the file exactly once and holds `right`
    alone    (optional) true: the fault must not share a simulation

Faults with the same `right` are alternatives; other overlaps are refused. `plant` puts faults into
the text of a file in one of three ways: `REPLACED` for one fault, `BY_MACRO` for all, of which a
macro FAULT_<id> selects one, `BY_NUMBER` for all, of which the variable `chosen` selects one.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TypeVar

from sim.rtl.build import ROOT

RTL = ROOT / "rtl"
OTHERS = ("nios_sw/", "sim/")  # what `file` begins with if it is not below RTL
WORD = re.compile(r"(?<=\w)(?=\w)")  # a place inside a word or a number
FIELDS = {"id": int, "file": str, "breaks": str, "found": list, "right": str, "wrong": str}
OPTIONAL = {"place": str, "alone": bool}


class TableError(ValueError):
    """The table is wrong or no longer fits the source; the text starts with `file:line: error:`."""


def folder_of(file: str) -> Path:
    """The folder from which a table names this file, or this folder of files."""
    return ROOT if f"{file}/".startswith(OTHERS) else RTL


@dataclass(frozen=True)
class Fault:
    """One entry of a table."""

    number: int
    file: str
    breaks: str
    right: str
    wrong: str
    found: tuple[str, ...]
    place: str = ""
    alone: bool = False
    where: str = "fault"  # file and line of the entry

    @property
    def macro(self) -> str:
        """`FAULT_07`."""
        return f"FAULT_{self.number:02d}"

    @property
    def path(self) -> Path:
        """The source."""
        return folder_of(self.file) / self.file

    @property
    def name(self) -> str:
        """Name of the file without folders."""
        return Path(self.file).name

    def __str__(self) -> str:
        return f"{self.number}-{Path(self.file).stem}"

    def error(self, text: str) -> TableError:
        """An error that names the entry."""
        return TableError(f"{self.where}: error: fault {self.number}: {text}")

    def start(self, text: str) -> int:
        """Where `right` begins in the text of the file. Raises TableError unless whole and once."""
        place = self.place or self.right
        for what, part, whole, inside in (
            ("`place`" if self.place else "`right`", place, text, self.name),
            ("`right`", self.right, place, "`place`"),
        ):
            if whole.count(part) != 1:
                raise self.error(
                    f"{what} stands {whole.count(part)} times in {inside}, not once; adapt the "
                    "entry to the present text of the unit"
                )
        start = text.index(place) + place.index(self.right)
        for end in (start, start + len(self.right)):
            if WORD.match(text, end):
                raise self.error(f"`right` cuts `{word_at(text, end)}`; take it whole, or leave it")
        return start


def word_at(text: str, at: int) -> str:
    """The word or number around a place of the text."""
    before, after = re.search(r"\w*\Z", text[:at]), re.match(r"\w*", text[at:])
    return f"{before[0]}{after[0]}" if before and after else ""


Entry = TypeVar("Entry", bound=Fault)
Render = Callable[[Sequence[Fault], str], str]


def load(path: Path, kind: type[Entry] = Fault) -> list[Entry]:
    """The faults in the order of the table. Raises TableError for the first wrong entry."""
    text = path.read_text(encoding="utf-8")
    try:
        entries = tomllib.loads(text).get("fault", [])
    except tomllib.TOMLDecodeError as error:
        raise TableError(f"{path}: error: not TOML: {error}") from error
    lines = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() == "[[fault]]"]
    faults: dict[int, Entry] = {}
    for line, entry in zip(lines, entries, strict=True):
        fault = _checked(f"{path}:{line}", entry, kind)
        if fault.number in faults:
            first = faults[fault.number].where.rpartition(":")[2]
            raise fault.error(f"the id is already that of the entry in line {first}; give another")
        faults[fault.number] = fault
    return list(faults.values())


def _checked(where: str, entry: dict, kind: type[Entry]) -> Entry:
    def wrong(text: str) -> TableError:
        return TableError(f"{where}: error: fault {entry.get('id', '?')}: {text}")

    for name, type_ in (FIELDS | OPTIONAL).items():
        if not isinstance(entry.get(name, OPTIONAL.get(name, object)()), type_):
            raise wrong(f"needs {name}, {type_.__name__}")
    if unknown := entry.keys() - FIELDS.keys() - OPTIONAL.keys():
        known = ", ".join(FIELDS | OPTIONAL)
        raise wrong(f"unknown {', '.join(sorted(unknown))}; known are {known}")
    if not entry["found"] or entry["id"] < 1:
        raise wrong("needs an id from 1 and somebody in `found`")
    if entry["right"].strip() == entry["wrong"].strip():
        raise wrong("`wrong` is the same as `right`")
    if not (folder_of(entry["file"]) / entry["file"]).is_file():
        raise wrong(f"no file {entry['file']} in {folder_of(entry['file'])}")
    rest = {name: value for name, value in entry.items() if name != "id"}
    fault = kind(entry["id"], **(rest | {"found": tuple(entry["found"]), "where": where}))
    fault.start(fault.path.read_text())
    return fault


def plant(text: str, faults: Iterable[Fault], render: Render) -> str:
    """`text` of one file with faults. Raises TableError if one does not fit or overlaps another."""
    places = sorted((fault.start(text), fault.number, fault) for fault in faults)
    pieces, end, last = [], 0, None
    for (start, right), group in groupby(places, key=lambda place: (place[0], place[2].right)):
        choices = [fault for _, _, fault in group]
        if start < end:
            raise choices[0].error(
                f"`right` overlaps that of fault {last}; give both the same text"
            )
        pieces += [text[end:start], render(choices, right)]
        end, last = start + len(right), choices[-1].number
    return "".join([*pieces, text[end:]])


def REPLACED(choices: Sequence[Fault], right: str) -> str:
    """The text of the one fault."""
    (fault,) = choices
    return fault.wrong


def BY_MACRO(choices: Sequence[Fault], right: str) -> str:
    """Alternatives under macros; without one of them nothing changes."""
    branches = "".join(
        f"`{'elsif' if n else 'ifdef'} {fault.macro}\n{fault.wrong}\n"
        for n, fault in enumerate(choices)
    )
    return f"\n{branches}`else\n{right}\n`endif\n"


def BY_NUMBER(choices: Sequence[Fault], right: str) -> str:
    """Alternatives of an expression, chosen while it runs."""
    chosen = "".join(f"chosen == {fault.number} ? ({fault.wrong}) : " for fault in choices)
    return f"({chosen}({right}))"


def write_if_changed(path: Path, text: str) -> None:
    """Write a file unless it has this text already, so that it keeps its time."""
    if not path.is_file() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def copy(folder: Path, faults: Sequence[Fault], render: Render = REPLACED, part: str = "") -> Path:
    """The files of `part` (named as `file` of a table) with these faults, in `folder`, which it
    returns. Raises TableError."""
    original = folder_of(part) / part
    for path in sorted(p for p in original.rglob("*.*") if "__pycache__" not in p.parts):
        mine = [fault for fault in faults if fault.path == path]
        text = plant(path.read_text(), mine, render)
        write_if_changed(folder / path.relative_to(original), text)
    return folder
