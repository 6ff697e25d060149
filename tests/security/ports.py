# SPDX-License-Identifier: Apache-2.0
"""The servers of this project, each as a process, and what is sent to them."""

from __future__ import annotations

import binascii
import json
import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from asip_asm.project import ROOT
from sim.debug import guard
from sim.debug.packets import Packet, Type, encode, read_body, write_body
from tests.debugger.debugged import LEG

LIMIT_S = 60.0  # guard against a hang
HOST = guard.LOOPBACK
SCOPED = """
import asyncio, sys, threading
from sim import guard
from sim.debug.scope import server
from tests.scope.fake_source import FakeSource

listening, token = server.bind(), guard.new_token()
print(server.address(listening, token), flush=True)
asyncio.run(server.serve(FakeSource(), listening, token))
"""


@dataclass
class Running:
    """A server in a process of its own; `said` are the lines that it has printed."""

    process: subprocess.Popen[str]
    port: int
    token: str
    said: list[str] = field(default_factory=list)

    def connect(self) -> socket.socket:
        """A connection to it."""
        return socket.create_connection((HOST, self.port), LIMIT_S)

    def alive(self) -> bool:
        """Whether the process goes on."""
        return self.process.poll() is None


@dataclass(frozen=True)
class Port:
    """A server: its command, the message that reaches it from a web page, its packets.

    harmful: bytes that change something, as a client of the protocol sends them after its
    greeting. works: whether an own client is served, with the token if one is due.
    """

    name: str
    command: tuple[str, ...]
    address: str
    harmful: bytes
    greeting: Callable[[str], bytes]
    works: Callable[[Running], bool]
    random: Callable[[Random], bytes]
    crafted: tuple[bytes, ...]
    token_due: bool = True

    @contextmanager
    def start(self) -> Iterator[Running]:
        """The server, ready for clients; ended by an interrupt."""
        process = subprocess.Popen(
            [sys.executable, *self.command],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        assert process.stdout is not None
        said: list[str] = []
        found = None
        while found is None and (line := process.stdout.readline()):
            said.append(line)
            found = re.search(self.address, line)
        assert found, "".join(said)
        port = int(found["port"])
        token = found.groupdict().get("token") or guard.token_of(HOST, port)
        reader = threading.Thread(target=lambda: said.extend(process.stdout), daemon=True)
        reader.start()
        try:
            yield Running(process, port, token, said)
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(LIMIT_S)
            except subprocess.TimeoutExpired:
                process.kill()
            reader.join(LIMIT_S)


def talk(server: Running, data: bytes, wait: float = 2.0) -> bytes:
    """What the server answers to these bytes until it closes, or is silent for so long."""
    answer = b""
    try:
        with server.connect() as peer:
            peer.settimeout(wait)
            peer.sendall(data)
            while part := peer.recv(65536):
                answer += part
    except OSError:
        pass
    return answer


def post(body: bytes, host: str, path: str = "/") -> bytes:
    """The request that a page of another origin can make any browser send."""
    head = f"POST {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://evil.example\r\n"
    head += "Content-Type: text/plain\r\nConnection: close\r\n"
    head += f"Content-Length: {len(body)}\r\n\r\n"
    return head.encode() + body


# ---------------------------------------------------------------------- GDB
def _gdb(data: bytes) -> bytes:
    return b"$%s#%02x" % (data, sum(data) & 255)


def _gdb_works(server: Running) -> bool:
    return b"T05" in talk(server, b"+" + _gdb(b"?"), 1.0)


_GDB_STARTS = (b"vCont", b"m", b"M", b"X", b"Z0,", b"z1,", b"G", b"P", b"p", b"qRcmd,", b"q", b"H")
_GDB_CRAFTED = tuple(
    _gdb(data)
    for data in (
        *(
            b"vCont",
            b"vCont;",
            b"vCont;x",
            b"vCont:",
            b"vCont?x",
            b"vRun;",
            b"vMustReplyE",
        ),
        *(
            b"m",
            b"m,",
            b"mffffffff,ffffffff",
            b"m0,-1",
            b"m-1,4",
            b"m0,0",
            b"m1,2,3",
            b"m\xff,\xff",
        ),
        *(b"M0,4:", b"M0,4:zz", b"M0,1:0", b"M,:", b"M0", b"X0,1:", b"X0,0:", b"Xffffffff,4:abcd"),
        *(b"G", b"G0", b"Gzz", b"G" + b"0" * 4000, b"P", b"P=", b"Pff=00000000", b"P-1=00000000"),
        *(b"p", b"p-1", b"pffff", b"pzz", b"Z", b"Z0", b"Z0,0", b"Z9,0,4", b"Z0,zz,4", b"z0,0,0"),
        *(
            b"Z0,0,4;X1,00",
            b"Z2,ffffffff,ffffffff",
            b"qRcmd,",
            b"qRcmd,6",
            b"qRcmd,zz",
            b"qRcmd,ff",
        ),
        *(
            b"qRcmd," + word.hex().encode()
            for word in (b"", b"help", b"freeze x", b"x y", b"\0", b"r")
        ),
        *(
            b"qXfer:features:read:",
            b"qXfer:features:read:target.xml:",
            b"qXfer:memory-map:read::-1,4",
        ),
        *(b"qXfer:features:read:target.xml:fffffff,ffffff", b"qXfer:features:read:../x:0,4"),
        *(
            b"c-1",
            b"czz",
            b"szz",
            b"C",
            b"C05;zz",
            b"S;",
            b"H",
            b"Hg-1",
            b"T",
            b"T0",
            b"!",
            b"?",
            b"g",
        ),
        *(
            b"QStartNoAckMode",
            b"qSupported:\xff",
            b"v",
            b"",
            b"\0",
            b"}",
            b"}}",
            b"*",
            b"a" * 16000,
        ),
    )
) + (
    b"$#00",
    b"$",
    b"$$$$#00",
    b"#",
    b"$a#zz",
    b"\x03\x03\x03",
    b"---",
    b"$" + b"a" * 70000,
    b"\r\n",
)


def _gdb_random(rng: Random) -> bytes:
    kind = rng.randrange(4)
    if kind == 0:
        return rng.randbytes(rng.randrange(1, 60))
    data = rng.choice(_GDB_STARTS) if kind > 1 else b""
    alphabet = b"0123456789abcdef,;:=-" if kind == 3 else bytes(range(256))
    data += bytes(rng.choice(alphabet) for _ in range(rng.randrange(24)))
    data = data.replace(b"#", b"").replace(b"$", b"")
    # Kill ends a server on purpose.
    return _gdb(data.removeprefix(b"vKill").lstrip(b"k"))


# ---------------------------------------------------------------------- debug block
def _write(address: int, word: int) -> bytes:
    return encode(Packet(Type.WRITE, 1, write_body(address, [word])))


def _block_works(server: Running) -> bool:
    ask = encode(Packet(Type.READ, 9, read_body(0, 1)))
    return len(talk(server, guard.hello(server.token) + ask, 1.0)) > 6


def _frame(content: bytes) -> bytes:
    """A frame with a right CRC around any content."""
    content += binascii.crc_hqx(content, 0xFFFF).to_bytes(2, "big")
    return b"".join(bytes([len(part) + 1]) + part for part in content.split(b"\0")) + b"\0"


def _block_random(rng: Random) -> bytes:
    if rng.randrange(2):
        return rng.randbytes(rng.randrange(1, 60)) + b"\0"
    return _frame(
        bytes([rng.choice((1, 2, 0x81, 0xC0, rng.randrange(256)))])
        + rng.randbytes(rng.randrange(40))
    )


_BLOCK_CRAFTED = (
    *(_frame(bytes([kind, n]) + b"\xff" * n) for kind in (0, 1, 2, 3, 127, 255) for n in range(16)),
    *(
        _frame(bytes([1, 7]) + struct + bytes([n]))
        for n in (0, 1, 60, 61, 255)
        for struct in (b"\0\0", b"\xff\xff")
    ),
    *(_frame(bytes([2, n]) + b"\xff\x7f" + b"\xff" * 4 * n) for n in range(1, 10)),
    *(bytes([n]) * 300 + b"\0" for n in (1, 2, 127, 255)),
    *(b"\0" * n for n in (1, 2, 100)),
    *(guard.hello("x" * n) for n in (0, 1, 200)),
)


# ---------------------------------------------------------------------- DAP
def dap(command: str, **arguments: object) -> bytes:
    """A request with its header."""
    message = {"seq": 1, "type": "request", "command": command, "arguments": arguments}
    return dap_raw(json.dumps(message).encode())


def dap_raw(data: bytes) -> bytes:
    """Any content after the protocol's header."""
    return b"Content-Length: %d\r\n\r\n" % len(data) + data


def _dap_works(server: Running) -> bool:
    ask = dap("launch", program=str(LEG), iss=True, token=server.token) + dap("disconnect")
    return talk(server, ask).count(b'"success": true') == 2


def _dap_random(rng: Random) -> bytes:
    kind = rng.randrange(4)
    if kind == 0:
        return rng.randbytes(rng.randrange(1, 60))
    if kind == 1:
        return dap_raw(rng.randbytes(rng.randrange(1, 60)))
    words = ("program", "threadId", "line", "expression", "source", "breakpoints", "token", "set")
    values = ("--help", -1, 1e999, None, [], {}, "x" * 50, True, "0x", "\0", {"path": 3}, [None])
    given = {rng.choice(words): rng.choice(values) for _ in range(rng.randrange(4))}
    return dap(rng.choice(_DAP_COMMANDS), **given)


_DAP_COMMANDS = (
    *("initialize", "launch", "attach", "configurationDone", "restart", "pause", "continue"),
    *("setBreakpoints", "stackTrace", "scopes", "variables", "evaluate", "setVariable", "close"),
    *("completions", "disassemble", "exceptionInfo", "threads", "source", "handle", "_go", ""),
)
_DAP_CRAFTED = (
    *(dap(command) for command in _DAP_COMMANDS),
    *(
        dap("launch", program=text)
        for text in ("--help", "-h", "", "\0", "/", "/dev/zero", "x" * 9999)
    ),
    *(
        dap("launch", **{name: value})
        for name in ("set", "inputs", "connect", "function", "iss", "token")
        for value in ("--help", [], {}, 1, None, {"a": {"b": 1}})
    ),
    *(
        dap_raw(data)
        for data in (
            b"{}",
            b"[]",
            b"null",
            b"1",
            b'"x"',
            b"[" * 4000,
            b'{"seq": 1e999}',
            b'{"type": 3}',
            b'{"type": "request"}',
            b'{"type": "request", "command": []}',
            b"\xff",
            b"NaN",
        )
    ),
    *(
        b"Content-Length: %s\r\n\r\n{}" % n
        for n in (b"-1", b"0", b"", b"x", b"9" * 400, b"+2", b"2.0", b"\xb2")
    ),
    *(
        b"\r\n",
        b"\n" * 100,
        b":\r\n\r\n",
        b"Content-Length\r\n\r\n",
        b"A" * 5000,
        b"Content-Type: x\r\n\r\n",
    ),
    b"Content-Length: 100\r\n\r\n{}",
    *(
        dap("initialize") + dap(command, **{name: value})
        for command in ("evaluate", "disassemble", "setVariable")
        for name in ("expression", "memoryReference", "variablesReference")
        for value in (-1, "", [], None, "9" * 99)
    ),
)


# ---------------------------------------------------------------------- scope
def _scope_works(server: Running) -> bool:
    head = (
        f"GET /{server.token}/ HTTP/1.1\r\nHost: {HOST}:{server.port}\r\nConnection: close\r\n\r\n"
    )
    return b"200 OK" in talk(server, head.encode())[:20]


def _get(path: str, *fields: str) -> bytes:
    lines = (f"GET {path} HTTP/1.1", f"Host: {HOST}", "Connection: close", *fields, "", "")
    return "\r\n".join(lines).encode()


_UPGRADE = ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13")


def _scope_random(rng: Random) -> bytes:
    if rng.randrange(2):
        return rng.randbytes(rng.randrange(1, 60)) + b"\r\n\r\n"
    path = "".join(rng.choice("/.%0aZ~x?&=\u00e9") for _ in range(rng.randrange(30)))
    return _get("/" + path, "X: " + "".join(rng.choice("ab\t;=\"'") for _ in range(9)))


_SCOPE_CRAFTED = (
    *(
        _get(path)
        for path in (
            "",
            "/",
            "//",
            "/x/ws",
            "/x/export/a.b",
            "/../..",
            "/%2e%2e/",
            "/\0",
            "*",
            "http://x/",
        )
    ),
    *(_get("/x/ws", *_UPGRADE, f"Sec-WebSocket-Key: {key}") for key in ("", "x", "x" * 5000)),
    *(_get("/", f"Content-Length: {n}") for n in ("-1", "x", "9" * 50, "1e9", "0x10")),
    *(_get("/", f"Transfer-Encoding: {n}") for n in ("chunked", "x", "chunked, chunked")),
    *(_get("/", f"Cookie: {n}") for n in ("a" * 60000, "\u00e9", ";;;=")),
    *(
        f"{verb} / HTTP/{v}\r\nHost: x\r\n\r\n".encode()
        for verb in ("POST", "PUT", "TRACE", "x", "CONNECT")
        for v in ("1.1", "1.0", "2.0", "9", "")
    ),
    *(b"\r\n" * n for n in (1, 2, 100)),
    b"\0" * 100,
    b"\x16\x03\x01" + b"a" * 200,
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
)


PORTS = (
    Port(
        name="gdb",
        command=("-m", "sim.debug.nios_run", "--gdb", ":0"),
        address=r"target remote [\d.]+:(?P<port>\d+)",
        harmful=_gdb(b"M10040000,4:78563412") + _gdb(b"m10040000,4"),
        greeting=lambda token: b"+" + _gdb(b"!"),
        works=_gdb_works,
        random=_gdb_random,
        crafted=_GDB_CRAFTED,
        token_due=False,
    ),
    Port(
        name="block",
        command=("-m", "sim.debug.server", str(LEG), "--port", "0", "--period", "200"),
        address=r"tcp://localhost:(?P<port>\d+)",
        harmful=b"\0" + _write(0x400, 0x3F800000),
        greeting=guard.hello,
        works=_block_works,
        random=_block_random,
        crafted=_BLOCK_CRAFTED,
    ),
    Port(
        name="dap",
        command=("-m", "sim.debug.asip_dbg", "--dap", "--port", "0", "--iss", str(LEG)),
        address=r"Protocol on [\d.]+:(?P<port>\d+)",
        harmful=dap("launch", program=str(LEG), connect="tcp://127.0.0.1:9"),
        greeting=lambda token: b"",
        works=_dap_works,
        random=_dap_random,
        crafted=_DAP_CRAFTED,
    ),
    Port(
        name="scope",
        command=("-c", SCOPED),
        address=r"http://[\d.]+:(?P<port>\d+)/(?P<token>[\w-]+)/",
        harmful=_get("/x/ws"),
        greeting=lambda token: b"",
        works=_scope_works,
        random=_scope_random,
        crafted=_SCOPE_CRAFTED,
    ),
)


def program_file(text: str, folder: Path) -> Path:
    """A source text for a server to debug."""
    path = folder / "program.s"
    path.write_text(text)
    return path
