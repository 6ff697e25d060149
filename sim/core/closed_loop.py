# SPDX-License-Identifier: Apache-2.0
"""A controller and the rigid-body plant in closed loop over a whole path, every tick of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.core.controller import AsipController, ControllerFault, LawTicks
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.records import Counts, Floats, SetPoints

PROGRESS_TICKS = 500  # ticks between two progress calls
SETTLED_S = 0.05  # tracking is checked from here on [s]


@dataclass(frozen=True)
class Recording:
    """Run of N ticks: counts (N, 5) seen, with stamps (N, 10), exact joints (N, 5) and tool (N, 3)
    at them, results."""

    counts: NDArray[np.int32]
    joints: NDArray[np.float64]
    tool: NDArray[np.float64]
    ticks: LawTicks


@dataclass(frozen=True)
class Tracking:
    """Largest tracking errors after the first 50 ms: legs and tool [m], table axes [rad]."""

    leg: float
    tool: float
    table: float


class Controller(Protocol):
    """Set-points (15,) and counts (5,) in, forces and torques (1, 5) out."""

    def prime(self, words: Floats, counts: Counts) -> object:
        """What there is to do before the first tick."""

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick. Raises ControllerFault."""


class Machine(Protocol):
    """Exact joints (5,) and tool (3,), what the encoders count, one period with outputs held."""

    @property
    def joints(self) -> Floats: ...

    @property
    def tool(self) -> Floats: ...

    @property
    def table(self) -> Floats: ...

    def counts(self) -> tuple[int, ...]: ...

    def step(self, outputs: Sequence[float]) -> tuple[int, ...]: ...


class Tap(Protocol):
    """Sees every tick and may change its set-points."""

    def words(self, words: NDArray[np.floating]) -> NDArray[np.floating]:
        """Set-points (15,) of the next tick."""

    def done(self, tick: int, counts: NDArray[np.int32], plant: Machine) -> None:
        """The controller has taken them with these counts, the plant has not moved yet."""

    def fault(self, tick: int, counts: NDArray[np.int32], plant: Machine) -> None:
        """The controller has stopped instead."""


def run(
    robot: Robot,
    path: SetPoints,
    controller: Controller,
    progress: Callable[[int], None],
    tap: Tap | None = None,
    plant: Machine | None = None,
) -> Recording:
    """Run every tick: counts from the plant, set-points from the path, forces back to the plant.

    plant: at rest at the first set-point, by default the rigid body with ideal drives. `progress`
    gets the ticks done since its last call.
    """
    n = len(path)
    words = path.words()
    drives = plant is not None
    if plant is None:
        plant = Plant(robot, tuple(path.position[0]), tuple(path.table_position[0]))
    joints, tool = np.empty((n, 5)), np.empty((n, 3))
    parts = []
    seen = plant.counts()
    counts = np.empty((n, len(seen)), dtype=np.int32)
    controller.prime(words[0], seen)
    for tick in range(n):
        counts[tick] = seen
        joints[tick] = plant.joints
        tool[tick] = plant.tool
        wanted = words[tick] if tap is None else tap.words(words[tick])
        try:
            result = controller.step(wanted, seen)
        except ControllerFault:
            if tap is not None:
                tap.fault(tick, counts[tick], plant)
            raise
        parts.append(result)
        if tap is not None:
            tap.done(tick, counts[tick], plant)
        try:
            seen = plant.step(result.outputs[0].tolist())
        except (ValueError, OverflowError) as error:  # no number any more
            raise ControllerFault(f"tick {tick}: {_cause(drives, error)}") from error
        if (tick + 1) % PROGRESS_TICKS == 0:
            progress(PROGRESS_TICKS)
    progress(n % PROGRESS_TICKS)
    return Recording(counts, joints, tool, concatenate(parts))


def _cause(drives: bool, error: Exception) -> str:
    """Why a plant has stopped; drives: it has motors of its own."""
    text = (
        f"the robot's motion has no bound any more ({error}); the loop is unstable with these "
        "parameters: lower f_legs or f_table"
    )
    if drives:
        text += (
            ". Or a current loop is, which `python -m sim.bench.drive --loops` reports: then check "
            "R, L_d, L_q and psi of the motors, and U_dc"
        )
    return text


def replay(
    path: SetPoints,
    counts: NDArray[np.int32],
    controller: AsipController,
    progress: Callable[[int], None],
) -> LawTicks:
    """Run a controller on recorded counts, open loop."""
    words = path.words()
    controller.prime(words[0], counts[0])
    parts = []
    for start in range(0, len(path), PROGRESS_TICKS):
        chunk = slice(start, start + PROGRESS_TICKS)
        parts.append(controller.batch(words[chunk], counts[chunk]))
        progress(len(parts[-1].cycles))
    return concatenate(parts)


def concatenate(parts: list[LawTicks]) -> LawTicks:
    """Consecutive ticks as one record."""
    return LawTicks(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0]))
    )


def tracking_error(
    robot: Robot, path: SetPoints, desired_joints: NDArray[np.float64], recording: Recording
) -> Tracking:
    """Largest deviation of the exact joints and tool from the desired ones, (N, 5) and path.

    A path that ends before the loop has settled is checked at its last tick.
    """
    settled = slice(min(round(SETTLED_S / robot.T_s), len(path) - 1), None)
    deviation = np.abs(recording.joints - desired_joints)[settled]
    tool = np.linalg.norm(recording.tool - path.position, axis=1)[settled]
    return Tracking(
        leg=float(deviation[:, :3].max()),
        tool=float(tool.max()),
        table=float(deviation[:, 3:].max()),
    )
