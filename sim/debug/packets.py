# SPDX-License-Identifier: Apache-2.0
"""Packets between a host and the debug block (docs/debug_block.md): frames, CRC, contents.

A frame is a packet in COBS (S. Cheshire, M. Baker: Consistent Overhead Byte Stuffing, IEEE/ACM
Trans. Networking 7(2), 1999) and a zero byte. A packet is type, sequence number, body, and
the CRC-16 of these (polynomial 0x1021, initial value 0xffff, high byte first), at most LARGEST
bytes, so that COBS adds one. Numbers in bodies are little-endian.
"""

from __future__ import annotations

import binascii
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum

from sim.rtl.asip_bus import AsipError

LARGEST = 254
"""Bytes of a packet with its CRC."""
READ_WORDS = 60
"""Words that one READ may ask for."""
WRITE_WORDS = 8
"""Words that one WRITE may carry."""
ANSWER = 0x80
CRC_START = 0xFFFF
SAMPLE_BYTES = (0, 2, 3, 4)
"""Bytes of a sample's difference, by its code of two bits."""
FULLEST = 218
"""Bytes of a packet of samples to which the block adds a record more."""


class Type(IntEnum):
    """First byte of a packet."""

    READ = 0x01
    WRITE = 0x02
    READ_DONE = READ | ANSWER
    WRITE_DONE = WRITE | ANSWER
    SAMPLES = 0xC0
    EVENT = 0xC1
    ERROR = 0xFF


class ErrorCode(IntEnum):
    """Body of an ERROR packet: what was wrong with the request."""

    TYPE = 1
    LENGTH = 2


class PacketError(AsipError, ValueError):
    """Bytes that are no packet."""


@dataclass(frozen=True)
class Packet:
    """A packet without its CRC. `sequence` of an answer is that of its request."""

    type: int
    sequence: int
    body: bytes = b""


@dataclass(frozen=True)
class Event:
    """Words of STATUS, PLACE and RUNS when STATUS changed."""

    status: int
    place: int
    runs: int


# ---------------------------------------------------------------------- frames
def cobs_encode(data: bytes) -> bytes:
    """Bytes without a zero that represent `data`, at most LARGEST bytes. Raises PacketError."""
    if len(data) > LARGEST:
        raise PacketError(f"{len(data)} bytes in a packet; at most {LARGEST}")
    return b"".join(bytes([len(part) + 1]) + part for part in data.split(b"\0"))


def cobs_decode(data: bytes) -> bytes:
    """What `cobs_encode` was given. Raises PacketError."""
    parts, at = [], 0
    while at < len(data):
        code = data[at]
        part = data[at + 1 : at + code]
        if not code or 0 in part or len(part) != code - 1:
            raise PacketError("the bytes between two zeros are not COBS")
        parts.append(part)
        at += code
    return b"\0".join(parts)


def encode(packet: Packet) -> bytes:
    """The frame of a packet. Raises PacketError if it is too long."""
    content = bytes([packet.type, packet.sequence & 0xFF]) + packet.body
    return cobs_encode(content + binascii.crc_hqx(content, CRC_START).to_bytes(2, "big")) + b"\0"


def decode(frame: bytes) -> Packet:
    """The packet of a frame without its zero. Raises PacketError."""
    content = cobs_decode(frame)
    if len(content) < 4:
        raise PacketError(f"{len(content)} bytes; a packet has 4 at least")
    if binascii.crc_hqx(content, CRC_START):
        raise PacketError("the CRC is wrong")
    return Packet(content[0], content[1], content[2:-2])


class Decoder:
    """Packets of a stream of bytes that come in any pieces; `dropped` counts bad frames."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self._lost = False  # the frame that is coming is too long
        self.dropped = 0

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Packets that end in `data`."""
        *ended, rest = data.split(b"\0")
        for part in ended:
            frame, lost = bytes(self._rest + part), self._lost
            self._rest.clear()
            self._lost = False
            if lost:
                continue
            if frame:
                try:
                    packet = decode(frame)
                except PacketError:
                    self.dropped += 1
                else:
                    yield packet
        self._rest += rest
        if len(self._rest) > LARGEST + 1 and not self._lost:
            self._lost = True
            self.dropped += 1
        if self._lost:
            self._rest.clear()


