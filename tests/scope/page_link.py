# SPDX-License-Identifier: Apache-2.0
"""Pages of the scope without a browser."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

from tornado.websocket import WebSocketClientConnection, websocket_connect

LIMIT = 600.0  # s, guard against a hang


class Page:
    """A page without a browser."""

    def __init__(self, link: WebSocketClientConnection) -> None:
        self.link = link

    def say(self, **message: Any) -> None:
        self.link.write_message(json.dumps(message))

    async def hear(self, kind: str, fits: Callable[[dict], bool] = lambda m: True) -> dict:
        """The next message of a kind that fits; frames are answered, as a page does."""
        while True:
            text = await asyncio.wait_for(self.link.read_message(), LIMIT)
            assert text is not None, "the server has closed the link"
            message = json.loads(text)
            if message["type"] == "frame":
                self.say(type="ready")
            if message["type"] == kind and fits(message):
                return message


def socket_of(url: str) -> str:
    """Address of the web socket of the page at an address."""
    return url.replace("http", "ws") + "ws"


def talk(url: str, act: Callable[..., Awaitable[None]], pages: int = 1) -> None:
    """Run `act` with so many open pages."""

    async def main() -> None:
        links = [await websocket_connect(socket_of(url)) for _ in range(pages)]
        await act(*map(Page, links))
        for link in links:
            link.close()

    asyncio.run(main())
