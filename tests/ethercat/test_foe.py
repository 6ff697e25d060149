# SPDX-License-Identifier: Apache-2.0
"""File access over EtherCAT and the firmware images in flash: transfers, every error code, lost
power, slow flash. Independent of us: zlib's CRC-32; pysoem, unmodified, at a TAP device.
"""

from __future__ import annotations

import ctypes as ct
import json
import random
import struct
import zlib

import pysoem
import pytest

from sim.bus.coe.firmware import firmware
from sim.bus.tap import in_namespace
from tests.bench.needs import needs
from tests.ethercat.host import BOOT, DEVICE, INIT, Host

READ, WRITE, DATA, ACK, ERROR, BUSY = range(1, 7)
ROOM = 244  # of a packet
IMAGE = 8192  # FLASH_IMAGE_BYTES
LARGEST = IMAGE - 32  # content: two headers of 16 bytes
PASSWORD = DEVICE.mailbox["foe_password"]
PRODUCT = DEVICE.device["product"]
SEED = 20


def file_of(size: int, seed: int = SEED) -> bytes:
    return firmware(random.Random(seed).randbytes(size), PRODUCT)


class RefusedError(Exception):
    """The server sent ERR; `code`."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(f"{code:04X}")


class Boot(Host):
    """A device in BOOT, and a client of FoE."""

    def __init__(self) -> None:
        super().__init__()
        self.library.flash_double_content.restype = ct.POINTER(ct.c_uint8)
        self.to_boot()

    def restart(self) -> None:
        self.power_on()
        self.to_boot()

    def ask_file(self, code: int, value: int, data: bytes = b"", wait: int = 60) -> tuple:
        """A message, and the answer's code, value and data; None if none comes in `wait` passes."""
        assert self.send(struct.pack("<BxI", code, value) + data, kind=4)
        return self.answer(wait)

    def answer(self, wait: int = 60) -> tuple:
        for _ in range(wait):
            self.background()
            if message := self.receive():
                kind, found = message
                assert kind == 4, message
                code, value = struct.unpack_from("<BxI", found)
                if code == ERROR:
                    raise RefusedError(value)
                return code, value, found[6:]
        return None

    def write_file(self, data: bytes, name: bytes = b"firmware", password: int = PASSWORD) -> None:
        assert self.ask_file(WRITE, password, name) == (ACK, 0, b"")
        for packet in range(len(data) // ROOM + 1):
            part = data[packet * ROOM : (packet + 1) * ROOM]
            assert self.ask_file(DATA, packet + 1, part) == (ACK, packet + 1, b"")

    def read_file(self, name: bytes = b"firmware", password: int = PASSWORD) -> bytes:
        code, packet, part = self.ask_file(READ, password, name)
        found = part
        while len(part) == ROOM:
            assert (code, packet) == (DATA, len(found) // ROOM)
            code, packet, part = self.ask_file(ACK, packet)
            found += part
        assert (code, packet) == (DATA, len(found) // ROOM + 1)
        assert self.ask_file(ACK, packet, wait=2) is None
        return found


@pytest.fixture
def boot() -> Boot:
    return Boot()


def refuses(code: int) -> pytest.RaisesExc:
    """A context that must end with this error code."""
    return pytest.raises(RefusedError, check=lambda error: error.code == code)


# -------------------------------------------------------------------- transfers


@pytest.mark.parametrize("size", [0, 1, 227, 228, 229, 472, 3000, LARGEST])
def test_image__comes_back_as_it_went_also_after_power_off(boot, size):
    file = file_of(size)
    boot.write_file(file)
    assert boot.read_file() == file
    boot.restart()
    assert boot.read_file() == file


def test_images__the_newest_of_many_counts(boot):
    for number in range(5):
        file = file_of(1000 + number, number)
        boot.write_file(file)
        assert boot.read_file() == file
        boot.restart()
        assert boot.read_file() == file


def test_packet_sent_again__is_acknowledged_again_and_stored_once(boot):
    file = file_of(500)
    parts = [file[at : at + ROOM] for at in range(0, len(file), ROOM)]
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    for number, part in enumerate(parts, start=1):
        for _ in range(3):
            assert boot.ask_file(DATA, number, part) == (ACK, number, b"")
    assert boot.read_file() == file


def test_read__packet_is_sent_again_when_its_predecessor_is_acknowledged_or_the_master_is_busy(
    boot,
):
    file = file_of(600)
    boot.write_file(file)
    boot.ask_file(READ, PASSWORD, b"firmware")
    second = (DATA, 2, file[ROOM : 2 * ROOM])
    assert boot.ask_file(ACK, 1) == second
    assert boot.ask_file(ACK, 1) == second
    assert boot.ask_file(BUSY, 0) == second
    assert boot.ask_file(ACK, 2) == (DATA, 3, file[2 * ROOM :])


def test_name_with_zeros_after_it__is_the_same_name(boot):
    boot.write_file(file_of(10), name=b"firmware\0\0")
    assert boot.read_file(name=b"firmware\0") == file_of(10)


def test_new_request__ends_a_transfer(boot):
    old, new = file_of(700, 1), file_of(900, 2)
    boot.write_file(old)
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    boot.ask_file(DATA, 1, new[:ROOM])
    assert boot.read_file() == old
    boot.write_file(new)
    assert boot.read_file() == new


def test_error_of_the_master__ends_a_transfer_without_an_answer(boot):
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    assert boot.ask_file(ERROR, 0x8000, wait=2) is None
    with refuses(0x8004):
        boot.ask_file(DATA, 1, file_of(10))


# -------------------------------------------------------------------- error codes


def test_wrong_name__8001(boot):
    for name in (b"", b"firm", b"firmware.bin", b"x" * ROOM):
        with refuses(0x8001):
            boot.ask_file(WRITE, PASSWORD, name)
        with refuses(0x8001):
            boot.ask_file(READ, PASSWORD, name)


@pytest.mark.parametrize("size", [LARGEST + 1, 2**32 - 1])
def test_image_beyond_its_place__8003(boot, size):
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    with refuses(0x8003):
        boot.ask_file(DATA, 1, struct.pack("<4s3I", b"MTFW", PRODUCT, size, 0) + bytes(228))


@pytest.mark.parametrize("code", [0, DATA, ACK, BUSY, 7, 255])
def test_message_without_its_transfer__8004(boot, code):
    with refuses(0x8004):
        boot.ask_file(code, 1, b"")


@pytest.mark.parametrize("packet", [0, 3, 2**32 - 1])
def test_wrong_packet__8005_and_the_transfer_ends(boot, packet):
    file = file_of(600)
    boot.write_file(file)
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    boot.ask_file(DATA, 1, file[:ROOM])
    with refuses(0x8005):
        boot.ask_file(DATA, packet, file[ROOM : 2 * ROOM])
    with refuses(0x8004):
        boot.ask_file(DATA, 2, file[ROOM : 2 * ROOM])
    boot.ask_file(READ, PASSWORD, b"firmware")
    with refuses(0x8005):
        boot.ask_file(ACK, packet + 4 & 0xFFFFFFFF)


def test_packet_after_the_last__8005(boot):
    boot.write_file(file_of(100))
    with refuses(0x8005):
        boot.ask_file(DATA, 2, b"")
    assert boot.read_file() == file_of(100)


def test_firmware_outside_of_boot__8008():
    host = Boot()
    host.ask(INIT)
    host.to_preop()
    for code in (READ, WRITE):
        with refuses(0x8008):
            host.ask_file(code, PASSWORD, b"firmware")
    assert host.get(0x1000) == 0xFFFF0192  # CoE goes on


@pytest.mark.parametrize("password", [0, PASSWORD + 1])
def test_wrong_password__800a(boot, password):
    for code in (READ, WRITE):
        with refuses(0x800A):
            boot.ask_file(code, password, b"firmware")


def damaged(file: bytes, at: int) -> bytes:
    return file[:at] + bytes([file[at] ^ 1]) + file[at + 1 :]


def saying(size: int, file: bytes) -> bytes:
    """The file with another size in its header; the check sum is that of the content."""
    return file[:8] + struct.pack("<I", size) + file[12:]


BROKEN = {
    "content": (0x800C, damaged(file_of(600), 500)),
    "check sum": (0x800C, damaged(file_of(600), 12)),
    "too short": (0x800C, file_of(600)[:-1]),
    "too long": (0x800C, file_of(600) + b"\0"),
    "fewer bytes than said": (0x800C, saying(601, file_of(600))),
    "product": (0x800D, firmware(bytes(600), PRODUCT + 1)),
    "magic": (0x8010, damaged(file_of(600), 0)),
    "no header": (0x8010, b"MTFW"),
    "empty": (0x8010, b""),
}


@pytest.mark.parametrize("what", BROKEN)
def test_broken_file__is_refused_and_the_former_image_stays(boot, what):
    code, file = BROKEN[what]
    with refuses(0x800F):
        boot.read_file()
    boot.write_file(file_of(300, 1))
    with refuses(code):
        boot.write_file(file)
    assert boot.read_file() == file_of(300, 1)
    boot.restart()
    assert boot.read_file() == file_of(300, 1)


def test_flash_that_fails_or_forgets__8011_and_the_former_image_stays(boot):
    old, new = file_of(3000, 1), file_of(3000, 2)
    boot.write_file(old)
    before = boot.library.flash_double_operations()
    boot.write_file(new)
    operations = boot.library.flash_double_operations() - before
    assert operations == 2 + 13 + 1  # sectors, packets, the record
    boot.write_file(old)
    for number in range(operations):
        boot.library.flash_double_fail_after(number)
        with refuses(0x8011):
            boot.write_file(new)
        assert boot.read_file() == old
    # A bit that was programmed is lost before the check.
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    for packet in range(12):
        boot.ask_file(DATA, packet + 1, new[packet * ROOM : (packet + 1) * ROOM])
    place = [n for n in range(2) if bytes(boot.library.flash_double_content()[
        n * IMAGE + 32 : n * IMAGE + 40]) == new[16:24]]  # fmt: skip
    boot.library.flash_double_content()[place[0] * IMAGE + 100] ^= 1
    with refuses(0x8011):
        boot.ask_file(DATA, 13, new[12 * ROOM :])
    assert boot.read_file() == old


# -------------------------------------------------------------------- power and time


def test_power_lost_in_any_operation__the_former_or_the_new_image_counts(boot):
    old, new = file_of(3000, 1), file_of(2500, 2)
    boot.write_file(old)
    counted = []
    for number in range(2 + 11 + 1):
        boot.library.flash_double_cut_after(number)
        with pytest.raises((AssertionError, RefusedError)):
            boot.write_file(new)
        boot.restart()
        counted.append(boot.read_file())
    assert counted == [old] * len(counted)
    boot.write_file(new)
    boot.restart()
    assert boot.read_file() == new


def test_damage_of_the_newest_image__the_former_counts_after_power_off(boot):
    old, new = file_of(700, 1), file_of(700, 2)
    boot.write_file(old)
    boot.write_file(new)
    content = boot.library.flash_double_content()
    (place,) = (
        n * IMAGE for n in range(2) if bytes(content[n * IMAGE + 16 : n * IMAGE + 716]) == new[:700]
    )
    content[place + 500] ^= 1
    boot.restart()
    assert boot.read_file() == old


def test_transfer_broken_by_leaving_boot__former_image_and_the_next_transfer_are_right(boot):
    old, new = file_of(1000, 1), file_of(1000, 2)
    boot.write_file(old)
    boot.library.flash_double_slow(50)
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    boot.send(struct.pack("<BxI", DATA, 1) + new[:ROOM], kind=4)
    boot.library.application_background()
    assert boot.ask(INIT) == (INIT, 0)
    boot.to_preop()
    boot.ask(INIT)
    boot.to_boot()
    boot.write_file(new)
    assert boot.read_file() == new


def test_slow_flash__busy_after_100_ms_and_the_packet_sent_again_is_acknowledged(boot):
    file = file_of(600)
    boot.library.flash_double_slow(5000)
    answers = []
    for code, value, data in (
        (WRITE, PASSWORD, b"firmware"),
        (DATA, 1, file[:ROOM]),
        (DATA, 2, file[ROOM : 2 * ROOM]),
        (DATA, 3, file[2 * ROOM :]),
    ):
        for _ in range(20):
            assert boot.send(struct.pack("<BxI", code, value) + data, kind=4)
            cycles, message = 0, None
            while not message and cycles < 2000:
                boot.cycle()
                cycles, message = cycles + 1, boot.receive()
            kind, found = message
            assert kind == 4
            answers.append(found[0])
            if found[0] == BUSY:
                assert 990 <= cycles <= 1020  # 100 ms
            else:
                assert found == struct.pack("<BxI", ACK, value if code == DATA else 0)
                break
    assert answers.count(ACK) == 4 and answers.count(BUSY) >= 4
    boot.library.flash_double_slow(0)
    assert boot.read_file() == file


def test_background__never_waits_for_the_flash(boot):
    """Each pass asks the flash once, and checks no more than a part of an image."""
    boot.library.flash_double_slow(3)
    boot.ask_file(WRITE, PASSWORD, b"firmware")
    file = file_of(LARGEST)
    before = boot.library.flash_double_operations()
    boot.send(struct.pack("<BxI", DATA, 1) + file[:ROOM], kind=4)
    for _ in range(3):
        boot.library.application_background()
    assert boot.library.flash_double_operations() - before <= 1


def test_crc32__is_that_of_zlib(boot):
    boot.library.crc32.restype = ct.c_uint32
    rng = random.Random(SEED)
    assert boot.library.crc32(0, b"123456789", 9) == 0xCBF43926
    for size in (0, 1, 2, 255, 1000):
        data, start = rng.randbytes(size), rng.getrandbits(32)
        assert boot.library.crc32(ct.c_uint32(start), data, size) == zlib.crc32(data, start)


def test_short_message__gets_a_mailbox_error(boot):
    boot.send(b"\1\0\0\0\0", kind=4)
    boot.background()
    assert boot.receive() == (0, struct.pack("<HH", 1, 6))
    assert boot.status == (BOOT, 0)


@needs("tap")
def test_pysoem__identifies_the_device_and_writes_and_reads_its_firmware():
    Host()  # built here: the master's clock runs in the other process
    done = in_namespace("tests.ethercat.pysoem_services", [], timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads(done.stdout)
    assert report["found"] == 1 and report["identify"] == [0x22, 0x1234]
    assert report["boot"] == {
        "preop_to_boot": [0x12, 0x0011],
        "init": pysoem.INIT_STATE,
        "boot": pysoem.BOOT_STATE,
        "written": True,
        "read_back": True,
        **dict.fromkeys(("other_device", "password", "name"), -5) | {"name": -10},
        "still_there": True,
        "init_again": pysoem.INIT_STATE,
        "preop": pysoem.PREOP_STATE,
        "device_type": "9201ffff",
    }
