# SPDX-License-Identifier: Apache-2.0
"""A tracking program on a core as a controller: one call per control tick or per batch.

The program's interface is asip_asm/programs/tracking.interface.toml: 15 set-points and five
encoder counts in, five forces and torques out, the desired joint motion exported. Words are
exchanged as raw binary32.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from sim.core.api import Core, CoreError, CoreFault
from sim.core.backends import Backend
from sim.core.fault import fault_text
from sim.robot.parameters import Robot
from sim.robot.records import (
    COUNTS,
    EXPORT_OF_ROW,
    MEASURED_STATES,
    OUTPUTS,
    SET_POINTS,
    STAMPS,
    Counts,
    Floats,
)
from sim.robot.tracking import Tracking
from sim.rtl.asip_bus import AsipError

# Rows of table 3 that the programs export, with the name there, and those that are set-points of
# the table, (18)-(20).
EXPORTED = {row: name for row, name in EXPORT_OF_ROW.items() if name not in SET_POINTS}
PASSED_ON = {row: name for row, name in EXPORT_OF_ROW.items() if name in SET_POINTS}


@dataclass(frozen=True)
class LawTicks:
    """Results of N ticks: outputs (N, 5) and exported rows (N, 9) as binary32, cycles (N,)."""

    outputs: NDArray[np.floating]
    exported: NDArray[np.float32]
    cycles: NDArray[np.uint32]


class ControllerFault(RuntimeError):
    """The core stopped in a fault; names the tick and the cause."""


class AsipController:
    """One core with one tracking program. Ticks are counted from 0 for messages.

    watched: states and exports that are read after every tick too, for `seen`. backend: as of
    `Core`. core: that backend.
    """

    def __init__(
        self,
        image: Image,
        intermediates: bool = True,
        watched: Sequence[str] = (),
        backend: str | Backend = "rtl",
    ) -> None:
        self.image = image
        self._program = Core(image, backend=backend)
        self.core = self._program.backend
        self._exports = tuple(EXPORTED.values()) if intermediates else ()
        self._read = len(OUTPUTS) + len(self._exports)
        self._reads = (*OUTPUTS, *self._exports, *watched)
        has = {entry.name for entry in image.inputs}
        measured = (*COUNTS, *(name for name in STAMPS if name in has))
        self.inputs = (*SET_POINTS, *measured)
        """Words that a tick takes, in their order."""
        self._data = np.zeros((1, len(self.inputs)), np.uint32)
        self._words = self._data[0, : len(SET_POINTS)].view(np.float32)
        self._counts = self._data[0, len(SET_POINTS) :].view(np.int32)

    @property
    def tick(self) -> int:
        """Ticks so far, the priming one not among them."""
        return self._program.ticks

    def prime(self, words: Floats, counts: Counts) -> None:
        """Make the first measurement the last one, so that the first tick sees no speed.

        Runs one tick, keeps what the program stored as its measurement, presets every other state.
        """
        self.step(words, counts)
        self.core.preset(
            {
                state.name: int(state.bits, 16)
                for state in self.image.states
                if state.name not in MEASURED_STATES
            }
        )
        self._program.ticks = 0

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick: 15 set-points (rounded to binary32 here) and five counts; then five stamps for
        a program that takes them."""
        self._words[:] = words
        self._counts[:] = counts
        try:
            runs = self._runs = self.core.run(self.inputs, self._data, self._reads)
        except AsipError as error:
            raise ControllerFault(f"tick {self.tick}: {error}") from error
        if runs.fault is not None:
            cause = runs.fault.cause
            raise ControllerFault(f"tick {self.tick}: the core stopped with fault {cause}")
        self._program.ticks += 1
        values = runs.words.view(np.float32)[:, : self._read]
        outputs, exported = values[:, : len(OUTPUTS)], values[:, len(OUTPUTS) :]
        return LawTicks(outputs, exported, _cycles(runs.cycles, 1))

    @property
    def seen(self) -> NDArray[np.float32]:
        """After a tick, faulted or not: outputs, exported rows, what is watched."""
        return self._runs.words.view(np.float32)[0]

    @property
    def cycles(self) -> int:
        """Clock cycles of the last tick, 0 without a clock."""
        return int(_cycles(self._runs.cycles, 1)[0])

    def fault_text(self) -> str:
        """Cause, place and source lines of the fault that the core is in."""
        assert self._runs.fault is not None
        return fault_text(self.image, self._runs.fault)

    def batch(self, words: NDArray[np.floating], counts: NDArray[np.integer]) -> LawTicks:
        """Consecutive ticks, words (N, 15) and counts (N, 5). Raises ControllerFault."""
        inputs = dict(zip(self.inputs, (*words.T, *counts.T), strict=True))
        try:
            ticks = self._program.batch(inputs, self._exports)
        except (AsipError, CoreError, CoreFault) as error:
            raise ControllerFault(str(error)) from error
        outputs = np.stack([ticks[name] for name in OUTPUTS], axis=1)
        exported = [ticks[name] for name in self._exports]
        cycles = _cycles(ticks.cycles, len(outputs))
        return LawTicks(outputs, np.array(exported, dtype=np.float32).T, cycles)


def _cycles(counted: NDArray[np.uint32] | None, ticks: int) -> NDArray[np.uint32]:
    """Clock cycles of ticks, 0 on a backend without a clock."""
    return np.zeros(ticks, np.uint32) if counted is None else counted


class LawController:
    """The computed-torque law in double precision, in the shape that the closed loop drives."""

    def __init__(self, robot: Robot, speed: str = "difference") -> None:
        """speed: one of `observer.SPEEDS`."""
        self._law = Tracking(robot, speed)

    def prime(self, words: Floats, counts: Counts) -> None:
        """Nothing: the law takes its first measurement as the last one."""

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick."""
        return one_tick(self._law.step(words, counts).output)


def one_tick(output: Iterable[float]) -> LawTicks:
    """Five forces and torques of a controller without a clock."""
    outputs = np.array([tuple(output)])
    return LawTicks(outputs, np.empty((1, 0), np.float32), np.zeros(1, dtype=np.uint32))
