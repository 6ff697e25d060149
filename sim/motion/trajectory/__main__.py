# SPDX-License-Identifier: Apache-2.0
"""Command line: check a G-code file, show its blocks and figures, write its set-points as CSV."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
from rich.table import Table

from asip_asm.command import command, script_parser
from asip_asm.files import open_output, refuse_overwriting
from sim.motion.command import (
    add_override_option,
    add_robot_option,
    failed,
    interruptible,
    output,
    require_positive,
)
from sim.motion.gcode.interpreter import parse_file
from sim.motion.gcode.tools import add_tools_option, tools_of
from sim.motion.geometry.curves import RateLimits
from sim.motion.geometry.override import overridden_program
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.exact_stop import AXIS_NAMES, MotionSettings, Trajectory, generate
from sim.robot.parameters import Robot

MOST_SHOWN = 2_500_000  # set-points, so that this command stays below 1 GiB


def _arguments() -> argparse.ArgumentParser:
    defaults = {field.name: field.default for field in fields(MotionSettings)}
    prog = "python -m sim.motion.trajectory"
    purpose = "Check a G-code program and show the motion made of it."
    parser = script_parser(purpose, f"{prog} sim/paths/agh.ngc --csv build/agh.csv", prog)
    parser.add_argument("program", type=Path, help="G-code file")
    add_robot_option(parser, "trajectory")
    add_tools_option(parser)
    add_override_option(parser)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write every set-point, SI units")
    options = (
        ("--rapid", RateLimits.rapid * 60, "rapid rate of the tool [m/min]"),
        ("--acceleration-time", defaults["acceleration_time"], "S-curve time tr [s]"),
        ("--jerk-time", defaults["jerk_time"], "S-curve jerk time tm [s]"),
        ("--lead-in", defaults["lead_in"], "rest before the first block [s]"),
    )
    parser.add_argument(
        "--table",
        type=float,
        metavar="NUMBER",
        help="largest table rate [degree/s] (v_max_table of the robot)",
    )
    for name, default, text in options:
        parser.add_argument(
            name, type=float, default=default, metavar="NUMBER", help=f"{text} (%(default)g)"
        )
    return parser


def _block_table(trajectory: Trajectory) -> Table:
    table = Table(title="blocks")
    for name in ("line", "motion", "length", "speed", "ticks", "time [s]"):
        table.add_column(name, justify="left" if name == "motion" else "right", no_wrap=True)
    table.add_column("source", no_wrap=True, overflow="ellipsis")
    period = trajectory.t[1]
    ticks = np.diff(trajectory.first_ticks)
    for block, count in zip(trajectory.blocks, ticks, strict=True):
        length, speed = block.curve.length, block.speed
        tool = block.measures_tool_path
        table.add_row(
            str(block.move.line),
            block.move.motion.value,
            f"{length * 1e3:.3f} mm" if tool else f"{math.degrees(length):.3f} deg",
            f"{speed * 60:.3f} m/min" if tool else f"{math.degrees(speed):.2f} deg/s",
            str(count),
            f"{count * period:.4f}",
            block.move.source.split(";")[0].strip(),
        )
    return table


def _axis_table(trajectory: Trajectory) -> Table:
    table = Table(title="axes")
    for name in ("axis", "least", "greatest", "speed", "acceleration"):
        table.add_column(name, justify="left" if name == "axis" else "right", no_wrap=True)
    for axis, name in enumerate(AXIS_NAMES):
        unit, scale = ("mm", 1e3) if axis < 3 else ("deg", math.degrees(1.0))
        position = trajectory.position[:, axis] * scale
        speed = np.max(np.abs(trajectory.velocity[:, axis])) * scale
        acceleration = np.max(np.abs(trajectory.acceleration[:, axis])) * scale
        table.add_row(
            name,
            f"{position.min():.3f} {unit}",
            f"{position.max():.3f} {unit}",
            f"{speed:.3f} {unit}/s",
            f"{acceleration:.2f} {unit}/s2",
        )
    return table


def _write_csv(trajectory: Trajectory, path: Path) -> None:
    columns = ["t", *(p + axis for p in ("", "v_", "a_") for axis in AXIS_NAMES)]
    values = np.column_stack(
        [trajectory.t, trajectory.position, trajectory.velocity, trajectory.acceleration]
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with open_output(path) as file:
        np.savetxt(file, values, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")


@command("python -m sim.motion.trajectory")
def main(argv: list[str] | None = None) -> int:
    """Run the command; 0, or 1 after a mistake in the program or the options."""
    parser = _arguments()
    arguments = parser.parse_args(argv)
    try:
        require_positive("--rapid", arguments.rapid, "m/min")
        if arguments.csv is not None:
            inputs = (arguments.program, arguments.robot, arguments.tools)
            refuse_overwriting([arguments.csv], [path for path in inputs if path])
        robot = Robot.load(arguments.robot)
        table = robot.v_max_table
        if arguments.table is not None:
            require_positive("--table", arguments.table, "degree/s")
            table = math.radians(arguments.table)
        settings = MotionSettings(
            robot,
            acceleration_time=arguments.acceleration_time,
            jerk_time=arguments.jerk_time,
            rates=RateLimits(arguments.rapid / 60, table),
            lead_in=arguments.lead_in,
        )
        program = parse_file(arguments.program, tools=tools_of(arguments), robot=robot)
        highest = MachineLimits.of(robot).tool.speed
        program = overridden_program(program, arguments.override, highest)
        trajectory = generate(program, settings, MOST_SHOWN)
        if arguments.csv is not None:
            _write_csv(trajectory, arguments.csv)
    except ValueError as error:
        return failed(parser.prog, error)
    console = output()
    console.print(_block_table(trajectory))
    console.print(_axis_table(trajectory))
    console.print(f"{len(trajectory)} set-points, {trajectory.t[-1]:.4f} s")
    return 0


if __name__ == "__main__":
    sys.exit(interruptible(main))
