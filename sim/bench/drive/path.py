# SPDX-License-Identifier: Apache-2.0
"""The chain as RTL on a path: start-up, then every clock of it, in closed loop with the plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from sim.bench.drive import start_up
from sim.bench.drive.chain import CONFIGURATIONS, CONTROL_PERIOD, ORDER_FILTER, ChainRtl
from sim.bench.drive.hardware import check
from sim.bench.drive.plant import Plant
from sim.bench.drive.status import told
from sim.bench.dual.moves import Move
from sim.bench.dual.system import TwoProcessors
from sim.core.controller import ControllerFault
from sim.laws.drive.clocks import HALF_PERIOD
from sim.laws.drive.current_law import Setting
from sim.robot.records import SetPoints

BEGIN = 1210  # clock of a half in which periods are let begin: the next half's is their first


class ChainController(TwoProcessors):
    """`TwoProcessors` in `drive_chain`; control periods begin with a half of the carrier."""

    system: ChainRtl

    def start(self) -> None:
        place = (self.system.look().clock - 64) % HALF_PERIOD
        self.system.clock((BEGIN - place) % HALF_PERIOD)
        super().start()


@dataclass(frozen=True)
class Run:
    """N control periods: counts (N, 5), exact joints (N, 5) and tool (N, 3) in their first clock,
    commands (N, 5) [N, N m]; half periods of the carrier (see `chain.HALF`)."""

    counts: NDArray[np.int32]
    joints: NDArray[np.float64]
    tool: NDArray[np.float64]
    commands: NDArray[np.float32]
    halves: NDArray[np.void]


class Chain:
    """RTL and plant, brought up and at rest near the first set-point of a path, brakes closed.

    angles: electrical angles at count 0 [rad] from a table, by default what the alignment finds;
    zeros: what it finds as the currents' offsets; tracking_program: as `TwoProcessors` has it.
    Raises ParameterError for what the hardware does not follow, StartUpError.
    """

    def __init__(
        self,
        plant: Plant,
        path: SetPoints,
        moves: Sequence[Move],
        angles: Sequence[float] | None = None,
        tracking_program: str | Image = "tracking_optimised",
    ) -> None:
        self.plant, self.path = plant, path
        self.at = (*path.position[0].tolist(), *path.table_position[0].tolist())
        robot, drives = plant.robot, plant.drives
        check(robot, drives)
        self.setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
        self.system = ChainRtl()
        counts = self.system.place(plant, self.at)
        start_up.configure(self.system, drives, self.setting, counts)
        self.zeros = start_up.measure_offsets(self.system)
        start_up.guard(self.system, robot, drives, self.setting)
        if angles is None:
            self.angles = start_up.align(self.system, drives, self.setting)
        else:
            self.angles = np.array(angles, dtype=float)
            start_up.write_angles(self.system, self.angles)
        self.controller = ChainController(
            robot,
            moves,
            CONTROL_PERIOD,
            tracking_program,
            CONFIGURATIONS["trajectory"],
            CONFIGURATIONS["tracking"],
            self.system,
        )
        self.counts = counts
        self.primed = counts

    def begin(self) -> None:
        """Currents on, tracking on from where the machine is: `primed` counts."""
        start_up.enable(self.system)
        self.primed = start_up.positions(self.system) + self.counts
        self.controller.prime(self.path.words()[0], self.primed)

    def advance(self, ticks: int, progress: Callable[[int], None] = lambda ticks: None) -> Run:
        """So many control periods; brakes open with the first commands. Raises ControllerFault,
        also if an axis has tripped, and StartUpError."""
        rows = []
        self.system.trace()
        for _ in range(ticks):
            record = self.controller.advance(self.counts)
            if self.controller.tick == 1:
                start_up.release(self.system)
            joints, tool, _ = self.system.begun()
            rows.append(
                (record["measured"].view(np.int32).copy(), joints, tool, record["commands"])
            )
            progress(1)
        status = self.system.status()
        if status["trip"]:
            raise ControllerFault(f"tick {self.controller.tick}: {told(status)}")
        counts, joints, tools, commands = (np.array(column) for column in zip(*rows, strict=True))
        return Run(counts, joints, tools, commands.view(np.float32), self.system.halves())
