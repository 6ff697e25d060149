# SPDX-License-Identifier: Apache-2.0
"""A piece of a path twice: every clock of the RTL chain, and with averaged inverters.

Both run the same start-up values, tracking program and plant, each in closed loop of its own. A
sample takes ten minutes for each second of the path, so what was simulated is kept (`BUILD/servo`),
named by a hash of the model and all that it ran on.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.project import BUILD
from sim.dual.moves import moves_of
from sim.dual.system import TRAJECTORY_PROGRAM, program
from sim.gcode.interpreter import parse_file
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.model.tracking import joint_path
from sim.run import closed_loop
from sim.run.controller import AsipController
from sim.run.nios import set_points
from sim.servo import friction_law
from sim.servo.averaged import AveragedPlant
from sim.servo.chain import CONFIGURATIONS, ORDER_FILTER, ChainRtl, current_program
from sim.servo.current_law import Setting
from sim.servo.path import Chain
from sim.servo.plant import Plant
from sim.servo.whole import FrictionController, reversals
from sim.trajectory.exact_stop import MotionSettings, generate

PATH = Path(__file__).resolve().parents[1] / "paths/reversals.ngc"
KINDS = ("none", "feed-forward")  # of `friction_law`
SETTLED = 500  # ticks
SOURCES = ("chain.py", "path.py", "sample.py", "start_up.py", "averaged.py", "averaged.cpp")
Progress = Callable[[int], None]


@dataclass(frozen=True)
class Sample:
    """Ticks of the path of reversals: error (N, 5) of the exact joints [m, rad] on RTL and
    averaged, of the RTL's tool (N,) [m]; ticks (N, 5) near a reversal; the RTL's half periods
    (`chain.HALF`); clocks simulated and processor time for them [s]; edges with both gates of a
    phase on."""

    error: NDArray[np.float64]
    averaged_error: NDArray[np.float64]
    tool: NDArray[np.float64]
    near: NDArray[np.bool_]
    halves: NDArray[np.void]
    clocks: NDArray[np.int64]
    seconds: NDArray[np.float64]
    shoot_through: NDArray[np.int64]

    @property
    def difference(self) -> NDArray[np.float64]:
        """Largest distance of the joints, RTL against averaged, behind the first 50 ms (5,)."""
        return np.abs(self.error - self.averaged_error)[SETTLED:].max(axis=0, initial=0.0)

    @property
    def largest(self) -> NDArray[np.float64]:
        """Of the errors behind the first 50 ms (5,)."""
        return np.abs(self.error)[SETTLED:].max(axis=0, initial=0.0)

    @property
    def at_reversals(self) -> NDArray[np.float64]:
        """Of the errors near a reversal (5,), 0 without one."""
        return np.where(self.near, np.abs(self.error), 0.0).max(axis=0)


def tracking_image(robot: Robot, drives: Drives, kind: str) -> Image:
    """The tracking core's program: the hand-written one without friction, or a friction law's."""
    if kind == "none":
        return program("tracking_optimised", CONFIGURATIONS["tracking"], robot)
    return friction_law.image(robot, drives, kind)


def sample(
    robot: Robot, drives: Drives, ticks: int, kind: str, progress: Progress = lambda n: None
) -> Sample:
    """The first ticks of the path of reversals with a law of `KINDS`. Raises ControllerFault,
    StartUpError."""
    settings = MotionSettings(robot)
    trajectory = generate(parse_file(PATH), settings)
    path = set_points(trajectory, ticks)
    desired = joint_path(robot, path)[0]
    plant, image = Plant(robot, drives), tracking_image(robot, drives, kind)
    chain = Chain(plant, path, moves_of(trajectory, settings), tracking_program=image)
    begin = time.process_time()
    chain.begin()
    before = chain.system.clocks
    run = chain.advance(ticks, progress)
    seconds = time.process_time() - begin
    machine = AveragedPlant(plant, chain.setting, chain.at, chain.angles, chain.zeros)
    controller = (
        AsipController(image, intermediates=False)
        if kind == "none"
        else FrictionController(robot, drives, kind)
    )
    other = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    return Sample(
        desired - run.joints,
        desired - other.joints,
        np.linalg.norm(run.tool - path.position, axis=1),
        reversals(robot, path),
        run.halves,
        np.array(chain.system.clocks - before),
        np.array(seconds),
        np.array(chain.system.look().shoot_through),
    )


def place_of(robot: Robot, drives: Drives, ticks: int, kind: str) -> Path:
    """File that keeps a sample; another for anything that changes it."""
    images = (
        tracking_image(robot, drives, kind),
        program(TRAJECTORY_PROGRAM, CONFIGURATIONS["trajectory"], robot),
        current_program(drives, Setting(robot.resolution, order_filter=ORDER_FILTER)).image,
    )
    digest = hashlib.sha256(ChainRtl().library.parent.name.encode())
    digest.update(repr((images, Plant(robot, drives).record().tolist(), ticks)).encode())
    for file in (PATH, *(Path(__file__).with_name(name) for name in SOURCES)):
        digest.update(file.read_bytes())
    return BUILD / "servo" / f"sample_{kind}_{digest.hexdigest()[:16]}.npz"


def _kept(robot: Robot, drives: Drives, ticks: int, kind: str) -> Path:
    """Simulates a sample into its file, with a line of progress for each 5 %."""
    place, begin, done = place_of(robot, drives, ticks, kind), time.monotonic(), 0

    def progress(more: int) -> None:
        nonlocal done
        done += more
        if done % max(1, ticks // 20) == 0:
            left = (time.monotonic() - begin) * (ticks / done - 1) / 60
            part = f"{done * robot.T_s:.2f} of {ticks * robot.T_s:g} s"
            print(f"  every clock, friction {kind}: {part}, {left:.0f} min left", flush=True)

    found = sample(robot, drives, ticks, kind, progress)
    draft = place.with_suffix(".new.npz")
    np.savez(draft, **{field.name: getattr(found, field.name) for field in fields(found)})
    draft.replace(place)
    return place


def samples(
    robot: Robot, drives: Drives, ticks: int, kinds: Sequence[str], jobs: int = 2
) -> dict[str, Sample]:
    """A sample for each kind, those that are not kept yet at the same time in `jobs` processes.
    Raises ControllerFault, StartUpError."""
    places = {kind: place_of(robot, drives, ticks, kind) for kind in kinds}
    missing = [kind for kind, place in places.items() if not place.exists()]
    with ProcessPoolExecutor(jobs) as pool:
        for work in [pool.submit(_kept, robot, drives, ticks, kind) for kind in missing]:
            work.result()
    found = {}
    for kind, place in places.items():
        with np.load(place) as kept:
            found[kind] = Sample(**{name: kept[name] for name in kept.files})
    return found
