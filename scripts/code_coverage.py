# SPDX-License-Identifier: Apache-2.0
"""Code coverage of rtl/asip, rtl/fpu, rtl/custom and rtl/nios by the regression.

    .venv/bin/python -m scripts.code_coverage measure           all suites, then the page's table
    .venv/bin/python -m scripts.code_coverage measure cocotb    one suite; the others keep theirs
    .venv/bin/python -m scripts.code_coverage holes rtl/fpu     points that nothing covers

`measure` builds every model with counters, runs the suites and writes docs/data/coverage.json and
the table of docs/cocotb.md.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from asip_asm.command import script_parser
from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT
from scripts.hardware_goals import BENCHES
from sim.report.goals import Goal, at_least, exactly, not_measured
from sim.report.marks import write_between_marks
from sim.rtl.coverage import KINDS, PARTS, Point, load, merge

FOLDER = BUILD / "coverage"
DATA = ROOT / "docs/data/coverage.json"
PAGE = ROOT / "docs/cocotb.md"
EXPLAINED = Path(__file__).with_suffix(".toml")
SUITES = {
    "cocotb": [*BENCHES, "tests/asip/test_axil.py"],
    "custom": ["tests/custom"],
    "nios": ["tests/nios"],
    "gdb": ["tests/gdb"],
    "asip": ["tests/asip"],
    "fpu": ["tests/fpu"],
    "debug": ["tests/debug"],
    "upsets": ["tests/upsets"],
}
LIMITS = {"line": 98, "branch": 95, "toggle": 90}
PLURAL = {"line": "lines", "branch": "branches", "toggle": "toggles"}
CURE = "make goals T=hardware RUN=full"


def measure(suites: Sequence[str]) -> list[str]:
    """Run suites with counters; their counts go to FOLDER, one file a suite. Returns the names
    of suites with failed tests; their counts are written too.
    """
    failed = []
    for name in suites:
        print(f"{name} ...", flush=True)
        folder = FOLDER / name
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("*.dat"):
            old.unlink()
        own = {"RTL_COVERAGE": "1", "RTL_COVERAGE_FOLDER": str(folder)}
        command = [sys.executable, "-m", "pytest", "-q", "-n", "1", "-m", "not full", *SUITES[name]]
        done = subprocess.run(command, cwd=ROOT, env=os.environ | own, check=False)
        files = [path for path in folder.iterdir() if path.suffix in (".dat", ".json")]
        total = FOLDER / f"{name}.json"
        total.unlink(missing_ok=True)
        merge(files, total)
        if done.returncode:
            print(f"note: tests of {name} failed; what they covered is counted", file=sys.stderr)
            failed.append(name)
    return failed


@cache
def explanations() -> list[dict]:
    """Entries of the table of points that no test can cover, or need not."""
    return tomllib.loads(EXPLAINED.read_text(encoding="utf-8")).get("hole", [])


@cache
def lines_of(file: str) -> list[str]:
    """Lines of a source file."""
    return (ROOT / file).read_text(encoding="utf-8").splitlines()


def explained(point: Point) -> str:
    """Why a point is not counted; empty if nothing explains it."""
    for entry in explanations():
        kinds = entry.get("kinds", KINDS)
        if point.file not in entry["files"] or point.kind not in kinds:
            continue
        text = lines_of(point.file)[point.line - 1]
        if any(part in text for part in entry.get("text", ("",))) and re.fullmatch(
            entry.get("what", ".*"), point.what.partition(":")[0]
        ):
            return entry["why"]
    return ""


def found() -> Counter[Point]:
    """Counts of all suites that were measured. Raises FileNotFoundError without any."""
    total: Counter[Point] = Counter()
    for name in SUITES:
        total.update(load(FOLDER / f"{name}.json"))
    if not total:
        raise FileNotFoundError(f"no counts in {FOLDER}; run `{CURE}`")
    return total


def shares(points: Mapping[Point, int]) -> dict[str, dict[str, list[int]]]:
    """Part of the RTL -> kind -> points covered, points in all, points explained."""
    table = {part: {kind: [0, 0, 0] for kind in KINDS} for part in PARTS}
    for point, count in points.items():
        row = table[point.file.rpartition("/")[0]][point.kind]
        if not count and explained(point):
            row[2] += 1
            continue
        row[0] += count > 0
        row[1] += 1
    return table


def holes(points: Mapping[Point, int]) -> list[Point]:
    """Points that nothing covers or explains."""
    return sorted(p for p, count in points.items() if not count and not explained(p))


def stale() -> list[dict]:
    """Explanations of points that are covered or are not there."""
    points = found()
    used = {explained(point) for point, count in points.items() if not count}
    return [entry for entry in explanations() if entry["why"] not in used]


def percent(covered: int, total: int) -> float:
    """Share in percent."""
    return 100 * covered / total if total else 100.0


def rows(full: bool) -> Iterator[Goal]:
    """The goals: one share of each kind over the four parts."""
    names = {kind: f"{PLURAL[kind]} covered in asip, fpu, custom, nios" for kind in KINDS}
    if not full:
        for kind in KINDS:
            yield not_measured(names[kind], f">= {LIMITS[kind]}", "%", CURE)
        return
    failed = measure(list(SUITES))
    yield exactly("suites with failed tests in the coverage", len(failed), 0, "", ", ".join(failed))
    left = stale()
    name = "explanations of points that are covered or gone"
    yield exactly(name, len(left), 0, "", ", ".join(entry["why"] for entry in left))
    table = write_data()
    for kind in KINDS:
        covered, total, _ = (sum(part[kind][i] for part in table.values()) for i in range(3))
        yield at_least(names[kind], percent(covered, total), LIMITS[kind], "%")


def write_data() -> dict[str, dict[str, list[int]]]:
    """Write docs/data and the page's table; returns the shares."""
    table = shares(found())
    suites = [name for name in SUITES if (FOLDER / f"{name}.json").exists()]
    write_text(DATA, json.dumps({"suites": suites, "parts": table}, indent=1) + "\n")
    write_between_marks(PAGE, {"coverage": page_table(suites, table)})
    return table


