# SPDX-License-Identifier: Apache-2.0
"""Figures of the slave controller, counted in clocks of its own simulation."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from sim.bus.clocks import read
from sim.bus.coe.dictionary import Device
from sim.bus.coe.sii import managers
from sim.bus.datagram import APWR, DATA_AT, LRW, answer, single
from sim.bus.gen import esc_regmap
from sim.bus.line import GAP_NIBBLES, Line

CLOCK_PS = 10_000
NIBBLE_PS = 40_000
PHASE_STEP_PS = 2_500
OUTPUT_MANAGER, INPUT_MANAGER = 2, 3
READ, WRITE = 1, 2  # types of FMMUs
LOGICAL = 0x10000


@dataclass(frozen=True)
class Forwarding:
    """Clocks from a frame's first nibble on port 0 to its first on port 1.

    least, most: over the phases of the sender's clock; spread: between frames of one phase.
    """

    least: int
    most: int
    spread: int


def forwarding(frames: int = 8) -> Forwarding:
    """Frames of all sizes through one slave, for every phase of the sender's clock."""
    least, most, spread = 1 << 30, 0, 0
    for cable in range(0, NIBBLE_PS, PHASE_STEP_PS):
        seen = []
        with Line([0.0], cable_ps=cable, closed=True) as line:
            for n in range(frames):
                line.send(single(LRW, 0, 1, bytes(1 + 1480 * n // frames)))
                began = (line.now // NIBBLE_PS + 1 + GAP_NIBBLES) * NIBBLE_PS + cable
                line.run(200_000)
                back = line.receive(1)
                assert back is not None and back.good
                seen.append(-(-(back.began - began) // CLOCK_PS))
        least, most = min(least, *seen), max(most, *seen)
        spread = max(spread, max(seen) - min(seen))
    return Forwarding(least, most, spread)


def set_up_process_data(line: Line, device: Device) -> int:
    """Sync managers and FMMUs of all axes, the copying application; bytes of a cycle's datagram."""
    rows = managers(device)
    for place, (manager, kind) in enumerate(((OUTPUT_MANAGER, WRITE), (INPUT_MANAGER, READ))):
        _, start, length, control = rows[manager]
        registers = struct.pack("<2H4B", start, length, control, 0, 1, 0)
        line.exchange(single(APWR, 0, esc_regmap.SM_START.at(manager), registers))
        logical = struct.pack("<IHBB", LOGICAL, length, 0, 7)  # with its first and last bit
        physical = struct.pack("<HBBB3x", start, 0, kind, 1)  # and first bit, type, activation
        line.exchange(single(APWR, 0, esc_regmap.FMMU_LOGICAL_START.at(place), logical + physical))
    events = esc_regmap.AL_EVENT.word(sm=1 << OUTPUT_MANAGER)
    line.write(esc_regmap.AL_EVENT_MASK, events)
    outputs, inputs = (rows[manager][1:3] for manager in (OUTPUT_MANAGER, INPUT_MANAGER))
    line.copy(outputs, inputs)
    return max(outputs[1], inputs[1])


def keeps_cycle(device: Device, period_ns: int, cycles: int) -> tuple[int, int]:
    """Wrong counters and cycles whose inputs are not the outputs of the cycle before."""
    wrong = late = 0
    with Line() as line:
        size = set_up_process_data(line, device)
        before = None
        for n in range(cycles):
            value = n % 255 + 1
            line.send(single(LRW, LOGICAL & 0xFFFF, LOGICAL >> 16, bytes([value]) * size))
            line.run(period_ns)
            back = line.receive()
            if back is None:
                wrong += 1
                continue
            wrong += answer(back.data, size)[1] != 3
            late += before is not None and back.data[DATA_AT] != before
            before = value
        wrong += read(line, 0, esc_regmap.PROCESSING_ERRORS)
    return wrong, late
