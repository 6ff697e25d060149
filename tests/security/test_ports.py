# SPDX-License-Identifier: Apache-2.0
"""Every port: who is served, who is refused, and that no client ends a server."""

from __future__ import annotations

import os
import re
import socket
import struct

import pytest

from sim.debug import guard
from sim.rtl import private
from tests.bench.seed import SEED
from tests.security.campaign_ports import (
    crafted,
    foreign_clients,
    survives,
    survives_crafted,
)
from tests.security.ports import PORTS

PACKETS = 300


@pytest.fixture(scope="module", params=PORTS, ids=lambda port: port.name)
def running(request):
    with request.param.start() as server:
        yield request.param, server


@pytest.mark.quick("gdb")
def test_own_client_is_served(running):
    port, server = running
    assert port.works(server), server.said


def test_web_page_rebound_host_and_client_without_token_are_refused(running):
    port, server = running
    assert foreign_clients(port, server) == []
    assert port.works(server), server.said


@pytest.mark.quick("gdb")
def test_no_packet_ends_the_server(running):
    port, server = running
    assert len(crafted(port)) >= 200
    assert survives_crafted(port, server, both=False) == ""
    assert survives(port, server, SEED, PACKETS) == ""


def test_client_that_resets_its_connection_ends_nothing(running):
    port, server = running
    for data in (b"", port.greeting(server.token), port.greeting(server.token) + port.harmful):
        peer = server.connect()
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        peer.sendall(data)
        peer.close()
    assert port.works(server), server.said


# ---------------------------------------------------------------------- the guard itself
@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"POST / HTTP/1.1\r\n", True),
        (b"GET /x", True),
        (b"+$g#67\r\nhost: x", True),
        (b"FOO /x HTTP/2\r\n", True),
        (b"Content-Length: 5\r\n", False),
        (b"+$vCont;c#a8", False),
        (b"token abc\n", False),
    ],
)
def test_http_is_known_by_its_lines(data, expected):
    assert guard.looks_like_http(data) is expected


def test_another_address_is_warned_of():
    said: list[str] = []
    guard.listen(0, said.append).close()
    assert said == []
    guard.listen(0, said.append, "0.0.0.0").close()
    assert re.search(r"warning: 0\.0\.0\.0 is no loopback address.*ssh -L", said[0])


def test_client_of_another_user_is_refused(monkeypatch):
    """The kernel's table names the user of the connecting socket."""
    said: list[str] = []
    with guard.listen(0, said.append) as listener:
        with socket.create_connection(listener.getsockname()):
            client = guard.accept(listener, said.append)
            assert client is not None
            client.close()
        monkeypatch.setattr(guard.os, "getuid", lambda: 4242)
        monkeypatch.setattr(guard, "ALLOWED", ())
        with socket.create_connection(listener.getsockname()):
            assert guard.accept(listener, said.append) is None
    assert f"a client of the user {os.stat('/proc/self').st_uid}" in said[-1]


def test_socket_without_a_process_tells_no_user():
    table = "head\n 0: 0100007F:0050 0100007F:1F90 01 0:0 0:0 0 1000 0 77 1\n"
    table += " 1: 0100007F:0051 0100007F:1F90 04 0:0 0:0 0 0 0 0 1\n"
    assert guard.user_of(table, ("127.0.0.1", 80), ("127.0.0.1", 8080)) == 1000
    assert guard.user_of(table, ("127.0.0.1", 81), ("127.0.0.1", 8080)) is None


def test_token_is_in_a_file_of_this_user_alone(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    token = guard.Token(65000)
    (file,) = (tmp_path / "microtick").iterdir()
    assert file.stat().st_mode & 0o777 == 0o600
    assert file.parent.stat().st_mode & 0o777 == 0o700
    assert guard.token_of("localhost", 65000) == token.text
    assert guard.token_of("example.org", 65000) == ""
    token.forget()
    assert guard.token_of("127.0.0.1", 65000) == ""


def test_hello_comes_in_pieces_and_leaves_what_follows():
    token = guard.Token(65001)
    try:
        hello = guard.Hello(token)
        got = [hello.feed(bytes([byte])) for byte in guard.hello(token.text) + b"ab"]
        assert b"".join(got) == b"ab" and hello.done
        for wrong in (b"POST / HTTP/1.1", b"x", b"token " + b"a" * 200, b"token \n", b"\0"):
            with pytest.raises(guard.Refused):
                guard.Hello(token).feed(wrong)
    finally:
        token.forget()


# ---------------------------------------------------------------------- private folders
def test_private_folder_of_others_is_refused(tmp_path, monkeypatch):
    folder = private.private_folder(tmp_path / "a")
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o755)
    assert private.private_folder(folder).stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    with pytest.raises(OSError, match="other users may write into it"):
        private.private_folder(folder)
    folder.chmod(0o700)
    (tmp_path / "link").symlink_to(folder)
    with pytest.raises(OSError, match="is no folder"):
        private.private_folder(tmp_path / "link")
    monkeypatch.setattr(private.os, "getuid", lambda: 4242)
    with pytest.raises(OSError, match="belongs to the user"):
        private.private_folder(folder)


def test_further_client_is_turned_away_and_one_after_the_first_is_served():
    said: list[str] = []
    with guard.listen(0, said.append) as listener:
        place = listener.getsockname()
        with socket.create_connection(place), guard.only_client(listener, said.append):
            first = guard.accept(listener, said.append)
            assert first is not None
            with first, socket.create_connection(place, timeout=10) as second:
                assert second.recv(1) == b""
        assert said == ["one client is connected already; another was turned away"]
        with socket.create_connection(place):
            after = guard.accept(listener, said.append)
            assert after is not None
            after.close()
