# SPDX-License-Identifier: Apache-2.0
"""The guard of every port: who may connect, and what an error of one client may end.

Each server of this project listens through `listen`, takes its clients through `accept` and serves
each inside `one_client`. SECURITY.md has the reasons.

- A port is on the loopback address unless the user names another one, which is warned of.
- A client of another user of this machine is refused: the kernel knows whose socket connects.
- A client that speaks HTTP is refused: a page in a browser can send nothing else to a port.
- A server from which a board, a write or a file is within reach wants a `Token`. Programs of the
  same user read it from a file that only this user can read.
- An error that nobody expected ends the connection in which it happened, never the server.
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import os
import re
import secrets
import select
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

from asip_asm.diagnostics import visible
from sim.rtl import private

LOOPBACK = "127.0.0.1"
LOG = logging.getLogger("microtick.guard")
HELLO_S = 5.0
"""Seconds in which a client must show its token."""
GRACE_S = 1.0
LONGEST_HELLO = 128
"""Bytes of the line with the token."""
HELLO = b"token "
Say = Callable[[str], None]

_HTTP = re.compile(rb"^(?:[A-Za-z]{3,10} \S.*HTTP/\d|(?:GET|POST|PUT|HEAD|OPTIONS|DELETE|PATCH|"
                   rb"CONNECT|TRACE|PRI) |host:)", re.IGNORECASE | re.MULTILINE)  # fmt: skip
_TABLE = Path("/proc/net/tcp")
ALLOWED = (0,)
"""Users besides the own one that may connect: the owner of the machine owns the process."""


class Refused(ConnectionError):
    """A client that may not be served; the text says why."""


# ---------------------------------------------------------------------- what a client sends
def looks_like_http(data: bytes) -> bool:
    """Whether a line of these bytes is the first line of an HTTP request, or its Host field."""
    return bool(_HTTP.search(data))


# ---------------------------------------------------------------------- tokens
def new_token() -> str:
    """A secret that nobody guesses."""
    return secrets.token_urlsafe(16)


def same_token(given: object, token: str) -> bool:
    """Whether a client has given the token; takes the same time for any wrong one."""
    return isinstance(given, str) and secrets.compare_digest(given.encode(), token.encode())


class Token:
    """The secret of a server at a port, in a file that clients of the same user read."""

    def __init__(self, port: int) -> None:
        """Raises OSError if the file cannot be written."""
        self.text = new_token()
        self._file = _file(port)
        private.write_secret(self._file, self.text)

    def check(self, given: object) -> None:
        """Raises Refused unless this is the token."""
        if not same_token(given, self.text):
            raise Refused("a client without the token")

    def forget(self) -> None:
        """Remove the file, at the end of the server."""
        with contextlib.suppress(OSError):
            if self._file.read_text(encoding="ascii") == self.text:
                self._file.unlink()


def token_of(host: str, port: int) -> str:
    """Token of this user's server at a port of this machine, empty if there is none."""
    if not is_loopback(host):
        return ""
    try:
        return _file(port).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return ""


def _file(port: int) -> Path:
    return private.runtime_folder() / f"port-{port}.token"


def hello(token: str) -> bytes:
    """The line that a client sends first."""
    return HELLO + token.encode() + b"\n"


class Hello:
    """Takes the first line of a client, in whatever pieces it comes."""

    def __init__(self, token: Token) -> None:
        self._token = token
        self._held = b""
        self.done = False

    def feed(self, data: bytes) -> bytes:
        """What follows the line with the token; raises Refused for any other beginning."""
        if self.done:
            return data
        self._held += data
        line, end, rest = self._held.partition(b"\n")
        if looks_like_http(self._held):
            raise Refused("a client that speaks HTTP")
        if not end and len(line) <= LONGEST_HELLO and line.startswith(HELLO[: len(line)]):
            return b""
        given = line.removeprefix(HELLO) if line.startswith(HELLO) else b""
        self._token.check(given.decode("ascii", "replace"))
        self.done = True
        return rest


# ---------------------------------------------------------------------- sockets
def is_loopback(host: str) -> bool:
    """Whether only programs of this machine reach the address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def listen(port: int, say: Say, host: str = LOOPBACK) -> socket.socket:
    """A listening socket; port 0 takes a free one. Raises OSError."""
    listener = socket.create_server((host, port), backlog=64)
    if not is_loopback(listener.getsockname()[0]):
        say(
            f"warning: {host} is no loopback address: whoever reaches this machine over the "
            f"network can use this port; use {LOOPBACK} and a tunnel (ssh -L)"
        )
    return listener


def accept(listener: socket.socket, say: Say) -> socket.socket | None:
    """The next client; None, with a line to the user, for one that is refused or has gone."""
    try:
        client, peer = listener.accept()
    except OSError:
        return None
    try:
        check_user(client)
        if client.family != socket.AF_UNIX:
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    except Refused as error:
        say(f"refused {peer[0]}:{peer[1]}: {error}")
        client.close()
        return None
    except OSError:
        client.close()
        return None
    return client


def check_user(client: socket.socket) -> None:
    """Raises Refused for a client on this machine whose socket belongs to another user.

    A client from another machine, and a system without this table, report nothing: they pass.
    """
    if client.family != socket.AF_INET or not is_loopback(client.getpeername()[0]):
        return
    try:
        user = user_of(_TABLE.read_text(encoding="ascii"), client.getpeername(),
                       client.getsockname())  # fmt: skip
    except FileNotFoundError:
        return
    if user is None:
        raise Refused("a client that has gone already")
    if user not in (os.getuid(), *ALLOWED):
        raise Refused(f"a client of the user {user}")


def user_of(table: str, local: tuple[str, int], remote: tuple[str, int]) -> int | None:
    """User of an open socket in a table of the kernel's form, None if there is no such one."""
    wanted = [_hexadecimal(local), _hexadecimal(remote)]
    for line in table.splitlines()[1:]:
        words = line.split()
        if words[1:3] == wanted and words[9] != "0":  # without a number of a file it is an orphan
            return int(words[7])
    return None


def _hexadecimal(address: tuple[str, int]) -> str:
    number = int.from_bytes(socket.inet_aton(address[0]), "little")
    return f"{number:08X}:{address[1]:04X}"


@contextlib.contextmanager
def only_client(listener: socket.socket, say: Say) -> Iterator[None]:
    """While the client inside is served, further ones are turned away: without this they would wait
    without a word. One that comes within GRACE_S before the end is left for the next `accept`.
    """
    done = threading.Event()
    end, wake = socket.socketpair()  # the end needs no wait until the thread looks

    def turn_away() -> None:
        while not done.is_set():
            if end in select.select([listener, end], [], [])[0] or done.wait(GRACE_S):
                continue
            further = accept(listener, say)
            if further is not None:
                further.close()
                say("one client is connected already; another was turned away")

    thread = threading.Thread(target=turn_away, name="further clients", daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        wake.close()
        thread.join()
        end.close()


@contextlib.contextmanager
def one_client(say: Say) -> Iterator[None]:
    """What happens inside concerns one client: whatever is raised ends it, and nothing else."""
    try:
        yield
    except Refused as error:
        say(f"refused: {error}")
    except OSError:
        pass  # it has gone
    except Exception as error:
        LOG.exception("an error in the work for one client; its connection is closed")
        say(visible(f"connection closed by an error: {type(error).__name__}: {error}"))
