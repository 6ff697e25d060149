# SPDX-License-Identifier: Apache-2.0
"""Words of a core and its debug block: requests over a link, and what comes unasked."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Self

from sim.debug.link import Link
from sim.debug.packets import (
    READ_WORDS,
    WRITE_WORDS,
    ErrorCode,
    Event,
    Packet,
    PacketError,
    Type,
    event,
    read_body,
    samples,
    unpack_words,
    write_body,
)
from sim.debug.state import REGISTER, REGMAP, Records, Sizes, State, fields_of
from sim.rtl.asip_bus import AsipError, LinkError

TRIES = 3


class DebugError(AsipError):
    """The block cannot do what was requested; the text says why, and the cure."""


class Requests:
    """One debug block over a link. Methods raise LinkError if nothing answers any more.

    timeout: seconds for an answer; a request is sent TRIES times. A read of registers, data or
    outputs during a run is answered when the run has ended or is halted.
    """

    def __init__(self, link: Link, timeout: float = 2.0) -> None:
        self.link = link
        self.timeout = timeout
        self.events: list[Event] = []
        """Events that came unasked, oldest first; whoever reads them removes them."""
        self._sequence = 0
        self._streamed: list[Records] = []
        identity, config = self._neighbours("ID", "CONFIG")
        if identity != REGMAP.registers["ID"].reset:
            raise LinkError(
                f"word {REGISTER['ID']:#06x} is {identity:#010x}, no debug block: the core was "
                "built without one, take `debug_asip` in place of `asip`"
            )
        fields = fields_of("CONFIG", config)
        self.sizes = Sizes(
            fields["breakpoints"],
            fields["watches"],
            fields["channels"],
            1 << fields["ring_log2"],
            1 << fields["stage_log2"],
            bool(fields["uart"]),
        )

    def close(self) -> None:
        """End the link; the core goes on as it is."""
        self.link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ------------------------------------------------------------------ words
    def read_words(self, address: int, count: int = 1) -> list[int]:
        """Words from a bus address on."""
        words: list[int] = []
        while len(words) < count:
            part = min(count - len(words), READ_WORDS)
            body = self._request(Type.READ, read_body(address + len(words), part))
            words += unpack_words(body)
        return words

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Words for a bus address and those after it."""
        for at in range(0, len(words), WRITE_WORDS):
            part = [word & 0xFFFFFFFF for word in words[at : at + WRITE_WORDS]]
            self._request(Type.WRITE, write_body(address + at, part))

    def read_word(self, address: int) -> int:
        """The word at a bus address."""
        return self.read_words(address)[0]

    def write_word(self, address: int, word: int) -> None:
        """One word to a bus address."""
        self.write_words(address, [word])

    def _read(self, register: str) -> int:
        return self.read_word(REGISTER[register])

    def _fields(self, register: str) -> dict[str, int]:
        return fields_of(register, self._read(register))

    def _neighbours(self, *registers: str) -> list[int]:
        """Registers that follow one after the other, in one packet."""
        return self.read_words(REGISTER[registers[0]], len(registers))

    def state(self) -> State:
        """The state now."""
        return State.of(*self._neighbours("STATUS", "PLACE"))

    def _write(self, register: str, word: int, n: int = 0) -> None:
        self.write_word(REGISTER[register] + n, word)

    def _control(self, *bits: str) -> None:
        self._write("CONTROL", REGMAP.registers["CONTROL"].word(**dict.fromkeys(bits, 1)))

    # ------------------------------------------------------------------ packets

    def set_events(self, on: bool = True) -> None:
        """Over a serial line: whether the block reports changes of its state by itself."""
        self._set_uart(events=int(on))

    def _set_uart(self, **bits: int) -> None:
        fields = self._fields("UART") | bits
        self._write("UART", REGMAP.registers["UART"].word(**fields))

    def poll(self) -> None:
        """Take in what came unasked: events and records."""
        while (packet := self.link.receive(0.0)) is not None:
            self._unasked(packet)

    def _unasked(self, packet: Packet) -> None:
        if packet.type == Type.EVENT:
            self.events.append(event(packet.body))
        elif packet.type == Type.SAMPLES:
            first, words = samples(packet.body)
            self._streamed.append(Records(first, words))

    def _request(self, kind: Type, body: bytes) -> bytes:
        """Body of the answer. Raises LinkError, PacketError."""
        self._sequence = (self._sequence + 1) & 0xFF
        request = Packet(kind, self._sequence, body)
        for _ in range(TRIES):
            self.link.send(request)
            end = time.monotonic() + self.timeout
            while (packet := self.link.receive(max(0.0, end - time.monotonic()))) is not None:
                if packet.sequence != self._sequence or packet.type in (Type.SAMPLES, Type.EVENT):
                    self._unasked(packet)
                elif packet.type == Type.ERROR:
                    known = [c.name for c in ErrorCode if packet.body == bytes([c])]
                    raise PacketError(f"the block refused {request}: {known or packet.body.hex()}")
                elif packet.type == kind | 0x80:
                    return packet.body
        raise LinkError(
            f"no answer within {self.timeout:g} s, {TRIES} times; is the board powered, has it a "
            "debug block, and is the baud rate that of UART.divider? A core inside a run without "
            "end answers when it is halted"
        )
