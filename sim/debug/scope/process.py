# SPDX-License-Identifier: Apache-2.0
"""The scope's server in a process of its own, next to a job that is busy with other things."""

from __future__ import annotations

import asyncio
import gc
import multiprocessing
import signal
import socket
import time
from typing import Any

from rich.console import Console

from sim.debug import guard
from sim.debug.scope import server
from sim.debug.scope.tap import HELD_S, TapSource


def _serve(source: TapSource, listening: socket.socket, token: str, pages: Any) -> None:
    gc.freeze()  # what the parent has left, such as models, is not ours to free
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def changed(number: int) -> None:
        pages.value = number

    asyncio.run(server.serve(source, listening, token, changed))


class ScopeProcess:
    """A context manager. The source's loop must begin in this process or a child of it.

    On leaving, what was recorded stays to be looked at while a page is open.
    """

    def __init__(self, source: TapSource, console: Console) -> None:
        self.source = source
        self._console = console
        self._pages = multiprocessing.Value("i", 0)
        listening, token = server.bind(), guard.new_token()
        self.url = server.address(listening, token)
        self._process = multiprocessing.Process(
            target=_serve, args=(source, listening, token, self._pages), daemon=True
        )
        self._process.start()
        listening.close()

    def __enter__(self) -> ScopeProcess:
        self._console.print(
            f"      scope: {self.url}\n"
            f"      the loop begins when this page is open, or after {HELD_S:g} s",
            soft_wrap=True,
            highlight=False,
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        *_: object,
    ) -> None:
        if self._pages.value and (kind is None or issubclass(kind, Exception)):
            if error is not None:
                self._console.print(f"error: {error}", markup=False, highlight=False)
            self._console.print("      the scope stays until its page is closed, or Ctrl-C")
            while self._pages.value and self._process.is_alive():
                time.sleep(0.2)
        self._process.terminate()
        self._process.join()
        self.source.close()
