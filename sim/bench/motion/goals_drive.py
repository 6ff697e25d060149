# SPDX-License-Identifier: Apache-2.0
"""Goals of the step axes of a path, of the drive study and of the robot with both kinds of drives.

The values are the figures of `microtick motion`, whose page shows them as plots.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from sim.bench.cnc import figures as drive_figures
from sim.bench.motion import show_path
from sim.motion.planner.figures import Result
from sim.report.goals import Goal, at_least, at_most, exactly
from sim.robot.parameters import Robot

FOLLOWING = {
    "no feed-forward": 2.5,
    "velocity": 0.1,
    "velocity and acceleration": 0.025,
    "velocity and acceleration, S-curve": 0.01,
}
"""Drive -> most following error [mm]."""
LOOP = "1st-order loop: "
PUBLISHED_LOAD_UM = 3.58
TARGETS = 5
"""Moves of one increment that the paper's drive made."""


def rows(full: bool) -> Iterator[Goal]:
    """Step axes on RTL, following errors, loads, and the robot on A-G-H (full: the whole path)."""
    with tempfile.TemporaryDirectory() as folder:
        yield from step_axes(_values(show_path.results(show_path.run())))
        yield from study(_values(drive_figures.figures(Path(folder))))
        found = drive_figures.robot_figures(Path(folder), full, lambda *done: None, Robot.load())
        yield from _robot(_values(found), "the whole path" if full else "part of the path")


def _values(results: list[Result]) -> dict[str, float]:
    return {result.name: float(result.ours) for result in results}


def step_axes(value: dict[str, float]) -> Iterator[Goal]:
    """From figures of show_path by name."""
    what = "G64 program on five step axes (RTL)"
    yield exactly(
        f"{what}: counts off at the end", value["five axes: final counts off"], 0, "steps"
    )
    off = value["five axes: steps off the plan"]
    yield at_most(f"{what}: off the plan", off, show_path.BOUND, "steps")


def study(value: dict[str, float]) -> Iterator[Goal]:
    """From figures of sim/bench/cnc by name."""
    for drive, most in FOLLOWING.items():
        error = round(value[LOOP + drive], 9)
        yield at_most(f"following error, 1st-order loop, {drive}", error, most, "mm")
    spikes = value[f"{LOOP}peak dI/dt, trapezoid over S-curve"]
    yield at_least("current spikes, trapezoid by S-curve", spikes, 5.0, "")
    load = value["load step 1.8 N m; 160 Hz read as i-p"]
    note = f"published: {PUBLISHED_LOAD_UM} um"
    yield at_most("load step of 1.8 N m", load, 2 * PUBLISHED_LOAD_UM, "um", note)
    for torque in (0.0, 1.8):
        met = value[f"+-1 of 144 000 counts under {torque} N m: targets met"]
        what = f"moves of 34.7 nm under {torque} N m that arrive, of {TARGETS}"
        yield exactly(what, met, TARGETS, "", "published: held")


def _robot(value: dict[str, float], part: str) -> Iterator[Goal]:
    for case in ("computed torque", "drives, velocity and acceleration"):
        error = next(v for name, v in value.items() if name.startswith(f"{case}: tool error"))
        yield at_most(f"robot on A-G-H, 2 m/min, {case}: tool error", error, 10.0, "um", part)
