# SPDX-License-Identifier: Apache-2.0
"""GDB server of a simulated Nios II system: the connection, and time while the program runs."""

from __future__ import annotations

import errno
import os
import select
import socket
import stat
import sys
from collections.abc import Callable
from pathlib import Path

from sim.debug import guard
from sim.debug.gdb.packets import LARGEST, Event, PacketReader, frame
from sim.debug.gdb.session import SIGINT, SIGSEGV, Session
from sim.debug.gdb.system import NiosSystem
from sim.rtl.nios_image import Program
from sim.rtl.nios_rtl import NiosRtl

CHUNK = 20_000  # cycles between two looks at the connection, some hundredths of a second
FAREWELL = 0.5  # s, for a debugger to take the last answer
PIPE = "-"
Say = Callable[[str], None]


class ServerError(RuntimeError):
    """The server cannot work; the message says why and what to do."""


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

    def receive(self) -> list[Event]:
        """Events that have come. Raises ConnectionError when the other side has gone."""
        data = os.read(self.read_fd, LARGEST)
        if not data:
            raise ConnectionResetError
        return list(self._reader.feed(data))

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


def once(events: list[Event]) -> list[Event]:
    """Events without packets that are repeated at once.

    A debugger that waits for the start of this process repeats its first packet. Two answers to it
    would make it take each later answer for that of the packet before.
    """
    following = [*events[1:], None]
    return [
        event
        for event, after in zip(events, following, strict=True)
        if event.kind != "packet" or event != after
    ]


class Server:
    """Serves one debugger after the other until the program ends or a debugger kills it."""

    def __init__(self, system: NiosSystem, say: Say) -> None:
        self._system, self._say = system, say
        self.running = False
        """The program runs without a debugger."""

    def serve(self, connection: Connection) -> int | None:
        """One debugger, to its end; the exit status if the program has ended, or was killed."""
        session = Session(self._system)
        if self.running:
            self._halt()
        with guard.one_client(self._say):
            return self._session(connection, session)
        if self._ended() is not None:
            return self._ended()
        if session.running:
            self._halt()
        self._system.target.forget()
        place = self._system.target.pc
        self._say(f"connection lost, the program is halted at 0x{place:08x}")
        return None

    def _session(self, connection: Connection, session: Session) -> int | None:
        begun = False
        while not session.over:
            if session.running:
                self._advance(connection, session)
                if not session.running and self._ended() is not None and not session.extended:
                    connection.finish()
                    return self._ended()
            if connection.ready(0 if session.running else None):
                events = connection.receive()
                for event in events if begun else once(events):
                    self._event(connection, session, event)
                begun = True
        connection.finish()
        self.running = not session.killed
        return 0 if session.killed and not session.extended else None

    def _event(self, connection: Connection, session: Session, event: Event) -> None:
        if event.kind == "interrupt":
            if session.running:
                self._halt()
                session.running = False
                connection.answer(session.stopped(signal=SIGINT))
        elif event.kind == "nack":
            connection.again()
        elif event.kind == "foreign":
            raise guard.Refused("a client that does not speak GDB's remote serial protocol")
        elif event.kind == "bad":
            connection.send(b"-")
        elif event.kind == "packet" and not session.running:
            if session.acknowledge:
                connection.send(b"+")
            reply = session.handle(event.data)
            if reply is not None:
                connection.answer(reply)

    def _advance(self, connection: Connection, session: Session) -> None:
        halted = self._system.run(CHUNK)
        self.console(connection)
        status = self._ended()
        if status is not None:
            session.running = False
            connection.answer(b"W%02x" % (status & 255))
        elif (address := self._system.core.stray) is not None:
            self._halt()
            session.running = False
            self._say(f"the program accesses 0x{address:08x}: neither memory nor a register")
            connection.answer(session.stopped(signal=SIGSEGV))
        elif halted:
            self._system.target.halted()
            session.running = False
            connection.answer(session.stopped())

    def run_alone(self) -> int | None:
        """Let a program that no debugger has go on for a while; its status when it has ended."""
        if self.running:
            self._system.run(CHUNK)
            self.console(None)
            return self._ended()
        return None

    def _ended(self) -> int | None:
        return self._system.core.ended

    def _halt(self) -> None:
        self.running = False
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
    return host or guard.LOOPBACK, int(port)


def serve(core: NiosRtl, program: Program | None, place: str, say: Say) -> int:
    """Serve debuggers at a place until the program has ended; its status.

    The place is `[HOST]:PORT`, the path of a Unix socket with a slash in it, or `-`.

    Raises ServerError if nobody can connect there.
    """
    server = Server(NiosSystem(core, program), say)
    if place == PIPE:
        status = server.serve(Connection(0, 1, console=True))
        while status is None and server.running:
            status = server.run_alone()
        return status or 0
    if "/" in place:
        return _serve_path(server, Path(place), core.platform, say)
    host, port = place_of(place)
    try:
        listener = guard.listen(port, say, host)
    except OSError as error:
        raise ServerError(
            f"cannot listen at {host}:{port}: {error.strerror}; choose another"
        ) from None
    with listener:
        host, port = listener.getsockname()[:2]
        say(f"{core.platform} waits for GDB: target remote {host}:{port}")
        return _accept(server, listener, say)


def _serve_path(server: Server, path: Path, platform: str, say: Say) -> int:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        before = os.umask(0o177)  # only this user may connect
        try:
            if path.exists() and stat.S_ISSOCK(path.lstat().st_mode):
                raise OSError(errno.EADDRINUSE, "another server made this socket; remove it")
            listener.bind(str(path))
        except OSError as error:
            raise ServerError(f"cannot listen at {path}: {error.strerror or error}") from None
        finally:
            os.umask(before)
        try:
            listener.listen(4)
            say(f"{platform} waits for GDB: target remote {path}")
            return _accept(server, listener, say)
        finally:
            path.unlink(missing_ok=True)


def _accept(server: Server, listener: socket.socket, say: Say) -> int:
    status = None
    while status is None:
        if not select.select([listener], [], [], 0 if server.running else None)[0]:
            status = server.run_alone()
            continue
        peer = guard.accept(listener, say)
        if peer is None:
            continue
        with peer, guard.only_client(listener, say):
            status = server.serve(Connection(peer.fileno(), peer.fileno(), console=False))
        if status is None:
            say("waiting for the next GDB" if not server.running else "detached, the program runs")
    return status
