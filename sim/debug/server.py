# SPDX-License-Identifier: Apache-2.0
"""Serve a simulated core with its debug block over TCP, by the packets of docs/debug_block.md.

    .venv/bin/python -m sim.debug.server PROGRAM --port 2331

The server loads the program (source or image) and starts a run every --period clocks until it is
interrupted. Inputs have the values given with --set, or 0. It serves one client at a time, and
listens on the loopback address only. A client must send the server's token first;
the client of this project finds the token of a server of the same user by itself.
"""

from __future__ import annotations

import contextlib
import select
import socket
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from asip_asm.assemble import assemble
from asip_asm.command import command, command_parser
from asip_asm.diagnostics import AssemblyError
from asip_asm.image import Image, ImageError
from asip_asm.isa import default_isa
from sim.core.api import CoreError
from sim.debug import guard
from sim.debug.link import Responder
from sim.debug.model import DebugRtl
from sim.debug.packets import Decoder, encode
from sim.debug.state import word_of
from sim.robot.parameters import Robot
from sim.rtl.asip_bus import BLOCK, CSR, START, STATUS

PORT = 2331
SLICE = 2000  # clocks between two looks at the socket


def _say(text: str) -> None:
    print(f"debug server: {text}", file=sys.stderr, flush=True)


class Server:
    """Answers the packets of one client at a time; call `poll` again and again."""

    def __init__(self, model: DebugRtl, port: int = PORT, say: guard.Say = _say) -> None:
        """Raises OSError if the port is taken; port 0 takes a free one, see `port`."""
        self._model, self._say = model, say
        self._listener = guard.listen(port, say)
        self._listener.setblocking(False)
        self.port = self._listener.getsockname()[1]
        self.token = guard.Token(self.port)
        self._client: socket.socket | None = None
        self._begun = 0.0

    def poll(self, timeout: float = 0.0) -> None:
        """Take a new client, or answer what has come, waiting so many seconds for it."""
        watched = [each for each in (self._client, self._listener) if each is not None]
        for ready in select.select(watched, [], [], timeout)[0]:
            if ready is self._listener:
                self._accept()
            else:
                self._answer()
        if self._client is not None and not self._hello.done:
            if time.monotonic() > self._begun + guard.HELLO_S:
                self._drop()

    def _accept(self) -> None:
        connection = guard.accept(self._listener, self._say)
        if connection is None:
            return
        if self._client is not None:
            connection.close()
            return
        self._client, self._begun = connection, time.monotonic()
        self._hello, self._decoder = guard.Hello(self.token), Decoder()
        self._responder = Responder(self._model)

    def _answer(self) -> None:
        assert self._client is not None
        goes_on = False
        with guard.one_client(self._say):
            data = self._client.recv(65536)
            for packet in self._decoder.feed(self._hello.feed(data)):
                self._client.sendall(encode(self._responder.answer(packet)))
            goes_on = bool(data)
        if not goes_on:
            self._drop()

    def _drop(self) -> None:
        assert self._client is not None
        self._client.close()
        self._client = None

    def close(self) -> None:
        """Close the port and the client's connection."""
        self.token.forget()
        for each in (self._client, self._listener):
            if each is not None:
                with contextlib.suppress(OSError):
                    each.close()


def serve(
    model: DebugRtl, server: Server, period: int, going: Callable[[], bool] = lambda: True
) -> None:
    """Start a run every `period` clocks and answer the client, while `going` says so.

    A held core keeps its run; the next one is started when it has ended.
    """
    while going():
        model.write(CSR["CONTROL"], START)
        begun = model.cycles
        while going() and (
            model.cycles - begun < period or STATUS["busy"].of(model.read(CSR["STATUS"]))
        ):
            server.poll()
            model.clock(min(SLICE, period))


def _settings(image: Image, settings: Sequence[str]) -> dict[int, int]:
    """Words of inputs by index. Raises CoreError."""
    inputs = {entry.name: entry for entry in image.inputs}
    words = {entry.index: 0 for entry in image.inputs}
    for setting in settings:
        name, _, text = setting.partition("=")
        try:
            words[inputs[name].index] = word_of(float(text), inputs[name].type)
        except (KeyError, ValueError):
            known = ", ".join(inputs) or "none"
            raise CoreError(f"--set {setting}: write NAME=NUMBER; inputs are {known}") from None
    return words


@command("python -m sim.debug.server")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit 0 interrupted, 1 for a program, value or port that does not work."""
    parser = command_parser("python -m sim.debug.server", __doc__)
    parser.add_argument("program", type=Path, help="assembly source, or image (*.json)")
    parser.add_argument("--port", type=int, default=PORT, help=f"default {PORT}; 0: a free one")
    period = round(Robot.load().T_s * 1e6 * default_isa().clock_mhz)
    parser.add_argument("--period", type=int, default=period, help="clocks from run to run")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=NUMBER", help="input of every run"
    )
    options = parser.parse_args(arguments)
    try:
        path = options.program
        image = Image.load(path) if path.suffix == ".json" else assemble(path)
        words = _settings(image, options.set)
        model = DebugRtl(image.configuration)
        server = Server(model, options.port)
    except (AssemblyError, ImageError, CoreError, OverflowError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    model.load(image)
    for index, word in words.items():
        model.write(BLOCK["constants"] + index, word)
    print(f"{image.title or options.program.name}: tcp://localhost:{server.port}", flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        serve(model, server, options.period)
    server.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
