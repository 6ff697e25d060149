# SPDX-License-Identifier: Apache-2.0
"""A client of the Debug Adapter Protocol that holds every message against the published schema.

The schema is debugProtocol.json of the protocol's own repository, as the package debugpy carries
it. Requests are held against it too, so that the sessions are ones that a real client could have.
"""

from __future__ import annotations

import importlib.util
import json
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO

import jsonschema

from asip_asm.project import ROOT

TIMEOUT = 60.0  # guard against a hang


@cache
def schema() -> dict[str, Any]:
    """The protocol's schema."""
    found = importlib.util.find_spec("debugpy")
    assert found is not None and found.origin is not None
    folder = Path(found.origin).parent / "_vendored/pydevd/_pydevd_bundle/_debug_adapter"
    return json.loads((folder / "debugProtocol.json").read_text())


def definition(message: dict[str, Any]) -> str:
    """Name of the schema's definition of a message."""
    kind = message["type"]
    if kind == "response" and not message["success"]:
        return "ErrorResponse"
    name = message["event" if kind == "event" else "command"]
    return f"{name[0].upper()}{name[1:]}{kind.capitalize()}"


def validate(message: dict[str, Any]) -> None:
    """Raises ValidationError for a message that the schema does not allow."""
    _validator(definition(message)).validate(message)


@cache
def _validator(name: str) -> jsonschema.Draft4Validator:
    assert name in schema()["definitions"], f"the protocol has no {name}"
    return jsonschema.Draft4Validator(
        {"$ref": f"#/definitions/{name}", "definitions": schema()["definitions"]}
    )


class DapClient:
    """Speaks over two streams; `seen` are the definitions that were checked, `refused` the texts of
    messages that the schema does not allow, which raise ValidationError unless `lenient`.
    """

    def __init__(self, reader: BinaryIO, writer: BinaryIO, lenient: bool = False) -> None:
        self.lenient = lenient
        self.refused: list[str] = []
        self.writer = writer
        self.sequence = 0
        self.events: list[dict[str, Any]] = []
        self.seen: set[str] = set()
        self.output: list[str] = []
        self.received = 0
        self._messages: queue.Queue[dict[str, Any] | None] = queue.Queue()
        threading.Thread(target=self._read, args=(reader,), daemon=True).start()

    def _read(self, reader: BinaryIO) -> None:
        while line := reader.readline():
            name, _, length = line.partition(b":")
            assert name == b"Content-Length" and reader.readline() == b"\r\n"
            self._messages.put(json.loads(reader.read(int(length))))
        self._messages.put(None)

    def _next(self) -> dict[str, Any]:
        message = self._messages.get(timeout=TIMEOUT)
        assert message is not None, "the server closed the connection"
        self.received += 1
        self._check(message)
        if message.get("event") == "output":
            self.output.append(message["body"]["output"])
        return message

    def _check(self, message: dict[str, Any]) -> None:
        try:
            validate(message)
            self.seen.add(definition(message))
        except jsonschema.ValidationError as error:
            if not self.lenient:
                raise
            self.refused.append(error.message)

    def request(self, command: str, **arguments: Any) -> dict[str, Any]:
        """The response to a request; events on the way are stored."""
        self.sequence += 1
        message = {"seq": self.sequence, "type": "request", "command": command}
        if arguments:
            message["arguments"] = arguments
        self._check(message)
        return self.exchange(message)

    def exchange(self, message: dict[str, Any]) -> dict[str, Any]:
        """The response to a message that is sent as it is."""
        self.send(json.dumps(message).encode())
        while True:
            answer = self._next()
            if answer["type"] == "response":
                wanted = message["seq"], message["command"]
                assert (answer["request_seq"], answer["command"]) == wanted
                return answer
            self.events.append(answer)

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Body of a response that must be a success."""
        answer = self.request(command, **arguments)
        assert answer["success"], answer
        return answer.get("body", {})

    def go(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Ask for what lets the core go; body of the event that states where it stopped."""
        self.ask(command, **arguments)
        return self.event("stopped")

    def launch(self, program: Path, **arguments: Any) -> None:
        """The requests up to a program that may get its breakpoints."""
        self.ask("initialize", adapterID="asip", linesStartAt1=True, pathFormat="path")
        self.ask("launch", program=str(program), **arguments)
        self.event("initialized")

    def send(self, data: bytes) -> None:
        self.writer.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
        self.writer.flush()

    def event(self, name: str) -> dict[str, Any]:
        """Body of the next event of a name; others before it are dropped."""
        while True:
            message = self.events.pop(0) if self.events else self._next()
            if message["type"] == "event" and message["event"] == name:
                return message.get("body", {})


@contextmanager
def start_server(*arguments: str) -> Iterator[subprocess.Popen]:
    """asip-dbg with these arguments, its streams as pipes; killed at the end."""
    command = [sys.executable, "-m", "sim.debug.asip_dbg", *arguments]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen(command, cwd=ROOT, **pipes) as server:
        try:
            yield server
        finally:
            server.kill()  # nothing if it has ended


@contextmanager
def dap_session(lenient: bool = False) -> Iterator[DapClient]:
    """A client of a server of its own, which must end well when the client goes."""
    with start_server("--dap") as server:
        yield DapClient(server.stdout, server.stdin, lenient)
        server.stdin.close()
        assert server.wait(timeout=TIMEOUT) == 0, server.stderr.read().decode()