def listed(names: Sequence[str]) -> str:
    """Names as code, between commas."""
    return ", ".join(f"`{name}`" for name in names)


def page_table(suites: Sequence[str], table: Mapping[str, Mapping[str, list[int]]]) -> str:
    """Markdown of the shares, one line a part."""
    whole = {
        kind: [sum(row[kind][i] for row in table.values()) for i in range(3)] for kind in KINDS
    }
    rows = ["| part | lines | branches | toggles |", "| --- | --- | --- | --- |"]
    for part, row in (*((f"`{part}`", row) for part, row in table.items()), ("all", whole)):
        cells = (
            f"{percent(covered, total):.1f} % of {total}" + (f", {left} explained" if left else "")
            for covered, total, left in (row[kind] for kind in KINDS)
        )
        rows.append(f"| {part} | {' | '.join(cells)} |")
    left = [name for name in SUITES if name not in suites]
    note = f"Suites that were counted: {listed(suites)}."
    note += f" Not counted yet: {listed(left)}." if left else ""
    return "\n".join((*rows, "", note)) + "\n"


def show(points: Sequence[Point]) -> None:
    """One line a signal or place."""
    grouped: dict[tuple[str, int, str, str], int] = {}
    for point in points:
        name = point.what.partition(":")[0].partition("[")[0]
        key = (point.file, point.line, point.kind, name)
        grouped[key] = grouped.get(key, 0) + 1
    for (file, line, kind, name), count in grouped.items():
        print(f"{file}:{line}: {kind} {name}: {count}")


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = script_parser(__doc__, "python -m scripts.code_coverage measure cocotb")
    parser.add_argument("what", choices=("measure", "holes", "table"))
    parser.add_argument("names", nargs="*", help="suites, or the beginning of paths")
    options = parser.parse_args(argv)
    if options.what == "measure":
        unknown = set(options.names) - SUITES.keys()
        if unknown:
            print(f"error: no suite {', '.join(unknown)}; there are {', '.join(SUITES)}")
            return 2
        measure(options.names or list(SUITES))
    try:
        points = found()
    except FileNotFoundError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if options.what == "holes":
        names = tuple(options.names) or ("",)
        show([point for point in holes(points) if point.file.startswith(names)])
        return 0
    for part, kinds in write_data().items():
        texts = (
            f"{PLURAL[kind]} {covered}/{total} = {percent(covered, total):.1f} %"
            for kind, (covered, total, _) in kinds.items()
        )
        print(f"{part}: {', '.join(texts)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
