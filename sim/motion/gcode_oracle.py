# SPDX-License-Identifier: Apache-2.0
"""Canonical moves of a program, ours and those of LinuxCNC's interpreter `rs274`, as equal lists.

    python -m sim.motion.gcode_oracle            fetch rs274 (linuxcnc-uspace) into build/
    python -m sim.motion.gcode_oracle part.ngc   compare both interpreters on a program
    python -m sim.motion.gcode_oracle --samples  the same on LinuxCNC's own sample programs

rs274 prints coordinates of the program; its records of offsets turn them into those of the machine.
Moves that stay where they are and rests of 0 s (our M0, M6) count in neither list. Lengths in mm,
angles in degrees. Both have the tools of LinuxCNC's sample configurations, if that table is there.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from sim.motion.gcode import GcodeErrors, parse
from sim.motion.gcode_tools import tool_table
from sim.motion.moves import MM_PER_INCH, Dwell, Motion

ROOT = Path(__file__).resolve().parents[2]
# With the libraries that a small machine may lack; the first is the interpreter.
PACKAGES = (
    "linuxcnc-uspace",
    *("libboost-python1.74.0", "libpython3.11", "libedit2", "libbsd0", "libmd0", "libtirpc3"),
)
UNPACKED = ROOT / "build/linuxcnc/root"
SAMPLES = "share/linuxcnc/ncfiles"  # below the folder of bin/rs274
TOOLS = "share/doc/linuxcnc/examples/sample-configs/common/tool.tbl"  # lengths in inches, as rs274
DIGITS = 1.01e-4  # rs274 prints four decimals of mm or inch; sums of two of them
_RECORD = re.compile(r"^ *\d+ \S+ +(\w+)\((.*)\)\s*$")
_COMMENT = re.compile(r"\([^)]*\)|;.*")
_TOOL_CHANGE = re.compile(r"[mM] *0*6(?![\d.])")
_TOOL_OFFSET = re.compile(r"[gG] *(43|49)(?![\d.])")
_TOOL_WORDS = re.compile(r"[mM] *0*6(?![\d.])|[tT] *\d+")
Record = tuple[str, tuple[float, ...]]


class OracleError(RuntimeError):
    """rs274 is not there, or it refuses a program."""


def find() -> Path | None:
    """rs274 as installed, or as unpacked by `fetch`."""
    installed = shutil.which("rs274")
    if installed:
        return Path(installed)
    unpacked = UNPACKED / "usr/bin/rs274"
    return unpacked if unpacked.exists() else None


def fetch() -> Path:
    """Downloads and unpacks the packages below build/, without installing them."""
    UNPACKED.mkdir(parents=True, exist_ok=True)
    download = ["apt-get", "download", *PACKAGES]
    try:
        if subprocess.run(download, cwd=UNPACKED.parent, check=False).returncode != 0:
            # A fresh machine has no lists of packages yet.
            subprocess.run(["apt-get", "update", "-q"], check=False)
            subprocess.run(download, cwd=UNPACKED.parent, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise OracleError(f"apt-get cannot download {' '.join(PACKAGES)}: {error}") from None
    for file in UNPACKED.parent.glob("*.deb"):
        subprocess.run(["dpkg", "-x", str(file), str(UNPACKED)], check=True)
    return UNPACKED / "usr/bin/rs274"


def sample_tools() -> Path | None:
    """LinuxCNC's sample tool table, None where it is not installed."""
    program = find()
    path = program.parent.parent / TOOLS if program else None
    return path if path is not None and path.exists() else None


def rs274(text: str) -> list[Record]:
    """Records of rs274 for a program. Raises OracleError with its message if it refuses."""
    return list(_machine_records(_canonical(text)))


