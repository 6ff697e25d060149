# SPDX-License-Identifier: Apache-2.0
"""Ports under attack: web pages, clients without a token, random and crafted packets."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator, Sequence
from functools import partial
from random import Random

from sim.report.goals import Goal, depth, exactly
from tests.security.outcomes import resumed
from tests.security.ports import HOST, PORTS, Port, Running, post, talk

RANDOM, SAMPLE = 100_000, 1_000
CRAFTED = 200
BATCH = 100  # packets of a connection


def obeyed(port: Port, answer: bytes) -> bool:
    """Whether the answer shows that a message of the protocol was carried out."""
    if port.name == "dap":
        return b'"success": true' in answer
    if port.name == "scope":
        return any(status in answer[:20] for status in (b" 200 ", b" 101 "))
    return bool(answer.strip(b"+-"))


def page(path: str, host: str) -> bytes:
    """The request of a browser that was led to a path of this machine by another name."""
    return f"GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode()


def foreign_clients(port: Port, server: Running) -> list[str]:
    """Kinds of clients without a right to it that the server obeys."""
    here = f"{HOST}:{server.port}"
    path = f"/{server.token}/" if port.name == "scope" else "/"
    tries = {
        "POST of a page": post(port.harmful, here),
        "POST without a body's length": post(port.harmful, here).replace(b"Content-Length", b"X"),
        "message in the first line": port.harmful + post(b"", here) if port.token_due else b"",
        "rebound host": page(path, f"evil.example:{server.port}"),
        "Host line alone": b"Host: evil.example\r\n" + port.harmful,
    }
    if port.token_due:
        tries["no token"] = port.harmful
        tries["wrong token"] = port.greeting("x" * 22) + port.harmful
    return [name for name, data in tries.items() if data and obeyed(port, talk(server, data))]


def send_packets(server: Running, greeting: bytes, packets: Sequence[bytes]) -> None:
    """Send packets on a connection, and take whatever comes back until the server closes it."""
    try:
        with server.connect() as peer:
            peer.sendall(greeting + b"".join(packets))
            peer.shutdown(socket.SHUT_WR)
            while peer.recv(65536):
                pass
    except ConnectionError:
        pass  # the server may close whenever it likes


def crafted(port: Port) -> list[bytes]:
    """At least CRAFTED packets: those of the table, and each of them cut and doubled."""
    found = list(port.crafted)
    for packet in port.crafted:
        found += [packet[: len(packet) // 2], packet * 2, packet[:-1]]
    return found


def survives(port: Port, server: Running, seed: int, count: int) -> str:
    """Why the server does not serve any more after so many random packets; empty if it does.

    Every second connection begins with the token, to get deeper.
    """
    rng = Random(f"{port.name} {seed}")
    for first in range(0, count, BATCH):
        packets = [port.random(rng) for _ in range(min(BATCH, count - first))]
        send_packets(server, port.greeting(server.token) if first // BATCH % 2 else b"", packets)
        if not server.alive():
            return f"ended in packets {first} to {first + BATCH} of seed {seed}"
    return "" if port.works(server) else f"does not answer after {count} packets of seed {seed}"


def survives_crafted(port: Port, server: Running, both: bool) -> str:
    """The same after each crafted packet, with the token before it or without; both: once each."""
    greetings = (b"", port.greeting(server.token))
    for n, packet in enumerate(crafted(port)):
        for greeting in greetings if both else greetings[n % 2 :][:1]:
            send_packets(server, greeting, [packet])
        if not server.alive():
            return f"ended by crafted packet {n}: {packet[:60]!r}"
    return "" if port.works(server) else "does not answer after the crafted packets"


def outcome(port: Port, full: bool) -> dict[str, list[str]]:
    """Clients without a right that a port obeys, and why its server has ended if it has."""
    with port.start() as server:
        obeying = [f"{port.name}: {text}" for text in foreign_clients(port, server)]
        count = RANDOM if full else SAMPLE
        why = survives_crafted(port, server, full) or survives(port, server, 1, count)
    return {"obeying": obeying, "ended": [f"{port.name} {why}"] if why else []}


def rows(full: bool) -> Iterator[Goal]:
    """Goals of the ports; the full form resumes."""
    found = []
    for port in PORTS:
        measure = partial(outcome, port, full)
        found.append(resumed("ports", port.name, measure) if full else measure())
    obeying = [text for each in found for text in each["obeying"]]
    ended = [text for each in found for text in each["ended"]]
    sent = (RANDOM if full else SAMPLE) * sum(not each["ended"] for each in found)
    least = min(len(crafted(port)) for port in PORTS)
    yield exactly("ports.foreign_clients_obeyed", len(obeying), 0, "cases", json.dumps(obeying))
    yield exactly("ports.servers_ended", len(ended), 0, "servers", json.dumps(ended))
    cure = "make goals T=security RUN=full sends all"
    yield depth("ports.random_packets_each", sent / len(PORTS), RANDOM, "packets", cure)
    yield depth("ports.crafted_packets_each", least, CRAFTED, "packets", cure)
