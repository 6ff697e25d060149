# SPDX-License-Identifier: Apache-2.0
"""Figures of the slave controller, counted in clocks of its own simulation."""

from __future__ import annotations

from dataclasses import dataclass

from sim.coe.dictionary import Device
from sim.ethercat.datagram import APRD, APWR, DATA_AT, LRW, answer, single
from sim.ethercat.gen import esc_regmap
from sim.ethercat.line import GAP_NIBBLES, Line

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
    outputs, inputs = device.bytes("rx"), device.bytes("tx")
    areas = device.process_data
    for manager, start, length, control in (
        (OUTPUT_MANAGER, areas["outputs"], outputs, 0x64),
        (INPUT_MANAGER, areas["inputs"], inputs, 0x20),
    ):
        registers = start.to_bytes(2, "little") + length.to_bytes(2, "little")
        registers += bytes([control, 0, 1, 0])
        line.exchange(single(APWR, 0, esc_regmap.SM_START.at(manager), registers))
    for place, start, length, kind in (
        (0, areas["outputs"], outputs, WRITE),
        (1, areas["inputs"], inputs, READ),
    ):
        registers = LOGICAL.to_bytes(4, "little") + length.to_bytes(2, "little") + bytes([0, 7])
        registers += start.to_bytes(2, "little") + bytes([0, kind, 1, 0, 0, 0])
        line.exchange(single(APWR, 0, esc_regmap.FMMU_LOGICAL_START.at(place), registers))
    events = esc_regmap.AL_EVENT.word(sm=1 << OUTPUT_MANAGER)
    line.write(esc_regmap.AL_EVENT_MASK, events)
    line.copy((areas["outputs"], outputs), (areas["inputs"], inputs))
    return max(outputs, inputs)


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
        status = line.exchange(single(APRD, 0, esc_regmap.PROCESSING_ERRORS.address, bytes(1)))
        wrong += answer(status.data, 1)[0]
    return wrong, late
