# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the main job up to the simulation: mutated programs, robots and command lines."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random

from sim.bench.run import __main__ as main_job
from sim.robot.parameters import ROBOT_TOML
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import command_lines, mutated_text

PATHS = Path(__file__).parents[2] / "sim" / "paths"
SHORT = """G21 G90 G64 P0.01
G1 X4 A2 F1200
X8 Y3 C6
G3 X5 Y6 I-3 A0
G4 P0.1
G61
G1 X0 Y6 Z603 C-4
G61.1 X0 Y0 Z600 A-1 C0
G64 X3 Y-2 A0
M2
"""
LOOPS = """O1 REPEAT [5]
G91 G1 X1 F600
G64 P0.02 Q0.01
Y[#1+0.5]
O1 ENDREPEAT
G81 X1 Z-1 R1 L3
M2
"""
WORDS = "G0 G1 G2 G3 G4 G61 G61.1 G64 P0 P1e3 Q1 F0.01 F1e9 X X0.01 X100 X-100 Z600 A90".split()
WORDS += "C-720 I0 J1 R5 M2 M98 O1 %".split()
LINES = ("part.ngc", "part.ngc --ticks 100 --platforms fpga3", "part.ngc --robot robot.toml")
OPTIONS = (
    "--ticks --platforms --robot --output --all-ticks --no-plots --plan-only --help 0 -5 1 1e9 "
)
OPTIONS += "fpga1 fpga2,fpga3 fpga4 , part.ngc robot.toml folder empty zero pipe absent"
PROGRAMS = (
    SHORT,
    LOOPS,
    *(path.read_text(encoding="utf-8") for path in sorted(PATHS.glob("*.ngc"))),
)
ROBOT = ROBOT_TOML.read_text(encoding="utf-8")


def _planned(arguments: list[str]) -> int:
    """The job stops before anything is built; folders must not appear."""
    before = sorted(os.listdir())
    status = main_job.main([*arguments, "--plan-only"])
    assert sorted(os.listdir()) == before, "the job left files behind"
    return status


def program(rng: Random) -> int:
    """A mutated program."""
    text = mutated_text(rng, rng.choice(PROGRAMS), WORDS)
    Path("part.ngc").write_text(text, encoding="utf-8", errors="surrogatepass")
    return _planned(["part.ngc"])


def robot(rng: Random) -> int:
    """A mutated robot file."""
    Path("part.ngc").write_text(SHORT, encoding="utf-8")
    text = mutated_text(rng, ROBOT, ["value", "unit", "meaning", "[T_s]", "1e-4", '"m"', "0.0"])
    Path("robot.toml").write_text(text, encoding="utf-8", errors="surrogatepass")
    return _planned(["part.ngc", "--robot", "robot.toml"])


def files(rng: Random) -> None:
    """What a command line may name."""
    Path("part.ngc").write_text(SHORT, encoding="utf-8")
    Path("robot.toml").write_text(ROBOT, encoding="utf-8")


CAMPAIGNS = (
    Campaign("run-program", 5_000, program),
    Campaign("run-robot", 5_000, robot),
    command_lines("run-line", _planned, LINES, OPTIONS, files),
)
