# SPDX-License-Identifier: Apache-2.0
"""Driver and monitor of one arithmetic unit of rtl/fpu: `fp_add`, `fp_mul`, `fp_sincos`, ..."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.cocotb.clocked import Bus, Clocked, Pin, word

ANSWER_LIMIT = 100  # clocks after the last operation


class UnitPins(Protocol):
    """Pins that all arithmetic units have."""

    clk_i: Pin
    rst_ni: Pin
    valid_i: Pin
    valid_o: Pin
    result_o: Bus
    flags_o: Bus


class Unit(Clocked):
    """A unit with valid_i, operands a_i .. c_i and controls such as sub_i; with ready_o or without.

    latency: register ranks, as in fp_pkg; every result is checked to come after exactly so many.
    `bubbles` is the probability of a clock without an operation; the pins are then random.
    `interval` is the least number of clocks from one operation to the next.
    """

    dut: UnitPins

    def __init__(
        self,
        dut: UnitPins,
        latency: int,
        period: int = 8000,
        seed: int = 1,
        bubbles: float = 0.0,
        interval: int = 1,
    ) -> None:
        super().__init__(dut, dut.clk_i, dut.rst_ni, 0, period, seed)
        self.latency, self.bubbles, self.interval = latency, bubbles, interval
        names = ["a", "b", "c", "sub", "sqrt", "cos", "kind", "neg_product", "neg_addend", "op"]
        names += ["unsigned", "truncate"]
        self.pins = {name: getattr(dut, f"{name}_i") for name in names if hasattr(dut, f"{name}_i")}

    def idle(self) -> None:
        self.dut.valid_i.value = 0
        for pin in self.pins.values():
            pin.value = self.random.getrandbits(len(pin))

    async def stream(self, **columns: ArrayLike) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
        """Result bits and flags of operations given one after the other, as fast as the unit takes.

        columns: values of each pin by its name without `_i`, arrays or one number for all. Raises
        ValueError for a pin that is left out or that the unit does not have.
        """
        if columns.keys() != self.pins.keys():
            raise ValueError(f"pins are {', '.join(self.pins)}; given were {', '.join(columns)}")
        rows = np.broadcast_arrays(*(np.atleast_1d(columns[n]) for n in self.pins))
        todo = deque(zip(*(row.tolist() for row in rows), strict=True))
        count = len(todo)
        issued: deque[int] = deque()
        results: list[tuple[int, int]] = []
        clock = last = 0
        earliest = 0  # clock of the next operation
        while len(results) < count:
            given = bool(todo) and self.random.random() >= self.bubbles and clock >= earliest
            self.idle()
            if given:
                self.dut.valid_i.value = 1
                self._drive(todo[0])
            await self.settle()
            if word(self.dut.valid_o):
                assert issued and clock - issued[0] == self.latency, (
                    f"a result in clock {clock}; operations in flight since {list(issued)}"
                )
                issued.popleft()
                results.append((word(self.dut.result_o), word(self.dut.flags_o)))
            if given and self._ready():
                todo.popleft()
                issued.append(clock)
                last, earliest = clock, clock + self.interval
            assert clock - last < ANSWER_LIMIT + self.latency, f"{len(issued)} results are missing"
            await self.next()
            clock += 1
        self.idle()
        bits, raised = zip(*results, strict=True)
        return np.array(bits, np.uint32), np.array(raised, np.uint8)

    def _ready(self) -> bool:
        return not hasattr(self.dut, "ready_o") or bool(word(self.dut.ready_o))

    def _drive(self, values: Sequence[int]) -> None:
        for pin, value in zip(self.pins.values(), values, strict=True):
            pin.value = value
