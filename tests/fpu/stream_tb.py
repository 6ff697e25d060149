# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the unit bench: clock, reset and the end of a vector stream.

Runs inside the simulator on the generated `bench` top (see `tests.fpu.tb.bench_source`). The rows
themselves are read and recorded by `sim/harness/unit_stream.sv`, because one awaited clock edge
per row in Python costs far more than the simulated row.
"""

import os

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge


class Bench:
    """Owns clock and reset of the bench top."""

    def __init__(self, dut) -> None:
        self.clk = dut.clk_i
        self.rst_n = dut.rst_ni
        self.done = dut.done_o
        self.valid = dut.valid_o

    async def start(self) -> None:
        """Start the clock and release the reset away from the rising edge."""
        self.rst_n.value = 0
        Clock(self.clk, 2, unit="step").start()
        await FallingEdge(self.clk)
        await FallingEdge(self.clk)
        self.rst_n.value = 1

    async def valid_within(self, clocks: int) -> bool:
        """Whether valid_o is high now or in one of so many clocks; stops in that clock."""
        for _ in range(clocks - 1):
            if self.valid.value == 1:
                break
            await FallingEdge(self.clk)
        return self.valid.value == 1


@cocotb.test()
async def stream_vectors(dut) -> None:
    """Run the vector file to its end."""
    bench = Bench(dut)
    await bench.start()
    await RisingEdge(bench.done)


@cocotb.test()
async def reset_clears_pipeline(dut) -> None:
    """Reset amid a full stream: valid_o falls at once and returns only with the new stream."""
    latency, interval = (int(os.environ[name]) for name in ("UNIT_LATENCY", "UNIT_INTERVAL"))
    bench = Bench(dut)
    await bench.start()
    for _ in range(latency + 4):
        await FallingEdge(bench.clk)
    assert await bench.valid_within(interval), "the pipeline never filled"
    bench.rst_n.value = 0
    await RisingEdge(bench.clk)
    assert bench.valid.value == 0, "valid_o survives an asynchronous reset"
    await FallingEdge(bench.clk)
    bench.rst_n.value = 1
    for edge in range(latency + 1):
        assert bench.valid.value == 0, f"stale valid_o {edge} edges after reset"
        await FallingEdge(bench.clk)
    assert await bench.valid_within(interval), "the pipeline does not refill after reset"
