# SPDX-License-Identifier: Apache-2.0
"""Links that carry packets: calls in this process, TCP, a serial line."""

from __future__ import annotations

import contextlib
import socket
import time
from typing import Protocol

from sim.debug import guard
from sim.debug.packets import (
    READ_WORDS,
    WRITE_WORDS,
    Decoder,
    ErrorCode,
    Packet,
    Type,
    encode,
    pack_words,
    unpack_words,
)
from sim.rtl.asip_bus import LinkError

ADDRESSES = 1 << 15
"""Words on the bus of `debug_asip`."""
GONE = "the server has another client, and serves one at a time, or is gone"
NO_TOKEN = "write tcp://TOKEN@host:port with the token that the server has printed"


class Bus(Protocol):
    """A Verilated `debug_asip`, or anything with its bus."""

    def read(self, address: int) -> int: ...

    def write(self, address: int, data: int) -> None: ...

    def clock(self, cycles: int = 1) -> None: ...


class Link(Protocol):
    """Carries packets in both directions."""

    streams: bool
    """Whether the block sends SAMPLES and EVENT by itself over this link."""

    def send(self, packet: Packet) -> None: ...

    def receive(self, timeout: float) -> Packet | None:
        """The next packet, None if none comes within so many seconds."""

    def pause(self) -> None:
        """Give the core a moment: what a client calls between two looks at its state."""

    def close(self) -> None: ...


