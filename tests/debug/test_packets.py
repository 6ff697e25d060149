# SPDX-License-Identifier: Apache-2.0
"""Packets of the debug block: frames, CRC, samples, damaged input."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.debug import packets
from sim.debug.link import Responder
from sim.debug.packets import ErrorCode, Packet, Type

bodies = st.binary(max_size=packets.LARGEST - 4) | st.lists(
    st.sampled_from([0, 1, 255]), max_size=packets.LARGEST - 4
).map(bytes)
packet_of = st.builds(Packet, st.integers(0, 255), st.integers(0, 255), bodies)


def test_crc__check_value__is_that_of_the_catalogue() -> None:
    """CRC-16/IBM-3740 (alias CCITT-FALSE) of "123456789" is 0x29b1 in G. Cook's catalogue."""
    frame = packets.encode(Packet(ord("1"), ord("2"), b"3456789"))
    assert packets.cobs_decode(frame[:-1])[-2:] == bytes.fromhex("29b1")


@pytest.mark.parametrize(
    ("data", "coded"),
    [
        ("00", "0101"),
        ("0000", "010101"),
        ("11220033", "0311220233"),
        ("11000000", "0211010101"),
        ("01" * 254, "ff" + "01" * 254),
    ],
)
def test_cobs__examples_of_the_article__have_their_bytes(data: str, coded: str) -> None:
    assert packets.cobs_encode(bytes.fromhex(data)).hex() == coded
    assert packets.cobs_decode(bytes.fromhex(coded)).hex() == data


@given(st.lists(packet_of, max_size=5), st.integers(1, 40))
def test_decoder__stream_in_pieces__gives_the_packets(sent: list[Packet], piece: int) -> None:
    stream = b"".join(packets.encode(packet) for packet in sent)
    decoder = packets.Decoder()
    got = [p for at in range(0, len(stream), piece) for p in decoder.feed(stream[at : at + piece])]
    assert (got, decoder.dropped) == (sent, 0)


@given(packet_of, st.data())
def test_decoder__one_bit_wrong__drops_the_frame_and_reads_the_next(packet, data) -> None:
    frame = bytearray(packets.encode(packet))
    bit = data.draw(st.integers(0, 8 * len(frame) - 9))
    frame[bit // 8] ^= 1 << bit % 8
    decoder = packets.Decoder()
    after = Packet(Type.READ_DONE, 9, b"abcd")
    got = list(decoder.feed(bytes(frame) + packets.encode(after)))
    assert got == [after] and decoder.dropped >= 1


def test_decoder__endless_garbage__keeps_bounded_memory() -> None:
    decoder = packets.Decoder()
    for _ in range(1000):
        assert not list(decoder.feed(b"\x55" * 1000))
    assert decoder.dropped == 1 and len(decoder._rest) <= 1000
    after = Packet(Type.WRITE_DONE, 1)
    assert list(decoder.feed(b"\0" + packets.encode(after))) == [after]


words = st.integers(0, 2**32 - 1) | st.sampled_from([0, 1, 0x3F800000, 0x3F800001, 0xFFFFFFFF])


@given(st.integers(1, 8), st.integers(0, 2**32 - 1), st.data())
def test_samples__any_records__come_back_bit_for_bit(channels, first, data) -> None:
    record = st.tuples(*[words] * channels)
    records = data.draw(st.lists(record, min_size=1, max_size=7))
    assert packets.samples(packets.samples_body(first, records)) == (first, records)


def test_samples__cut_anywhere__is_an_error_or_whole_records() -> None:
    records = [(n * 0x01010101, 0x3F800000 + n) for n in range(5)]
    body = packets.samples_body(7, records)
    for length in range(len(body)):
        try:
            _, got = packets.samples(body[:length])
        except packets.PacketError:
            continue
        assert got == records[: len(got)] and len(got) < len(records)


class _Memory:
    def __init__(self) -> None:
        self.words: dict[int, int] = {}
        self.writes = 0

    def read(self, address: int) -> int:
        return self.words.get(address, 0)

    def write(self, address: int, data: int) -> None:
        self.words[address] = data
        self.writes += 1

    def clock(self, cycles: int = 1) -> None: ...


def test_responder__write_sent_again__is_carried_out_once() -> None:
    memory = _Memory()
    responder = Responder(memory)
    write = Packet(Type.WRITE, 5, packets.write_body(0x100, [1, 2, 3]))
    assert responder.answer(write) == responder.answer(write) == Packet(Type.WRITE_DONE, 5)
    assert memory.writes == 3
    read = responder.answer(Packet(Type.READ, 6, packets.read_body(0x100, 3)))
    assert packets.unpack_words(read.body) == (1, 2, 3)
    # The number of a write that is not the last request is a new request.
    assert responder.answer(write) == Packet(Type.WRITE_DONE, 5) and memory.writes == 6


@pytest.mark.parametrize(
    ("kind", "body", "code"),
    [
        (0x33, b"", ErrorCode.TYPE),
        (Type.READ, b"\0\0", ErrorCode.LENGTH),
        (Type.READ, b"\0\0\0", ErrorCode.LENGTH),
        (Type.READ, b"\0\0\x3d", ErrorCode.LENGTH),
        (Type.WRITE, b"\0\0", ErrorCode.LENGTH),
        (Type.WRITE, b"\0\0abcde", ErrorCode.LENGTH),
        (Type.WRITE, b"\0\0" + 9 * b"abcd", ErrorCode.LENGTH),
    ],
)
def test_responder__bad_request__is_an_error(kind: int, body: bytes, code: ErrorCode) -> None:
    answer = Responder(_Memory()).answer(Packet(kind, 3, body))
    assert answer == Packet(Type.ERROR, 3, bytes([code]))
