# SPDX-License-Identifier: Apache-2.0
"""A G64 program on the motion front-end as RTL: look-ahead, phase records, step lines.

The program moves tool and table through lines, arcs and corners rounded within P. Its set-points
become phase records of the three legs and both table axes (step_stream.py), the records go through
the rings of the front-end while it runs, and the edges of its drive lines are compared with the
planned joints at every edge.
"""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from sim.bench.motion.step_stream import AXES, PathEncoder, Steps, joints
from sim.motion.gcode.interpreter import stream
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.moves import Move
from sim.motion.lookahead.check import Deviation
from sim.motion.lookahead.planner import Lookahead, Setpoints
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.planner.figures import Result
from sim.report import pictures
from sim.robot.kinematics import forward
from sim.robot.parameters import Robot
from sim.rtl.motion_rtl import CLOCK_HZ, COUNTED, RECORDS, MotionError, MotionRtl
from sim.rtl.phase_record import Record

PROGRAM = """G21 G90 G64 P0.01
G1 X4 A2 F12000
X8 Y3 C6
G3 X5 Y6 I-3 A0
G1 X0 Y6 Z603 C-4
X0 Y0 Z600 A-1 C0
X3 Y-2 A0
M2
"""
FILE = "g64_rtl.svg"
TICK_CLOCKS = CLOCK_HZ // 1_000_000
# A record waits for the first tick after its release and is taken in it; its first rate counts
# from the tick after that.
START_TICKS = 1
BOUND = 1.0  # steps: half a step of rounding, and half a step at a change of direction
TIMING = 40  # clocks of a step line high, low; of the direction before, after a step
CHUNK = 20_000  # clocks between two looks at the rings


@dataclass(frozen=True)
class PathRun:
    """What was planned and what the drive lines did.

    points: set-points; wanted: steps (5,) of the whole path; counted: POSITION of each axis; edges:
    per axis the seconds of its steps since the start and its count after each; deviation (5,):
    greatest difference [steps] between count and planned joint, before and after every step and
    at every set-point; records and reversals per axis.
    """

    moves: list[Move]
    points: Setpoints
    robot: Robot
    period: float
    steps: Steps
    wanted: list[int]
    counted: list[int]
    edges: list[tuple[FloatArray, NDArray[np.int64]]]
    deviation: FloatArray
    records: list[int]
    reversals: list[int]

    def commanded(self) -> Setpoints:
        """The poses that the counted steps represent at the set-points: forward kinematics."""
        times = np.arange(len(self.points), dtype=float) * self.period
        start = joints(self.robot, self.points, self.steps)[0][0]
        places = start + np.stack([_counts(*edge, times) for edge in self.edges], axis=1)
        q = places / self.steps.scale
        pose = np.hstack([forward(self.robot, q[:, :3]), q[:, 3:]])
        return dataclasses.replace(self.points, position=pose)

    def tool_error(self) -> float:
        """Greatest distance [m] of the commanded tool from the planned one at the set-points."""
        off = self.commanded().position[:, :3] - self.points.position[:, :3]
        return float(np.linalg.norm(off, axis=1).max())

    def beyond_p(self) -> float:
        """How far [m] the commanded path leaves the programmed one beyond P; see Deviation."""
        away = Deviation(self.moves)
        for _ in away.watched([self.commanded()]):
            pass
        return away.path


def _counts(at: FloatArray, count: NDArray[np.int64], times: FloatArray) -> NDArray[np.int64]:
    """Count of an axis at times [s]."""
    return np.concatenate([[0], count])[np.searchsorted(at, times, side="right")]


