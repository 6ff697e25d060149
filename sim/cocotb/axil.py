# SPDX-License-Identifier: Apache-2.0
"""The AXI4-Lite ports of `asip_axil` and `motion_axil` for the manager of cocotbext-axi."""

from __future__ import annotations

from logging import Logger
from typing import Protocol

from cocotb.clock import Clock
from cocotb.handle import LogicObject
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiLiteBus, AxiLiteMaster

CHANNELS = {
    "aw": ("addr", "prot", "valid", "ready"),
    "w": ("data", "strb", "valid", "ready"),
    "b": ("resp", "valid", "ready"),
    "ar": ("addr", "prot", "valid", "ready"),
    "r": ("data", "resp", "valid", "ready"),
}
WORD = 4  # bytes


class AxiLitePins(Protocol):
    """The module with the port."""

    clk_i: LogicObject
    rst_ni: LogicObject
    _log: Logger
    _name: str


class Pins:
    """The signals of the port without the ending _i or _o, as cocotbext-axi names them."""

    def __init__(self, dut: AxiLitePins) -> None:
        self._log, self._name = dut._log, dut._name
        for channel, signals in CHANNELS.items():
            for name in (channel + signal for signal in signals):
                ends = (end for end in "io" if hasattr(dut, f"{name}_{end}"))
                setattr(self, name, getattr(dut, f"{name}_{next(ends)}"))


class AxiLite(AxiLiteMaster):
    """cocotbext-axi's manager at a port, with its methods; addresses there count bytes.

    `put` and `get` take word addresses, as the register maps do.
    """

    def __init__(self, dut: AxiLitePins, period: int = 10_000) -> None:
        self.dut, self.period = dut, period
        bus = AxiLiteBus.from_entity(Pins(dut))
        super().__init__(bus, dut.clk_i, dut.rst_ni, reset_active_level=False)

    async def reset(self, cycles: int = 4) -> None:
        """Start the clock and hold reset for some cycles."""
        self.dut.rst_ni.value = 0
        Clock(self.dut.clk_i, self.period, unit="ps").start()
        await ClockCycles(self.dut.clk_i, cycles)
        self.dut.rst_ni.value = 1
        await ClockCycles(self.dut.clk_i, 2)

    async def put(self, address: int, data: int) -> None:
        """Write a word."""
        await self.write_dword(WORD * address, data)

    async def get(self, address: int) -> int:
        """Read a word."""
        return await self.read_dword(WORD * address)
