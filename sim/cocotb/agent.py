# SPDX-License-Identifier: Apache-2.0
"""Avalon-MM agents with a register map: `asip`, `motion_front_end`, `drive_front_end`."""

from __future__ import annotations

from typing import Protocol

from asip_asm.regmap import RegisterMap
from sim.cocotb.clocked import Bus, Clocked, Pin, word
from sim.core.backends import unknown

WAIT_LIMIT = 20_000  # clocks of one access


class AgentPins(Protocol):
    """Pins of an agent."""

    clk_i: Pin
    rst_ni: Pin
    waitrequest_o: Pin
    address_i: Bus
    writedata_i: Bus
    readdata_o: Bus


class Agent(Clocked):
    """A module with clk_i, rst_ni and the port address_i, read_i, ... of an agent.

    `pause` is the probability of an idle clock before an access. The inputs in `quiet`, the names
    of further pins, are 0 during and after a reset.
    """

    dut: AgentPins

    def __init__(
        self,
        dut: AgentPins,
        regmap: RegisterMap,
        period: int = 10_000,
        seed: int = 1,
        pause: float = 0.0,
        quiet: tuple[str, ...] = (),
    ) -> None:
        super().__init__(dut, dut.clk_i, dut.rst_ni, 0, period, seed)
        self.regmap, self.pause, self._quiet = regmap, pause, quiet

    def idle(self) -> None:
        for name in ("read_i", "write_i", "address_i", "writedata_i", *self._quiet):
            getattr(self.dut, name).value = 0

    async def write(self, address: int, data: int) -> None:
        """Write a word; waits as long as the module holds the access."""
        await self._access("write_i", address, data)

    async def read(self, address: int) -> int:
        """Read a word."""
        return await self._access("read_i", address, self.random.getrandbits(32))

    async def _access(self, strobe: str, address: int, data: int) -> int:
        while self.random.random() < self.pause:
            await self.next()
        self.dut.address_i.value, self.dut.writedata_i.value = address, data
        getattr(self.dut, strobe).value = 1
        for _ in range(WAIT_LIMIT):
            await self.settle()
            if not word(self.dut.waitrequest_o):
                break
            await self.next()
        else:
            raise AssertionError(f"address {address:#06x}: no answer in {WAIT_LIMIT} clocks")
        got = word(self.dut.readdata_o) if strobe == "read_i" else 0
        await self.next()
        getattr(self.dut, strobe).value = 0
        return got

    async def register(self, name: str, index: int = 0) -> int:
        """Read a register of the map by its name; `index` selects one of several of that name."""
        return await self.read(self._address(name, index))

    async def field(self, name: str, field: str) -> int:
        """Read one field of a register."""
        return self._record(name).fields[field].of(await self.register(name))

    async def put(self, name: str, data: int | None = None, /, index: int = 0, **fields: int):
        """Write a register: a whole word, or its fields, the others 0."""
        if data is None:
            data = self._record(name).word(**fields)
        elif fields:
            raise ValueError(f"register {name}: write a whole word or its fields, not both")
        await self.write(self._address(name, index), data & 0xFFFFFFFF)

    def _record(self, name: str):
        if name not in self.regmap.registers:
            raise ValueError(unknown("register", name, self.regmap.registers))
        return self.regmap.registers[name]

    def _address(self, name: str, index: int) -> int:
        if not 0 <= index < self._record(name).count:
            raise ValueError(f"register {name} has no index {index}")
        return self.regmap.address(name) + index


def signed(value: int) -> int:
    """A word as a number in two's complement."""
    return value - ((value & 0x80000000) << 1)
