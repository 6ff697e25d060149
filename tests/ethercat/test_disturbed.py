# SPDX-License-Identifier: Apache-2.0
"""Frames that are damaged, circulate or come twice; cables that break; watchdog and SII that fail:
each with the state and the counter that results."""

from __future__ import annotations

import pytest

from sim.bus.clocks import read, write
from sim.bus.coe.dictionary import load
from sim.bus.coe.sii import crc8, image
from sim.bus.datagram import (
    APRD,
    APWR,
    BRD,
    DATA_AT,
    FPRD,
    SHORTEST,
    answer,
    datagram,
    frame,
    single,
)
from sim.bus.gen import esc_regmap
from sim.bus.line import Line, check_sequence
from tests.ethercat import managers
from tests.ethercat.frames import Fmmu

LWR = 11
MEMORY = 0x1000
CIRCULATING = 0x40  # in the datagram's byte 7
FLAGS_AT = 16 + 7
OUTPUTS, OUTPUT_BYTES = 0x1200, 6
PORT_0_ALONE = esc_regmap.DL_STATUS.word(communication0=1, loop1=1)
BOTH = PORT_0_ALONE | esc_regmap.DL_STATUS.word(communication1=1, loop0=1)
WRITE = single(APWR, 0, MEMORY, b"\xa5\x5a\xa5\x5a")
ZEROS = single(APWR, 0, OUTPUTS, bytes(OUTPUT_BYTES))


def with_alias(alias: int) -> bytes:
    """The SII image with that station alias and the check sum that belongs to it."""
    whole = bytearray(image(load()))
    whole[8:10] = alias.to_bytes(2, "little")
    whole[14] = crc8(bytes(whole[:14]))
    return bytes(whole)


def inverted(sequence: bytes) -> bytes:
    return bytes(byte ^ 0xFF for byte in sequence)


def dl_control(line: Line, **fields: int) -> None:
    """Written by the master."""
    write(line, 0, esc_regmap.DL_CONTROL, esc_regmap.DL_CONTROL.word(**fields))


def alive(line: Line) -> bool:
    """Whether the watchdog of the process data has not run out; takes its event."""
    status = line.read(esc_regmap.WATCHDOG_STATUS)
    return bool(status & esc_regmap.WATCHDOG_STATUS.word(alive=1))


def sync_manager(line: Line, place: int, start: int, length: int, control: int) -> None:
    """Set one up as a master does."""
    registers = managers.registers(start, length, control)
    address = esc_regmap.SM_START.at(place)
    back = line.exchange(single(APWR, 0, address, registers))
    assert answer(back.data, 8)[1] == 1


def test_corrupted__leaves_marked_and_writes_nothing(line: Line):
    wrong = bytes([check_sequence(WRITE)[0] ^ 1]) + check_sequence(WRITE)[1:]
    back = line.exchange(WRITE, sequence=wrong)
    assert not back.good and len(back.data) == len(WRITE)
    assert back.sequence == inverted(check_sequence(back.data))
    assert line.read(MEMORY, width=4) == 0
    assert line.read(esc_regmap.INVALID_FRAMES_0) == 1
    assert line.exchange(WRITE).good and line.read(MEMORY, width=4) == 0x5AA55AA5


def test_bad_frame__writes_nothing_with_the_next_one_either(line: Line):
    line.exchange(WRITE, sequence=bytes(4))
    assert line.exchange(single(APWR, 0, MEMORY + 8, b"\x11" * 4)).good
    assert line.read(MEMORY, width=4) == 0 and line.read(MEMORY + 8, width=4) == 0x11111111


def test_corrupted__in_a_line_only_the_first_counts_it_as_its_own():
    with Line([0.0, 0.0]) as line:
        line.exchange(WRITE, sequence=bytes(4))
        assert [line.read(esc_regmap.INVALID_FRAMES_0, slave=n) for n in (0, 1)] == [1, 0]
        assert [line.read(esc_regmap.FORWARDED_ERRORS_0, slave=n) for n in (0, 1)] == [0, 1]
        assert line.read(esc_regmap.FORWARDED_ERRORS_1, slave=0) == 1  # on its way back
        assert line.read(MEMORY, width=4, slave=1) == 0


