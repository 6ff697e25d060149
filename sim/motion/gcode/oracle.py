# SPDX-License-Identifier: Apache-2.0
"""Canonical moves of a program, ours and those of LinuxCNC's interpreter `rs274`, as equal lists.

    python -m sim.motion.gcode.oracle            fetch rs274 (linuxcnc-uspace) into build/
    python -m sim.motion.gcode.oracle part.ngc   compare both interpreters on a program
    python -m sim.motion.gcode.oracle --samples  the same on LinuxCNC's own sample programs

rs274 prints coordinates of the program; its records of offsets turn them into those of the machine.
After a probing move it draws the probe back by DRAWN_BACK, which a machine does not: axes that have
not left that range since then count as where the probing ended.
Moves that stay where they are and rests of 0 s (our M0, M6) count in neither list. Lengths in mm,
angles in degrees. Both have the tools of LinuxCNC's sample configurations, if that table is there.
"""

from __future__ import annotations

import cmath
import itertools
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from asip_asm.command import command, script_parser
from asip_asm.files import read_bytes, read_text, write_text
from sim.motion.gcode.interpreter import GcodeErrors, stream
from sim.motion.gcode.oracle_splines import Point
from sim.motion.gcode.oracle_splines import blocks as preview_blocks
from sim.motion.gcode.tools import tool_table
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.moves import MM_PER_INCH, Dwell, Motion
from sim.motion.geometry.rotation import Rotation

ROOT = Path(__file__).resolve().parents[3]
# With the libraries that a small machine may lack; the first is the interpreter.
PACKAGES = (
    "linuxcnc-uspace",
    *("libboost-python1.74.0", "libpython3.11", "libedit2", "libbsd0", "libmd0", "libtirpc3"),
)
UNPACKED = ROOT / "build/linuxcnc/root"
SAMPLES = "share/linuxcnc/ncfiles"  # path below the folder of bin/rs274
MODULES = "lib/python3/dist-packages"
TOOLS = "share/doc/linuxcnc/examples/sample-configs/common/tool.tbl"  # lengths in inches, as rs274
DIGITS = 1.01e-4  # rs274 prints four decimals of mm or inch; sums of two of them
_RECORD = re.compile(r"^ *\d+ (?:N\d{6,}|N\S* +)([A-Z][A-Z0-9_.]*)\((.*)\)\s*$")
_NUMBERED = re.compile(r"^ *\d+ N")
# Records without a path; the comparison passes over them.
_NO_PATH = frozenset(
    """
    CHANGE_TOOL CHANGE_TOOL_NUMBER CLEAR_AUX_OUTPUT_BIT CLEAR_MOTION_OUTPUT_BIT COMMENT
    DISABLE_FEED_OVERRIDE DISABLE_SPEED_OVERRIDE ENABLE_FEED_OVERRIDE ENABLE_SPEED_OVERRIDE FINISH
    FLOOD_OFF FLOOD_ON LOG LOGAPPEND LOGCLOSE LOGOPEN MESSAGE MIST_OFF MIST_ON ON_RESET
    OPTIONAL_PROGRAM_STOP ORIENT_SPINDLE PALLET_SHUTTLE PROGRAM_END PROGRAM_STOP RELOAD_TOOLDATA
    SELECT_TOOL SET_AUX_OUTPUT_BIT SET_AUX_OUTPUT_VALUE SET_CUTTER_RADIUS_COMPENSATION
    SET_FEED_REFERENCE SET_MOTION_CONTROL_MODE SET_MOTION_OUTPUT_BIT SET_MOTION_OUTPUT_VALUE
    SET_NAIVECAM_TOLERANCE SET_SPINDLE_MODE SET_TOOL_TABLE_ENTRY SPINDLE.0.WAIT_ORIENT_COMPLETE
    START_CHANGE START_CUTTER_RADIUS_COMPENSATION START_SPINDLE_CLOCKWISE
    START_SPINDLE_COUNTERCLOCKWISE STOP_CUTTER_RADIUS_COMPENSATION STOP_SPEED_FEED_SYNCH
    STOP_SPINDLE_TURNING TURN_PROBE_OFF TURN_PROBE_ON USE_NO_SPINDLE_FORCE USE_SPINDLE_FORCE
    """.split()
)
CHORD_MM = 0.001  # greatest distance between our chords of a spline and its points
LEAST_EQUAL = 22  # sample programs, the target of the goal
DRAWN_BACK = 0.254  # mm, of a probe in rs274
MAX_BYTES = 10_000_000  # largest program to compare
MAX_ITEMS = 1_000_000  # of its moves and rests
SECONDS = 20  # time limit, because rs274 runs endless loops
_SPLINE = re.compile(r"[gG] *0*5(\.[123])?(?!\d)")
_COMMENT = re.compile(r"\([^)]*\)|;.*")
_TOOL_CHANGE = re.compile(r"[mM] *0*6(?![\d.])")
_TOOL_NUMBER = re.compile(r"[mM] *0*61(?![\d.])")
_TOOL_OF_M61 = re.compile(r"[qQ] *(#<[^>]*>|#?[\d.]+|\[[^\]]*\])")
_TOOL_OFFSET = re.compile(r"[gG] *(43|49)(?![\d.])")
_TOOL_WORDS = re.compile(r"[mM] *0*6(?![\d.])|[tT] *\d+")
_STRAIGHT = ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "STRAIGHT_PROBE", "RIGID_TAP")
_MOVING = ("G0", "G1", "G2", "G3", "G5")
UNKNOWN = "unknown record"
Record = tuple[str, tuple[float, ...]]