# ---------------------------------------------------------------------- bodies
def read_body(address: int, count: int) -> bytes:
    """Body of READ: `count` words from a word address on, 1 to READ_WORDS."""
    if not 1 <= count <= READ_WORDS:
        raise PacketError(f"{count} words to read; 1 to {READ_WORDS}")
    return struct.pack("<HB", address, count)


def write_body(address: int, words: Sequence[int]) -> bytes:
    """Body of WRITE: 1 to WRITE_WORDS words for a word address and those after it."""
    if not 1 <= len(words) <= WRITE_WORDS:
        raise PacketError(f"{len(words)} words to write; 1 to {WRITE_WORDS}")
    return struct.pack("<H", address) + pack_words(words)


def pack_words(words: Sequence[int]) -> bytes:
    """Words of 32 bits as bytes."""
    return struct.pack(f"<{len(words)}I", *words)


def unpack_words(body: bytes) -> tuple[int, ...]:
    """Words of 32 bits of bytes. Raises PacketError."""
    if len(body) % 4:
        raise PacketError(f"{len(body)} bytes are no whole number of words")
    return struct.unpack(f"<{len(body) // 4}I", body)


def event(body: bytes) -> Event:
    """Content of an EVENT. Raises PacketError."""
    words = unpack_words(body)
    if len(words) != 3:
        raise PacketError(f"an event has 3 words, got {len(words)}")
    return Event(*words)


# ---------------------------------------------------------------------- samples
def samples_body(first: int, records: Sequence[Sequence[int]]) -> bytes:
    """Body of SAMPLES: records of one length from number `first` on, each coded against the one
    before, the first against zeros."""
    channels = len(records[0])
    out = bytearray(struct.pack("<IB", first & 0xFFFFFFFF, channels))
    before: Sequence[int] = [0] * channels
    for record in records:
        codes, data = 0, bytearray()
        for channel, (word, old) in enumerate(zip(record, before, strict=True)):
            difference = word ^ old
            code = next(c for c, n in enumerate(SAMPLE_BYTES) if difference < 1 << 8 * n)
            codes |= code << 2 * channel
            data += difference.to_bytes(4, "little")[: SAMPLE_BYTES[code]]
        out += codes.to_bytes(_code_bytes(channels), "little") + data
        before = record
    return bytes(out)


def line_bits(records: Sequence[Sequence[int]]) -> float:
    """Bits of the line that a record takes in the mean, start and stop bits included, when the
    block sends these records in full packets: times records a second, what the line must carry."""
    bits, first = 0, 0
    for n in range(1, len(records) + 1):
        body = samples_body(first, records[first:n])
        if n == len(records) or 2 + len(body) > FULLEST:
            bits += 10 * len(encode(Packet(Type.SAMPLES, 0, body)))
            first = n
    return bits / len(records)


def samples(body: bytes) -> tuple[int, list[tuple[int, ...]]]:
    """Number of the first record of a SAMPLES body, and the records. Raises PacketError."""
    if len(body) < 5 or not 1 <= body[4] <= 8:
        raise PacketError("a packet of samples without its head")
    first, channels = struct.unpack_from("<IB", body)
    width, at = _code_bytes(channels), 5
    records: list[tuple[int, ...]] = []
    before: Sequence[int] = [0] * channels
    while at < len(body):
        codes = int.from_bytes(body[at : at + width], "little")
        at += width
        record = []
        for channel in range(channels):
            length = SAMPLE_BYTES[codes >> 2 * channel & 3]
            if at + length > len(body):
                raise PacketError("a packet of samples ends inside a record")
            record.append(before[channel] ^ int.from_bytes(body[at : at + length], "little"))
            at += length
        before = tuple(record)
        records.append(before)
    return first, records


def _code_bytes(channels: int) -> int:
    return (2 * channels + 7) // 8