@pytest.mark.parametrize("drop", (1, 2, 7, 40, 100))
def test_truncated__keeps_its_length_and_writes_nothing(line: Line, drop: int):
    back = line.exchange(WRITE, drop=drop)
    assert back.nibbles == 2 * (len(WRITE) + 4) - drop and not back.good
    assert line.read(MEMORY, width=4) == 0
    assert line.read(esc_regmap.INVALID_FRAMES_0) == 1


def test_receive_error__is_counted_and_writes_nothing(line: Line):
    assert not line.exchange(WRITE, error_at=50).good
    assert line.read(esc_regmap.RX_ERRORS_0) == line.read(esc_regmap.INVALID_FRAMES_0) == 1
    assert line.read(MEMORY, width=4) == 0
    write(line, 0, esc_regmap.RX_ERRORS_0, 0)
    assert line.read(esc_regmap.RX_ERRORS_0) == line.read(esc_regmap.INVALID_FRAMES_0) == 0


def test_datagram__longer_than_its_frame_is_a_processing_error(line: Line):
    assert line.exchange(single(APWR, 0, MEMORY, bytes(100))[:60]).good
    assert line.read(esc_regmap.PROCESSING_ERRORS) == 1
    assert line.read(esc_regmap.INVALID_FRAMES_0) == 0


def test_header__shorter_than_its_datagrams_writes_nothing(line: Line):
    broken = bytearray(WRITE)
    broken[14] -= 4
    assert line.exchange(bytes(broken)).good
    assert line.read(esc_regmap.PROCESSING_ERRORS) == 1 and line.read(MEMORY, width=4) == 0


def test_oversized__passes_whole(line: Line):
    back = line.exchange(WRITE + bytes(3000))
    assert back.good and len(back.data) == len(WRITE) + 3000
    assert line.read(MEMORY, width=4) == 0x5AA55AA5


def test_duplicated__second_write_of_a_mailbox_is_not_counted(line: Line):
    sync_manager(line, 0, 0x1400, 16, managers.BOX_OUT)
    message = single(APWR, 0, 0x1400, bytes(range(1, 17)))
    assert [answer(line.exchange(message).data, 16)[1] for _ in range(2)] == [1, 0]
    assert line.read(esc_regmap.AL_EVENT) & esc_regmap.AL_EVENT.word(sm=1)
    assert line.read(0x1400, width=16) == int.from_bytes(bytes(range(1, 17)), "little")
    assert not line.read(esc_regmap.SM_STATUS, 0) & esc_regmap.SM_STATUS.word(full=1)
    assert answer(line.exchange(message).data, 16)[1] == 1


def test_mailbox__is_read_once(line: Line):
    sync_manager(line, 1, 0x1500, 8, managers.BOX_IN)
    question = single(APRD, 0, 0x1500, bytes(8))
    assert answer(line.exchange(question).data, 8) == (0, 0)
    line.write(0x1500, 0x1122334455667788, width=8)
    assert answer(line.exchange(question).data, 8) == (0x1122334455667788, 1)
    assert answer(line.exchange(question).data, 8) == (0, 0)


def test_bad_frame__leaves_the_mailbox_full(line: Line):
    sync_manager(line, 1, 0x1500, 8, managers.BOX_IN)
    line.write(0x1500, 0x1122334455667788, width=8)
    question = single(APRD, 0, 0x1500, bytes(8))
    assert not line.exchange(question, sequence=bytes(4)).good
    assert answer(line.exchange(question).data, 8) == (0x1122334455667788, 1)


def test_buffers__a_reader_between_its_bytes_sees_one_value(line: Line):
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    for value in range(1, 9):
        line.exchange(single(APWR, 0, OUTPUTS, bytes([value]) * OUTPUT_BYTES))
        first = line.read(OUTPUTS, width=2)
        for later in range(3):
            line.exchange(single(APWR, 0, OUTPUTS, bytes([100 + later]) * OUTPUT_BYTES))
        rest = line.read(OUTPUTS + 2, width=OUTPUT_BYTES - 2)
        assert (first, rest) == (0x0101 * value, 0x01010101 * value)


