# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the motion front-end's AXI4-Lite port: the scenarios on `motion_axil`.

Started by test_axil.py. Environment: SEED.
"""

from __future__ import annotations

import os

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge

from sim.rtl.motion_rtl import REGMAP
from sim.rtl.phase_record import FIRST, LAST, Record
from tests.bus import axil_scenarios as scenarios
from tests.bus.axil import OKAY, SLVERR, Bus

CSR = {name: REGMAP.address(name) for name in REGMAP.registers}
RECORDS = REGMAP.blocks["records"].base
WRITABLE = {  # address: the bits that are there
    CSR[name]: sum(field.mask for field in REGMAP.registers[name].fields.values())
    for name in ("STEP_TIMING", "DIRECTION_TIMING", "IRQ_ENABLE")
}
ABORT_ALL = REGMAP.registers["CONTROL"].fields["abort"].mask
STEPS, IRQ, HEAD = (REGMAP.registers[name] for name in ("STEP_TIMING", "IRQ_ENABLE", "HEAD"))


async def started(dut, pause: float = 0.0) -> Bus:
    """A bus out of reset."""
    bus = Bus(dut, int(os.environ["SEED"]), pause)
    await bus.start()
    return bus


async def put(bus: Bus, axis: int, record: Record, number: int = 0) -> None:
    """Write the axis' record of this number, from 0, and release it."""
    for word, value in enumerate(record.words()):
        assert await bus.write(RECORDS + 64 * axis + 8 * number + word, value) == OKAY
    assert await bus.write(CSR["HEAD"], HEAD.word(**{f"axis{axis}": number + 1})) == OKAY


async def rises(dut, axis: int, count: list[int]) -> None:
    """Counts rising edges of an axis' step line into count[0]."""
    level = 0
    while True:
        await FallingEdge(dut.clk_i)
        before, level = level, int(dut.step_o.value) >> axis & 1
        count[0] += level and not before


@cocotb.test()
async def registers__writes_and_reads_at_random__as_a_memory(dut) -> None:
    bus = await started(dut, 0.4)
    memory = {address: await bus.read(address) for address in WRITABLE}
    await scenarios.random_access(bus, WRITABLE, memory)
    assert bus.stalls["b"] and bus.stalls["r"], bus.stalls


@cocotb.test()
async def move__random_pauses__pulses_as_ordered(dut) -> None:
    bus, count = await started(dut), [0]
    cocotb.start_soon(rises(dut, 2, count))
    turns = REGMAP.registers["DIRECTION_TIMING"].word(setup=1, hold=1)
    assert await bus.write(CSR["STEP_TIMING"], STEPS.word(length=1, space=1)) == OKAY
    assert await bus.write(CSR["DIRECTION_TIMING"], turns) == OKAY
    assert await bus.write(CSR["IRQ_ENABLE"], IRQ.word(idle=1, fault=1)) == OKAY
    for number, bus.pause in enumerate((0.0, 0.6)):
        await put(bus, 2, Record(FIRST | LAST, 20, 16 * 2_000_000 << 32, 0, 0), number)
        assert bus.bit("irq_o") == 0
        await RisingEdge(dut.irq_o)
        await FallingEdge(dut.clk_i)  # where the bus model acts
        assert count == [40 * (number + 1)]
        assert await bus.read(CSR["POSITION"] + 2) == count[0]
        assert await bus.read(CSR["POSITION"] + 1) == 0


@cocotb.test()
async def partial_strobes__no_register_changes_and_nothing_moves(dut) -> None:
    bus = await started(dut, 0.2)
    assert await bus.write(CSR["IRQ_ENABLE"], IRQ.word(fault=1)) == OKAY
    await put(bus, 0, Record(FIRST, 1 << 20, 16 * 100_000 << 32, 0, 0))
    for strobes in range(15):
        assert await bus.write(CSR["IRQ_ENABLE"], IRQ.word(idle=1), strobes) == SLVERR
        assert await bus.write(CSR["CONTROL"], ABORT_ALL, strobes) == SLVERR
        assert await bus.write(CSR["HEAD"], HEAD.word(axis0=1, axis1=1), strobes) == SLVERR
        assert await bus.write(RECORDS + 1, 1, strobes) == SLVERR
    assert await bus.read(CSR["IRQ_ENABLE"]) == IRQ.word(fault=1)
    assert await bus.read(CSR["HEAD"]) == HEAD.word(axis0=1)
    for _ in range(120):
        await FallingEdge(dut.clk_i)
    running = REGMAP.registers["STATUS"].word(running=1)
    assert await bus.read(CSR["STATUS"]) == running, "axis 0 runs on, nothing else happened"


@cocotb.test()
async def latency__handshake_to_response_valid(dut) -> None:
    bus = await started(dut)
    await scenarios.latency(bus, CSR["STEP_TIMING"], STEPS.word(length=500), 2)


@cocotb.test()
async def write_response_not_taken__reads_go_on(dut) -> None:
    bus = await started(dut)
    known = CSR["ID"], REGMAP.registers["ID"].reset
    await scenarios.response_not_taken(bus, CSR["STEP_TIMING"], STEPS.word(length=77), known)


@cocotb.test()
async def transfers_queued_on_every_channel__answered_in_order(dut) -> None:
    bus = await started(dut, 0.5)
    addresses = [CSR[name] for name in ("STEP_TIMING", "DIRECTION_TIMING")] * 30
    await scenarios.queued_transfers(bus, addresses, lambda i: 100 + i)