def _as_on_a_machine(text: str) -> str:
    """The text with T and M6 in a block of their own.

    rs274 alone takes over its old position behind a block with M6, whatever G43 or G49 of the same
    block has made of it; with a machine it reads the position back. In two blocks both are alike.
    """
    lines = []
    for line in text.splitlines():
        code = _COMMENT.sub("", line)
        if _TOOL_CHANGE.search(code) and _TOOL_OFFSET.search(code):
            changes = [match.group() for match in _TOOL_WORDS.finditer(code)]
            lines += [" ".join(changes), _TOOL_WORDS.sub("", code)]
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _canonical(text: str) -> str:
    """What rs274 prints for a program. Raises OracleError as `rs274` does."""
    program = find()
    if program is None:
        raise OracleError("rs274 is missing: run python -m sim.motion.gcode_oracle")
    libraries = [UNPACKED / "usr/lib", *(UNPACKED / "usr/lib").glob("*-linux-gnu")]
    path = ":".join([*(str(folder) for folder in libraries), os.environ.get("LD_LIBRARY_PATH", "")])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.ngc"
        file.write_text(_as_on_a_machine(text), encoding="utf-8")
        run = subprocess.run(
            [str(program), "-t", str(sample_tools() or "/dev/null"), "-g", str(file)],
            cwd=folder,
            # Its tool table in memory is a file of the home folder, which runs at once would share.
            env={**os.environ, "LD_LIBRARY_PATH": path, "HOME": folder},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
        )
    if run.returncode != 0:
        raise OracleError((run.stderr.strip() or run.stdout.strip()).splitlines()[-1])
    return run.stdout


def _machine_records(text: str) -> Iterator[Record]:
    """Records in coordinates of the machine, mm and degrees, x y z A C."""
    system, shift, tool, here = [0.0] * 5, [0.0] * 5, [0.0] * 5, [0.0] * 5
    unit, plane, feed = 1.0, "XY", 0.0

    def pose(values: list[float]) -> list[float]:
        x, y, z, a, _, c = values[:6]
        lengths = [value * unit for value in (x, y, z)]
        parts = zip([*lengths, a, c], system, shift, tool, strict=True)
        return [v + s + g + t for v, s, g, t in parts]

    for line in text.splitlines():
        match = _RECORD.match(line)
        if not match:
            continue
        name, rest = match.groups()
        if name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCHES" in rest else 1.0
        elif name == "SELECT_PLANE":
            plane = rest.split("_")[-1]
        elif name == "SET_FEED_RATE":
            feed = float(rest) * unit
        elif name in ("SET_G5X_OFFSET", "SET_G92_OFFSET"):
            values = [float(value) for value in rest.split(",")][-6:]
            offset = [*(value * unit for value in values[:3]), values[3], values[5]]
            if name == "SET_G5X_OFFSET":
                system = offset
            else:
                shift = offset
        elif name == "USE_TOOL_LENGTH_OFFSET":
            x, y, z, a, _, c = (float(value) for value in re.split(r"[ ,]+", rest)[:6])
            tool = [x * unit, y * unit, z * unit, a, c]
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            end = pose([float(value) for value in rest.split(",")])
            if max(abs(a - b) for a, b in zip(end, here, strict=True)) > DIGITS:
                motion = "G0" if name == "STRAIGHT_TRAVERSE" else "G1"
                yield motion, (*end, *([feed] if motion == "G1" else []))
            here = end
        elif name == "ARC_FEED":
            first, second, cx, cy, turns, rise, a, _, c = (float(v) for v in rest.split(","))
            axes = {"XY": (0, 1), "XZ": (2, 0), "YZ": (1, 2)}[plane]
            values, centre = [0.0] * 6, [0.0] * 6
            values[axes[0]], values[axes[1]], values[3 - sum(axes)] = first, second, rise
            centre[axes[0]], centre[axes[1]] = cx, cy
            values[3], values[5] = a, c
            end, middle = pose(values), pose(centre)
            yield "G3" if turns > 0 else "G2", (*end, middle[axes[0]], middle[axes[1]], feed)
            here = end
        elif name == "DWELL" and float(rest) > 0.0:
            yield "G4", (float(rest),)


def ours(text: str) -> list[Record]:
    """The same records by our interpreter, from the origin. Raises GcodeErrors."""
    table = sample_tools()
    tools = tool_table(table.read_text().splitlines(), str(table), MM_PER_INCH) if table else {}
    program = parse(text, "program.ngc", (0.0,) * 5, tools)
    records: list[Record] = []
    dwells = [(before, dwell) for before, dwell in program.dwells if dwell.seconds > 0.0]
    for number, move in enumerate(program.moves):
        while dwells and dwells[0][0] <= number:
            records.append(_dwell(dwells.pop(0)[1]))
        feed = [] if move.motion is Motion.RAPID else [move.feed]
        if move.motion.is_arc:
            records.append((move.motion.value, (*move.end, *move.centre, *feed)))
        elif max(abs(a - b) for a, b in zip(move.start, move.end, strict=True)) > DIGITS:
            records.append((move.motion.value, (*move.end, *feed)))
    return records + [_dwell(dwell) for _, dwell in dwells]