def test_event__of_outputs_that_come_during_a_read_stays(line: Line):
    """The first byte ends the event of the outputs that it opens, not that of the next ones."""
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    event = esc_regmap.AL_EVENT.word(sm=4)
    written = esc_regmap.SM_STATUS.word(written=1)

    def seen() -> tuple[bool, bool]:
        status = line.read(esc_regmap.SM_STATUS, 2)
        return bool(line.read(esc_regmap.AL_EVENT) & event), bool(status & written)

    for value in range(1, 5):
        line.exchange(single(APWR, 0, OUTPUTS, bytes([value]) * OUTPUT_BYTES))
        assert seen() == (True, True)
        line.read(OUTPUTS, width=2)
        assert seen() == (False, False)
        line.exchange(single(APWR, 0, OUTPUTS, bytes([0x80 + value]) * OUTPUT_BYTES))
        line.read(OUTPUTS + 2, width=OUTPUT_BYTES - 2)
        assert seen() == (True, True)
        assert line.read(OUTPUTS, width=OUTPUT_BYTES) == 0x010101010101 * (0x80 + value)
        assert seen() == (False, False)


def test_event__of_inputs_that_are_read_while_the_next_are_written_stays(line: Line):
    sync_manager(line, 3, 0x1300, OUTPUT_BYTES, managers.INPUTS)
    event = esc_regmap.AL_EVENT.word(sm=8)
    question = single(APRD, 0, 0x1300, bytes(OUTPUT_BYTES))
    line.write(0x1300, 1, width=OUTPUT_BYTES)
    for value in range(2, 6):
        line.write(0x1300, value, width=2)
        assert not line.read(esc_regmap.AL_EVENT) & event
        assert answer(line.exchange(question).data, OUTPUT_BYTES) == (value - 1, 1)
        line.write(0x1302, 0, width=OUTPUT_BYTES - 2)
        assert line.read(esc_regmap.AL_EVENT) & event


def test_event__of_inputs_written_during_the_master_s_read_stays(line: Line):
    """The frame opens the area when it passes, and ends the event when it is good."""
    control = esc_regmap.SM_CONTROL.word(master_event=1)
    sync_manager(line, 3, 0x1300, OUTPUT_BYTES, control)
    event = esc_regmap.MASTER_EVENT.word(sm=8)
    padding = datagram(0, 0, 0, bytes(1000))  # NOP
    question = frame(datagram(APRD, 0, 0x1300, bytes(OUTPUT_BYTES), more=True), padding)
    line.write(0x1300, 1, width=OUTPUT_BYTES)
    for during in (True, False):
        assert line.read(esc_regmap.MASTER_EVENT) & event
        line.send(question)
        line.run(20_000)
        if during:
            line.write(0x1300, 2, width=OUTPUT_BYTES)
        line.run(100_000)
        line.receive()
        assert bool(line.read(esc_regmap.MASTER_EVENT) & event) == during


@pytest.mark.parametrize("bytes_", [1, 2, OUTPUT_BYTES])
def test_buffers__a_read_at_any_clock_gets_these_outputs_or_the_last(line: Line, bytes_: int):
    """Frames and reads at one distance in each cycle: none makes the reader miss every buffer."""
    sync_manager(line, 2, OUTPUTS, bytes_, managers.OUTPUTS)
    older = []
    for clocks in range(690, 740):
        for value in range(1, 6):
            line.send(single(APWR, 0, OUTPUTS, bytes([value]) * bytes_))
            line.run(10 * clocks)
            seen = line.read(OUTPUTS, width=bytes_)
            line.run(20_000 - 10 * clocks)
            line.receive()
            assert seen % 0x100 * int("01" * bytes_, 16) == seen
            older.append(value - seen % 0x100)
            assert value < 3 or older[-1] in (0, 1), clocks
    assert set(older[4::5]) == {0, 1}