def _feed(
    motion: MotionRtl, records: list[list[Record]], progress: Callable[[int], None]
) -> tuple[int, int]:
    """Streams records through the rings; returns the clocks of the start and of the end."""
    waiting = [deque(axis) for axis in records]
    heads = [0] * len(waiting)
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    begin = 0
    while True:
        tails = motion.tails()
        parts: dict[int, list[Record]] = {}
        for axis, queue in enumerate(waiting):
            room = RECORDS - (heads[axis] - tails[axis]) % COUNTED
            part = [queue.popleft() for _ in range(min(room, len(queue)))]
            if part:
                parts[axis] = part
                heads[axis] += len(part)
        if parts:
            motion.put(parts)
            begin = begin or motion.now
        if not any(waiting):
            break
        motion.clock(CHUNK)
        progress(CHUNK)
        if motion.status("underrun"):
            raise MotionError("records ran out inside the path: underrun")
    ticks = sum(record.count for record in records[0])
    progress(motion.wait_for_irq((ticks + 1000) * TICK_CLOCKS))
    tick = -(-begin // TICK_CLOCKS) + START_TICKS
    return tick * TICK_CLOCKS, motion.now


def run(
    text: str = PROGRAM,
    steps: Steps | None = None,
    robot: Robot | None = None,
    progress: Callable[[int], None] = lambda clocks: None,
) -> PathRun:
    """Plan and run a program. progress gets clocks. Raises MotionError for underrun and overrun."""
    robot, steps = robot or Robot.load(), steps or Steps()
    settings = LookaheadSettings(robot=robot)
    moves = [item for item in stream(text.splitlines(), robot=robot) if isinstance(item, Move)]
    blocks = list(Lookahead(iter(moves), settings).setpoints())
    names = [field.name for field in dataclasses.fields(Setpoints) if field.name != "first"]
    whole = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in names}
    points = Setpoints(0, **whole)
    encoder = PathEncoder(robot, settings.period, steps)
    records: list[list[Record]] = [[] for _ in AXES]
    for parts in encoder.run([points]):
        for axis, part in zip(records, parts, strict=True):
            axis += part
    motion = MotionRtl()
    motion.set("STEP_TIMING", length=TIMING, space=TIMING)
    motion.set("DIRECTION_TIMING", setup=TIMING, hold=TIMING)
    begin, _ = _feed(motion, records, progress)
    if motion.status("underrun") or motion.status("overrun"):
        raise MotionError("the front-end reports an underrun or overrun")
    place, speed = joints(robot, points, steps)
    counted = [motion.position(axis) for axis in range(len(AXES))]
    lines = motion.edges()
    level = lines.direction
    found, deviations = [], []
    times = np.arange(len(points), dtype=float) * settings.period
    for n in range(len(AXES)):
        rises = lines.pulses(n)
        negative = level[np.searchsorted(lines.clock, rises)] >> n & 1
        at = (rises - begin) / CLOCK_HZ
        count = np.cumsum(1 - 2 * negative.astype(np.int64))
        found.append((at, count))
        plan = CubicHermiteSpline(times, place[:, n] - place[0, n], speed[:, n])
        planned = plan(np.clip(at, 0.0, times[-1]))
        behind = np.abs(count - planned)
        before = np.abs(np.concatenate([[0], count[:-1]]) - planned)
        held = np.abs(_counts(at, count, times) - plan(times))
        deviations.append(max(x.max(initial=0.0) for x in (behind, before, held)))
    return PathRun(
        moves,
        points,
        robot,
        settings.period,
        steps,
        [round(float(x)) for x in place[-1] - place[0]],
        counted,
        found,
        np.array(deviations),
        [len(axis) for axis in records],
        [int((np.diff(np.sign(np.diff(count))) != 0).sum()) for _, count in found],
    )


def results(run: PathRun) -> list[Result]:
    """Counts, deviations and records of the program as figures."""

    def row(name: str, unit: str, goal: str, ours: float, agrees: bool = True) -> Result:
        return Result("G64 RTL", name, unit, goal, "goal" if goal else "", ours, agrees, FILE)

    off = max(abs(a - b) for a, b in zip(run.wanted, run.counted, strict=True))
    worst = float(run.deviation.max())
    seconds = (len(run.points) - 1) * run.period
    return [
        row("five axes: final counts off", "steps", "0", float(off), off == 0),
        row("five axes: steps off the plan", "steps", f"<= {BOUND:g}", worst, worst <= BOUND),
        row("five axes: steps sent", "", "", float(sum(len(at) for at, _ in run.edges))),
        row("five axes: changes of direction", "", "", float(sum(run.reversals))),
        row("five axes: tool off its planned place", "um", "", run.tool_error() * 1e6),
        row("five axes: records a second", "", "", max(run.records) / seconds),
    ]


def draw(run: PathRun, output: Path) -> None:
    """The tool's way, a corner of it in single steps, and the joints' deviations in steps."""
    plt = pictures.pyplot("g64")
    figure = plt.figure(figsize=(9, 8))
    grid = figure.add_gridspec(2, 2, height_ratios=(1.2, 1))
    way, corner = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    off = figure.add_subplot(grid[1, :])
    planned = run.points.position[:, :3] * 1e3
    commanded = run.commanded().position[:, :3] * 1e3
    ends = np.array([run.moves[0].start[:3], *(move.end[:3] for move in run.moves)])
    way.plot(planned[:, 0], planned[:, 1], lw=0.9)
    way.plot(ends[:, 0], ends[:, 1], "k.", ms=3)
    way.set(xlabel="X [mm]", ylabel="Y [mm]", title="tool, planned", aspect="equal")
    place = ends[1]
    near = np.linalg.norm(planned - place, axis=1).argmin() + np.arange(-40, 41)
    x, y = ((path[near] - place) * 1e3 for path in (planned, commanded))
    corner.plot(x[:, 0], x[:, 1], lw=0.9, label="planned")
    corner.plot(y[:, 0], y[:, 1], ".", ms=4, label="from the counted steps")
    corner.plot(0, 0, "kx", label="corner")
    title = f"first corner, every {run.period * 1e6:g} µs"
    corner.set(xlabel="X [µm]", ylabel="Y [µm]", title=title, aspect="equal")
    corner.legend(fontsize=8)
    times = np.arange(len(run.points), dtype=float) * run.period
    joint = joints(run.robot, run.points, run.steps)[0]
    for axis, name in enumerate(AXES):
        miss = _counts(*run.edges[axis], times) - (joint[:, axis] - joint[0, axis])
        off.hist(miss, bins=np.linspace(-1, 1, 81), histtype="step", label=name)
    off.set(xlabel="counted steps less planned joint", ylabel="set-points", yscale="log")
    off.legend(ncol=5, fontsize=8, loc="upper center")
    for axes in (way, corner, off):
        axes.grid(alpha=0.3)
    pictures.save(figure, output / FILE)
