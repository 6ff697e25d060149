# SPDX-License-Identifier: Apache-2.0
"""GDB server of a simulated Nios II system: the connection, and time while the program runs."""

from __future__ import annotations

import os
import select
import socket
import sys
from collections.abc import Callable

from sim.gdb.module import DebugModule
from sim.gdb.packets import LARGEST, PacketReader, frame
from sim.gdb.session import Session
from sim.gdb.target import HALT_CYCLES, Target, TargetError
from sim.harness.nios_image import Program
from sim.harness.nios_rtl import NiosRtl

CHUNK = 20_000  # cycles between two looks at the connection, some hundredths of a second
FAREWELL = 0.5  # s, for a debugger to take the last answer
PIPE = "-"
LOOPBACK = "127.0.0.1"
Say = Callable[[str], None]


class ServerError(RuntimeError):
    """The server cannot work; the message says why and what to do."""


class NiosSystem:
    """A simulated system under a debugger, halted before the first instruction of its program.

    None: there is no program, the debugger is to load one.
    """

    def __init__(self, core: NiosRtl, program: Program | None) -> None:
        self.core, self.program = core, program
        self.spent = 0  # clock cycles of the running program
        self.target = Target(core.platform, core.map, DebugModule(core.debug, self.run))
        self.reset()

    def run(self, cycles: int) -> bool:
        """Let the core run; whether it has halted."""
        before = self.core.cycles
        halted = self.core.until_halt(cycles)
        self.spent += self.core.cycles - before
        return halted

    def reset(self) -> str:
        """Reset the core, halted before its first instruction; what is to be said of it."""
        load = self.program is not None and not self.target.code_written
        if load:
            self.core.load(self.program)
        else:
            self.core.hold()
        self.target.module.request_halt()
        self.core.start()
        if not self.run(HALT_CYCLES):
            raise TargetError("the core did not halt after its reset")
        self.target.halted()
        self.spent = 0
        if load:
            self.target.again()
            return f"{self.program.name} is loaded, the core stands at its reset vector"
        return "the core stands at its reset vector; memories are as they were: `load` again"

    def tick(self) -> None:
        """Start a control tick."""
        self.core.tick()

    def counters(self) -> tuple[int, int]:
        """Clock cycles and instructions of the program since its reset."""
        return self.spent, self.core.retired


class Connection:
    """Bytes to and from one debugger, over a socket or a pair of pipes."""

    def __init__(self, read: int, write: int, console: bool) -> None:
        self.read_fd, self._write_fd = read, write
        self.takes_console = console
        self._reader = PacketReader()
        self._last = b""

    def ready(self, seconds: float | None) -> bool:
        """Whether something came within so many seconds (None: wait for it)."""
        return bool(select.select([self.read_fd], [], [], seconds)[0])

    def receive(self) -> list[tuple[str, bytes]]:
        """Events that have come. Raises ConnectionError when the other side has gone."""
        data = os.read(self.read_fd, LARGEST)
        if not data:
            raise ConnectionResetError
        return [(event.kind, event.data) for event in self._reader.feed(data)]

    def send(self, data: bytes) -> None:
        """Send bytes as they are."""
        while data:
            data = data[os.write(self._write_fd, data) :]

    def answer(self, data: bytes) -> None:
        """Send a packet, and keep it in case it must be sent again."""
        self._last = frame(data)
        self.send(self._last)

    def finish(self) -> None:
        """Let the debugger take the last answer, which a socket that closes too early can lose."""
        try:
            while self.ready(FAREWELL):
                self.receive()
        except ConnectionError:
            pass  # it has gone, which is what it shall do

    def again(self) -> None:
        """Send the last answer again."""
        self.send(self._last)


