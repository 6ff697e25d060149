# SPDX-License-Identifier: Apache-2.0
"""Server of the Debug Adapter Protocol: `asip-dbg --dap` on standard input and output or TCP."""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import sys
from typing import BinaryIO

from sim.debugger.dap_adapter import Adapter
from sim.debugger.dap_messages import MessageError, Sender, read_message

LOOPBACK = "127.0.0.1"


def serve(options: argparse.Namespace) -> int:
    """Serve one client on standard input and output, or with `port` one after another on TCP."""
    if options.port is None:
        with _standard_streams() as (reader, writer):
            return serve_client(reader, writer, options)
    with socket.create_server((LOOPBACK, options.port)) as server:
        port = server.getsockname()[1]
        print(f"asip-dbg: Debug Adapter Protocol on {LOOPBACK}:{port}", file=sys.stderr, flush=True)
        while True:
            client, _ = server.accept()
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with client, client.makefile("rb") as reader, client.makefile("wb") as writer:
                with contextlib.suppress(OSError):
                    serve_client(reader, writer, options)


def serve_client(reader: BinaryIO, writer: BinaryIO, options: argparse.Namespace) -> int:
    """Serve a client to its end; exit status 1 if it does not speak the protocol."""
    adapter = Adapter(Sender(writer), options)
    try:
        while not adapter.ended:
            message = read_message(reader)
            if message is None:
                return 0
            adapter.handle(message)
        return 0
    except MessageError as error:
        print(
            f"asip-dbg: error: {error}; --dap is for clients of the Debug Adapter Protocol",
            file=sys.stderr,
        )
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