def _dwell(dwell: Dwell) -> Record:
    return "G4", (dwell.seconds,)


def differences(text: str) -> list[str]:
    """Differences of both lists, in words; empty if they agree."""
    mine, printed = ours(text), _canonical(text)
    theirs = list(_machine_records(printed))
    digits = DIGITS * (25.4 if "CANON_UNITS_INCHES" in printed else 1.0)
    found = []
    if len(mine) != len(theirs):
        found.append(f"{len(mine)} records here, {len(theirs)} of rs274")
    for number, (a, b) in enumerate(zip(mine, theirs, strict=False), start=1):
        alike = a[0] == b[0] and len(a[1]) == len(b[1])
        if not alike or any(abs(x - y) > digits for x, y in zip(a[1], b[1], strict=True)):
            found.append(f"record {number}: {a[0]} {a[1]} here, {b[0]} {b[1]} of rs274")
    return found


@dataclass
class Samples:
    """LinuxCNC's sample programs by what became of them, as file names.

    refused: we refuse what rs274 runs, with our first reason; unfit: rs274 itself refuses (tools,
    probes, subroutines called from elsewhere); moving: of those that it runs, with moves.
    """

    equal: list[str] = field(default_factory=list)
    different: dict[str, str] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    unfit: dict[str, str] = field(default_factory=dict)
    moving: set[str] = field(default_factory=set)

    @property
    def all_equal(self) -> bool:
        """Whether every program that moves in rs274 moves alike here."""
        return self.moving <= set(self.equal)

    @property
    def text(self) -> str:
        """Counts in words."""
        alike = len(self.moving & set(self.equal))
        return (
            f"{alike} of {len(self.moving)} equal, {len(self.moving & self.different.keys())} "
            f"different, {len(self.moving & self.refused.keys())} refused"
        )


def compare_samples() -> Samples:
    """Both interpreters on every sample program. Raises OracleError where LinuxCNC is missing."""
    program = find()
    folder = program.parent.parent / SAMPLES if program else None
    files = sorted(folder.glob("*.ngc")) if folder else []
    if not files:
        raise OracleError("LinuxCNC's samples are missing: run python -m sim.motion.gcode_oracle")
    found = Samples()
    for file in files:
        text = file.read_text(encoding="utf-8", errors="replace")
        try:
            theirs = rs274(text)
        except (OracleError, subprocess.TimeoutExpired) as error:
            found.unfit[file.name] = str(error)
            continue
        if any(record[0] != "G4" for record in theirs):
            found.moving.add(file.name)
        try:
            differing = differences(text)
        except GcodeErrors as errors:
            found.refused[file.name] = str(errors.errors[0]).splitlines()[0].partition("error: ")[2]
            continue
        if differing:
            found.different[file.name] = differing[0]
        else:
            found.equal.append(file.name)
    return found


def main(argv: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m sim.motion.gcode_oracle",
        description="Fetch LinuxCNC's interpreter, or compare it with ours on programs.",
        epilog="example: python -m sim.motion.gcode_oracle sim/paths/circle.ngc",
    )
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--samples", action="store_true", help="compare LinuxCNC's own samples")
    arguments = parser.parse_args(argv)
    status = 0
    try:
        if arguments.samples:
            found = compare_samples()
            for kind in ("unfit", "refused", "different"):
                for name, reason in getattr(found, kind).items():
                    sys.stdout.write(f"{name}: {kind}: {reason}\n")
            sys.stdout.write("".join(f"{name}: equal\n" for name in found.equal))
            sys.stdout.write(f"programs that move: {found.text}\n")
            return int(bool(found.different))
        if not arguments.files:
            sys.stdout.write(f"{find() or fetch()}\n")
        for file in arguments.files:
            found = differences(file.read_text(encoding="utf-8"))
            sys.stdout.write("".join(f"{file}: {text}\n" for text in found or ["equal"]))
            status = max(status, int(bool(found)))
    except (OracleError, GcodeErrors) as error:
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return 1
    except OSError as error:
        sys.stderr.write(f"{error.filename}: error: {error.strerror}\n")
        return 1
    return status


if __name__ == "__main__":
    sys.exit(main())
