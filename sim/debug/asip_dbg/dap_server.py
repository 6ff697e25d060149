# SPDX-License-Identifier: Apache-2.0
"""Server of the Debug Adapter Protocol: `asip-dbg --dap` on standard input and output or TCP."""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import sys
from typing import BinaryIO

from sim.debug import guard
from sim.debug.asip_dbg.dap_adapter import Adapter
from sim.debug.asip_dbg.dap_messages import MessageError, Sender, read_message


def serve(options: argparse.Namespace) -> int:
    """Serve one client on standard input and output, or with `port` one after another on TCP."""
    if options.port is None:
        with _standard_streams() as (reader, writer):
            return serve_client(reader, writer, options)
    with guard.listen(options.port, _say) as listener:
        port = listener.getsockname()[1]
        token = guard.Token(port)
        _say(f"Debug Adapter Protocol on {guard.LOOPBACK}:{port}")
        _say(f'launch and attach need the argument "token": "{token.text}"')
        try:
            while True:
                client = guard.accept(listener, _say)
                if client is not None:
                    with guard.only_client(listener, _say):
                        _serve_socket(client, options, token)
        finally:
            token.forget()


def _serve_socket(client: socket.socket, options: argparse.Namespace, token: guard.Token) -> None:
    with guard.one_client(_say), client:
        with client.makefile("rb") as reader, client.makefile("wb") as writer:
            serve_client(reader, writer, options, token)


def _say(text: str) -> None:
    print(f"asip-dbg: {text}", file=sys.stderr, flush=True)


def serve_client(
    reader: BinaryIO,
    writer: BinaryIO,
    options: argparse.Namespace,
    token: guard.Token | None = None,
) -> int:
    """Serve a client to its end; exit status 1 if it does not speak the protocol.

    token: what `launch` and `attach` must give, which reach files and boards.
    """
    adapter = Adapter(Sender(writer), options, token)
    try:
        while not adapter.ended:
            message = read_message(reader)
            if message is None:
                return 0
            adapter.handle(message)
        return 0
    except MessageError as error:
        _say(f"error: {error}; --dap is for clients of the Debug Adapter Protocol")
        return 1
    finally:
        adapter.close()


@contextlib.contextmanager
def _standard_streams():
    """Standard input and output for the protocol alone: what else is printed goes to standard
    error.
    """
    sys.stdout.flush()
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    try:
        yield sys.stdin.buffer, output
    finally:
        with contextlib.suppress(OSError):
            output.close()