@pytest.mark.parametrize("bytes_", [1, 2, OUTPUT_BYTES])
def test_buffers__a_frame_at_any_clock_gets_these_inputs_or_the_last(line: Line, bytes_: int):
    sync_manager(line, 3, 0x1300, bytes_, managers.INPUTS)
    older = []
    for clocks in range(370, 420):
        for value in range(1, 6):
            line.send(single(APRD, 0, 0x1300, bytes(bytes_)))
            line.run(10 * clocks)
            line.write(0x1300, value * int("01" * bytes_, 16), width=bytes_)
            line.run(20_000 - 10 * clocks)
            seen, counter = answer(line.receive().data, bytes_)
            assert counter == 1 and seen % 0x100 * int("01" * bytes_, 16) == seen
            older.append(value - seen % 0x100)
            assert value < 3 or older[-1] in (0, 1), clocks
    assert set(older[4::5]) == {0, 1}


@pytest.mark.parametrize("bytes_", [1, 2, 4])
def test_buffers__two_writes_of_the_application_without_a_pause(line: Line, bytes_: int):
    sync_manager(line, 3, 0x1300, bytes_, managers.INPUTS)
    for value in range(1, 9, 2):
        for each in (value, value + 1):
            line.order(0x1300, each * int("01" * bytes_, 16), bytes_)
        line.run(2000)
        seen = answer(line.exchange(single(APRD, 0, 0x1300, bytes(bytes_))).data, bytes_)
        assert seen == ((value + 1) * int("01" * bytes_, 16), 1)


@pytest.mark.parametrize("bytes_", [1, 2, OUTPUT_BYTES])
def test_buffers__two_writes_of_one_frame(line: Line, bytes_: int):
    """The second begins with the commit that follows the last byte of the first."""
    sync_manager(line, 2, OUTPUTS, bytes_, managers.OUTPUTS)
    for value in range(1, 9, 2):
        first, second = (bytes([each]) * bytes_ for each in (value, value + 1))
        line.exchange(
            frame(datagram(APWR, 0, OUTPUTS, first, more=True), datagram(APWR, 0, OUTPUTS, second))
        )
        line.run(2000)
        assert line.read(OUTPUTS, width=bytes_) == int.from_bytes(second, "little")


def test_buffers__an_end_without_its_beginning_is_refused(line: Line):
    """A datagram of the last bytes alone: no outputs, no counter."""
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    for value in (0x11, 0x22, 0x33):
        line.exchange(single(APWR, 0, OUTPUTS, bytes([value]) * OUTPUT_BYTES))
    back = line.exchange(single(APWR, 0, OUTPUTS + OUTPUT_BYTES - 2, b"\x44" * 2))
    assert answer(back.data, 2)[1] == 0
    assert line.read(OUTPUTS, width=OUTPUT_BYTES) == 0x333333333333


@pytest.mark.parametrize("ascending", (True, False))
def test_buffers__two_fmmus_of_one_area(line: Line, ascending: bool):
    """In ascending order they are whole outputs; in the other the end comes first."""
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    whole = single(APWR, 0, OUTPUTS, b"\x11" * OUTPUT_BYTES)
    line.exchange(whole)
    for n, start in enumerate((0, 3) if ascending else (3, 0)):
        entry = Fmmu(0x10000 + 3 * n, 3, 0, 7, OUTPUTS + start, 0, read=False, write=True)
        line.exchange(single(APWR, 0, esc_regmap.FMMU_LOGICAL_START.at(n), entry.registers()))
    back = line.exchange(single(LWR, 0, 1, b"\x22" * OUTPUT_BYTES))
    assert answer(back.data, OUTPUT_BYTES)[1] == 1
    wanted = 0x222222222222 if ascending else 0x111111111111
    assert line.read(OUTPUTS, width=OUTPUT_BYTES) == wanted


