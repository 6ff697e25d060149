# SPDX-License-Identifier: Apache-2.0
"""A client of GDB's remote serial protocol, written from its description alone.

Source: Debugging with GDB, appendix "GDB Remote Serial Protocol". Nothing here is imported from
sim/debug/gdb: both sides must have read the same text in the same way.
"""

from __future__ import annotations

import re
import socket
import struct
import threading
from functools import cache

from sim.debug.gdb.server import Connection, Server, serve
from sim.debug.gdb.system import NiosSystem
from sim.rtl.nios_image import IMAGES, Program, read_elf
from sim.rtl.nios_rtl import NiosRtl

PC, SP, RA, STATUS = 32, 27, 31, 33
TIMEOUT = 30.0  # seconds: a server that says nothing for so long is dead


def framed(data: bytes) -> bytes:
    """`$data#` and two digits: the sum of the bytes modulo 256."""
    return b"$" + data + b"#" + f"{sum(data) % 256:02x}".encode()


class Client:
    """One connection, with acknowledgements as after its start."""

    def __init__(self, peer: socket.socket) -> None:
        self.peer = peer
        self.peer.settimeout(TIMEOUT)
        self._bytes = b""
        self.console = b""  # what the program has written

    def byte(self) -> bytes:
        """The next byte. Raises EOFError at the end of the connection."""
        if not self._bytes:
            try:
                self._bytes = self.peer.recv(65536)
            except ConnectionResetError:
                self._bytes = b""
            if not self._bytes:
                raise EOFError
        first, self._bytes = self._bytes[:1], self._bytes[1:]
        return first

    def packet(self) -> bytes:
        """The next packet, acknowledged; its escapes are undone."""
        assert self.byte() == b"$"
        data = b""
        while (byte := self.byte()) != b"#":
            data += byte
        assert int(self.byte() + self.byte(), 16) == sum(data) % 256, "checksum"
        self.peer.sendall(b"+")
        return re.sub(rb"\}(.)", lambda m: bytes([m[1][0] ^ 0x20]), data, flags=re.DOTALL)

    def send(self, data: bytes) -> None:
        """Send a packet and take its acknowledgement."""
        self.peer.sendall(framed(data))
        assert self.byte() == b"+"

    def ask(self, data: bytes | str) -> bytes:
        """The answer to a packet."""
        self.send(data if isinstance(data, bytes) else data.encode())
        return self.packet()

    def ok(self, data: bytes | str) -> None:
        """A packet that must be answered by OK."""
        answer = self.ask(data)
        assert answer == b"OK", (data, answer)

    # ------------------------------------------------------------------ what debuggers do
    def register(self, number: int) -> int:
        """A register by its number."""
        return struct.unpack("<I", bytes.fromhex(self.ask(f"p{number:x}").decode()))[0]

    def set_register(self, number: int, value: int) -> None:
        """Write a register."""
        self.ok(f"P{number:x}={struct.pack('<I', value).hex()}")

    def registers(self) -> tuple[int, ...]:
        """All that `g` has."""
        data = bytes.fromhex(self.ask("g").decode())
        return struct.unpack(f"<{len(data) // 4}I", data)

    def read(self, address: int, length: int) -> bytes:
        """Memory."""
        return bytes.fromhex(self.ask(f"m{address:x},{length:x}").decode())

    def write(self, address: int, data: bytes) -> None:
        """Write memory."""
        self.ok(f"M{address:x},{len(data):x}:{data.hex()}")

    def monitor(self, line: str) -> str:
        """What a command of `monitor` prints."""
        return bytes.fromhex(self.ask(b"qRcmd," + line.encode().hex().encode()).decode()).decode()

    def go(self, packet: str = "c") -> bytes:
        """Let the program run until it stops; the stop reply."""
        self.send(packet.encode())
        return self.stop()

    def stop(self) -> bytes:
        """The next stop reply; text that comes before it goes to `console`."""
        while (reply := self.packet()).startswith(b"O"):
            self.console += bytes.fromhex(reply[1:].decode())
        return reply


@cache
def system() -> NiosRtl:
    """One model of FPGA2 for all tests of the process."""
    return NiosRtl("fpga2", debug=True)


@cache
def program(name: str) -> Program:
    """A committed program."""
    return read_elf(IMAGES / f"{name}.elf")


def listening(
    core: NiosRtl, elf: Program, place: str
) -> tuple[threading.Thread, list[str], list[int]]:
    """A server in a thread that waits for debuggers: what it says, its status after its end."""
    said: list[str] = []
    status: list[int] = []
    listens = threading.Event()

    def say(text: str) -> None:
        said.append(text)
        listens.set()

    server = threading.Thread(
        target=lambda: status.append(serve(core, elf, place, say)), daemon=True
    )
    server.start()
    assert listens.wait(2 * TIMEOUT)
    return server, said, status


def stopped_at(reply: bytes) -> int:
    """The program counter that a stop reply carries."""
    found = re.search(rb"[;0-9a-z]20:([0-9a-f]{8});", reply)
    assert found, reply
    return struct.unpack("<I", bytes.fromhex(found[1].decode()))[0]


class Debugged:
    """A system with its server in a thread of its own, and clients of it."""

    def __init__(self, core: NiosRtl, program: Program | None) -> None:
        self.system = NiosSystem(core, program)
        self.said: list[str] = []
        self.server = Server(self.system, self.said.append)
        self.status: int | None = None
        self._thread: threading.Thread | None = None
        self.client: Client | None = None

    def connect(self) -> Client:
        """A new connection; the one before must have ended."""
        self.join()
        ours, theirs = socket.socketpair()

        def serve() -> None:
            with theirs:
                fd = theirs.fileno()
                self.status = self.server.serve(Connection(fd, fd, console=True))

        self._thread = threading.Thread(target=serve, daemon=True)
        self._thread.start()
        self.client = Client(ours)
        return self.client

    def join(self) -> None:
        """Wait until the server has done with the connection."""
        if self._thread is not None:
            self._thread.join(TIMEOUT)
            assert not self._thread.is_alive(), "the server goes on"

    def __enter__(self) -> Client:
        return self.connect()

    def __exit__(self, *_: object) -> None:
        self.client.peer.close()
        self.join()
