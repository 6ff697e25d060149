# SPDX-License-Identifier: Apache-2.0
"""A run of the main job made up without simulation: a path, and recordings with known errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sim.bench.run import page
from sim.core.closed_loop import Recording
from sim.core.controller import EXPORTED, LawTicks
from sim.motion.gcode.interpreter import parse_file
from sim.motion.geometry.moves import Motion
from sim.motion.trajectory.exact_stop import generate
from sim.motion.trajectory.program import set_points
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS
from sim.robot.tracking import joint_path

PEAK_TICK, PEAK_M = 7_000, 9e-6  # a single tick with a large error
RESULTS = {
    "platforms": {
        "fpga1": {"clock_mhz": 100, "cycles_min": 1, "cycles_max": 2, "time_us": 152.14},
        "fpga3": {
            "as_printed": {"clock_mhz": 125, "cycles_min": 204, "cycles_max": 204, "time_us": 1.6},
            "optimised": {"clock_mhz": 125, "cycles_min": 118, "cycles_max": 118, "time_us": 0.9},
        },
    },
    "simulation": {"cycles": 123456, "wall_s": 7.0},
}


def shown(gcode: Path, recorded: bool = True, most: int | None = None, **changes) -> page.Shown:
    """What the page of a run over `gcode` would show, with the peak above in leg 2 and the tool.

    most: only the first so many ticks, then without the peak if it comes later.
    """
    robot = Robot.load()
    trajectory = generate(parse_file(gcode))
    path = set_points(trajectory, most)
    desired = joint_path(robot, path)[0]
    rng = np.random.default_rng(1)
    n = len(path)
    joints = desired + rng.normal(0.0, 1e-7, (n, 5))
    tool = path.position + rng.normal(0.0, 1e-7, (n, 3))
    joints[PEAK_TICK : PEAK_TICK + 1, 1] -= PEAK_M
    tool[PEAK_TICK : PEAK_TICK + 1, 2] += PEAK_M
    outputs = rng.normal(100.0, 5.0, (n, len(OUTPUTS))).astype(np.float32)
    ticks = LawTicks(outputs, np.zeros((n, len(EXPORTED)), np.float32), np.full(n, 118, np.uint32))
    recording = Recording(np.zeros((n, 5), np.int32), joints, tool, ticks)
    feed = np.array([block.move.motion is not Motion.RAPID for block in trajectory.blocks])
    values = {
        "gcode": gcode,
        "robot": robot,
        "path": path,
        "desired": desired,
        "drawing": ((trajectory.block >= 0) & feed[trajectory.block])[:most],
        "recordings": {"optimised": recording, "as printed": recording} if recorded else {},
        "results": RESULTS,
        "tables": [],
    }
    return page.Shown(**(values | changes))