class Rate(float):
    """A feed of rs274 by turns of the spindle, off by `miss` at most, as its digits leave it."""

    def __new__(cls, per_turn: float, speed: float, digit: float) -> Rate:
        """per_turn [mm], printed to `digit` [mm]; speed [1/min]."""
        rate = super().__new__(cls, per_turn * speed)
        rate.miss = digit * speed / 2
        return rate

    miss: float


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


def _usr() -> Path:
    """The folder that holds bin/rs274, its samples and its modules. Raises OracleError."""
    program = find()
    if program is None:
        raise OracleError("rs274 is missing: run python -m sim.motion.gcode.oracle")
    return program.parent.parent


def sample_tools() -> Path | None:
    """LinuxCNC's sample tool table, None where it is not installed."""
    path = _usr() / TOOLS if find() else None
    return path if path is not None and path.exists() else None


def rs274(text: str) -> list[Record]:
    """Records of rs274 for a program. Raises OracleError with its message if it refuses.

    A record that is neither compared nor known to have no path is UNKNOWN with its text, which
    equals none of ours.

    A spline, G5, has the feed and the points of LinuxCNC's preview, x and y in turn.
    """
    return _records(text, _canonical(text))


def _records(text: str, printed: str) -> list[Record]:
    blocks: list[list[Point]] = []
    if "NURBS_FEED" in printed:
        try:
            blocks = preview_blocks(_as_on_a_machine(text), _libraries(), _usr() / MODULES)
        except (RuntimeError, subprocess.TimeoutExpired) as error:
            raise OracleError(f"LinuxCNC's preview: {error}") from None
    return list(machine_records(printed, blocks))


def _libraries() -> str:
    """LD_LIBRARY_PATH for the unpacked programs."""
    folders = [UNPACKED / "usr/lib", *(UNPACKED / "usr/lib").glob("*-linux-gnu")]
    return ":".join([*(str(folder) for folder in folders), os.environ.get("LD_LIBRARY_PATH", "")])


def _as_on_a_machine(text: str) -> str:
    """The text with T and M6 in a block of their own, and M6 for M61.

    rs274 alone takes over its old position after a block with M6, whatever G43 or G49 of the same
    block has made of it; with a machine it reads the position back. In two blocks both agree. It
    also leaves the old tool in the spindle after M61.
    """
    lines = []
    for line in text.splitlines():
        code = _COMMENT.sub("", line)
        if _TOOL_NUMBER.search(code) and (number := _TOOL_OF_M61.search(code)):
            rest = _TOOL_NUMBER.sub("", _TOOL_OF_M61.sub("", code))
            lines += [f"T{number.group(1)} M6", rest]
            continue
        if _TOOL_CHANGE.search(code) and _TOOL_OFFSET.search(code):
            changes = [match.group() for match in _TOOL_WORDS.finditer(code)]
            lines += [" ".join(changes), _TOOL_WORDS.sub("", code)]
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _canonical(text: str) -> str:
    """What rs274 prints for a program. Raises OracleError as `rs274` does."""
    program = _usr() / "bin/rs274"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.ngc"
        write_text(file, _as_on_a_machine(text))
        command = [str(program), "-t", str(sample_tools() or "/dev/null"), "-g", str(file)]
        try:
            run = subprocess.run(
                command,
                cwd=folder,
                # Its tool table in memory is a file of the home folder, which all would share.
                env={**os.environ, "LD_LIBRARY_PATH": _libraries(), "HOME": folder},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=SECONDS,
            )
        except subprocess.TimeoutExpired:
            raise OracleError(f"rs274 has not ended after {SECONDS} s") from None
    if run.returncode != 0:
        said = run.stderr.strip() or run.stdout.strip() or f"exit status {run.returncode}"
        raise OracleError(said.splitlines()[-1])
    return run.stdout


