# SPDX-License-Identifier: Apache-2.0
"""Driver of `ci_slaves`: custom instructions given as a Nios II gives them, with stalls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from sim.cocotb.clocked import Bus, Clocked, Pin, word
from sim.core.backends import unknown
from sim.rtl.custom_table import Instruction, load

DONE_LIMIT = 200  # enabled clocks; the longest instruction takes 38


@dataclass(frozen=True)
class Result:
    """Bits of a result, and the enabled clocks that it took, the start included."""

    bits: int
    cycles: int


class SlavePins(Protocol):
    """Pins of `ci_slaves` that the driver looks at."""

    multi_clk_i: Pin
    multi_reset_i: Pin
    multi_start_i: Pin
    multi_clk_en_i: Pin
    multi_done_o: Pin
    combo_result_o: Bus
    multi_result_o: Bus


class CustomInstructions(Clocked):
    """Both masters of the CPU at `ci_slaves`. platform: its parameter, 1 or 2.

    `stalls` is the probability that clk_en is low in a clock of a multicycle instruction, `gaps`
    that a further idle clock follows one. The operand pins are random while nothing runs.
    """

    dut: SlavePins

    def __init__(
        self,
        dut: SlavePins,
        platform: int = 2,
        period: int = 8000,
        seed: int = 1,
        stalls: float = 0.0,
        gaps: float = 0.0,
    ) -> None:
        super().__init__(dut, dut.multi_clk_i, dut.multi_reset_i, 1, period, seed)
        table = load()[f"fpga{platform}"]
        self.instructions, self._components = table.instructions, table.components
        self.stalls, self.gaps = stalls, gaps

    def idle(self) -> None:
        dut, draw = self.dut, self.random.getrandbits
        dut.multi_start_i.value, dut.multi_clk_en_i.value = 0, 1
        for group in ("multi", "combo"):
            for name, width in (("dataa", 32), ("datab", 32), ("n", 8), ("a", 5), ("b", 5)):
                getattr(dut, f"{group}_{name}_i").value = draw(width)
            for name in ("readra", "readrb", "writerc"):
                getattr(dut, f"{group}_{name}_i").value = draw(1)
            getattr(dut, f"{group}_c_i").value = draw(5)

    def instruction(self, name: str) -> Instruction:
        """Record of an instruction of nios_sw/custom.toml. Raises ValueError for another name."""
        if name not in self.instructions:
            raise ValueError(unknown("custom instruction", name, self.instructions))
        return self.instructions[name]

    def combinational(self, name: str) -> bool:
        """Whether the instruction ends in the clock in which it is given."""
        return self._components[self.instruction(name).component].type == "combinational"

    async def call(
        self, name: str, a: int, b: int = 0, ra: int = 0, rb: int = 0, rc: int = 0
    ) -> Result:
        """Execute an instruction on operand bits a and b.

        ra, rb, rc: indices of the component's internal registers, where the instruction takes
        them. Raises AssertionError if it does not end.
        """
        item, dut = self.instruction(name), self.dut
        group = "combo" if self.combinational(name) else "multi"
        fields = {"dataa": a, "datab": b, "n": item.n, "a": ra, "b": rb, "c": rc}
        fields |= {
            flag: int(place == "r")
            for flag, place in zip(("writerc", "readra", "readrb"), item.registers, strict=True)
        }
        for pin, value in fields.items():
            getattr(dut, f"{group}_{pin}_i").value = value
        if group == "combo":
            await self.settle()
            got = Result(word(dut.combo_result_o), 1)
            await self.next()
        else:
            got = await self._multicycle(name)
        self.idle()
        while self.random.random() < self.gaps:
            await self.next()
            self.idle()
        return got

    async def _multicycle(self, name: str) -> Result:
        dut, cycles = self.dut, 0
        dut.multi_start_i.value = 1
        while cycles < DONE_LIMIT:
            enabled = self.random.random() >= self.stalls
            dut.multi_clk_en_i.value = int(enabled)
            await self.settle()
            cycles += enabled
            done = enabled and word(dut.multi_done_o)
            bits = word(dut.multi_result_o) if done else 0
            await self.next()
            if enabled:  # A start that is stalled is held.
                dut.multi_start_i.value = 0
            if done:
                return Result(bits, cycles)
        raise AssertionError(f"{name}: not done after {DONE_LIMIT} enabled clocks")
