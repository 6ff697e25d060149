# SPDX-License-Identifier: Apache-2.0
"""The table of planted faults and copies of the RTL that hold them, each behind a macro."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from sim.fpbench import folded
from sim.fpbench.native import RTL, operations, sources, unit_of
from sim.harness.build import ROOT

TABLE = Path(__file__).with_name("mutants.toml")
BUILD = ROOT / "build/mutants"
COPY = BUILD / "rtl"
FIELDS = {"id": int, "file": str, "ops": list, "breaks": str, "right": str, "wrong": str}


class TableError(ValueError):
    """The table is wrong or no longer fits the RTL; the text starts with `file:line:`."""


@dataclass(frozen=True)
class Fault:
    """One entry: `right` stands once in `file`, the macro puts `wrong` in its place."""

    number: int
    file: str
    ops: tuple[str, ...]
    breaks: str
    right: str
    wrong: str
    alone: bool = False  # must not share a simulation: it breaks the handshake
    line: int = 0  # of the table

    @property
    def macro(self) -> str:
        """`FP_BUG_07`."""
        return f"FP_BUG_{self.number:02d}"

    @property
    def unit(self) -> str:
        """Unit of the bench through which the fault is looked for."""
        return folded.NAME if self.file == f"{folded.NAME}.sv" else unit_of(self.ops[0])


def load(path: Path = TABLE) -> list[Fault]:
    """The faults in the order of the table. Raises TableError for the first wrong entry."""
    text = path.read_text(encoding="utf-8")
    try:
        entries = tomllib.loads(text).get("fault", [])
    except tomllib.TOMLDecodeError as error:
        raise TableError(f"{path}: error: not TOML: {error}") from error
    lines = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() == "[[fault]]"]
    faults: list[Fault] = []
    for line, entry in zip(lines, entries, strict=True):
        faults.append(_fault(path, line, entry))
    numbers: dict[int, int] = {}
    for fault in faults:
        if fault.number in numbers:
            raise TableError(
                f"{path}:{fault.line}: error: id {fault.number} is already that of the entry in "
                f"line {numbers[fault.number]}; give it another one"
            )
        numbers[fault.number] = fault.line
    return faults


def _fault(path: Path, line: int, entry: dict) -> Fault:
    def wrong(text: str) -> TableError:
        return TableError(f"{path}:{line}: error: fault {entry.get('id', '?')}: {text}")

    for name, kind in FIELDS.items():
        if not isinstance(entry.get(name), kind):
            raise wrong(f"needs {name}, {kind.__name__}")
    if unknown := entry.keys() - FIELDS.keys() - {"alone"}:
        raise wrong(f"unknown {', '.join(sorted(unknown))}; known are {', '.join(FIELDS)}, alone")
    if not entry["ops"] or entry["ops"] != [op for op in entry["ops"] if op in operations()]:
        raise wrong(f"ops must name operations of the bench: {', '.join(operations())}")
    units = {unit_of(op) for op in entry["ops"]}
    if len(units) > 1:
        raise wrong(f"ops belong to several units: {', '.join(sorted(units))}")
    if entry["right"].strip() == entry["wrong"].strip():
        raise wrong("`wrong` is the same as `right`")
    return Fault(
        entry["id"],
        entry["file"],
        tuple(entry["ops"]),
        entry["breaks"],
        entry["right"],
        entry["wrong"],
        bool(entry.get("alone", False)),
        line,
    )


def planted(text: str, faults: Sequence[Fault], table: Path = TABLE) -> str:
    """`text` with the faults of its file, each behind its macro; without a macro nothing changes.

    Raises TableError if a text to replace does not stand there exactly once or overlaps another.
    """
    places: list[tuple[int, Fault]] = []
    for fault in faults:
        count = text.count(fault.right)
        if count != 1:
            raise TableError(
                f"{table}:{fault.line}: error: fault {fault.number}: `right` stands {count} times "
                f"in {fault.file}, not once; adapt the entry to the present text of the unit"
            )
        places.append((text.index(fault.right), fault))
    places.sort(key=lambda place: (place[0], place[1].number))
    pieces, end, last = [], 0, None
    for (start, right), group in groupby(places, key=lambda place: (place[0], place[1].right)):
        choices = [fault for _, fault in group]
        if start < end:
            raise TableError(
                f"{table}:{choices[0].line}: error: fault {choices[0].number}: `right` overlaps "
                f"that of fault {last}; give both the same text"
            )
        branches = [
            f"`{'elsif' if n else 'ifdef'} {fault.macro}\n{fault.wrong}\n"
            for n, fault in enumerate(choices)
        ]
        pieces += [text[end:start], "\n", *branches, f"`else\n{right}\n`endif\n"]
        end, last = start + len(right), choices[-1].number
    return "".join([*pieces, text[end:]])


def write_copy(faults: Sequence[Fault], folder: Path = COPY, rtl: Path = RTL) -> Path:
    """Write the files of `rtl` with all faults to `folder`; files that stay equal keep their time.

    Raises TableError if the table does not fit.
    """
    files = {path.name: path for path in sorted(rtl.glob("*.sv"))}
    for fault in faults:
        if fault.file not in files:
            raise TableError(
                f"{TABLE}:{fault.line}: error: fault {fault.number}: no file {fault.file} in {rtl}"
            )
        used = [path.name for path in sources(fault.unit, rtl)]
        if fault.file not in used:
            raise TableError(
                f"{TABLE}:{fault.line}: error: fault {fault.number}: {fault.file} is no part of "
                f"{fault.unit}, which executes {fault.ops[0]}; name an operation that uses it"
            )
    texts = {
        name: planted(path.read_text(), [fault for fault in faults if fault.file == name])
        for name, path in files.items()
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_if_changed(folder / name, text)
    return folder


def write_if_changed(path: Path, text: str) -> None:
    """Write a file unless it has this text already."""
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


def write_lanes(unit: str, faults: Sequence[Fault], top: Sequence[Path]) -> list[Path]:
    """Sources above a unit for one lane without fault (lane 0) and one lane per fault.

    The modules of a faulty lane are the copies compiled with the macro of the fault, under names
    of their own. `top`: fp_lane.sv and fpbench.sv of the fast bench. Returns what replaces them.
    """
    lane, bench = (path.read_text() for path in top)
    modules = [path for path in sources(unit, COPY) if path.stem != "fp_pkg"]
    names = "|".join([*(path.stem for path in modules), top[0].stem])
    text = "\n".join([*(path.read_text() for path in modules), lane])
    variants = [
        f"`define {fault.macro}\n"
        + re.sub(rf"\b({names})\b", rf"\1__{fault.number:02d}", text)
        + f"\n`undef {fault.macro}\n"
        for fault in faults
    ]
    instance = re.search(r"\bfp_lane lane (\(.*?\);)", bench, re.DOTALL)
    if instance is None:
        raise TableError(f"{top[1]}: no instance `fp_lane lane (...)` to vary from lane to lane")
    chain = "".join(
        f"if (i == {k}) begin : gen_{fault.number:02d}\n"
        f"    fp_lane__{fault.number:02d} lane {instance[1]}\n    end else "
        for k, fault in enumerate(faults, 1)
    )
    chain += f"begin : gen_good\n    {instance[0]}\n    end"
    folder = BUILD / "lanes" / unit
    folder.mkdir(parents=True, exist_ok=True)
    write_if_changed(folder / "variants.sv", "".join(variants))
    changed = bench[: instance.start()] + chain + bench[instance.end() :]
    write_if_changed(folder / "fpbench.sv", changed)
    return [top[0], folder / "variants.sv", folder / "fpbench.sv"]
