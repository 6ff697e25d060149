# SPDX-License-Identifier: Apache-2.0
"""The two-processor system with its programs, as a controller of `sim.core.closed_loop`."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.assemble import assemble
from asip_asm.image import Image
from sim.bench.dual.moves import RECORD_WORDS, RING_RECORDS, Move
from sim.core.controller import ControllerFault, LawTicks
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, MEASURED_STATES, OUTPUTS, SET_POINTS, TRACKING
from sim.rtl.asip_bus import BLOCK, CLEAR, CSR, START, STATUS
from sim.rtl.dual_rtl import MEASURED_SOURCE, DualRtl

PROGRAMS = Path(__file__).resolve().parents[3] / "asip_asm/programs"
TRAJECTORY_PROGRAM = "path_set_points"
FEED_PERIODS = 100  # between two looks at the ring
RATES = tuple(SET_POINTS.index(signal.name) for signal in TRACKING.inputs if signal.rate)


@functools.cache
def program(name: str, configuration: str, robot: Robot) -> Image:
    """Image of a program of asip_asm/programs for a robot, assembled once; for reading alone."""
    values = robot.values()
    if name == TRAJECTORY_PROGRAM:
        values = {"T_s": values["T_s"]}
    return assemble(PROGRAMS / f"{name}.s", configuration=configuration, defines=values)


class TwoProcessors:
    """Both cores loaded, lists and buffer set up, moves fed to the ring.

    moves: the path. period_clocks: clocks of a period. tracking_program: one of
    asip_asm/programs, or the image of another with the same words in and out, in their order. The
    interface is that of `AsipController`, but set-points come from the first core, not from the
    caller. `set_points` gets what it made.
    system: one that exists, of the configurations named; by default a new one.
    """

    def __init__(
        self,
        robot: Robot,
        moves: Sequence[Move],
        period_clocks: int | None = None,
        tracking_program: str | Image = "tracking_optimised",
        trajectory: str = "fast",
        tracking: str = "fast",
        system: DualRtl | None = None,
    ) -> None:
        self.system = system or DualRtl(trajectory, tracking)
        self.images = {
            "trajectory": program(TRAJECTORY_PROGRAM, trajectory, robot),
            "tracking": tracking_program
            if isinstance(tracking_program, Image)
            else program(tracking_program, tracking, robot),
        }
        self._inputs = [entry.name for entry in self.images["tracking"].inputs]
        first, second = self.system.trajectory, self.system.tracking
        first.load(self.images["trajectory"])
        second.load(self.images["tracking"])
        inputs = second.input_addresses(self._inputs)
        sources = [*range(len(SET_POINTS)), *(MEASURED_SOURCE + i for i in range(len(COUNTS)))]
        self.system.set_lists(
            {
                "set_points": list(zip(first.output_addresses(SET_POINTS), range(15), strict=True)),
                "inputs": list(zip(sources, inputs, strict=True)),
                "commands": list(zip(second.output_addresses(OUTPUTS), range(5), strict=True)),
            }
        )
        self.system.write("ZERO_ON_HOLD", sum(1 << i for i in RATES))
        self.system.set("IRQ_ENABLE", stop=1, late=1)
        if period_clocks is not None:
            self.system.write("PERIOD", period_clocks)
        self._moves = moves
        self._written = 0
        self.set_points: list[NDArray[np.float32]] = []
        self.tick = 0
        self.feed()

    # ------------------------------------------------------------------ moves
    def feed(self) -> None:
        """Write as many records as the ring has room for, then their number; periods go on."""
        if self.system.queued:
            return
        core = self.system.trajectory
        begun = 1
        if self._written:
            begun = max(1, core.read(core.output_addresses(["begun"])[0]))
        # The record under way and those after it stay; all others may be overwritten.
        room = min(len(self._moves), begun - 1 + RING_RECORDS)
        if room == self._written:
            return
        writes = []
        for number in range(self._written, room):
            place = BLOCK["data"] + number % RING_RECORDS * RECORD_WORDS
            writes += list(enumerate(self._moves[number].words().tolist(), place))
        core.queue([*writes, (core.input_addresses(["moves"])[0], room)])
        self._written = room

    def append(self, moves: Sequence[Move]) -> None:
        """Further moves after the present ones."""
        self._moves = [*self._moves, *moves]
        self.feed()

    # ------------------------------------------------------------------ closed loop
    def prime(self, words: ArrayLike, counts: ArrayLike) -> np.void:
        """Make the first measurement the last one; let the first set-point be made.

        words: the first set-point, for the tracking core alone. It runs once for its memory of the
        measurement; then one period, whose record is returned, makes the set-point with which
        tracking begins.
        """
        core, image = self.system.tracking, self.images["tracking"]
        data = [
            *np.asarray(words, dtype=np.float32).view(np.uint32).tolist(),
            *np.asarray(counts, dtype=np.int32).tolist(),
        ]
        for address, word in zip(core.input_addresses(self._inputs), data, strict=True):
            core.write(address, word)
        core.write(CSR["CONTROL"], START | CLEAR)
        self.system.clock(image.watchdog)
        if not STATUS["done"].of(core.read(CSR["STATUS"])):
            raise ControllerFault("the tracking core did not finish its first run")
        measured = MEASURED_STATES | {f"{name}_before" for name in self._inputs}
        core.preset(
            {
                state.name: int(state.bits, 16)
                for state in image.states
                if state.name not in measured
            }
        )
        self.start()
        return self.periods(counts)[0]

    def start(self) -> None:
        """Let periods begin."""
        self.system.set("CONTROL", run=1)

    def periods(self, counts: ArrayLike) -> NDArray[np.void]:
        """Run one period per row of counts (n, 5) whatever happens; see `dual_rtl.PERIOD`."""
        records = self.system.run(np.atleast_2d(np.asarray(counts)))
        self.set_points += list(records["words"].view(np.float32))
        return records

    def step(self, words: ArrayLike, counts: ArrayLike) -> LawTicks:
        """One period with five counts; `words` are not used. Raises ControllerFault."""
        record = self.advance(counts)
        commands = record["commands"].view(np.float32)[np.newaxis]
        return LawTicks(commands, np.empty((1, 0), np.float32), record["used"][np.newaxis])

    def advance(self, counts: ArrayLike) -> np.void:
        """One period with five counts, its record. Raises ControllerFault if anything was late."""
        record = self.periods(counts)[0]
        words = record["stored"] == len(SET_POINTS)
        if (
            self.system.stop
            or record["late"]
            or record["updates"] != 1
            or record["torn"]
            or not words
        ):
            flags = ", ".join(name for name, on in self.system.flags().items() if on)
            raise ControllerFault(f"tick {self.tick}: no new command or set-point; flags: {flags}")
        self.tick += 1
        if self.tick % FEED_PERIODS == 0 and self._written < len(self._moves):
            self.feed()
        return record
