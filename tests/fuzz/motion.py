# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the G-code reader and of the command lines around it."""

from __future__ import annotations

from pathlib import Path
from random import Random

from sim.motion.gcode import oracle
from sim.motion.gcode.interpreter import GcodeErrors, stream_file
from sim.motion.gcode.tools import Tool
from sim.motion.lookahead import __main__ as lookahead
from sim.motion.planner import __main__ as planner
from sim.motion.trajectory import __main__ as trajectory
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import command_lines, mutated_text

ROOT = Path(__file__).parents[2]
TOOLS = {1: Tool((0.0, 0.0, 5.0, 0.0, 0.0), 4.0), 2: Tool(diameter=1.0)}
MOST = 30_000  # moves of a program that are looked at: it may be endless where it moves
LOOPS = """\
o100 sub
o101 repeat [#1]
G91 G1 X1 Y[#2*2] F200
G90 G64 P.01 Q.02
o101 endrepeat
o100 endsub [5]
#<n> = 0
o102 while [#<n> LT 4]
#<n> = [#<n> + 1]
o103 if [#<n> EQ 2]
o104 do
o104 break
o104 while [0]
o103 elseif [#<n> GT 2]
o100 call [2] [SIN[30]]
o103 else
G4 P.1
o103 endif
o102 endwhile
M2
"""
PARTS = """\
%
G21 G90 G17 G54 G64 P.01
T1 M6 G43 H1
G0 X0 Y0 Z600
G41 D1 G1 X10 F400
X20 Y5
G3 X25 Y10 R5
G1 Z601
G40 G1 X30 Y20
G5 X40 Y0 I3 J3 P-3 Q-3
G5.1 X45 Y0 I1 J1
G5.2 P2 L3
X46 Y1 P1
X47 Y3 P.5
G5.3
G43.4
G1 X10 Y5 A5 C30 F300
G49 G0 X0 Y0 A0 C0
G98 G81 X1 Y1 Z590 R600 L3 F100
G83 X2 Q2
G80 M70
G91 G28 Z1
M72
G10 L2 P2 X1 Y2 G55
G92 X3
G92.1 G93 G1 X1 F5
G94 M5 M9
M30
%
"""
PATHS = sorted((ROOT / "sim" / "paths").glob("*.ngc"))
PROGRAMS = [LOOPS, PARTS, LOOPS + PARTS, *(path.read_text() for path in PATHS)]
TABLE = "T1 P1 D4 Z12.5 ; mill\nT2 D1\n"
WORDS = (
    *("G0 G1 G2 G3 G4 G5 G5.1 G5.2 G5.3 G40 G41 G42 G41.1 G43 G43.4 G49 G53 G61 G64 G81".split()),
    *("G90 G91 G92 G93 G17 G18 G19 G20 M0 M2 M6 M70 M72 M98 X1 Y-3 Z600 A9 C-400 I1 J2".split()),
    *("R5 P1 Q1e9 Q0.0000001 L10000000 F0.01 D1 H2 T1 @5 ^30 #1 #<n> [1] [1/0] %".split()),
    *("o1 while [1]", "o1 endwhile", "o2 sub", "o2 call", "o3 if [1]", "SIN[", "ATAN", "#1=", "\n"),
)


def gcode(rng: Random) -> int | None:
    """One mutated program through the reader."""
    text = mutated_text(rng, rng.choice(PROGRAMS), WORDS)
    data = text.encode("utf-8", errors="surrogatepass")
    if rng.random() < 0.02:
        data = data[: rng.randrange(len(data) + 1)] + rng.randbytes(200)
    Path("part.ngc").write_bytes(data)
    try:
        for _ in zip(range(MOST), stream_file(Path("part.ngc"), tools=TOOLS), strict=False):
            pass
    except GcodeErrors as errors:
        print(errors)
        return 1
    return 0


def files(rng: Random) -> None:
    """What a command line may name: programs, a table of tools."""
    Path("part.ngc").write_text(mutated_text(rng, PARTS, WORDS), errors="surrogatepass")
    Path("short.ngc").write_text("G64 P.1\nG1 X2 F2000\nY2\nM2\n")
    Path("tool.tbl").write_text(mutated_text(rng, TABLE, ["D", "Z1e9"]), errors="surrogatepass")


FILES = "part.ngc short.ngc tool.tbl empty folder zero pipe out.csv none.ngc"
MOTION_LINES = (
    "part.ngc --tools tool.tbl",
    "short.ngc --csv out.csv",
    "short.ngc --rapid 2 --acceleration-time 0.1 --jerk-time 0.02 --lead-in 0.1",
)
MOTION_OPTIONS = "--tools --csv --robot --rapid --acceleration-time --jerk-time --lead-in 1e9 1e-9"
LOOKAHEAD_LINES = (
    "short.ngc --time-only --tool 250 4800 1e6 --json out.json",
    "part.ngc --tools tool.tbl --time-only --steps",
    "short.ngc --leg 200 4000 1e6 --table 90 900 1e5 --rapid 100 --depth 16 --time-only",
)
LOOKAHEAD_OPTIONS = "--time-only --steps --tool --leg --table --rapid --depth --json 1 0 1e9"
PLANNER_LINES = (
    "--v0 15 --vm 200 --tr 0.4 --tm 0.1 --length 100",
    "--v0 0 --vm 600 --tr 0.6 --tm 0.15 --length 800 --json out.json",
    "--v0 0 --vm 600 --tr 0.6 --tm 0.15 --length 800 --optimal --ve 3 --acceleration 2e3",
)
PLANNER_OPTIONS = "--v0 --vm --tr --tm --length --optimal --ve --acceleration --jerk --json 0 1e-9"


CAMPAIGNS = (
    Campaign("gcode", 20_000, gcode),
    *(
        command_lines(name, main, lines, f"{options} {FILES}", files)
        for name, main, lines, options in (
            ("motion", trajectory.main, MOTION_LINES, MOTION_OPTIONS),
            ("lookahead", lookahead.main, LOOKAHEAD_LINES, LOOKAHEAD_OPTIONS),
            ("planner", planner.main, PLANNER_LINES, PLANNER_OPTIONS),
            ("oracle", oracle.main, ("part.ngc", "short.ngc"), "--help part.ngc"),
        )
    ),
)
