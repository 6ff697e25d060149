# SPDX-License-Identifier: Apache-2.0
"""Messages of the Debug Adapter Protocol on a stream of bytes.

A message is JSON in UTF-8 after a header `Content-Length: N`, as the base protocol of
https://microsoft.github.io/debug-adapter-protocol/specification says.
"""

from __future__ import annotations

import json
import threading
from typing import Any, BinaryIO

from sim.debug.guard import looks_like_http

MESSAGE_BYTES = 4 << 20
"""Largest message that is read."""
HEADER_BYTES = 4096

Message = dict[str, Any]


class MessageError(Exception):
    """The stream is no protocol of this kind; nothing after this place can be read."""


def read_message(stream: BinaryIO) -> Message | None:
    """The next message; None at the end of the stream. Raises MessageError.

    The base protocol has two header fields, Content-Length and, for what hosts add, Content-Type.
    Any other one is the mark of a client of another kind, such as a browser.
    """
    length = None
    used = 0
    while True:
        line = stream.readline(HEADER_BYTES)
        used += len(line)
        if not line and length is None and used == 0:
            return None
        if not line.endswith(b"\n") or used > HEADER_BYTES:
            raise MessageError("a header that does not end")
        if not line.strip():
            break
        if looks_like_http(line):
            raise MessageError("a request of HTTP")
        name, _, value = line.strip().partition(b":")
        if name.lower() == b"content-length" and length is None:
            text = value.strip()
            if not text.isdigit() or len(text) > 8 or not 0 < int(text) <= MESSAGE_BYTES:
                raise MessageError(f"Content-Length is not 1 to {MESSAGE_BYTES}")
            length = int(text)
        elif name.lower() != b"content-type":
            raise MessageError("a header field that is not Content-Length, once, or Content-Type")
    if length is None:
        raise MessageError("a header without Content-Length")
    data = stream.read(length)
    if len(data) < length:
        raise MessageError("the stream ends inside a message")
    try:
        message = json.loads(data)
    except (ValueError, RecursionError):
        raise MessageError("a message that is no JSON") from None
    if not isinstance(message, dict):
        raise MessageError("a message that is no JSON object")
    return message


class Sender:
    """Writes messages with rising sequence numbers, from any thread."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._lock = threading.Lock()
        self._sequence = 0

    def _send(self, message: Message) -> None:
        with self._lock:
            self._sequence += 1
            data = json.dumps({"seq": self._sequence} | message).encode()
            self._stream.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
            self._stream.flush()

    def event(self, name: str, body: Message | None = None) -> None:
        """An event."""
        self._send({"type": "event", "event": name} | ({} if body is None else {"body": body}))

    def response(self, request: Message, body: Message | None = None) -> None:
        """The answer to a request that succeeded."""
        self._send(self._answer(request, True) | ({} if body is None else {"body": body}))

    def failure(self, request: Message, text: str) -> None:
        """The answer to a request that did not; clients show the text."""
        error = {"id": 1, "format": "{text}", "variables": {"text": text}, "showUser": True}
        self._send(self._answer(request, False) | {"message": text, "body": {"error": error}})

    @staticmethod
    def _answer(request: Message, success: bool) -> Message:
        sequence = request.get("seq")
        return {
            "type": "response",
            "request_seq": sequence if isinstance(sequence, int) else 0,
            "command": str(request.get("command", "")),
            "success": success,
        }