def test_application__what_is_refused_is_counted(line: Line):
    """Outside an open area, or from the wrong side."""
    sync_manager(line, 3, 0x1300, OUTPUT_BYTES, managers.INPUTS)
    line.write(0x1304, 0xEEEE, width=2)
    assert line.read(esc_regmap.PDI_ERRORS) == 2
    assert line.read(0x1300, width=2) == 0
    assert line.read(esc_regmap.PDI_ERRORS) == 4
    write(line, 0, esc_regmap.PDI_ERRORS, 0)
    assert line.read(esc_regmap.PDI_ERRORS) == 0


def test_buffers__three_seen_from_the_master(line: Line):
    sync_manager(line, 3, 0x1300, OUTPUT_BYTES, managers.INPUTS)
    question = single(APRD, 0, 0x1300, bytes(OUTPUT_BYTES))
    for value in range(1, 9):
        line.write(0x1300, int.from_bytes(bytes([value]) * OUTPUT_BYTES, "little"), width=6)
        line.write(0x1300, 0xEEEE, width=2)  # the next one, not finished
        seen, counter = answer(line.exchange(question).data, OUTPUT_BYTES)
        assert (seen.to_bytes(6, "little"), counter) == (bytes([value]) * 6, 1)


def circulated(line: Line, circulating: bool):
    """A frame from beyond a slave whose port 0 has no link."""
    question = bytearray(single(BRD, 0, 0, bytes(4)))
    question[FLAGS_AT] |= CIRCULATING * circulating
    line.cable(0, False)
    line.run(5000)
    return line.exchange(bytes(question), port=1, limit_ns=30_000)


def test_circulating__the_first_round_is_marked():
    with Line([0.0], closed=True) as line:
        back = circulated(line, False)
        assert back.good and back.data[FLAGS_AT] & CIRCULATING
        assert answer(back.data, 4)[1] == 1
        assert line.read(esc_regmap.LOST_LINKS_0) == 1


def test_circulating__the_second_round_is_destroyed():
    with Line([0.0], closed=True) as line:
        back = circulated(line, True)
        assert back is None or back.nibbles < 2 * SHORTEST
        assert line.read(esc_regmap.PROCESSING_ERRORS) == 1


def test_circulating__the_ring_falls_silent():
    """The cable before the first slave goes while a frame is behind it: what is left of the frame
    does not come round for ever."""
    with Line([0.0, 0.0], cable_ps=20_000_000) as line:
        line.send(single(BRD, 0, 0, bytes(4)))
        line.run(45_000)
        line.cable(0, False)
        line.run(1_000_000)
        counters = (esc_regmap.INVALID_FRAMES_1, esc_regmap.FORWARDED_ERRORS_1)
        assert line.read(esc_regmap.PROCESSING_ERRORS) == 1
        seen = [line.read(counter) for counter in counters]
        line.run(1_000_000)
        assert [line.read(counter) for counter in counters] == seen
        assert sum(seen) < 16


def test_ring__cable_break_leaves_all_slaves_in_reach():
    with Line([0.0] * 3, closed=True) as line:
        question = single(BRD, 0, 0, bytes(4))
        line.send(question)
        line.run(40_000)
        assert answer(line.receive(1).data, 4)[1] == 3  # out at the far end
        line.cable(2, False)
        line.run(5000)
        assert answer(line.exchange(question).data, 4)[1] == 2
        assert answer(line.exchange(question, port=1).data, 4)[1] == 1
        line.cable(2, True)
        line.run(5000)
        line.send(question)
        line.run(40_000)
        assert answer(line.receive(1).data, 4)[1] == 3


def test_port__closed_by_the_master_stays_closed():
    with Line([0.0, 0.0]) as line:
        dl_control(line, loop1=3)
        line.run(5000)
        assert answer(line.exchange(single(BRD, 0, 0, bytes(2))).data, 2)[1] == 1
        assert line.read(esc_regmap.DL_STATUS) & BOTH == PORT_0_ALONE


