# SPDX-License-Identifier: Apache-2.0
"""Clock and reset, and when drivers and monitors look at pins.

Drivers change inputs at the falling edge of the clock. What combinational logic makes of them is
sampled a quarter of a period later, before the rising edge, in every simulator.
"""

from __future__ import annotations

import random

from cocotb.clock import Clock
from cocotb.handle import LogicArrayObject, LogicObject
from cocotb.triggers import FallingEdge, Timer

Pin = LogicObject
Bus = LogicArrayObject
RESET_CYCLES = 4


class Clocked:
    """A module with one clock. period: in picoseconds, a multiple of four; reset_level: the level
    of the reset pin that resets. `random` is seeded with `seed`.
    """

    def __init__(
        self,
        dut: object,
        clock: LogicObject,
        reset: LogicObject,
        reset_level: int,
        period: int = 8000,
        seed: int = 1,
    ) -> None:
        if period % 4 or period <= 0:
            raise ValueError(f"a period of {period} ps; take a multiple of 4 ps")
        self.dut, self.period, self.random = dut, period, random.Random(seed)
        self._clock, self._reset, self._level, self._started = clock, reset, reset_level, False

    async def reset(self) -> None:
        """Hold reset for some cycles; the first time, start the clock before."""
        self.idle()
        self._reset.value = self._level
        if not self._started:
            self._started = True
            Clock(self._clock, self.period, unit="ps").start()
        for _ in range(RESET_CYCLES):
            await self.next()
        self._reset.value = 1 - self._level
        await self.next()

    def idle(self) -> None:
        """Give every input a value that asks for nothing."""
        raise NotImplementedError

    async def next(self) -> None:
        """Until inputs may change again."""
        await FallingEdge(self._clock)

    async def settle(self) -> None:
        """Until outputs follow the inputs of this cycle, before the rising edge."""
        await Timer(self.period // 4, unit="ps")

    async def cycles(self, count: int) -> None:
        """Wait for so many clocks."""
        for _ in range(count):
            await self.next()


def word(handle: Pin | Bus) -> int:
    """Value of pins. Raises AssertionError if one of them is X or Z."""
    value = handle.value
    assert value.is_resolvable, f"{handle._path} is {value}"
    return int(value)
