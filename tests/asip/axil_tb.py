# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the AXI4-Lite port: bus model with random pauses, protocol monitor, scenarios.

Runs inside the simulator on `asip_axil`, started by test_axil.py. Inputs change at the falling
edge; handshakes are sampled just before the rising edge. Environment: AXIL_PLAN, a JSON file with
words to write and read and expected values; SEED.
"""

from __future__ import annotations

import json
import os
import random
from collections import deque
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer

from sim.harness.asip_rtl import CSR, STATUS

OKAY, SLVERR = 0, 2
START, CLEAR = 1, 2
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
    """AXI4-Lite manager and monitor of one `asip_axil`.

    `pause` is the probability that a channel waits another cycle before VALID or READY. The monitor
    checks on every cycle that VALID of the subordinate stays, with its payload, until READY; that
    each response answers a complete request; that no VALID shows in reset.
    """

    def __init__(self, dut, seed: int, pause: float = 0.0) -> None:
        self.dut, self.random, self.pause = dut, random.Random(seed), pause
        self.cycle = self.core_read_cycles = 0
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
            self.core_read_cycles += self.bit("read_q")
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

    async def run(self, polls: int = 500) -> int:
        """Start a run and poll STATUS to its end; returns STATUS."""
        assert await self.write(CSR["CONTROL"], START) == OKAY
        for _ in range(polls):
            status = await self.read(CSR["STATUS"])
            if not STATUS["busy"].of(status):
                return status
        raise AssertionError("the run did not end")


def plan() -> dict:
    """What test_axil.py wants done."""
    return json.loads(Path(os.environ["AXIL_PLAN"]).read_text())


def seed() -> int:
    """SEED of the environment."""
    return int(os.environ["SEED"])


async def load(bus: Bus, todo: dict) -> None:
    for address, word in todo["load"]:
        assert await bus.write(address, word) == OKAY


@cocotb.test()
async def program__random_pauses__outputs_of_the_model(dut) -> None:
    bus, todo = Bus(dut, seed()), plan()
    await bus.start()
    for pause in (0.0, 0.3, 0.8):
        bus.pause = pause
        await load(bus, todo)
        for tick in todo["ticks"]:
            for address, word in tick["inputs"]:
                assert await bus.write(address, word) == OKAY
            status = await bus.run()
            assert STATUS["done"].of(status) and not STATUS["fault"].of(status)
            assert bus.bit("irq_o") == 1
            got = [await bus.read(address) for address, _ in tick["outputs"]]
            want = [word for _, word in tick["outputs"]]
            assert got == want, f"pause {pause}: {got} {want}"
            assert await bus.write(CSR["CONTROL"], CLEAR) == OKAY
            assert bus.bit("irq_o") == 0
    assert bus.stalls["b"] and bus.stalls["r"], bus.stalls


@cocotb.test()
async def data_memory__writes_and_reads_at_random__as_a_memory(dut) -> None:
    bus = Bus(dut, seed(), 0.4)
    await bus.start()
    base, memory = plan()["data"], {}
    for _ in range(300):
        offset, word = bus.random.randrange(16), bus.random.getrandbits(32)
        strobes = 15 if bus.random.random() < 0.6 else bus.random.randrange(15)
        response = await bus.write(base + offset, word, strobes)
        assert response == (OKAY if strobes == 15 else SLVERR), f"strobes {strobes:04b}"
        if strobes == 15:
            memory[offset] = word
        offset = bus.random.choice(sorted(memory) or [None])
        if offset is not None:
            assert await bus.read(base + offset) == memory[offset]


@cocotb.test()
async def partial_strobes__no_register_changes_and_no_run_starts(dut) -> None:
    bus = Bus(dut, seed(), 0.2)
    await bus.start()
    await load(bus, plan())
    watchdog = await bus.read(CSR["WATCHDOG"])
    for strobes in range(15):
        assert await bus.write(CSR["WATCHDOG"], watchdog ^ 0xFFFFFFFF, strobes) == SLVERR
        assert await bus.write(CSR["CONTROL"], START, strobes) == SLVERR
    assert await bus.read(CSR["WATCHDOG"]) == watchdog
    assert await bus.read(CSR["STATUS"]) == 0


@cocotb.test()
async def latency__handshake_to_response_valid(dut) -> None:
    bus = Bus(dut, seed())
    await bus.start()
    for _ in range(4):
        await bus.write(CSR["WATCHDOG"], 500)
        assert bus.valid_at["b"] - max(bus.at["aw"], bus.at["w"]) == 3
        assert await bus.read(CSR["WATCHDOG"]) == 500
        assert bus.valid_at["r"] - bus.at["ar"] == 2 + bus.core_read_cycles
        bus.core_read_cycles = 0


@cocotb.test()
async def write_response_not_taken__reads_go_on(dut) -> None:
    bus = Bus(dut, seed())
    await bus.start()
    first = cocotb.start_soon(bus._send("w", wdata=77, wstrb=15))
    await bus._send("aw", awaddr=4 * CSR["WATCHDOG"])
    await first
    for _ in range(3):
        assert await bus.read(CSR["ID"]) == 0x4D544B31
    assert bus.bit("bvalid_o") and bus.accepted["b"] == 0
    assert await bus._receive("b", "bresp_o") == (OKAY,)
    assert await bus.read(CSR["WATCHDOG"]) == 77


@cocotb.test()
async def access_held_by_a_run__waits_and_is_not_lost(dut) -> None:
    bus, todo = Bus(dut, seed()), plan()
    await bus.start()
    await load(bus, todo)
    for address, word in todo["ticks"][0]["inputs"]:
        await bus.write(address, word)
    assert await bus.write(CSR["CONTROL"], START) == OKAY
    started = bus.cycle
    address, word = todo["ticks"][0]["outputs"][0]
    reading = cocotb.start_soon(bus.read(address))
    await RisingEdge(dut.irq_o)
    assert not reading.done(), "an output was read while the program ran"
    assert await reading == word
    assert bus.cycle - started >= await bus.read(CSR["CYCLES"])


@cocotb.test()
async def transfers_queued_on_every_channel__answered_in_order(dut) -> None:
    """Writes and reads from three independent streams; a read sees the writes answered before."""
    bus = Bus(dut, seed(), 0.5)
    await bus.start()
    base, count = plan()["data"], 60
    answered: deque[int] = deque()

    async def addresses() -> None:
        for i in range(count):
            await bus._send("aw", awaddr=4 * (base + i))

    async def words() -> None:
        for i in range(count):
            await bus._send("w", wdata=1000 + i, wstrb=15)

    async def responses() -> None:
        for i in range(count):
            assert await bus._receive("b", "bresp_o") == (OKAY,)
            answered.append(i)

    streams = [cocotb.start_soon(stream()) for stream in (addresses, words, responses)]
    while len(answered) < count:
        await FallingEdge(dut.clk_i)
        if answered:
            i = bus.random.choice(answered)
            assert await bus.read(base + i) == 1000 + i
    for stream in streams:
        await stream
    assert bus.accepted["b"] == count and bus.accepted["r"] > 0
    assert bus.stalls["aw"] and bus.stalls["w"], bus.stalls