def machine_records(text: str, blocks: list[list[Point]]) -> Iterator[Record]:
    """Records in coordinates of the machine, mm and degrees, x y z A C.

    blocks: ends of the moves in the preview, which replaces what rs274 does not print of splines.
    """
    preview = iter(blocks)
    left: list[Point] = []
    system, shift, tool, here = [0.0] * 5, [0.0] * 5, [0.0] * 5, [0.0] * 5
    unit, plane, feed, rotation = 1.0, "XY", 0.0, 0.0
    speed, thread = 0.0, 0.0  # of the spindle [1/min], of a thread [mm/min]
    per_turn = False  # the feed [mm] is for a turn of the spindle
    probed: dict[int, float] = {}  # where the last probing ended, of axes not moved since [mm]

    def axes_of(values: list[float]) -> list[float]:
        x, y, z, a, _, c = values
        return [x * unit, y * unit, z * unit, a, c]

    def pose(values: list[float]) -> list[float]:
        x, y, *rest = (v + g for v, g in zip(axes_of(values), shift, strict=True))
        place = complex(x, y) * cmath.rect(1.0, rotation)
        parts = zip([place.real, place.imag, *rest], system, tool, strict=True)
        return [v + s + t for v, s, t in parts]

    for line in text.splitlines():
        match = _RECORD.match(line)
        if not match:
            if _NUMBERED.match(line):
                yield f"{UNKNOWN} {line.strip()}", ()
            continue
        name, rest = match.groups()
        if blocks and name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED", "NURBS_FEED"):
            left = left or next(preview)
            curve, left = (left, []) if name == "NURBS_FEED" else (left[:1], left[1:])
        if name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCHES" in rest else 1.0
        elif name == "SELECT_PLANE":
            plane = rest.split("_")[-1]
        elif name == "SET_FEED_RATE":
            feed = float(rest) * unit
        elif name == "SET_FEED_MODE":
            per_turn = rest.split(",")[-1].strip() == "1"
        elif name in ("SET_G5X_OFFSET", "SET_G92_OFFSET"):
            offset = axes_of([float(value) for value in rest.split(",")][-6:])
            if name == "SET_G5X_OFFSET":
                system = offset
            else:
                shift = offset
        elif name == "USE_TOOL_LENGTH_OFFSET":
            tool = axes_of([float(value) for value in re.split(r"[ ,]+", rest)[:6]])
        elif name == "SET_XY_ROTATION":
            rotation = math.radians(float(rest))
        elif name == "SET_SPINDLE_SPEED":
            speed = float(rest.split(",")[-1])
        elif name == "START_SPEED_FEED_SYNC":
            thread = Rate(float(rest.split(",")[0]) * unit, speed, 1e-6 * unit)
        elif name == "STOP_SPEED_FEED_SYNCH":
            thread = 0.0
        elif name in _STRAIGHT:
            values = [float(value) for value in rest.split(",")][:6]
            for axis, place in list(probed.items()):
                if abs(values[axis] * unit - place) <= DRAWN_BACK + DIGITS:
                    values[axis] = place / unit
                else:
                    del probed[axis]
            if name == "STRAIGHT_PROBE":
                probed = {axis: value * unit for axis, value in enumerate(values[:3])}
            end, back = pose([*values, *[0.0] * (6 - len(values))]), here
            if name == "RIGID_TAP":
                end[3:] = here[3:]
            if max(abs(a - b) for a, b in zip(end, here, strict=True)) > DIGITS:
                motion = "G0" if name == "STRAIGHT_TRAVERSE" else "G1"
                rate = thread or (Rate(feed, speed, 1e-4 * unit) if per_turn else feed)
                yield motion, (*end, *([rate] if motion == "G1" else []))
                if name == "RIGID_TAP":
                    yield motion, (*back, thread)
            here = back if name == "RIGID_TAP" else end
        elif name == "ARC_FEED":
            first, second, cx, cy, turns, rise, a, _, c = (float(v) for v in rest.split(","))
            axes = {"XY": (0, 1), "XZ": (2, 0), "YZ": (1, 2)}[plane]
            values, centre = [0.0] * 6, [0.0] * 6
            values[axes[0]], values[axes[1]], values[3 - sum(axes)] = first, second, rise
            centre[axes[0]], centre[axes[1]] = cx, cy
            values[3], values[5] = a, c
            if plane != "XY":
                centre[3 - sum(axes)] = rise
            end, middle = pose(values), pose(centre)
            if plane != "XY":  # in the axes before the rotation of the plane
                middle = [*Rotation(math.degrees(rotation)).turned_back(middle)]
            kind = ("G3" if turns > 0 else "G2") + (f" P{abs(turns):g}" if abs(turns) > 1 else "")
            rate = Rate(feed, speed, 1e-4 * unit) if per_turn else feed
            yield kind, (*end, middle[axes[0]], middle[axes[1]], rate)
            here = end
        elif name == "NURBS_FEED":
            points = [pose([x / unit, y / unit, z / unit, 0, 0, 0])[:2] for x, y, z in curve]
            here = [*points[-1], *here[2:]]
            yield "G5", (feed, *itertools.chain(*points))
        elif name == "DWELL":
            if float(rest) > 0.0:
                yield "G4", (float(rest),)
        elif name not in _NO_PATH:
            yield f"{UNKNOWN} {line.strip()}", ()