def test_port__that_closed_by_itself_opens_when_its_control_is_written():
    with Line([0.0, 0.0]) as line:
        dl_control(line, loop1=1)
        question = single(BRD, 0, 0, bytes(2))

        def reached() -> int:
            line.run(5000)
            return answer(line.exchange(question).data, 2)[1]

        assert reached() == 2
        line.cable(1, False)
        assert reached() == 1
        dl_control(line, loop1=1)  # no link: it stays closed
        line.cable(1, True)
        assert reached() == 1
        dl_control(line, loop1=1)
        assert reached() == 2


def test_alias__addresses_the_slave_once_it_is_on(line: Line):
    line.load_sii(with_alias(0x1234))
    line.run(5000)
    question = single(FPRD, 0x1234, esc_regmap.STATION_ALIAS.address, bytes(2))
    assert answer(line.exchange(question).data, 2)[1] == 0
    dl_control(line, use_alias=1)
    assert answer(line.exchange(question).data, 2) == (0x1234, 1)


def test_watchdog__of_the_application_runs_out(line: Line):
    write(line, 0, esc_regmap.WATCHDOG_DIVIDER, 0)  # 80 ns
    write(line, 0, esc_regmap.WATCHDOG_PDI, 500)
    alive = esc_regmap.DL_STATUS.word(watchdog=1)
    line.read(esc_regmap.TYPE)
    line.run(20_000)
    assert read(line, 0, esc_regmap.WATCHDOG_PDI_COUNT) == 0
    assert read(line, 0, esc_regmap.DL_STATUS) & alive
    line.run(40_000)
    assert read(line, 0, esc_regmap.WATCHDOG_PDI_COUNT) == 1
    assert not read(line, 0, esc_regmap.DL_STATUS) & alive
    line.read(esc_regmap.TYPE)
    assert read(line, 0, esc_regmap.DL_STATUS) & alive


def test_watchdog__longest_unit__is_none_of_a_few_clocks(line: Line):
    write(line, 0, esc_regmap.WATCHDOG_DIVIDER, 0xFFFF)  # 2.6 ms
    write(line, 0, esc_regmap.WATCHDOG_PDI, 2)
    line.read(esc_regmap.TYPE)
    line.run(2_600_000)
    assert read(line, 0, esc_regmap.WATCHDOG_PDI_COUNT) == 0
    line.run(2_800_000)
    assert read(line, 0, esc_regmap.WATCHDOG_PDI_COUNT) == 1


def test_watchdog__runs_out_without_process_data(line: Line):
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    write(line, 0, esc_regmap.WATCHDOG_DIVIDER, 0)  # 80 ns
    line.exchange(ZEROS)
    line.run(60_000)
    assert line.read(esc_regmap.WATCHDOG_DATA_COUNT) == 0
    line.run(60_000)
    assert line.read(esc_regmap.WATCHDOG_DATA_COUNT) == 1
    assert line.read(esc_regmap.AL_EVENT) & esc_regmap.AL_EVENT.word(watchdog=1)
    assert not alive(line)
    assert not line.read(esc_regmap.AL_EVENT) & esc_regmap.AL_EVENT.word(watchdog=1)
    line.exchange(ZEROS)
    assert alive(line)


def test_watchdog__a_bad_frame_does_not_feed_it(line: Line):
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    write(line, 0, esc_regmap.WATCHDOG_DIVIDER, 0)
    line.exchange(ZEROS)
    for _ in range(8):
        line.exchange(ZEROS, sequence=bytes(4))
        line.run(10_000)
    assert line.read(esc_regmap.WATCHDOG_DATA_COUNT) == 1


@pytest.mark.parametrize("right", (True, False))
def test_sii__check_sum_decides(line: Line, right: bool):
    whole = bytearray(image(load()))
    whole[14] ^= not right
    line.load_sii(bytes(whole))
    line.run(5000)
    control = line.read(esc_regmap.SII_CONTROL)
    assert bool(control & esc_regmap.SII_CONTROL.word(checksum_error=1)) is not right
    assert bool(control & esc_regmap.SII_CONTROL.word(not_loaded=1)) is not right
    operational = line.read(esc_regmap.DL_STATUS) & esc_regmap.DL_STATUS.word(operational=1)
    assert bool(operational) is right


