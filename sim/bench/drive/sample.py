# SPDX-License-Identifier: Apache-2.0
"""A piece of a path twice: every clock of the RTL chain, and with averaged inverters.

Both have the same start-up values, tracking program and plant, from the state that the alignment
leaves. Once the averaged inverters take the orders and the motion of the RTL: then the currents are
the same except for what the noise of the RTL does, which says when a current leaves the zone of the
dead time and whether a pulse is long enough to be made; `draws` says how much that is. And each
runs in closed loop of its own, the averaged inverters with the noise of the modulators: then the
largest errors are the same, which is what whole paths are run for. At every instant they are not:
near a reversal a machine sticks a part of a count aside by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.averaged import AveragedPlant
from sim.bench.drive.chain import ORDER_FILTER
from sim.bench.drive.path import Run
from sim.bench.drive.plant import AXES, Plant
from sim.bench.drive.recording import PATH, Recording, recordings, tracking_image
from sim.bench.drive.response import LAG, NOISE
from sim.bench.drive.whole import FrictionController, path_of, reversals
from sim.core import closed_loop
from sim.core.controller import AsipController
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.tracking import joint_path

SETTLED = 500  # ticks
SKIP = 20  # ticks in which the current loops find their integrals
BEFORE = 11  # half periods in a recording, before the first command acts


@dataclass(frozen=True)
class Sample:
    """Ticks of the path of reversals: error (N, 5) of the exact joints [m, rad] on RTL and
    averaged, of the RTL's tool (N,) [m]; ticks (N, 5) near a reversal; the RTL's recording;
    difference (ticks, 5) of the torque-making current [A], means of a tick, same orders and motion.
    """

    error: NDArray[np.float64]
    averaged_error: NDArray[np.float64]
    tool: NDArray[np.float64]
    near: NDArray[np.bool_]
    rtl: Recording
    current: NDArray[np.float64]

    @property
    def difference(self) -> NDArray[np.float64]:
        """Of the largest errors, RTL against averaged, after the first 50 ms (5,)."""
        averaged = np.abs(self.averaged_error)[SETTLED:].max(axis=0, initial=0.0)
        return np.abs(self.largest - averaged)

    @property
    def largest(self) -> NDArray[np.float64]:
        """Of the errors after the first 50 ms (5,)."""
        return np.abs(self.error)[SETTLED:].max(axis=0, initial=0.0)

    @property
    def at_reversals(self) -> NDArray[np.float64]:
        """Of the errors near a reversal (5,), 0 without one."""
        return np.where(self.near, np.abs(self.error), 0.0).max(axis=0)


def per_tick(halves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means (ticks, 5) of a tick's ten half periods (10 ticks, 5)."""
    return halves.reshape(-1, 10, AXES).mean(axis=1)


def same_currents(machine: AveragedPlant, rtl: Run | Recording) -> NDArray[np.float64]:
    """Difference (ticks, 5) of i_q [A], means of a tick after the first `SKIP`, where the averaged
    inverters take the orders and the motion of the RTL."""
    ticks = len(rtl.halves) // 10 - 2
    position = rtl.halves["position"]
    middle = (position[:-1] + position[1:]) / 2  # of a half of the carrier
    orders = np.repeat(rtl.commands[:ticks], 10, axis=0)
    found = machine.halves(orders, middle[BEFORE - 2 :][: len(orders) + 1])[:, 5:10]
    # Theirs are currents at the ends of halves, the RTL's are means around `LAG` after these.
    found[:-1] += LAG / Setting.period * np.diff(found, axis=0)
    same = rtl.halves["i_q"][BEFORE:][: len(found)]
    return per_tick(found - same)[SKIP:]


def sample(robot: Robot, drives: Drives, kind: str, rtl: Recording) -> Sample:
    """A recording of a law of `KINDS` next to averaged inverters. Raises ControllerFault."""
    path = path_of(robot, len(rtl.joints), PATH)
    desired = joint_path(robot, path)[0]
    setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    plant = Plant(robot, drives)
    machine = AveragedPlant(plant, setting, at, rtl.angles, rtl.zeros, NOISE)
    machine.put(*rtl.first)
    controller = (
        AsipController(tracking_image(robot, drives, kind), intermediates=False)
        if kind == "none"
        else FrictionController(robot, drives, kind)
    )
    averaged = closed_loop.run(robot, path, controller, lambda _: None, plant=machine)
    return Sample(
        desired - rtl.joints,
        desired - averaged.joints,
        np.linalg.norm(rtl.tool - path.position, axis=1),
        reversals(robot, path),
        rtl,
        same_currents(AveragedPlant(plant, setting, at, rtl.angles, rtl.zeros), rtl),
    )


def samples(
    robot: Robot, drives: Drives, ticks: int, kinds: Sequence[str], jobs: int = 2
) -> dict[str, Sample]:
    """A sample for each kind; recordings are cached. Raises ControllerFault, StartUpError."""
    found = recordings(robot, drives, ticks, kinds, jobs)
    return {kind: sample(robot, drives, kind, rtl) for kind, rtl in found.items()}