class Responder:
    """Answers requests as the block's serial port does, by accesses on a bus."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._last: int | None = None

    def answer(self, packet: Packet) -> Packet:
        """The answer to a request; a READ or WRITE waits as long as the core holds it."""
        body = packet.body
        repeated, self._last = packet.sequence == self._last, packet.sequence
        if packet.type == Type.READ and len(body) == 3 and 1 <= body[2] <= READ_WORDS:
            first = int.from_bytes(body[:2], "little")
            words = [self._bus.read((first + n) % ADDRESSES) for n in range(body[2])]
            return Packet(Type.READ_DONE, packet.sequence, pack_words(words))
        count, odd = divmod(len(body) - 2, 4)
        if packet.type == Type.WRITE and 1 <= count <= WRITE_WORDS and not odd:
            if not repeated:
                first = int.from_bytes(body[:2], "little")
                for n, word in enumerate(unpack_words(body[2:])):
                    self._bus.write((first + n) % ADDRESSES, word)
            return Packet(Type.WRITE_DONE, packet.sequence)
        known = packet.type in (Type.READ, Type.WRITE)
        code = ErrorCode.LENGTH if known else ErrorCode.TYPE
        return Packet(Type.ERROR, packet.sequence, bytes([code]))


class DirectLink:
    """A model in this process; `pause` lets it run for `clocks`."""

    streams = False

    def __init__(self, bus: Bus, clocks: int = 500) -> None:
        self._bus, self._clocks = bus, clocks
        self._responder = Responder(bus)
        self._answers: list[Packet] = []

    def send(self, packet: Packet) -> None:
        self._answers.append(self._responder.answer(packet))

    def receive(self, timeout: float) -> Packet | None:
        return self._answers.pop(0) if self._answers else None

    def pause(self) -> None:
        self._bus.clock(self._clocks)

    def close(self) -> None:
        self._answers.clear()


class TcpLink:
    """A server (sim/debug/server.py) that has a model."""

    streams = False

    def __init__(self, host: str, port: int, token: str = "", timeout: float = 5.0) -> None:
        """token: that of the server; without it that of this user's own server at this port."""
        self._place = f"{host}:{port}"
        token = token or guard.token_of(host, port)
        self._gone = GONE if token else f"{GONE}, or wants its token: {NO_TOKEN}"
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise LinkError(
                f"tcp://{self._place}: {error.strerror or error}; start the server first: "
                f".venv/bin/python -m sim.debug.server PROGRAM --port {port}"
            ) from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._decoder = Decoder()
        self._packets: list[Packet] = []
        self._send(guard.hello(token))

    def send(self, packet: Packet) -> None:
        self._send(encode(packet))

    def _send(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise LinkError(f"tcp://{self._place}: {error}; {self._gone}") from None

    def receive(self, timeout: float) -> Packet | None:
        end = time.monotonic() + timeout
        while not self._packets:
            self._socket.settimeout(max(end - time.monotonic(), 1e-3))
            try:
                data = self._socket.recv(65536)
            except TimeoutError:
                return None
            except OSError as error:
                raise LinkError(f"tcp://{self._place}: {error}; {self._gone}") from None
            if not data:
                raise LinkError(f"tcp://{self._place}: the connection was closed; {self._gone}")
            self._packets += self._decoder.feed(data)
        return self._packets.pop(0)

    def pause(self) -> None:
        time.sleep(1e-3)

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._socket.close()


class ByteLine(Protocol):
    """A serial line, or a model of one: bytes that have come so far, at once."""

    def write(self, data: bytes) -> object: ...

    def read(self) -> bytes: ...

    def close(self) -> None: ...


class SerialLink:
    """A serial line to a board, or to the pins of a model."""

    streams = True

    def __init__(self, line: ByteLine, place: str, *, clock: Bus | None = None) -> None:
        self._line, self._place, self._clock = line, place, clock
        self.decoder = Decoder()
        self._packets: list[Packet] = []

    def send(self, packet: Packet) -> None:
        try:
            self._line.write(encode(packet))
        except OSError as error:
            raise LinkError(f"{self._place}: {error}; is the board connected?") from None

    def receive(self, timeout: float) -> Packet | None:
        end = time.monotonic() + timeout
        while True:
            try:
                data = self._line.read()
            except OSError as error:
                raise LinkError(f"{self._place}: {error}; is the board connected?") from None
            self._packets += self.decoder.feed(data)
            if self._packets:
                return self._packets.pop(0)
            if time.monotonic() >= end:
                return None
            if not data:
                self.pause()

    def pause(self) -> None:
        if self._clock is None:
            time.sleep(2e-4)
        else:
            self._clock.clock(500)

    def close(self) -> None:
        self._line.close()


def open_serial(path: str, baud: int) -> SerialLink:
    """The serial device `path`. Raises LinkError."""
    # Only a board needs the package.
    import serial

    try:
        port = serial.Serial(path, baud, timeout=0, exclusive=True)
    except (serial.SerialException, ValueError, OSError) as error:
        raise LinkError(
            f"{path}: {error}; `ls /dev/ttyUSB* /dev/ttyACM*` shows the serial devices, and "
            "their group (dialout) may need to be yours"
        ) from None

    class _Line:
        def write(self, data: bytes) -> object:
            return port.write(data)

        def read(self) -> bytes:
            return port.read(65536)

        def close(self) -> None:
            port.close()

    return SerialLink(_Line(), path)


def open_link(target: str) -> Link:
    """Link of `tcp://[TOKEN@]host:port`, `serial:PATH[?baud=N]` or the path of a device.

    Raises LinkError, PacketError.
    """
    if target.startswith("tcp://"):
        token, _, place = target.removeprefix("tcp://").rpartition("@")
        host, _, port = place.rpartition(":")
        if not host or not port.isdecimal() or int(port) > 0xFFFF:
            raise LinkError(f"{target}: write tcp://host:port, for example tcp://localhost:2331")
        return TcpLink(host, int(port), token)
    if target.startswith(("serial:", "/dev/")):
        path, _, option = target.removeprefix("serial:").partition("?")
        baud = option.removeprefix("baud=") or "3000000"
        if not baud.isdecimal():
            raise LinkError(f"{target}: write serial:PATH?baud=3000000")
        return open_serial(path, int(baud))
    raise LinkError(
        f"{target}: no such link; write tcp://host:port, serial:PATH?baud=N or /dev/ttyUSB0"
    )
