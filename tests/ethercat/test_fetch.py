# SPDX-License-Identifier: Apache-2.0
"""The port of the application: fetches into its window, writes that are answered early."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import pytest

from sim.bus.datagram import answer
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from tests.bench.seed import SEED
from tests.ethercat import managers
from tests.ethercat.frames import MEMORY, Datagram, Fmmu, frame

WINDOW, START = 0x4000, 0x4200
SIZES = (1, 2, 3, 4, 5, 8, 9, 101, 512)
LOGICAL = 0x10000


@pytest.fixture(params=[False, True], ids=["quiet", "frames pass"])
def line(request) -> Iterator[Line]:
    """With frames: one FMMU is in use, and logical bytes pass during the whole test."""
    with Line() as line:
        if request.param:
            fmmu = Fmmu(LOGICAL, 1, 0, 7, MEMORY + 0x1FFF, 0, True, False)
            at = esc_regmap.FMMU_LOGICAL_START.at(0)
            line.exchange(frame([Datagram(2, fmmu.registers(), 0, at)]))
            for _ in range(20):
                line.send(frame([Datagram(10, bytes(1400), logical=LOGICAL)]))
            line.run(20_000)
        yield line


def fetch(line: Line, address: int, count: int) -> None:
    line.write(START, address | count << 16, width=4)


def window(line: Line, count: int) -> bytes:
    """The first bytes of the window, by whole words."""
    words = range(WINDOW, WINDOW + count, 4)
    return b"".join(line.read(at, width=4).to_bytes(4, "little") for at in words)[:count]


def put(line: Line, address: int, data: bytes) -> None:
    line.write(address, int.from_bytes(data, "little"), width=len(data))


def get(line: Line, address: int, count: int) -> bytes:
    return line.read(address, width=count).to_bytes(count, "little")


@pytest.mark.parametrize("size", SIZES)
def test_fetch__window_has_the_bytes(line, size):
    random = Random(f"{SEED} {size}")
    data = random.randbytes(size + 16)
    put(line, MEMORY, data)
    for offset in (0, 4, 12):
        fetch(line, MEMORY + offset, size)
        assert window(line, size) == data[offset : offset + size]
        assert get(line, MEMORY, 5) == data[:5]


@pytest.mark.parametrize("size", [1, 4, 5, 64, 512])
def test_access__waits_for_the_end_of_a_fetch(line, size):
    data = Random(f"{SEED} {size}").randbytes(size)
    put(line, MEMORY, data)
    fetch(line, MEMORY, size)
    put(line, MEMORY, bytes(size))  # what was ordered before has the old bytes
    assert window(line, size) == data
    assert get(line, MEMORY, size) == bytes(size)


@pytest.mark.parametrize("size", [0, 513, 1023])
def test_wrong_size__fetches_nothing(line, size):
    put(line, MEMORY, bytes(range(8)))
    fetch(line, MEMORY, 8)
    put(line, MEMORY, bytes(8))
    fetch(line, MEMORY, size)
    assert window(line, 8) == bytes(range(8))


@pytest.mark.parametrize("width", [1, 2, 4])
def test_read__after_a_write_gives_what_was_written(line, width):
    """A write is answered before it is done."""
    random = Random(f"{SEED} {width}")
    for _ in range(100):
        at = MEMORY + 4 * random.randrange(4) + width * random.randrange(4 // width)
        data = random.randbytes(width)
        line.order(at, int.from_bytes(data, "little"), width)
        assert get(line, at, width) == data


@pytest.mark.parametrize("address", [START + 2, START + 4, 0x4400, 0x7F80])
def test_order__of_a_part_or_at_another_address_fetches_nothing(line, address):
    put(line, MEMORY, bytes(range(8)))
    fetch(line, MEMORY, 8)
    put(line, MEMORY, bytes(8))
    width = 2 if address % 4 else 4
    line.write(address, (MEMORY | 8 << 16) >> 8 * (4 - width), width=width)
    assert window(line, 8) == bytes(range(8))


def test_mailbox__repeated_right_after_its_manager_was_switched__is_whole():
    """A register acts some clocks after its byte went in. Off and on empty a mailbox; the writes to
    its memory come without a pause."""
    manager = managers.registers(MEMORY, 16, managers.BOX_IN)
    off, on = (esc_regmap.SM_PDI.word(disable=bit) for bit in (1, 0))
    with Line() as line:
        line.exchange(frame([Datagram(2, manager, 0, esc_regmap.SM_START.at(1))]))
        put(line, MEMORY, bytes(16))
        data = bytes(range(100, 116))
        line.order(esc_regmap.SM_PDI.at(1), off, 1)
        line.order(esc_regmap.SM_PDI.at(1), on, 1)
        for at in range(0, 16, 4):
            line.order(MEMORY + at, int.from_bytes(data[at : at + 4], "little"), 4)
        line.run(2000)
        back = line.exchange(frame([Datagram(1, bytes(16), 0, MEMORY)]))
        assert answer(back.data, 16) == (int.from_bytes(data, "little"), 1)


def test_outputs__the_newest_buffer_is_taken_and_the_event_goes():
    """An area of a sync manager is opened by its first byte and closed by its last."""
    with Line() as line:
        manager = managers.registers(MEMORY, 101, managers.OUTPUTS)
        line.exchange(frame([Datagram(2, manager, 0, esc_regmap.SM_START.at(2))]))
        for n in (1, 2):
            data = bytes((n + k) % 256 for k in range(101))
            line.exchange(frame([Datagram(2, data, 0, MEMORY)]))
        event = esc_regmap.AL_EVENT.word(sm=4)
        assert line.read(esc_regmap.AL_EVENT) & event
        fetch(line, MEMORY, 101)
        assert window(line, 101) == data
        assert not line.read(esc_regmap.AL_EVENT) & event


def test_time__of_a_fetch_is_a_byte_a_clock_and_of_a_write_a_few_more():
    with Line() as line:
        fetch(line, MEMORY, 512)
        before = line.clocks()
        line.read(WINDOW + 508, width=4)
        assert line.clocks() - before <= 512 + 20
        before = line.clocks()
        put(line, MEMORY, bytes(512))
        assert line.clocks() - before <= 128 * 10
