# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the ASIP's AXI4-Lite port: the scenarios on `asip_axil`, started by test_axil.py.

Environment: AXIL_PLAN, a JSON file with words to write and read and expected values; SEED.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import cocotb
from cocotb.triggers import RisingEdge

from asip_asm.gen.asip_regmap import REGMAP
from sim.rtl.asip_bus import CLEAR, CSR, START, STATUS
from tests.bench.seed import SEED
from tests.bus import axil_scenarios as scenarios
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


async def started(dut, pause: float = 0.0) -> Bus:
    """The port out of reset; see Bus for `pause`."""
    bus = Bus(dut, SEED, pause)
    await bus.start()
    return bus


async def load(bus: Bus, todo: dict) -> None:
    for address, word in todo["load"]:
        assert await bus.write(address, word) == OKAY


@cocotb.test()
async def program__random_pauses__outputs_of_the_model(dut) -> None:
    bus, todo = await started(dut), plan()
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
    bus = await started(dut, 0.4)
    base = plan()["data"]
    await scenarios.random_access(bus, {base + i: 0xFFFFFFFF for i in range(16)}, {})


@cocotb.test()
async def partial_strobes__no_register_changes_and_no_run_starts(dut) -> None:
    bus = await started(dut, 0.2)
    await load(bus, plan())
    watchdog = await bus.read(CSR["WATCHDOG"])
    for strobes in range(15):
        assert await bus.write(CSR["WATCHDOG"], watchdog ^ 0xFFFFFFFF, strobes) == SLVERR
        assert await bus.write(CSR["CONTROL"], START, strobes) == SLVERR
    assert await bus.read(CSR["WATCHDOG"]) == watchdog
    assert await bus.read(CSR["STATUS"]) == 0


@cocotb.test()
async def latency__handshake_to_response_valid(dut) -> None:
    bus = await started(dut)
    await scenarios.latency(bus, CSR["WATCHDOG"], 500)


@cocotb.test()
async def write_response_not_taken__reads_go_on(dut) -> None:
    bus = await started(dut)
    known = CSR["ID"], REGMAP.registers["ID"].reset
    await scenarios.response_not_taken(bus, CSR["WATCHDOG"], 77, known)


@cocotb.test()
async def access_held_by_a_run__waits_and_is_not_lost(dut) -> None:
    bus, todo = await started(dut), plan()
    await load(bus, todo)
    for address, word in todo["ticks"][0]["inputs"]:
        await bus.write(address, word)
    assert await bus.write(CSR["CONTROL"], START) == OKAY
    began = bus.cycle
    address, word = todo["ticks"][0]["outputs"][0]
    reading = cocotb.start_soon(bus.read(address))
    await RisingEdge(dut.irq_o)
    assert not reading.done(), "an output was read while the program ran"
    assert await reading == word
    assert bus.cycle - began >= await bus.read(CSR["CYCLES"])


@cocotb.test()
async def transfers_queued_on_every_channel__answered_in_order(dut) -> None:
    bus = await started(dut, 0.5)
    base = plan()["data"]
    await scenarios.queued_transfers(bus, range(base, base + 60), lambda i: 1000 + i)
