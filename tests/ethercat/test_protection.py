# SPDX-License-Identifier: Apache-2.0
"""Write protection of registers and controller, and frames of other types."""

from __future__ import annotations

import pytest

from sim.bus.clocks import read, write
from sim.bus.datagram import APRD, APWR, ETHERNET, LRW, answer, datagram, frame, single
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.register import ByteRegister
from tests.ethercat.frames import MEMORY, Fmmu

STATION = esc_regmap.STATION_ADDRESS
KINDS = [
    (esc_regmap.REGISTER_PROTECTION, esc_regmap.REGISTER_ENABLE, False),
    (esc_regmap.WRITE_PROTECTION, esc_regmap.WRITE_ENABLE, True),
]


def counters(line: Line, *writes: tuple[int, bytes]) -> list[int]:
    """One frame of these writes; the working counter of each."""
    parts = [datagram(APWR, 0, at, data, more=True) for at, data in writes]
    back = line.exchange(frame(*parts, datagram(APRD, 0, 0, bytes(1)))).data
    found, at = [], 16
    for _, data in writes:
        at += 10 + len(data) + 2
        found.append(int.from_bytes(back[at - 2 : at], "little"))
    return found


def byte(register: ByteRegister, value: int) -> tuple[int, bytes]:
    """A write of a register's lowest byte."""
    return register.address, bytes([value])


def switch(register: ByteRegister, on: bool = True) -> tuple[int, bytes]:
    """A write of a protection or enable register, which has one field."""
    (name,) = register.fields
    return byte(register, register.word(**{name: on}))


@pytest.mark.parametrize(("protection", "enable", "memory"), KINDS)
def test_protected__is_not_written_and_not_counted(
    line: Line, protection: ByteRegister, enable: ByteRegister, memory: bool
):
    assert counters(line, switch(protection), byte(STATION, 1)) == [1, 1]  # from the next frame on
    assert counters(line, byte(STATION, 2), switch(protection, False), (MEMORY, b"\x5a")) == [
        0,
        0,
        not memory,
    ]
    assert read(line, 0, STATION) == 1 and read(line, 0, protection) == 1
    assert line.read(MEMORY) == (0 if memory else 0x5A)
    # The application is not protected from.
    line.write(esc_regmap.AL_STATUS_CODE, 0x11)
    assert line.read(esc_regmap.AL_STATUS_CODE) == 0x11


@pytest.mark.parametrize(("protection", "enable", "memory"), KINDS)
def test_enable__frees_the_rest_of_its_frame(
    line: Line, protection: ByteRegister, enable: ByteRegister, memory: bool
):
    counters(line, switch(protection))
    found = counters(line, byte(STATION, 1), switch(enable), byte(STATION, 2), (MEMORY, b"\x5a"))
    assert found == [0, 1, 1, 1]
    assert read(line, 0, STATION) == 2 and line.read(MEMORY) == 0x5A
    assert read(line, 0, enable) == 0
    assert counters(line, byte(STATION, 3)) == [0]
    assert counters(line, switch(enable, False), byte(STATION, 3)) == [1, 0]
    assert counters(line, switch(enable), switch(protection, False)) == [1, 1]
    assert counters(line, byte(STATION, 4)) == [1]


def test_enable__of_a_bad_frame_frees_no_other(line: Line):
    counters(line, switch(esc_regmap.REGISTER_PROTECTION))
    line.exchange(single(APWR, 0, *switch(esc_regmap.REGISTER_ENABLE)), sequence=bytes(4))
    assert counters(line, byte(STATION, 3)) == [0]


def test_register_enable__does_not_free_a_protected_controller(line: Line):
    counters(line, switch(esc_regmap.WRITE_PROTECTION), switch(esc_regmap.REGISTER_PROTECTION))
    one, both = switch(esc_regmap.REGISTER_ENABLE), switch(esc_regmap.WRITE_ENABLE)
    assert counters(line, one, byte(STATION, 1)) == [1, 0]
    assert counters(line, both, byte(STATION, 1)) == [1, 0]
    assert counters(line, one, both, byte(STATION, 1)) == [1, 1, 1]


def test_logical_write__to_a_protected_register_is_refused(line: Line):
    entry = Fmmu(0x10000, 2, 0, 7, STATION.address, 0, read=True, write=True)
    line.exchange(single(APWR, 0, esc_regmap.FMMU_LOGICAL_START.at(0), entry.registers()))
    question = single(LRW, 0, 1, b"\x34\x12")
    assert answer(line.exchange(question).data, 2)[1] == 3
    counters(line, switch(esc_regmap.REGISTER_PROTECTION))
    assert answer(line.exchange(single(LRW, 0, 1, b"\x78\x56")).data, 2) == (0x1234, 1)
    assert read(line, 0, STATION) == 0x1234


def test_reads__are_served_while_all_is_protected(line: Line):
    counters(line, switch(esc_regmap.WRITE_PROTECTION))
    assert read(line, 0, esc_regmap.TYPE) == esc_regmap.TYPE.reset


FOREIGN = ETHERNET[:12] + b"\x08\x06" + bytes(range(100))


def test_forwarding__decides_about_frames_of_other_types(line: Line):
    whole = line.exchange(FOREIGN)
    assert whole.good and whole.data[12:] == FOREIGN[12:]
    write(line, 0, esc_regmap.DL_CONTROL, esc_regmap.DL_CONTROL.word(forwarding=1))
    cut = line.exchange(FOREIGN)
    assert not cut.good and cut.nibbles < 2 * 20
    assert line.read(esc_regmap.PROCESSING_ERRORS) == 0
    assert read(line, 0, esc_regmap.TYPE) == esc_regmap.TYPE.reset
    write(line, 0, esc_regmap.DL_CONTROL, 0)
    assert line.exchange(FOREIGN).good