def ours(text: str) -> list[Record]:
    """The same records by our interpreter, from the origin. Raises GcodeErrors."""
    table = sample_tools()
    tools = tool_table(table.read_text().splitlines(), str(table), MM_PER_INCH) if table else {}
    records: list[Record] = []
    for number, move in enumerate(stream(text.splitlines(), "program.ngc", (0.0,) * 5, tools)):
        if number == MAX_ITEMS:
            raise OracleError(f"more than {MAX_ITEMS} moves to compare")
        if isinstance(move, Dwell):
            if move.seconds > 0.0:
                records.append(("G4", (move.seconds,)))
            continue
        spline = _SPLINE.search(_COMMENT.sub("", move.source)) and move.motion is Motion.LINEAR
        feed = [] if move.motion is Motion.RAPID else [move.rate]
        if spline:
            if not move.inner:
                records.append(("G5", (move.rate, *move.start[:2])))
            records[-1] = "G5", (*records[-1][1], *move.end[:2])
        elif move.motion.is_arc:
            kind = move.motion.value + (f" P{move.turns}" if move.turns > 1 else "")
            records.append((kind, (*move.end, *move.circle[1], *feed)))
        elif max(abs(a - b) for a, b in zip(move.start, move.end, strict=True)) > DIGITS:
            records.append((move.motion.value, (*move.end, *feed)))
    return records


def curve_difference(chords: FloatArray, points: FloatArray) -> str | None:
    """How our chords (n, 2) of a spline differ from LinuxCNC's points (m, 2) of it, None if equal.

    Every point, also the last one, must be within CHORD_MM of the chords, in their order. LinuxCNC
    has fewer points: every end of a chord must be as near to the lines between them as those are to
    the curve, which is 1/8 of the second differences for even steps.
    """
    points = np.vstack([chords[0], points])
    at = 0.0
    for point in points:
        places, gaps = _nearest(chords, point)
        good = np.flatnonzero((gaps <= CHORD_MM) & (places >= at - CHORD_MM))
        if not len(good):
            return f"is {float(gaps.min()):.6f} mm or more from {point} of LinuxCNC"
        at = places[good[0]]
    if math.dist(chords[-1], points[-1]) > CHORD_MM:
        return f"ends at {chords[-1]}, in LinuxCNC at {points[-1]}"
    bend = np.linalg.norm(np.diff(points, n=2, axis=0), axis=1).max(initial=0.0)
    far = max(float(_nearest(points, end)[1].min()) for end in chords)
    if far > bend / 8 * 1.5 + CHORD_MM:
        return f"is {far:.6f} mm from the lines of LinuxCNC"
    return None


