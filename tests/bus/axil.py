# SPDX-License-Identifier: Apache-2.0
"""AXI4-Lite bus model with random pauses and a protocol monitor, and the run of a cocotb bench.

The bus model runs inside the simulator. Inputs change at the falling edge; handshakes are sampled
just before the rising edge. cocotbext-axi does not take its place: its manager sends no strobes
with gaps, and holds a payload behind the handshake, where this one sends noise.
"""

from __future__ import annotations

import os
import random
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer
from cocotb_tools.runner import get_results

from sim.cocotb.runner import OPTIMISATION, Simulation
from sim.rtl.build import ROOT

OKAY, SLVERR = 0, 2
PERIOD = 10  # simulation steps
LIMIT = 20000  # cycles for one transaction
PAYLOAD = {
    "aw": ("awaddr_i",),
    "w": ("wdata_i", "wstrb_i"),
    "b": ("bresp_o",),
    "ar": ("araddr_i",),
    "r": ("rdata_o", "rresp_o"),
}


class Bus:
    """AXI4-Lite manager and monitor of one `axil_bridge` with an agent behind it.

    `pause` is the probability that a channel waits another cycle before VALID or READY. The monitor
    checks on every cycle that VALID of the subordinate stays, with its payload, until READY; that
    each response answers a complete request; that no VALID shows in reset.
    """

    def __init__(self, dut, seed: int, pause: float = 0.0) -> None:
        self.dut, self.random, self.pause = dut, random.Random(seed), pause
        self.cycle = self.agent_read_cycles = 0
        self.accepted = {name: 0 for name in PAYLOAD}
        self.at = dict.fromkeys(PAYLOAD, 0)  # cycle of the last handshake of a channel
        self.valid_at = {"b": 0, "r": 0}  # cycle in which the last response became valid
        self.held = {"b": None, "r": None}
        self.stalls = {name: 0 for name in PAYLOAD}
        for name in ("awvalid", "wvalid", "bready", "arvalid", "rready"):
            getattr(dut, f"{name}_i").value = 0
        for name in ("awaddr", "awprot", "wdata", "wstrb", "araddr", "arprot"):
            getattr(dut, f"{name}_i").value = 0

    async def start(self) -> None:
        """Start the clock, hold reset for some cycles, release it."""
        self.dut.rst_ni.value = 0
        Clock(self.dut.clk_i, PERIOD, unit="step").start()
        for _ in range(4):
            await FallingEdge(self.dut.clk_i)
            assert self.bit("bvalid_o") == 0 and self.bit("rvalid_o") == 0, "VALID in reset"
        self.dut.rst_ni.value = 1
        cocotb.start_soon(self._monitor())

    def bit(self, name: str) -> int:
        return int(getattr(self.dut, name).value)

    async def _monitor(self) -> None:
        while True:
            await Timer(PERIOD // 4, unit="step")  # inputs of this cycle have settled
            self.cycle += 1
            self.agent_read_cycles += self.bit("read")
            for name, payload in PAYLOAD.items():
                source, sink = ("o", "i") if name in "br" else ("i", "o")
                valid, ready = self.bit(f"{name}valid_{source}"), self.bit(f"{name}ready_{sink}")
                if name in self.held:
                    words = tuple(self.bit(port) for port in payload) if valid else None
                    before = self.held[name]
                    assert before is None or words == before, f"{name}: changed before READY"
                    if valid and before is None:
                        self.valid_at[name] = self.cycle
                    self.held[name] = None if valid and ready else words
                if valid and ready:
                    self.accepted[name] += 1
                    self.at[name] = self.cycle
                elif valid:
                    self.stalls[name] += 1
            done = self.accepted
            requests = min(done["aw"], done["w"])
            assert done["b"] + self.bit("bvalid_o") * (self.at["b"] != self.cycle) <= requests
            assert done["r"] + self.bit("rvalid_o") * (self.at["r"] != self.cycle) <= done["ar"]
            await FallingEdge(self.dut.clk_i)

    async def _wait(self) -> None:
        while self.random.random() < self.pause:
            await FallingEdge(self.dut.clk_i)

    async def _send(self, channel: str, **payload: int) -> None:
        await self._wait()
        for port, value in payload.items():
            getattr(self.dut, f"{port}_i").value = value
        valid = getattr(self.dut, f"{channel}valid_i")
        valid.value = 1
        await self._handshake(channel, f"{channel}ready_o")
        valid.value = 0
        for port in payload:  # a subordinate must not look at it any longer
            handle = getattr(self.dut, f"{port}_i")
            handle.value = self.random.getrandbits(len(handle))

    async def _receive(self, channel: str, *ports: str) -> tuple[int, ...]:
        ready = getattr(self.dut, f"{channel}ready_i")
        if self.random.random() < 0.5:  # READY before VALID, or only behind it
            for _ in range(LIMIT):
                if self.bit(f"{channel}valid_o"):
                    break
                await FallingEdge(self.dut.clk_i)
        await self._wait()
        ready.value = 1
        words = await self._handshake(channel, f"{channel}valid_o", ports)
        ready.value = 0
        return words

    async def _handshake(
        self, channel: str, other: str, ports: tuple[str, ...] = ()
    ) -> tuple[int, ...]:
        for _ in range(LIMIT):
            await Timer(PERIOD // 4, unit="step")
            done = self.bit(other)
            words = tuple(self.bit(port) for port in ports) if done else ()
            await FallingEdge(self.dut.clk_i)
            if done:
                return words
        raise AssertionError(f"{channel}: no handshake in {LIMIT} cycles")

    async def write(self, address: int, data: int, strobes: int = 15) -> int:
        """Write a word; returns the response. AW and W start independently."""
        address = 4 * address + self.random.randrange(4)
        sends = [
            cocotb.start_soon(self._send("aw", awaddr=address, awprot=self.random.randrange(8))),
            cocotb.start_soon(self._send("w", wdata=data, wstrb=strobes)),
        ]
        (response,) = await self._receive("b", "bresp_o")
        for send in sends:
            await send
        return response

    async def read(self, address: int) -> int:
        """Read a word; the response must be OKAY."""
        address = 4 * address + self.random.randrange(4)
        send = cocotb.start_soon(self._send("ar", araddr=address, arprot=self.random.randrange(8)))
        word, response = await self._receive("r", "rdata_o", "rresp_o")
        await send
        assert response == OKAY
        return word


def run_scenarios(
    top: str,
    sources: Sequence[Path],
    bench: Path,
    folder: Path,
    parameters: Mapping[str, int] | None = None,
    environment: Mapping[str, str] | None = None,
    optimisation: str = OPTIMISATION,
) -> None:
    """Build `top` in `folder` and run every `@cocotb.test()` or `@scenario` of `bench`, or SCENARIO
    alone. `optimisation` is the C++ compiler's, for long simulations.

    Raises AssertionError with the log's end and how to replay if one fails or is missing.
    """
    seed, scenario = os.environ.get("SEED", "1"), os.environ.get("SCENARIO")
    scenarios = re.findall(r"@(?:cocotb\.test\(\)|scenario)\n(?:async )?def", bench.read_text())
    simulation = Simulation(top, sources, folder, parameters, optimisation=optimisation)
    results = simulation.run(
        ".".join(bench.relative_to(ROOT).with_suffix("").parts),
        {"SEED": seed, **(environment or {})},
        test_filter=f"{scenario}$" if scenario else None,
    )
    total, failed = get_results(results)
    assert failed == 0 and total == (1 if scenario else len(scenarios)), (
        f"{failed} of {total} failed; replay: SEED={seed}\n{simulation.log.read_text()[-4000:]}"
    )