def test_sii__master_reads_and_writes_words(line: Line):
    whole = image(load())
    line.load_sii(whole)

    def command(code: int, word: int, data: bytes = b"") -> int:
        request = bytes([code & 1, code >> 8]) + word.to_bytes(4, "little") + data
        line.exchange(single(APWR, 0, esc_regmap.SII_CONTROL.address, request))
        line.run(2000)
        return line.read(esc_regmap.SII_CONTROL)

    command(0x100, 8)
    assert line.read(esc_regmap.SII_DATA) == int.from_bytes(whole[16:24], "little")
    assert command(0x200, 4, b"\x34\x12") & esc_regmap.SII_CONTROL.word(write_error=1)
    assert not command(0x201, 4, b"\x34\x12") & esc_regmap.SII_CONTROL.word(write_error=1)
    command(0x100, 4)
    assert line.read(esc_regmap.SII_DATA) & 0xFFFF == 0x1234
    assert command(0x100, 0x10000) & esc_regmap.SII_CONTROL.word(command_error=1)


def test_emulation__follows_the_master(line: Line):
    line.write(esc_regmap.PDI_CONFIG, esc_regmap.PDI_CONFIG.word(emulation=1))
    asked = esc_regmap.AL_CONTROL.word(state=2, acknowledge=1)
    write(line, 0, esc_regmap.AL_CONTROL, asked)
    assert read(line, 0, esc_regmap.AL_STATUS) == esc_regmap.AL_STATUS.word(state=2)


def test_frame__of_two_datagrams_reads_before_it_writes(line: Line):
    data = bytes([1, 2, 3, 4])
    both = frame(datagram(APWR, 0, MEMORY, data, more=True), datagram(APRD, 0, MEMORY, bytes(4)))
    back = line.exchange(both)
    assert back.data[DATA_AT + 16 : DATA_AT + 20] == bytes(4)
    assert answer(line.exchange(single(APRD, 0, MEMORY, bytes(4))).data, 4)[0] == 0x04030201


def test_process_data__shorter_than_the_manager_are_no_outputs(line: Line):
    """A datagram that ends before the last byte changes no buffer, and the watchdog runs on."""
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    write(line, 0, esc_regmap.WATCHDOG_DIVIDER, 0)
    line.exchange(single(APWR, 0, OUTPUTS, b"\x11" * OUTPUT_BYTES))
    assert line.read(OUTPUTS, width=OUTPUT_BYTES) == 0x111111111111
    for _ in range(8):
        line.exchange(single(APWR, 0, OUTPUTS, b"\x22" * (OUTPUT_BYTES - 1)))
        line.run(10_000)
    assert line.read(OUTPUTS, width=OUTPUT_BYTES) == 0x111111111111
    assert line.read(esc_regmap.WATCHDOG_DATA_COUNT) == 1
    assert not alive(line)


def test_process_data__longer_than_the_manager_are_outputs_and_what_is_behind(line: Line):
    sync_manager(line, 2, OUTPUTS, OUTPUT_BYTES, managers.OUTPUTS)
    back = line.exchange(single(APWR, 0, OUTPUTS, b"\x33" * (OUTPUT_BYTES + 20)))
    assert answer(back.data, OUTPUT_BYTES + 20)[1] == 1
    assert line.read(OUTPUTS, width=OUTPUT_BYTES) == 0x333333333333


def test_lost__counter_of_the_master_stays_and_nothing_is_written():
    """A frame that the broken cable swallows: no answer, no counter of the slave after."""
    with Line([0.0, 0.0]) as line:
        line.cable(0, False)
        assert line.exchange(WRITE, limit_ns=30_000) is None
        line.cable(0, True)
        line.run(5000)
        assert line.read(MEMORY, width=4) == 0 and line.read(esc_regmap.LOST_LINKS_0) == 1
        assert answer(line.exchange(WRITE).data, 4)[1] == 1