class Server:
    """Serves one debugger after the other until the program ends or a debugger kills it."""

    def __init__(self, system: NiosSystem, say: Say) -> None:
        self._system, self._say = system, say
        self._running = False

    def serve(self, connection: Connection) -> int | None:
        """One debugger, to its end; the exit status if the program has ended, or was killed."""
        session = Session(self._system)
        if self._running:
            self._halt()
        try:
            return self._session(connection, session)
        except OSError:
            if self._ended() is not None:
                return self._ended()
            if session.running:
                self._halt()
            self._system.target.forget()
            place = self._system.target.pc
            self._say(f"connection lost, the program stands at 0x{place:08x}")
            return None

    def _session(self, connection: Connection, session: Session) -> int | None:
        while not session.over:
            if session.running:
                self._advance(connection, session)
                if not session.running and self._ended() is not None and not session.extended:
                    connection.finish()
                    return self._ended()
            if connection.ready(0 if session.running else None):
                for kind, data in connection.receive():
                    self._event(connection, session, kind, data)
        connection.finish()
        self._running = not session.killed
        return 0 if session.killed and not session.extended else None

    def _event(self, connection: Connection, session: Session, kind: str, data: bytes) -> None:
        if kind == "interrupt":
            if session.running:
                self._halt()
                session.running = False
                connection.answer(session.stopped(interrupted=True))
        elif kind == "nack":
            connection.again()
        elif kind == "bad":
            connection.send(b"-")
        elif kind == "packet" and not session.running:
            if session.acknowledge:
                connection.send(b"+")
            reply = session.handle(data)
            if reply is not None:
                connection.answer(reply)

    def _advance(self, connection: Connection, session: Session) -> None:
        halted = self._system.run(CHUNK)
        self.console(connection)
        status = self._ended()
        if status is not None:
            session.running = False
            connection.answer(b"W%02x" % (status & 255))
        elif halted:
            self._system.target.halted()
            session.running = False
            connection.answer(session.stopped())

    def run_alone(self) -> int | None:
        """Let a program that no debugger has go on for a while; its status when it has ended."""
        if self._running:
            self._system.run(CHUNK)
            self.console(None)
            return self._ended()
        return None

    @property
    def running(self) -> bool:
        """The program runs without a debugger."""
        return self._running

    def _ended(self) -> int | None:
        return self._system.core.ended

    def _halt(self) -> None:
        self._running = False
        self._system.target.halt()

    def console(self, connection: Connection | None) -> None:
        """Pass on what the program wrote: to the debugger if it takes it, else standard output."""
        text = self._system.core.take_console()
        if text and connection is not None and connection.takes_console:
            connection.send(frame(b"O" + text.hex().encode()))
        elif text:
            sys.stdout.buffer.write(text)
            sys.stdout.buffer.flush()


def place_of(text: str) -> tuple[str, int]:
    """Host and port of `[HOST]:PORT` or `PORT`; without a host, this machine alone.

    Raises ValueError.
    """
    host, _, port = text.rpartition(":")
    if not port.isdecimal() or int(port) > 65535:
        raise ValueError(f"'{text}' is no [HOST]:PORT, and not -")
    return host or LOOPBACK, int(port)


def serve(core: NiosRtl, program: Program | None, place: str, say: Say) -> int:
    """Serve debuggers at a place, `[HOST]:PORT` or `-`, until the program has ended; its status.

    Raises ServerError if nobody can connect there.
    """
    server = Server(NiosSystem(core, program), say)
    if place == PIPE:
        status = server.serve(Connection(0, 1, console=True))
        while status is None and server.running:
            status = server.run_alone()
        return status or 0
    host, port = place_of(place)
    try:
        listener = socket.create_server((host, port), backlog=4)
    except OSError as error:
        raise ServerError(
            f"cannot listen at {host}:{port}: {error.strerror}; choose another"
        ) from None
    with listener:
        host, port = listener.getsockname()[:2]
        say(f"{core.platform} waits for GDB: target remote {host}:{port}")
        return _accept(server, listener, say)


def _accept(server: Server, listener: socket.socket, say: Say) -> int:
    status = None
    while status is None:
        if not select.select([listener], [], [], 0 if server.running else None)[0]:
            status = server.run_alone()
            continue
        peer, _ = listener.accept()
        with peer:
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            status = server.serve(Connection(peer.fileno(), peer.fileno(), console=False))
        if status is None:
            say("waiting for the next GDB" if not server.running else "detached, the program runs")
    return status
