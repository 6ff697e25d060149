# SPDX-License-Identifier: Apache-2.0
"""Latch inputs: system times of edges, their events, and what clears them."""

from __future__ import annotations

import pytest

from sim.bus.clocks import read, write
from sim.bus.datagram import APRD, single
from sim.bus.gen import esc_regmap
from sim.bus.line import Line

CLOCK_NS = 10
LATENCY = 2  # clocks from that in which an input changes to the time taken
RISING, FALLING = 1, 2
CONTROL = (esc_regmap.LATCH_CONTROL_0, esc_regmap.LATCH_CONTROL_1)
STATUS = (esc_regmap.LATCH_STATUS_0, esc_regmap.LATCH_STATUS_1)
TIMES = (
    (esc_regmap.LATCH_TIME_0_RISING, esc_regmap.LATCH_TIME_0_FALLING),
    (esc_regmap.LATCH_TIME_1_RISING, esc_regmap.LATCH_TIME_1_FALLING),
)
EVENT = esc_regmap.AL_EVENT.word(latch=1)
MASTER_EVENT = esc_regmap.MASTER_EVENT.word(latch=1)


def edge(line: Line, levels: int) -> int:
    """New levels of the inputs; the system time then, ns."""
    line.latch(levels)
    now = line.time()
    line.run(100 * CLOCK_NS)
    return now


@pytest.mark.parametrize("n", (0, 1))
def test_continuous__every_edge_takes_its_time(line: Line, n: int):
    bit = 1 << n
    for _ in range(2):
        up, down = edge(line, bit), edge(line, 0)
        for at, time in zip((up, down), TIMES[n], strict=True):
            for found in (line.read(time), read(line, 0, time)):
                assert 0 <= found - at - LATENCY * CLOCK_NS <= CLOCK_NS
    assert line.read(STATUS[n]) == 0 and not line.read(esc_regmap.AL_EVENT) & EVENT
    assert not any(line.read(time) for time in TIMES[1 - n])


@pytest.mark.parametrize("n", (0, 1))
def test_single__the_first_edge_takes_its_time_until_it_was_read(line: Line, n: int):
    bit = 1 << n
    write(line, 0, CONTROL[n], RISING | FALLING)
    up, _ = edge(line, bit), edge(line, 0)
    edge(line, bit), edge(line, 0)
    assert line.read(STATUS[n]) == RISING | FALLING
    assert line.read(STATUS[1 - n]) == 0
    assert line.read(esc_regmap.AL_EVENT) & EVENT
    assert line.read(esc_regmap.MASTER_EVENT) & MASTER_EVENT
    assert abs(line.read(TIMES[n][0]) - up - LATENCY * CLOCK_NS) <= CLOCK_NS
    assert line.read(STATUS[n]) == RISING | FALLING  # the master owns the input
    assert abs(read(line, 0, TIMES[n][0]) - up - LATENCY * CLOCK_NS) <= CLOCK_NS
    assert line.read(STATUS[n]) == FALLING
    assert line.read(esc_regmap.AL_EVENT) & EVENT
    read(line, 0, TIMES[n][1])
    assert line.read(STATUS[n]) == 0 and not line.read(esc_regmap.AL_EVENT) & EVENT
    again = edge(line, bit)
    assert abs(read(line, 0, TIMES[n][0]) - again - LATENCY * CLOCK_NS) <= CLOCK_NS


def test_owner__is_who_clears_the_event(line: Line):
    write(line, 0, esc_regmap.SYNC_CONTROL, esc_regmap.SYNC_CONTROL.word(latch1=1))
    line.write(CONTROL[1], RISING)  # the application may set it up too
    edge(line, 2)
    read(line, 0, TIMES[1][0])
    assert line.read(STATUS[1]) == RISING | esc_regmap.LATCH_STATUS_1.word(high=1)
    line.read(TIMES[1][0].address + 1)
    assert line.read(STATUS[1]) & RISING
    line.read(TIMES[1][0])
    assert line.read(STATUS[1]) == esc_regmap.LATCH_STATUS_1.word(high=1)


def test_bad_frame__clears_nothing(line: Line):
    write(line, 0, CONTROL[0], RISING)
    edge(line, 1)
    question = single(APRD, 0, TIMES[0][0].address, bytes(8))
    assert not line.exchange(question, sequence=bytes(4)).good
    assert line.read(STATUS[0]) & RISING


def test_time__is_whole_while_edges_come(line: Line):
    """Halves that a side reads one after the other are of one edge, for both sides at once."""
    low = TIMES[0][0].address
    write(line, 0, esc_regmap.TIME_OFFSET, (1 << 32) - line.time() - 50_000)
    edge(line, 1)
    first = line.read(low, width=4)
    line.run(100_000)  # the low half of the system time has wrapped
    edge(line, 0), edge(line, 1)
    assert read(line, 0, TIMES[0][0]) >> 32 == 1
    assert first > 1 << 31 and line.read(low + 4, width=4) == 0
    assert line.read(TIMES[0][0]) >> 32 == 1


def test_system_time__is_whole_for_the_application(line: Line):
    """Its high half is that of the read of the low one."""
    at = esc_regmap.SYSTEM_TIME.address
    write(line, 0, esc_regmap.TIME_OFFSET, (1 << 32) - line.time() - 50_000)
    first = line.read(at, width=4)
    line.run(100_000)
    assert first > 1 << 31 and line.read(at + 4, width=4) == 0
