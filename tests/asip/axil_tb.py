# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the ASIP's AXI4-Lite port: the scenarios on `asip_axil`, started by test_axil.py.

Environment: AXIL_PLAN, a JSON file with words to write and read and expected values; SEED.
"""

from __future__ import annotations

import json
import os
from collections import deque
from pathlib import Path

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge

from asip_asm.gen.asip_regmap import REGMAP
from sim.harness.asip_bus import CLEAR, CSR, START, STATUS
from tests.bus.axil import OKAY, SLVERR, Bus


async def run(bus: Bus, polls: int = 500) -> int:
    """Start a run and poll STATUS to its end; returns STATUS."""
    assert await bus.write(CSR["CONTROL"], START) == OKAY
    for _ in range(polls):
        status = await bus.read(CSR["STATUS"])
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
            status = await run(bus)
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
        assert bus.valid_at["r"] - bus.at["ar"] == 2 + bus.agent_read_cycles
        bus.agent_read_cycles = 0


@cocotb.test()
async def write_response_not_taken__reads_go_on(dut) -> None:
    bus = Bus(dut, seed())
    await bus.start()
    first = cocotb.start_soon(bus._send("w", wdata=77, wstrb=15))
    await bus._send("aw", awaddr=4 * CSR["WATCHDOG"])
    await first
    for _ in range(3):
        assert await bus.read(CSR["ID"]) == REGMAP.registers["ID"].reset
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
