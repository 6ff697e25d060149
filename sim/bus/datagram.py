# SPDX-License-Identifier: Apache-2.0
"""Datagrams that simulations send: built and taken apart without a master."""

from __future__ import annotations

APRD, APWR, FPRD, FPWR, BRD, BWR, LRD, LRW, ARMW = 1, 2, 4, 5, 7, 8, 10, 12, 13
DATA_AT = 26  # of the first datagram in its frame
SHORTEST = 60
ETHERNET = b"\xff" * 6 + b"\x02\0\0\0\0\x01" + b"\x88\xa4"


def datagram(command: int, position: int, offset: int, data: bytes, more: bool = False) -> bytes:
    """One datagram with counter 0; of logical commands the address' halves are given."""
    head = bytes([command, 0]) + position.to_bytes(2, "little") + offset.to_bytes(2, "little")
    return head + (len(data) | more << 15).to_bytes(2, "little") + bytes(2) + data + bytes(2)


def frame(*datagrams: bytes) -> bytes:
    """Ethernet frame of these datagrams, padded to its least length."""
    body = b"".join(datagrams)
    return (ETHERNET + (len(body) | 0x1000).to_bytes(2, "little") + body).ljust(SHORTEST, b"\0")


def single(command: int, position: int, offset: int, data: bytes) -> bytes:
    """Frame of one datagram."""
    return frame(datagram(command, position, offset, data))


def answer(data: bytes, count: int) -> tuple[int, int]:
    """Value and working counter of a frame's first datagram, of `count` bytes."""
    value = int.from_bytes(data[DATA_AT : DATA_AT + count], "little")
    return value, int.from_bytes(data[DATA_AT + count : DATA_AT + count + 2], "little")
