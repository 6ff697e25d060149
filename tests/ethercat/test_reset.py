# SPDX-License-Identifier: Apache-2.0
"""ESC reset: what the master writes for it, and what is left after it."""

from __future__ import annotations

import pytest

from sim.bus.clocks import read, write
from sim.bus.datagram import APWR, BRD, answer, datagram, frame, single
from sim.bus.device import CLOCK_NS, CYCLE_CLOCKS, DeviceRtl
from sim.bus.gen import esc_regmap
from sim.bus.line import SETTLE_NS, Line
from sim.bus.session import START_NS

SEQUENCE = b"RES"
HOLD_NS = 163_840
STATION = 0x1234
COUNT = single(BRD, 0, 0, bytes(1))


def ask(line: Line, data: bytes) -> list[int]:
    """Write a byte a frame; how many were right after each, as the master reads it."""
    seen = []
    for byte in data:
        write(line, 0, esc_regmap.ESC_RESET, byte)
        seen.append(read(line, 0, esc_regmap.ESC_RESET))
    return seen


def was_reset(line: Line) -> bool:
    """Whether a reset comes in the time after which it must."""
    for _ in range(HOLD_NS // 100 + 20):
        line.run(100)
        if line.in_reset():
            return True
    return False


def test_three_bytes__reset_controller_and_application(line: Line):
    write(line, 0, esc_regmap.STATION_ADDRESS, STATION)
    write(line, 0, esc_regmap.PULSE_LENGTH, 5)
    line.write(esc_regmap.AL_STATUS, esc_regmap.AL_STATUS.word(state=2))
    assert ask(line, SEQUENCE) == [1, 2, 3]
    assert not line.in_reset()
    assert was_reset(line)
    line.run(SETTLE_NS)
    assert not line.in_reset()
    for register in (esc_regmap.STATION_ADDRESS, esc_regmap.AL_STATUS, esc_regmap.ESC_RESET):
        assert read(line, 0, register) == register.reset
    assert not was_reset(line)


def test_third_frame__comes_back_and_so_does_a_line():
    with Line([0.0, 0.0]) as line:
        ask(line, SEQUENCE[:2])
        third = line.exchange(single(APWR, 0, esc_regmap.ESC_RESET.address, SEQUENCE[2:]))
        assert third.good and answer(third.data, 1)[1] == 1
        assert was_reset(line)
        assert not line.in_reset(1)
        line.run(SETTLE_NS)
        assert answer(line.exchange(COUNT).data, 1)[1] == 2


@pytest.mark.parametrize("data", [b"RESET"[:2] + b"TS", b"RRES", b"ERS", b"RE\0S"])
def test_other_bytes__begin_anew(line: Line, data: bytes):
    assert 3 not in ask(line, data)
    assert not was_reset(line)


def test_other_frames__may_pass_between(line: Line):
    for byte in SEQUENCE:
        ask(line, bytes([byte]))
        write(line, 0, esc_regmap.STATION_ADDRESS, STATION)
    assert was_reset(line)


def test_one_frame__is_one_byte(line: Line):
    """R, E and S in one frame count as S."""
    at = esc_regmap.ESC_RESET.address
    whole = frame(*(datagram(APWR, 0, at, bytes([b]), more=b != SEQUENCE[-1]) for b in SEQUENCE))
    line.exchange(whole)
    assert read(line, 0, esc_regmap.ESC_RESET) == 0
    assert not was_reset(line)


def test_bad_frame__counts_for_nothing(line: Line):
    ask(line, SEQUENCE[:2])
    line.exchange(single(APWR, 0, esc_regmap.ESC_RESET.address, b"S"), sequence=bytes(4))
    assert not was_reset(line)
    assert read(line, 0, esc_regmap.ESC_RESET) == 2


def test_core__starts_anew_with_the_controller():
    """Its first pass lasts longer than a cycle, for it waits for the start of the program."""
    device = DeviceRtl()
    device.run(START_NS)
    device.restart_counts()
    device.run(START_NS)
    assert device.counts()["longest"] < CYCLE_CLOCKS
    for byte in SEQUENCE:
        device.send(single(APWR, 0, esc_regmap.ESC_RESET.address, bytes([byte])))
        device.run(20_000)
    device.run(HOLD_NS + START_NS)
    assert device.counts()["longest"] > 2 * CYCLE_CLOCKS
    device.restart_counts()
    device.run(START_NS)
    assert device.counts()["ticks"] == START_NS // (CYCLE_CLOCKS * CLOCK_NS)
    assert device.counts()["longest"] < CYCLE_CLOCKS
