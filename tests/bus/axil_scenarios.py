# SPDX-License-Identifier: Apache-2.0
"""Scenarios that every AXI4-Lite port of the project passes, on registers that its bench names.

Addresses count words; each register takes the words that are written to it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

import cocotb
from cocotb.triggers import FallingEdge

from tests.bus.axil import OKAY, SLVERR, Bus


async def random_access(bus: Bus, masks: dict[int, int], memory: dict[int, int]) -> None:
    """Words with whole and partial strobes: a memory of the bits in `masks`, by address."""
    for _ in range(300):
        address, word = bus.random.choice(sorted(masks)), bus.random.getrandbits(32)
        strobes = 15 if bus.random.random() < 0.6 else bus.random.randrange(15)
        response = await bus.write(address, word, strobes)
        assert response == (OKAY if strobes == 15 else SLVERR), f"strobes {strobes:04b}"
        if strobes == 15:
            memory[address] = word & masks[address]
        if memory:
            address = bus.random.choice(sorted(memory))
            assert await bus.read(address) == memory[address]


async def latency(bus: Bus, address: int, word: int, agent: int | None = None) -> None:
    """Three clocks from the later of AW and W to BVALID; from AR to RVALID two and the agent's, of
    which there are `agent` if that is fixed.
    """
    for _ in range(4):
        await bus.write(address, word)
        assert bus.valid_at["b"] - max(bus.at["aw"], bus.at["w"]) == 3
        assert await bus.read(address) == word
        assert bus.valid_at["r"] - bus.at["ar"] == 2 + bus.agent_read_cycles
        assert agent in (None, bus.agent_read_cycles)
        bus.agent_read_cycles = 0


async def response_not_taken(bus: Bus, address: int, word: int, known: tuple[int, int]) -> None:
    """Reads of a `known` (address, word) go on while a write response waits."""
    first = cocotb.start_soon(bus._send("w", wdata=word, wstrb=15))
    await bus._send("aw", awaddr=4 * address)
    await first
    for _ in range(3):
        assert await bus.read(known[0]) == known[1]
    assert bus.bit("bvalid_o") and bus.accepted["b"] == 0
    assert await bus._receive("b", "bresp_o") == (OKAY,)
    assert await bus.read(address) == word


async def queued_transfers(bus: Bus, addresses: Sequence[int], word: Callable[[int], int]) -> None:
    """Writes and reads from three independent streams; a read sees the writes answered before.

    Write i goes to addresses[i]; several of them may be one register.
    """
    count = len(addresses)
    answered: deque[int] = deque()

    async def send_addresses() -> None:
        for address in addresses:
            await bus._send("aw", awaddr=4 * address)

    async def send_words() -> None:
        for i in range(count):
            await bus._send("w", wdata=word(i), wstrb=15)

    async def take_responses() -> None:
        for i in range(count):
            assert await bus._receive("b", "bresp_o") == (OKAY,)
            answered.append(i)

    streams = (send_addresses, send_words, take_responses)
    tasks = [cocotb.start_soon(stream()) for stream in streams]
    while len(answered) < count:
        await FallingEdge(bus.dut.clk_i)
        if answered:
            address = addresses[bus.random.choice(answered)]
            last = max(i for i in answered if addresses[i] == address)
            later = (i for i in range(last, count) if addresses[i] == address)
            assert await bus.read(address) in map(word, later), f"address {address:#x}"
    for task in tasks:
        await task
    assert bus.accepted["b"] == count and bus.accepted["r"] > 0
    assert bus.stalls["aw"] and bus.stalls["w"], bus.stalls
