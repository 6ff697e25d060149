# SPDX-License-Identifier: Apache-2.0
"""Stored parameters: objects 1010 and 1011, power lost and damage of the flash.

Independent of us: python-canopen writes the signatures; its dictionary is not used.
"""

from __future__ import annotations

import ctypes as ct
import struct

import pytest

from tests.ethercat.canopen_client import client_of
from tests.ethercat.host import DEVICE, INIT, AbortedError, Host

SAVE, LOAD = b"save", b"load"
STORE, SECTOR, HEADER, RECORD = 2 * 8192, 2048, 16, 8  # as in flash.h, parameters.c
STORED = [(one.index, entry) for one in DEVICE.objects for entry in one.entries if entry.stored]
NONE, LOADED, DAMAGED, FORMER, PARTLY = range(5)


@pytest.fixture
def host() -> Host:
    return Host().to_preop()


def aborts(code: int) -> pytest.RaisesExc:
    """A context that must end with this abort code."""
    return pytest.raises(AbortedError, check=lambda error: error.code == code)


def other(entry) -> float:
    """A value that is allowed and is not the default."""
    if entry.values:
        return next(v for v in entry.values if v != entry.default)
    low, high = entry.limits or (0, 100)
    return next(v for v in (low, low + 1, 5) if v != entry.default and low <= v <= high)


def restart(host: Host) -> None:
    host.power_on()
    host.to_preop()


def save(host: Host) -> None:
    host.download(0x1010, 1, SAVE)


def content(host: Host) -> ct.Array:
    host.library.flash_double_content.restype = ct.POINTER(ct.c_uint8)
    return host.library.flash_double_content()


def test_every_marked_entry__is_there_after_power_off_and_no_other(host):
    assert {0x2000, 0x2001, 0x2002, 0x607D, 0x607F, 0x605A} <= {index for index, _ in STORED}
    assert HEADER + RECORD * len(STORED) <= SECTOR
    # 607D: the limit first that keeps the pair in order; 60C2: the value is 100 us at least.
    for index, entry in STORED:
        host.put(index, entry.subindex, other(entry) if index & 0x7FF != 0xC2 else entry.default)
    host.put(0x60C2, 1, 250)
    host.put(0x60C2, 2, -6)
    host.put(0x607A, 0, 77)
    save(host)
    before = {key: host.upload(*key) for key in ((i, e.subindex) for i, e in STORED)}
    restart(host)
    assert {key: host.upload(*key) for key in before} == before
    assert host.get(0x60C2, 1) == 250 and host.get(0x607A) == 0 and host.get(0x2022) == LOADED


def test_many_stores__the_newest_counts(host):
    for value in range(1, 6):
        host.put(0x2021, 0, value)
        save(host)
        restart(host)
        assert (host.get(0x2021), host.get(0x2022)) == (value, LOADED)


def test_loaded_gains__go_to_the_law(host):
    for n in range(5):
        for index in (0x2000, 0x2001, 0x2002):
            host.put(index, n + 1, n + 1.5)
    save(host)
    restart(host)
    given = {}
    for _ in range(20):
        host.cycle()
        given[host.command.setting_index, host.command.setting_subindex] = (
            host.command.setting_value
        )
    wanted = {(index, n + 1): n + 1.5 for n in range(5) for index in (0x2000, 0x2001, 0x2002)}
    assert given == wanted


def test_canopen__saves_and_restores(host):
    client = client_of(host)
    assert client.upload(0x1010, 1) == client.upload(0x1011, 1) == struct.pack("<I", 1)
    client.download(0x2021, 0, struct.pack("<H", 9))
    client.download(0x1010, 1, SAVE)
    assert client.upload(0x1010, 1) == struct.pack("<I", 1)
    restart(host)
    assert host.get(0x2021) == 9
    client.download(0x1011, 1, LOAD)
    assert host.get(0x2021) == 9  # until power off
    restart(host)
    assert host.get(0x2021) == 0 and host.get(0x2022) == NONE


@pytest.mark.parametrize(
    ("index", "signature"), [(0x1010, LOAD), (0x1010, b"SAVE"), (0x1011, SAVE), (0x1011, bytes(4))]
)
def test_wrong_signature__08000020_and_nothing_is_done(host, index, signature):
    host.put(0x2021, 0, 9)
    save(host)
    operations = host.library.flash_double_operations()
    with aborts(0x08000020):
        host.download(index, 1, signature)
    assert host.library.flash_double_operations() == operations
    restart(host)
    assert host.get(0x2021) == 9


def test_signature_of_wrong_length__06070010(host):
    with aborts(0x06070010):
        host.download(0x1010, 1, b"sav")


