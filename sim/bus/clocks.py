# SPDX-License-Identifier: Apache-2.0
"""Distributed clocks of a line, set up as a master does it, and how far apart they then run.

Delays come from receive times (ETG.1000.4): half of what a round trip beyond a slave takes longer
than beyond its neighbour. The first slave is the reference; every cycle an ARMW of its time passes.
"""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from sim.bus.datagram import APRD, APWR, ARMW, BWR, answer, single
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.register import ByteRegister

WORD = 1 << 32


@dataclass(frozen=True)
class Differences:
    """System times less the reference's, ns, once a cycle of those that count.

    worst: the largest, of any slave; mean: of each slave; delays: measured, of each slave.
    """

    worst: int
    mean: list[float]
    delays: list[int]
    cycles: int


def read(line: Line, slave: int, register: ByteRegister) -> int:
    """A register of the slave at that position, by the master.

    Raises TimeoutError if no frame comes back, or one that no slave or several answered.
    """
    width = register.width
    back = line.exchange(single(APRD, -slave & 0xFFFF, register.address, bytes(width)))
    value, counter = answer(back.data, width) if back else (0, 0)
    if counter != 1:
        raise TimeoutError(f"{register.name} of slave {slave}: no answer")
    return value


def write(line: Line, slave: int, register: ByteRegister, value: int) -> None:
    """Write a register of the slave at that position, by the master."""
    data = (value % (1 << 8 * register.width)).to_bytes(register.width, "little")
    line.exchange(single(APWR, -slave & 0xFFFF, register.address, data))


def measure_delays(line: Line, times: int) -> list[int]:
    """From the first slave to each, ns: the mean of so many measurements."""
    found = []
    for _ in range(times):
        line.exchange(single(BWR, 0, esc_regmap.RECEIVE_TIME_0.address, bytes(4)))
        rounds = []
        for slave in range(line.slaves):
            first = read(line, slave, esc_regmap.RECEIVE_TIME_0)
            second = read(line, slave, esc_regmap.RECEIVE_TIME_1)
            rounds.append((second - first) % WORD if slave < line.slaves - 1 else 0)
        sums = [0.0]
        for near, far in zip(rounds, rounds[1:], strict=False):
            sums.append(sums[-1] + (near - far) / 2)
        found.append(sums)
    return [round(statistics.mean(column)) for column in zip(*found, strict=True)]


def synchronise(
    line: Line, cycles: int, period_ns: int = 31_250, counted: int = 1000, speed_filter: int = 12
) -> Differences:
    """Set up the clocks and let so many cycles pass; the last `counted` of them count."""
    delays = measure_delays(line, 16)
    line.exchange(single(BWR, 0, esc_regmap.RECEIVE_TIME_0.address, bytes(4)))
    local = [read(line, slave, esc_regmap.RECEIVE_TIME_UNIT) for slave in range(line.slaves)]
    for slave in range(line.slaves):
        write(line, slave, esc_regmap.TIME_OFFSET, local[0] + delays[slave] - local[slave])
        write(line, slave, esc_regmap.TIME_DELAY, delays[slave])
        write(line, slave, esc_regmap.SPEED_FILTER, speed_filter)
        write(line, slave, esc_regmap.SPEED_START, 0x1000)
    share = single(ARMW, 0, esc_regmap.SYSTEM_TIME.address, bytes(8))
    seen: list[list[int]] = []
    for cycle in range(cycles):
        line.pass_by(share, period_ns)
        if cycle >= cycles - counted:
            reference = line.time(0)
            seen.append([line.time(slave) - reference for slave in range(line.slaves)])
    columns = list(zip(*seen, strict=True))
    return Differences(
        worst=max(abs(value) for column in columns for value in column),
        mean=[round(statistics.mean(column), 2) for column in columns],
        delays=delays,
        cycles=cycles,
    )
