# SPDX-License-Identifier: Apache-2.0
"""The two-processor system in closed loop with the plant, with repeats at another period.

A repeat is a fork of the process: plant, both cores, buffer and moves go on from the same bits,
once at each length of a period. So nothing has to be saved and restored.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from sim.bench.dual.system import TwoProcessors
from sim.bench.run.nios import merged
from sim.core.closed_loop import PROGRESS_TICKS, Recording
from sim.core.controller import ControllerFault, LawTicks
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.records import SetPoints
from sim.rtl.asip_rtl import AsipError
from sim.rtl.dual_rtl import PERIOD

TICK = np.dtype(
    [
        ("counts", np.int32, 5),
        ("joints", np.float64, 5),
        ("tool", np.float64, 3),
        ("set_point", np.float32, 15),
        ("period", PERIOD),
    ]
)
"""One tick: counts seen, exact joints and tool (SI units), set-point tracked, its period."""

SAME_BITS = ("counts", "joints", "tool", "set_point")
SAME_BITS_OF_PERIOD = ("commands", "words", "cycles", "stored", "updates", "late")


def stretches_of(
    changes: Sequence[int], ticks: int, ends: int = 500, around: int = 40
) -> list[range]:
    """Both ends of a path and the neighbourhood of each change of moves, merged, in order.

    changes: first ticks of moves. ends, around: ticks at an end, and on each side of a change.
    """
    wanted = [(0, ends), (ticks - ends, ticks)]
    wanted += [(int(tick) - around, int(tick) + around) for tick in changes]
    return merged(range(max(0, first), min(end, ticks)) for first, end in wanted)


class Loop:
    """Controller and plant, at rest at the first set-point; `ticks` (N,) of `TICK` fill as it goes.

    start: record of the period before the first tick, which makes the set-point to begin with.
    """

    def __init__(self, robot: Robot, path: SetPoints, controller: TwoProcessors) -> None:
        self.controller = controller
        self.ticks = np.zeros(len(path), dtype=TICK)
        self.done = 0
        self._plant = Plant(robot, tuple(path.position[0]), tuple(path.table_position[0]))
        self._seen = self._plant.counts()
        self.start = controller.prime(path.words()[0], self._seen)
        self._words = self.start["words"]

    def advance(self, end: int) -> None:
        """Go on to tick `end`. Raises ControllerFault; `done` ticks are good then."""
        for tick in range(self.done, end):
            row = self.ticks[tick]
            row["counts"] = self._seen
            row["joints"] = self._plant.joints
            row["tool"] = self._plant.tool
            row["set_point"] = self._words.view(np.float32)
            record = self.controller.advance(self._seen)
            row["period"] = record
            self._words = record["words"]
            self._seen = self._plant.step(record["commands"].view(np.float32).tolist())
            self.done = tick + 1

    def repeat(self, end: int, period_clocks: int) -> NDArray[np.void]:
        """What `advance` to tick `end` gives at another length of a period; changes nothing here.

        Raises ControllerFault with what happened in the repeat.
        """
        first = self.done
        read_end, write_end = os.pipe()
        child = os.fork()
        if child == 0:
            code = 2
            try:
                os.close(read_end)
                try:
                    self.controller.system.write("PERIOD", period_clocks)
                    self.advance(end)
                    answer, code = self.ticks[first:end].tobytes(), 0
                except (ControllerFault, AsipError) as error:
                    answer, code = str(error).encode(), 1
                with os.fdopen(write_end, "wb") as pipe:
                    pipe.write(answer)
            finally:
                os._exit(code)
        os.close(write_end)
        try:
            with os.fdopen(read_end, "rb") as pipe:
                answer = pipe.read()
        except BaseException:  # the repeat is of no use any more
            os.kill(child, signal.SIGKILL)
            raise
        finally:
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status:
            cause = answer.decode() if status == 1 else f"the process ended with status {status}"
            raise ControllerFault(
                f"ticks {first}..{end - 1} at {period_clocks} clocks a period: {cause}"
            )
        return np.frombuffer(answer, dtype=TICK)

    def recording(self) -> Recording:
        """The ticks done, as `sim.core.closed_loop` records them; cycles are clocks of all work."""
        done = self.ticks[: self.done]
        period = done["period"]
        outputs = np.ascontiguousarray(period["commands"]).view(np.float32)
        exported = np.empty((len(done), 0), np.float32)
        ticks = LawTicks(outputs, exported, period["used"].copy())
        return Recording(done["counts"], done["joints"], done["tool"], ticks)


def differing(ours: NDArray[np.void], other: NDArray[np.void]) -> NDArray[np.intp]:
    """Numbers of the ticks with any bit of another value: words, commands, plant, cycles of cores.

    Clocks of the sequencer may differ where the host writes moves: idle time is not the same.
    """
    pairs = [(ours[name], other[name]) for name in SAME_BITS]
    pairs += [(ours["period"][name], other["period"][name]) for name in SAME_BITS_OF_PERIOD]
    bad = np.zeros(len(ours), dtype=bool)
    for left, right in pairs:
        bits = (np.ascontiguousarray(side).view(np.uint8) for side in (left, right))
        same = np.equal(*(side.reshape(len(ours), -1) for side in bits))
        bad |= ~same.all(axis=1)
    return np.flatnonzero(bad)


def follow(
    loop: Loop,
    stretches: Sequence[range],
    period_clocks: int,
    progress: Callable[[str, int], None],
    save: Callable[[list[range]], None],
) -> None:
    """Run the whole path and repeat the stretches at `period_clocks`.

    progress gets 'path' or 'repeat' and the ticks done since the last call; save gets the stretches
    that were repeated, and may write a partial result. Raises ControllerFault, also for a repeat
    that differs by a bit.
    """
    repeated: list[range] = []
    pending = list(stretches)
    total = len(loop.ticks)
    while loop.done < total:
        other, stretch = None, pending[0] if pending else range(total, total)
        if pending and stretch.start == loop.done:
            pending.pop(0)
            end = stretch.stop
            other = loop.repeat(end, period_clocks)
            progress("repeat", len(stretch))
        else:
            end = stretch.start
        while loop.done < end:
            before = loop.done
            loop.advance(min(before + PROGRESS_TICKS, end))
            progress("path", loop.done - before)
            save(repeated)
        if other is not None:
            bad = differing(loop.ticks[stretch.start : end], other)
            if len(bad):
                raise ControllerFault(
                    f"tick {stretch.start + bad[0]}: other bits at {period_clocks} clocks a period"
                )
            repeated.append(stretch)
            save(repeated)
