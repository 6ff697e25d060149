# SPDX-License-Identifier: Apache-2.0
"""A piece of the path of reversals on the RTL of the chain, every clock, with a law of friction.

It takes ten minutes for each second of the path, so what was simulated is cached (`BUILD/servo`),
named by a hash of the model and all that it ran on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.files import replaced
from asip_asm.image import Image
from asip_asm.project import BUILD
from sim.bench.drive import friction_law
from sim.bench.drive.chain import CONFIGURATIONS, ORDER_FILTER, ChainRtl, current_program
from sim.bench.drive.path import Chain
from sim.bench.drive.plant import Plant
from sim.bench.dual.moves import Move, moves_of
from sim.bench.dual.system import TRAJECTORY_PROGRAM, program
from sim.laws.drive.current_law import Setting
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import set_points
from sim.report.cache import fingerprint
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints
from sim.rtl.processes import processes

PATH = Path(__file__).resolve().parents[2] / "paths/reversals.ngc"
KINDS = ("none", "feed-forward")  # of `friction_law`
SOURCES = ("chain.py", "path.py", "recording.py", "start_up.py")
Progress = Callable[[int], None]


@dataclass(frozen=True)
class Recording:
    """N ticks: exact joints (N, 5) and tool (N, 3), commands (N, 5) [N, N m]; half periods
    (`chain.HALF`); clocks simulated and processor time for them [s]; edges after which both
    gates or switches of a phase are on. What the start-up found:
    electrical angles (5,) [rad], currents' offsets (5, 2) [counts]; state before the first tick
    (3, 5): place, rates, bristles (`chain.Look`)."""

    joints: NDArray[np.float64]
    tool: NDArray[np.float64]
    commands: NDArray[np.float32]
    halves: NDArray[np.void]
    clocks: NDArray[np.int64]
    seconds: NDArray[np.float64]
    shoot_through: NDArray[np.int64]
    angles: NDArray[np.float64]
    zeros: NDArray[np.float64]
    first: NDArray[np.float64]


def tracking_image(robot: Robot, drives: Drives, kind: str) -> Image:
    """The tracking core's program: the hand-written one without friction, or a friction law's."""
    if kind == "none":
        return program("tracking_optimised", CONFIGURATIONS["tracking"], robot)
    return friction_law.image(robot, drives, kind)


def record(
    robot: Robot, drives: Drives, ticks: int, kind: str, progress: Progress = lambda n: None
) -> Recording:
    """The first ticks with a law of `KINDS`. Raises ControllerFault, StartUpError."""
    path, moves = path_and_moves(robot, ticks)
    image = tracking_image(robot, drives, kind)
    chain = Chain(Plant(robot, drives), path, moves, tracking_program=image)
    begin = time.process_time()
    chain.begin()
    before, first = chain.system.clocks, chain.system.look()
    run = chain.advance(ticks, progress)
    return Recording(
        run.joints,
        run.tool,
        run.commands,
        run.halves,
        np.array(chain.system.clocks - before),
        np.array(time.process_time() - begin),
        np.array(chain.system.look().shoot_through),
        chain.angles,
        chain.zeros,
        np.stack([first.place, first.rates, first.bristles]),
    )


def path_and_moves(robot: Robot, ticks: int) -> tuple[SetPoints, tuple[Move, ...]]:
    """First ticks of the path of reversals, and its moves."""
    settings = MotionSettings(robot)
    trajectory = generate(parse_file(PATH, robot=robot), settings)
    return set_points(trajectory, ticks), moves_of(trajectory, settings)


def place_of(robot: Robot, drives: Drives, ticks: int, kind: str) -> Path:
    """File that keeps a recording; another for anything that changes it."""
    images = (
        tracking_image(robot, drives, kind),
        program(TRAJECTORY_PROGRAM, CONFIGURATIONS["trajectory"], robot),
        current_program(drives, Setting(robot.resolution, order_filter=ORDER_FILTER)).image,
    )
    path, moves = path_and_moves(robot, ticks)
    record = Plant(robot, drives).record().tolist()
    files = [Path(__file__).with_name(name) for name in SOURCES]
    system, words = ChainRtl().library.parent.name, path.words().tolist()
    of = fingerprint(files, system, images, record, moves, words)
    return BUILD / "servo" / f"recording_{kind}_{of}.npz"


def _keep(place: Path, robot: Robot, drives: Drives, ticks: int, kind: str) -> None:
    """Simulates into a file, with a line of progress for each 5 %."""
    begin, done = time.monotonic(), 0

    def progress(more: int) -> None:
        nonlocal done
        done += more
        if done % max(1, ticks // 20) == 0:
            left = (time.monotonic() - begin) * (ticks / done - 1) / 60
            part = f"{done * robot.T_s:.2f} of {ticks * robot.T_s:g} s"
            print(f"  every clock, friction {kind}: {part}, {left:.0f} min left", flush=True)

    found = record(robot, drives, ticks, kind, progress)
    with replaced(place) as draft:
        np.savez(draft, **{field.name: getattr(found, field.name) for field in fields(found)})


def recordings(
    robot: Robot, drives: Drives, ticks: int, kinds: Sequence[str], jobs: int
) -> dict[str, Recording]:
    """One for each kind, those that are not cached yet at the same time in `jobs` processes. Raises
    ControllerFault, StartUpError."""
    places = {kind: place_of(robot, drives, ticks, kind) for kind in kinds}
    missing = {kind: place for kind, place in places.items() if not place.exists()}
    with processes(jobs) as pool:
        for work in [
            pool.submit(_keep, place, robot, drives, ticks, kind) for kind, place in missing.items()
        ]:
            work.result()
    found = {}
    for kind, place in places.items():
        with np.load(place) as kept:
            found[kind] = Recording(**{name: kept[name] for name in kept.files})
    return found