def _nearest(line: FloatArray, point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """For each piece of a line (n, 2): way along the line to the nearest place, distance there."""
    ways = np.diff(line, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    square = np.maximum(lengths**2, np.finfo(float).tiny)
    share = np.clip(np.sum((point - line[:-1]) * ways, axis=1) / square, 0.0, 1.0)
    gaps = np.linalg.norm(point - line[:-1] - share[:, None] * ways, axis=1)
    return np.cumsum(lengths) - lengths * (1.0 - share), gaps


def differences(text: str) -> list[str]:
    """Differences of both lists, in words; empty if they agree."""
    mine, printed = ours(text), _canonical(text)
    theirs = _records(text, printed)
    digits = DIGITS * (25.4 if "CANON_UNITS_INCHES" in printed else 1.0)
    found = []
    mine, theirs = _aligned(mine, theirs, digits)
    if len(mine) != len(theirs):
        found.append(f"{len(mine)} records here, {len(theirs)} of rs274")
    found += [f"{kind} of rs274" for kind, _ in theirs if kind.startswith(UNKNOWN)]
    for number, (a, b) in enumerate(zip(mine, theirs, strict=False), start=1):
        if a[0] == b[0] == "G5":
            far = curve_difference(np.reshape(a[1][1:], (-1, 2)), np.reshape(b[1][1:], (-1, 2)))
            if far is not None or abs(a[1][0] - b[1][0]) > digits:
                found.append(f"record {number}: spline {far}, feed {a[1][0]} here, {b[1][0]}")
            continue
        alike = a[0] == b[0] and len(a[1]) == len(b[1])
        miss = b[1][-1].miss if b[1] and isinstance(b[1][-1], Rate) else 0.0
        near = [digits] * (len(a[1]) - 1) + [digits + miss]
        if not alike or any(abs(x - y) > d for x, y, d in zip(a[1], b[1], near, strict=True)):
            found.append(f"record {number}: {a[0]} {a[1]} here, {b[0]} {b[1]} of rs274")
    return found


def _aligned(
    mine: list[Record], theirs: list[Record], digits: float
) -> tuple[list[Record], list[Record]]:
    """Both lists without the moves that only one of them has and that go nowhere but by rounding:
    every axis by at most 2 digits."""

    def near(a: Record, b: Record) -> bool:
        pairs = zip(a[1][:5], b[1][:5], strict=False)
        return a[0] == b[0] and all(abs(x - y) <= digits for x, y in pairs)

    def stays(records: list[Record], at: int) -> bool:
        kind, values = records[at]
        before = (r[1][:5] for r in reversed(records[:at]) if r[0] not in ("G4", "G5"))
        pairs = zip(values[:5], next(before, (0.0,) * 5), strict=False)
        return kind in ("G0", "G1") and all(abs(x - y) <= 2 * digits for x, y in pairs)

    kept: tuple[list[Record], list[Record]] = ([], [])
    i = j = 0
    while i < len(mine) or j < len(theirs):
        both = i < len(mine) and j < len(theirs)
        if not (both and near(mine[i], theirs[j])):
            if j < len(theirs) and stays(theirs, j):
                j += 1
                continue
            if i < len(mine) and stays(mine, i):
                i += 1
                continue
        kept[0].extend(mine[i : i + 1])
        kept[1].extend(theirs[j : j + 1])
        i, j = i + 1, j + 1
    return kept


@dataclass
class Samples:
    """Programs by what became of them, such as LinuxCNC's samples, as file names.

    refused: we refuse what rs274 runs, with our first reason; unfit: rs274 itself refuses (tools,
    probes, subroutines called from elsewhere); moving: of those that it runs, with moves.
    """

    equal: list[str] = field(default_factory=list)
    different: dict[str, str] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    unfit: dict[str, str] = field(default_factory=dict)
    moving: set[str] = field(default_factory=set)

    @property
    def goal_met(self) -> bool:
        """Whether LEAST_EQUAL of the moving programs give equal moves here, and none differs."""
        return not self.different and len(self.moving & set(self.equal)) >= LEAST_EQUAL

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
    files = sorted((_usr() / SAMPLES).glob("*.ngc"))
    if not files:
        raise OracleError("LinuxCNC's samples are missing: run python -m sim.motion.gcode.oracle")
    return compare_files(files)


def compare_files(files: Sequence[Path]) -> Samples:
    """Both interpreters on these programs. Raises OracleError where LinuxCNC is missing."""
    found = Samples()
    for file in files:
        text = read_bytes(file, MAX_BYTES, "a G-code program").decode(errors="replace")
        try:
            theirs = rs274(text)
        except OracleError as error:
            found.unfit[file.name] = str(error)
            continue
        if any(record[0] in _MOVING for record in theirs):
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


@command("python -m sim.motion.gcode.oracle")
def main(argv: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    prog = "python -m sim.motion.gcode.oracle"
    purpose = "Fetch LinuxCNC's interpreter, or compare it with ours on programs."
    parser = script_parser(purpose, f"{prog} sim/paths/circle.ngc", prog)
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
            unequal = differences(read_text(file, MAX_BYTES, "a G-code program"))
            sys.stdout.write("".join(f"{file}: {text}\n" for text in unequal or ["equal"]))
            status = max(status, int(bool(unequal)))
    except (OracleError, GcodeErrors) as error:
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return 1
    return status


if __name__ == "__main__":
    sys.exit(main())
