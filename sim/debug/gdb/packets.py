# SPDX-License-Identifier: Apache-2.0
"""Framing of GDB's remote serial protocol: `$data#checksum`, acknowledgements, escapes, Ctrl-C.

Source: Debugging with GDB, appendix "GDB Remote Serial Protocol", sections Overview and Packet
Acknowledgment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

LARGEST = 0x4000  # bytes between $ and #, escapes included
INTERRUPT = 3  # outside of a packet: Ctrl-C


@dataclass(frozen=True)
class Event:
    """What came: 'packet' with its data, 'bad' (checksum, length), 'ack', 'nack', 'interrupt', or
    'foreign', bytes that no debugger sends between packets."""

    kind: str
    data: bytes = b""


class PacketReader:
    """Bytes as they come, in whatever pieces, to events; holds at most one packet.

    Between packets the protocol knows acknowledgements and Ctrl-C alone. Any other byte is the mark
    of a client of another kind, such as a browser.
    """

    def __init__(self) -> None:
        self._held = bytearray()
        self._inside = False
        self._too_long = False

    def feed(self, data: bytes) -> Iterator[Event]:
        """The events that these bytes complete."""
        for byte in data:
            if not self._inside:
                if byte == ord("$"):
                    self._begin()
                elif byte == INTERRUPT:
                    yield Event("interrupt")
                elif byte == ord("+"):
                    yield Event("ack")
                elif byte == ord("-"):
                    yield Event("nack")
                else:
                    yield Event("foreign")
            elif byte == ord("$"):  # never inside of a packet: the one before was cut off
                self._begin()
            else:
                self._held.append(byte)
                end = self._held.find(b"#", max(0, len(self._held) - 3))
                if end >= 0 and len(self._held) == end + 3:
                    self._inside = False
                    yield self._complete(end)
                elif len(self._held) > LARGEST + 3:
                    self._too_long = True
                    del self._held[:-3]  # its end is still to be found

    def _begin(self) -> None:
        self._held.clear()
        self._inside, self._too_long = True, False

    def _complete(self, end: int) -> Event:
        data, digits = bytes(self._held[:end]), bytes(self._held[end + 1 :])
        if self._too_long or digits.lower() != b"%02x" % checksum(data):
            return Event("bad")
        return Event("packet", unescape(data))


def checksum(data: bytes) -> int:
    """Sum of the bytes between $ and #, modulo 256."""
    return sum(data) & 255


def escape(data: bytes) -> bytes:
    """Binary data with } before each byte that has a meaning, and that byte changed."""
    return re.sub(rb"[$#}*]", lambda found: b"}" + bytes(b ^ 0x20 for b in found[0]), data)


def unescape(data: bytes) -> bytes:
    """The data before `escape`."""
    return re.sub(rb"}(.?)", lambda found: bytes(b ^ 0x20 for b in found[1]), data, flags=re.DOTALL)


def frame(data: bytes) -> bytes:
    """A packet that holds these bytes, which are escaped where they must be."""
    return b"$%s#%02x" % (data, checksum(data))
