# SPDX-License-Identifier: Apache-2.0
"""Diagnosis history (10F3): what is noted, acknowledged, overwritten and dropped. Layout and modes:
ETG.1020, as device manuals publish them; numbers are read by the client of python-canopen.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import pytest

from sim.bus.coe import esi
from tests.ethercat.canopen_client import client_of
from tests.ethercat.host import BOOT, DEVICE, ERROR, INIT, OP, PREOP, AbortedError, Host
from tests.ethercat.test_foe import PASSWORD, Boot, RefusedError, file_of

TEXTS = {one.name: n for n, one in enumerate(DEVICE.diagnosis, start=1)}
NEWEST, ACKNOWLEDGED, AVAILABLE, FLAGS, FIRST, COUNT = 2, 3, 4, 5, 6, 16
INFO_OFF, WARNING_OFF, ERROR_OFF, KEEPS, LOST = 2, 4, 8, 0x10, 0x20
INFO, WARNING, FAILURE = range(3)
QUEUE = 32  # notes that the background has not entered yet, at most


@dataclass(frozen=True)
class Message:
    """A message as ETG.1020 lays it out, with two parameters."""

    text: int
    kind: int
    diagnosis: int
    word: int
    byte: int
    time: int

    @classmethod
    def read(cls, data: bytes) -> Message:
        found = struct.unpack("<IHHQHHHB", data)
        diagnosis, flags, text, time, word_type, word, byte_type, byte = found
        assert (flags >> 8, word_type, byte_type) == (2, 6, 5)
        return cls(text, flags & 0xF, diagnosis, word, byte, time)


@pytest.fixture
def host() -> Host:
    return Host().to_preop()


def refuse(host: Host, state: int = OP) -> None:
    """An AL error with code 0011, acknowledged."""
    now = host.status[0] & 0xF
    assert host.ask(state | ERROR) == (now | ERROR, 0x0011)
    assert host.ask(now | ERROR) == (now, 0)


def head(host: Host) -> tuple[int, int, int, int]:
    return tuple(host.get(0x10F3, sub) for sub in (NEWEST, ACKNOWLEDGED, AVAILABLE, FLAGS))


def newest(host: Host) -> Message:
    return Message.read(host.upload(0x10F3, host.get(0x10F3, NEWEST)))


def aborts(code: int) -> pytest.RaisesExc:
    return pytest.raises(AbortedError, check=lambda error: error.code == code)


def test_al_error__is_noted_with_code_state_and_time(host):
    assert head(host) == (0, 0, 0, 0)
    host.write(0x0910, struct.pack("<Q", 0x123456789ABCDEF0))
    refuse(host)
    client = client_of(host)
    assert client.upload(0x10F3, NEWEST) == bytes([FIRST])
    wanted = Message(TEXTS["AL_ERROR"], FAILURE, 0x0011E000, 0x11, PREOP, 0x123456789ABCDEF0)
    assert newest(host) == wanted
    assert client.upload(0x10F3, AVAILABLE) == b"\0"


def test_fault_of_an_axis__is_noted_once_and_its_reset_is_not():
    host = Host().to_op()
    host.feedback.axis[3].fault = 0x5441
    for _ in range(3):
        host.outputs()
        host.cycle()
    found = newest(host)
    assert (found.text, found.kind) == (TEXTS["AXIS_ERROR"], FAILURE)
    assert (found.diagnosis, found.word, found.byte) == (0x5441E800, 0x5441, 4)
    host.feedback.axis[3].fault = 0
    for control in (0, 0x80):
        host.outputs({(0x7840, 0): control})
        host.cycle(3)
    assert host.get(0x783F) == 0 and host.get(0x10F3, NEWEST) == FIRST


def test_watchdog__notes_the_state_and_every_axis():
    host = Host().to_op()
    host.cycle(1100)
    found = [Message.read(host.upload(0x10F3, FIRST + n)) for n in range(6)]
    assert host.get(0x10F3, NEWEST) == FIRST + 5
    assert [(m.text, m.word, m.byte) for m in found if m.text == TEXTS["AL_ERROR"]] == [
        (TEXTS["AL_ERROR"], 0x001A, OP)
    ]
    assert [m.byte for m in found if m.text == TEXTS["AXIS_ERROR"]] == [1, 2, 3, 4, 5]


def test_errors_outside_of_the_mailbox__are_read_later():
    host = Host()
    refuse(host, BOOT + 8 - 3)
    assert host.ask(INIT) == (INIT, 0)
    host.to_preop()
    assert (newest(host).word, newest(host).byte) == (0x0011, INIT)


def test_new_flag__falls_when_the_newest_is_read(host):
    refuse(host)
    refuse(host)
    assert head(host) == (FIRST + 1, 0, 1, 0)
    host.upload(0x10F3, FIRST)
    assert host.get(0x10F3, AVAILABLE) == 1
    host.upload(0x10F3, FIRST + 1)
    assert head(host) == (FIRST + 1, 0, 0, 0)


def test_overwrite_mode__the_oldest_goes_and_it_is_reported(host):
    for n in range(COUNT):
        host.write(0x0910, struct.pack("<Q", n))
        refuse(host)
    assert head(host) == (FIRST + COUNT - 1, 0, 1, 0)
    host.write(0x0910, struct.pack("<Q", 99))
    refuse(host)
    assert head(host) == (FIRST, 0, 1, LOST)
    times = [Message.read(host.upload(0x10F3, FIRST + n)).time for n in range(COUNT)]
    assert times == [99, *range(1, COUNT)]
    host.put(0x10F3, ACKNOWLEDGED, FIRST)
    assert head(host) == (FIRST, FIRST, 0, 0)
    for _ in range(COUNT):
        refuse(host)
    assert head(host) == (FIRST, 0, 1, 0)  # the acknowledged one was overwritten: nothing is lost


def test_acknowledge_mode__new_ones_are_dropped_until_room_is_made(host):
    host.put(0x10F3, FLAGS, KEEPS)
    for n in range(COUNT + 3):
        host.write(0x0910, struct.pack("<Q", n))
        refuse(host)
    assert head(host) == (FIRST + COUNT - 1, 0, 1, KEEPS | LOST)
    assert newest(host).time == COUNT - 1
    assert host.get(0x10F3, AVAILABLE) == 1  # reading is not enough
    host.put(0x10F3, ACKNOWLEDGED, FIRST + 4)
    assert head(host) == (FIRST + COUNT - 1, FIRST + 4, 1, KEEPS)
    host.put(0x10F3, ACKNOWLEDGED, FIRST + 2)  # it is already
    assert host.get(0x10F3, ACKNOWLEDGED) == FIRST + 4
    for _ in range(5):
        refuse(host)
    assert head(host) == (FIRST + 4, 0, 1, KEEPS)
    refuse(host)
    assert head(host) == (FIRST + 4, 0, 1, KEEPS | LOST)
    host.put(0x10F3, ACKNOWLEDGED, FIRST + 4)
    assert head(host) == (FIRST + 4, FIRST + 4, 0, KEEPS)


def test_more_than_the_queue_holds__is_reported_as_lost(host):
    """Notes of one control cycle, of a kind that is off, so that the history itself loses none."""
    host.put(0x10F3, FLAGS, ERROR_OFF)
    for count, flags in ((QUEUE, ERROR_OFF), (QUEUE + 1, ERROR_OFF | LOST)):
        for number in range(count):
            host.library.diagnosis_note(TEXTS["NOT_STORED"], number, 0)
        host.background()
        assert host.get(0x10F3, FLAGS) == flags


def test_full_queue__holds_the_first_notes(host):
    for number in range(QUEUE + 3):
        host.library.diagnosis_note(TEXTS["NOT_STORED"], number, 0)
    host.background()
    assert newest(host).word == QUEUE - 1


def test_zero__clears_the_history(host):
    for _ in range(3):
        refuse(host)
    host.put(0x10F3, ACKNOWLEDGED, 0)
    assert head(host) == (0, 0, 0, 0)
    assert host.upload(0x10F3, FIRST) == bytes(23)
    refuse(host)
    assert host.get(0x10F3, NEWEST) == FIRST


@pytest.mark.parametrize("subindex", [1, 5, FIRST + 1, FIRST + COUNT, 255])
def test_acknowledging_what_is_not_there__06090030(host, subindex):
    refuse(host)
    with aborts(0x06090030):
        host.put(0x10F3, ACKNOWLEDGED, subindex)
    assert head(host) == (FIRST, 0, 1, 0)


@pytest.mark.parametrize("flags", [1, LOST, 0x40, 0x8000])
def test_flags_that_are_not_to_be_written__06090030(host, flags):
    with aborts(0x06090030):
        host.put(0x10F3, FLAGS, flags)


def test_kinds_that_are_off__are_not_noted(host):
    host.put(0x10F3, FLAGS, ERROR_OFF)
    refuse(host)
    assert head(host) == (0, 0, 0, ERROR_OFF)
    host.put(0x10F3, FLAGS, INFO_OFF | WARNING_OFF)
    refuse(host)
    assert host.get(0x10F3, NEWEST) == FIRST


def test_damaged_parameters__are_a_warning(host):
    host.put(0x2021, 0, 1)
    host.download(0x1010, 1, b"save")
    host.library.flash_double_fail_after(1)
    with aborts(0x06060000):
        host.download(0x1010, 1, b"save")
    assert (newest(host).text, newest(host).kind) == (TEXTS["NOT_STORED"], FAILURE)
    boot = Boot()
    boot.ask(INIT)
    boot.to_preop()
    boot.download(0x1010, 1, b"save")
    boot.library.flash_double_content()[2 * 8192 + 20] ^= 1
    boot.power_on()
    boot.to_preop()
    found = newest(boot)
    assert (found.text, found.kind, found.byte) == (TEXTS["DAMAGED"], WARNING, 2)


def test_firmware__stored_is_an_info_and_refused_an_error():
    boot = Boot()
    boot.write_file(file_of(600))
    with pytest.raises(RefusedError):
        boot.write_file(file_of(600) + b"\0")
    with pytest.raises(RefusedError):
        boot.ask_file(2, PASSWORD + 1, b"firmware")  # nothing began
    boot.ask(INIT)
    boot.to_preop()
    found = [Message.read(boot.upload(0x10F3, FIRST + n)) for n in range(2)]
    assert [(m.text, m.kind, m.word) for m in found] == [
        (TEXTS["FIRMWARE"], INFO, 0),
        (TEXTS["NO_FIRMWARE"], FAILURE, 0x800C),
    ]
    assert boot.get(0x10F3, NEWEST) == FIRST + 1


def test_texts__are_in_the_esi_file_with_their_numbers():
    document = ET.fromstring(esi.document(DEVICE))
    found = {
        int(one.findtext("TextId").removeprefix("#x"), 16): one.findtext("MessageText")
        for one in document.iter("DiagMessage")
    }
    assert found == {n: one.text for n, one in enumerate(DEVICE.diagnosis, start=1)}
    assert all(text.count("%") == 2 for text in found.values())  # a word and a byte
