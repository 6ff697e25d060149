# SPDX-License-Identifier: Apache-2.0
"""Framing of GDB's protocol: packets whole, in pieces, damaged, too long; escapes."""

from __future__ import annotations

import random

import pytest

from sim.debug.gdb.packets import LARGEST, Event, PacketReader, checksum, escape, frame, unescape
from tests.bench.seed import SEED


def events(*pieces: bytes) -> list[Event]:
    """What comes of these pieces, one after the other."""
    reader = PacketReader()
    return [event for piece in pieces for event in reader.feed(piece)]


def test_checksums_are_those_of_the_manual():
    """`$vMustReplyEmpty#3a`, `$OK#9a`, `$#00`: as GDB sends them."""
    assert frame(b"OK") == b"$OK#9a"
    assert frame(b"") == b"$#00"
    assert frame(b"vMustReplyEmpty") == b"$vMustReplyEmpty#3a"


def test_pieces_of_any_size_give_the_same_events():
    rng = random.Random(SEED)
    stream = b"+$g#67\x03-noise$OK#9a$#00$m10000000,4#%02x" % (sum(b"m10000000,4") & 255)
    whole = events(stream)
    noise = ["foreign"] * 5
    kinds = ["ack", "packet", "interrupt", "nack", *noise] + ["packet"] * 3
    assert [e.kind for e in whole] == kinds
    assert [e.data for e in whole if e.kind == "packet"] == [b"g", b"OK", b"", b"m10000000,4"]
    for _ in range(50):
        cuts = sorted(rng.sample(range(len(stream)), 5))
        assert (
            events(*(stream[a:b] for a, b in zip([0, *cuts], [*cuts, None], strict=True))) == whole
        )


@pytest.mark.parametrize("damaged", [b"$g#68", b"$g#6", b"$g#zz", b"$h#67", b"$g#+7", b"$g# 7"])
def test_damaged_packet_is_not_taken_and_the_next_one_is(damaged):
    found = events(damaged, b"$OK#9a")
    assert found[-1] == Event("packet", b"OK")
    assert Event("packet", b"g") not in found and Event("packet", b"h") not in found


def test_packet_that_is_cut_off_is_forgotten_at_the_next_one():
    assert events(b"$m1000", b"$OK#9a") == [Event("packet", b"OK")]


def test_packet_without_end_takes_no_memory():
    reader = PacketReader()
    assert not list(reader.feed(b"$"))
    for _ in range(100):
        assert not list(reader.feed(b"a" * LARGEST))
    assert len(reader._held) <= LARGEST + 3
    assert list(reader.feed(b"#00")) == [Event("bad")]
    assert list(reader.feed(b"$OK#9a")) == [Event("packet", b"OK")]


def test_escapes_come_back_and_hide_every_special_byte():
    data = bytes(range(256)) * 2
    hidden = escape(data)
    assert unescape(hidden) == data
    assert not set(hidden.replace(b"}", b"")) & set(b"$#*")
    assert escape(b"#$}*") == b"}\x03}\x04}]}\x0a"
    assert checksum(b"\xff\xff") == 0xFE
