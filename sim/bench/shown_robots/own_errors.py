# SPDX-License-Identifier: Apache-2.0
"""Errors of the own robot's laws in Python next to those of the assembly programs, as in table 3 of
the main job: a program in closed loop with the rigid body along the path A-G-H, its outputs against
double precision on the counts that it saw.
"""

from __future__ import annotations

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.model.compiler import Compiled
from asip_asm.project import ROOT
from sim.bench.run.checks import TARGET_PATH
from sim.bench.run.job import PROGRAMS
from sim.bench.run.results import compare
from sim.core.closed_loop import run
from sim.core.controller import AsipController
from sim.laws.native.controller import NativeController
from sim.motion.gcode.interpreter import parse
from sim.motion.trajectory.program import plan, set_points
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS, SetPoints

PATH = ROOT / "sim/paths" / TARGET_PATH
ASSEMBLY = {"own_printed": "tracking_as_printed", "own_optimised": "tracking_optimised"}
"""The assembly program with the equations of each law."""


def compare_with_assembly(
    name: str, compiled: Compiled, ticks: int | None = None
) -> dict[str, tuple[float, float]]:
    """Output -> largest error of the law `name` (a key of ASSEMBLY) and of its assembly program, N
    and N m, over the first `ticks` of the path or all. Raises ControllerFault, CompilerError.
    """
    robot = Robot.load()
    program = parse(PATH.read_text(encoding="utf-8"), PATH.name, robot=robot)
    path = set_points(plan(program, robot, ticks))
    source = PROGRAMS / f"{ASSEMBLY[name]}.s"
    image = assemble(source, configuration="fast", defines=robot.values())
    got = output_errors(robot, path, NativeController(compiled))
    want = output_errors(robot, path, AsipController(image))
    return {output: (got[output], want[output]) for output in OUTPUTS}


def output_errors(
    robot: Robot, path: SetPoints, controller: NativeController | AsipController
) -> dict[str, float]:
    """Largest distance of each output from double precision on unrounded set-points and on the
    counts that the controller saw, with the digits of table 3.
    """
    recording = run(robot, path, controller, lambda ticks: None)
    reference = compare(robot, path, recording.counts).reference.output
    worst = np.abs(recording.ticks.outputs.astype(np.float64) - reference).max(axis=0)
    return {name: as_printed(error) for name, error in zip(OUTPUTS, worst.tolist(), strict=True)}


def as_printed(error: float) -> float:
    """Digits of table 3: after them a run differs from the next, since the rounding of the
    set-points, the same for all programs, is nearly all of the optimised programs' errors.
    """
    return float(f"{error:.2e}")
