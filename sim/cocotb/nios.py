# SPDX-License-Identifier: Apache-2.0
"""Driver of `n2_system`: C programs on the Nios II systems FPGA1 and FPGA2, and their ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from cocotb.triggers import FallingEdge, First, Timer

from sim.cocotb.clocked import Bus, Clocked, Pin, word
from sim.core.backends import unknown
from sim.rtl.nios_image import Program
from sim.rtl.nios_image import load as committed
from sim.rtl.nios_map import default_system_map

TICK_LIMIT = 200_000  # clocks
RESET_CLOCKS = 2  # of the core, at least


@dataclass(frozen=True)
class NiosTick:
    """Words of the program's outputs by name, and the clocks that the hardware counted."""

    words: dict[str, int]
    cycles: int


class NiosPins(Protocol):
    """Pins of `n2_system` that the driver looks at."""

    clk_i: Pin
    rst_ni: Pin
    run_i: Pin
    enable_i: Pin
    tick_i: Pin
    host_write_i: Pin
    pending_o: Pin
    host_address_i: Bus
    host_wdata_i: Bus
    host_rdata_o: Bus
    tick_cycles_o: Bus


class Nios(Clocked):
    """A system at its host port; the core is in reset until `start`.

    Addresses are byte addresses, inputs and outputs those of nios_sw/system.toml.
    """

    dut: NiosPins

    def __init__(self, dut: NiosPins, period: int = 10_000, seed: int = 1) -> None:
        super().__init__(dut, dut.clk_i, dut.rst_ni, 0, period, seed)
        self.map = default_system_map()
        self.program: Program | None = None

    def idle(self) -> None:
        for name in ("run", "enable", "tick", "host_write", "host_address", "host_wdata"):
            getattr(self.dut, f"{name}_i").value = 0
        for name in ("ext_readdata", "ext_waitrequest"):
            getattr(self.dut, f"{name}_i").value = 0
        for name in ("address", "read", "write", "writedata"):
            getattr(self.dut, f"debug_{name}_i").value = 0

    # ------------------------------------------------------------------ host port
    async def write(self, address: int, words: Sequence[int]) -> None:
        """Write words to a memory, or to the block input."""
        self.dut.host_write_i.value = 1
        for i, data in enumerate(words):
            self.dut.host_address_i.value = address + 4 * i
            self.dut.host_wdata_i.value = int(data)
            await self.next()
        self.dut.host_write_i.value = 0

    async def read(self, address: int, count: int = 1) -> list[int]:
        """Read words of a memory, or of the block output."""
        found = []
        for i in range(count):
            self.dut.host_address_i.value = address + 4 * i
            await self.next()
            await self.settle()
            found.append(word(self.dut.host_rdata_o))
        await self.next()
        return found

    # ------------------------------------------------------------------ programs
    async def load(self, program: Program | str) -> Program:
        """Put the core into reset and write a program, by name one of nios_sw/images."""
        self.program = committed(program) if isinstance(program, str) else program
        self.dut.run_i.value = 0
        await self.cycles(RESET_CLOCKS)
        for memory in self.map.memories.values():
            await self.write(memory.base, self.program.memories[memory.name])
        return self.program

    async def start(self, clocks: int) -> None:
        """Let the core run, with the host's wish for control, and give it time to initialise."""
        self.dut.run_i.value = self.dut.enable_i.value = 1
        await Timer(clocks * self.period, unit="ps")
        await self.next()

    async def set(self, **inputs: int) -> None:
        """Write words of inputs by name; the others keep theirs."""
        for name, value in inputs.items():
            if name not in self.map.inputs:
                raise ValueError(unknown("input", name, self.map.inputs))
            place = self.map.base("inputs") + 4 * self.map.inputs.index(name)
            await self.write(place, [value & 0xFFFFFFFF])

    async def trigger(self) -> None:
        """Begin a control tick."""
        self.dut.tick_i.value = 1
        await self.next()
        self.dut.tick_i.value = 0

    async def tick(self, **inputs: int) -> NiosTick:
        """Write words of inputs, run one control tick, read the outputs."""
        await self.set(**inputs)
        await self.trigger()
        return await self.result()

    async def result(self) -> NiosTick:
        """Wait for the end of the tick; its outputs. Raises AssertionError if it does not end."""
        if word(self.dut.pending_o):
            limit = Timer(TICK_LIMIT * self.period, unit="ps")
            await First(FallingEdge(self.dut.pending_o), limit)
        await self.next()
        assert not word(self.dut.pending_o), f"the tick did not end in {TICK_LIMIT} clocks"
        names = self.map.outputs
        words = await self.read(self.map.base("outputs"), len(names))
        cycles = word(self.dut.tick_cycles_o)
        return NiosTick(dict(zip(names, words, strict=True)), cycles)
