# SPDX-License-Identifier: Apache-2.0
"""The memory of a stream against a list: bundles that wait, seek and are void, a host that writes.

A model of stages Q and D drives the memory; the reference runs the bundles in the order in which
they issue. test_asip.py starts the test.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from tests.bench.seed import SEED

WORDS, LANES = 16, 2
CYCLES = 6_000
SETTLED = 3  # clocks from a write of the host to a bundle that may issue


@dataclass(frozen=True)
class Bundle:
    """What a bundle asks of the stream."""

    take: bool
    seek: int | None


def bundle(random: Random) -> Bundle | None:
    """The next one from fetch, or none."""
    if random.random() < 0.2:
        return None
    return Bundle(random.random() < 0.7, random.randrange(WORDS) if random.random() < 0.2 else None)


@cocotb.test()
async def stream__bundle_that_takes__has_the_word_at_the_pointer(dut) -> None:
    """Also after it waited, after a seek, a flush or a write of that word."""
    random = Random(SEED)
    memory = [[0] * WORDS for _ in range(LANES)]
    pointer, wait, wrote, taken = 0, 0, 0, 0
    q: Bundle | None = None
    d: Bundle | None = None
    expected: list[int] | None = None
    cocotb.start_soon(Clock(dut.clk_i, 10, "ns").start())
    dut.rst_ni.value = 0
    for name in ("clear", "flush", "advance", "take_q", "seek_q", "take", "seek", "write"):
        getattr(dut, f"{name}_i").value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    filled = [(lane, place) for lane in range(LANES) for place in range(WORDS)]
    for cycle in range(CYCLES):
        if not filled and wait == 0 and random.random() < 0.02:
            wait = random.randrange(1, 20)  # a halt in which the host writes
        write = filled.pop() if filled else None
        if not filled and wait > SETTLED and random.random() < 0.5:
            write = random.randrange(LANES), random.randrange(WORDS)
        wait = max(wait - 1, SETTLED if write else 0)
        void = random.random() < 0.03
        clear = random.random() < 0.005
        issue = d is not None and wait == 0 and not void and not clear and random.random() < 0.6
        advance = d is None or issue
        dut.clear_i.value, dut.flush_i.value, dut.advance_i.value = clear, void or clear, advance
        dut.take_q_i.value = q is not None and q.take
        dut.seek_q_i.value = q is not None and q.seek is not None
        dut.seek_address_q_i.value = q.seek or 0 if q else 0
        dut.take_i.value = issue and d.take
        dut.seek_i.value = issue and d.seek is not None
        dut.seek_address_i.value = d.seek or 0 if d else 0
        dut.write_i.value = write is not None
        if write is not None:
            lane, place = write
            memory[lane][place] = random.getrandbits(32)
            dut.write_lane_i.value, dut.write_address_i.value = write
            dut.write_data_i.value = memory[lane][place]
            wrote += 1
        await FallingEdge(dut.clk_i)
        if expected is not None:
            word = int(dut.word_r1_o.value)
            found = [word >> 32 * lane & 0xFFFFFFFF for lane in range(LANES)]
            assert found == expected, f"cycle {cycle}: {found} instead of {expected}"
            taken += 1
        expected = [memory[lane][pointer] for lane in range(LANES)] if issue and d.take else None
        if issue and d.seek is not None:
            pointer = d.seek
        elif issue and d.take:
            pointer = (pointer + 1) % WORDS
        if clear:
            pointer = 0
        if void or clear:
            q = d = None
        elif advance:
            q, d = bundle(random), q
        await RisingEdge(dut.clk_i)
    assert taken > CYCLES / 8 and wrote > 3 * LANES * WORDS