def test_failing_flash__06060000_and_the_former_values_stay(host):
    host.put(0x2021, 0, 1)
    save(host)
    operations = host.library.flash_double_operations()
    for number in range(operations):
        host.put(0x2021, 0, 2)
        host.library.flash_double_fail_after(number)
        with aborts(0x06060000):
            save(host)
        restart(host)
        assert (host.get(0x2021), host.get(0x2022)) == (1, LOADED)


def test_power_lost_in_any_operation__former_or_new_values_count(host):
    host.put(0x2021, 0, 1)
    save(host)
    operations = host.library.flash_double_operations()
    for index, signature, count in ((0x1010, SAVE, operations), (0x1011, LOAD, 2)):
        for number in range(count):
            host.put(0x2021, 0, 2)
            host.library.flash_double_cut_after(number)
            host.send(struct.pack("<HBHB", 2 << 12, 0x23, index, 1) + signature)
            for _ in range(3 * operations):
                host.background()
            assert host.receive() is None  # no confirmation of what is not done
            restart(host)
            wanted = (1, LOADED)
            if signature == SAVE and number == count - 1:
                wanted = (1, FORMER)  # half of a header
            elif signature == LOAD and number == 1:
                wanted = (0, NONE)  # the present ones are erased last
            assert (host.get(0x2021), host.get(0x2022)) == wanted


def test_damage__defaults_or_the_former_values_and_it_is_reported(host):
    host.put(0x2021, 0, 1)
    save(host)
    host.put(0x2021, 0, 2)
    save(host)
    size = HEADER + RECORD * len(STORED)
    for at in (*range(4, 20), size - 1):
        content(host)[STORE + SECTOR + at] ^= 4
        restart(host)
        assert (host.get(0x2021), host.get(0x2022)) == (1, FORMER), at
        content(host)[STORE + SECTOR + at] ^= 4
    content(host)[STORE + SECTOR + 40] ^= 1
    content(host)[STORE + 40] ^= 1
    restart(host)
    assert (host.get(0x2021), host.get(0x2022)) == (0, DAMAGED)
    host.put(0x2021, 0, 3)
    save(host)
    restart(host)
    assert host.get(0x2021) == 3


def test_value_that_is_not_allowed_any_more__is_the_default_and_is_reported(host):
    """605A of the third axis as another program may have stored it; the check sum is right."""
    host.put(0x705A, 0, 5)
    host.put(0x2021, 0, 1)
    save(host)
    library, at = host.library, STORE + HEADER
    library.crc32.restype = ct.c_uint32
    for n in range(len(STORED)):
        place = at + RECORD * n
        if bytes(content(host)[place : place + 3]) == struct.pack("<HB", 0x705A, 0):
            content(host)[place + 4] = 7
    number_and_count = bytes(content(host)[STORE + 4 : STORE + 12])
    records = bytes(content(host)[at : at + RECORD * len(STORED)])
    total = library.crc32(library.crc32(0, records, len(records)), number_and_count, 8)
    for n, byte in enumerate(struct.pack("<I", total & 0xFFFFFFFF)):
        content(host)[STORE + 12 + n] = byte
    restart(host)
    assert (host.get(0x705A), host.get(0x2021), host.get(0x2022)) == (2, 1, PARTLY)


def test_slow_flash__the_mailbox_serves_others_and_a_second_save_waits_its_turn(host):
    host.put(0x2021, 0, 1)
    host.library.flash_double_slow(50)
    host.send(struct.pack("<HBHB", 2 << 12, 0x23, 0x1010, 1) + SAVE)
    host.background()
    assert host.receive() is None  # not stored yet
    assert host.get(0x1000) == 0xFFFF0192
    with aborts(0x08000022):
        save(host)
    for _ in range(2000):
        host.background()
    host.library.flash_double_slow(0)
    restart(host)
    assert host.get(0x2021) == 1


def test_left_for_init_while_it_stores__is_stored_all_the_same(host):
    host.put(0x2021, 0, 1)
    host.library.flash_double_slow(50)
    host.send(struct.pack("<HBHB", 2 << 12, 0x23, 0x1010, 1) + SAVE)
    host.background()
    assert host.ask(INIT) == (INIT, 0)
    for _ in range(2000):
        host.background()
    restart(host)
    assert host.get(0x2021) == 1


def test_whole_object__saves_too(host):
    host.put(0x2021, 0, 4)
    host.download(0x1010, 1, SAVE, complete=True)
    with pytest.raises(AbortedError):
        host.download(0x1010, 1, LOAD, complete=True)
    restart(host)
    assert host.get(0x2021) == 4
