# SPDX-License-Identifier: Apache-2.0
"""A simulated board at a pseudo terminal: programs open it as they open /dev/ttyUSB0."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import tty
from collections.abc import Callable, Iterator
from threading import Event, Thread

from sim.rtl.board.model import BoardRtl

SLICE = 2000
"""Clocks between two looks at the terminal."""
RESTS = 200
"""Slices without a byte in either direction after which the simulation waits for the next one."""


class SerialDevice:
    """The serial port of a board as `path`; call `poll` again and again."""

    def __init__(self, board: BoardRtl) -> None:
        self.board = board
        self._here, self._there = pty.openpty()  # that end stays open: clients come and go
        tty.setraw(self._there)
        os.set_blocking(self._here, False)
        self.path = os.ttyname(self._there)
        self._quiet = 0

    def poll(self, timeout: float = 0.1) -> None:
        """Simulate a slice; a board that has been quiet for long waits so many seconds first."""
        idle = self._quiet >= RESTS
        if select.select([self._here], [], [], timeout if idle else 0)[0]:
            self.board.write(os.read(self._here, 4096))
            self._quiet = 0
        if self._quiet >= RESTS:
            return
        self.board.clock(SLICE)
        data = self.board.read()
        self._quiet = 0 if data else self._quiet + 1
        # Nobody reads: what a terminal cannot take is lost, as on a line.
        with contextlib.suppress(BlockingIOError):
            os.write(self._here, data)

    def close(self) -> None:
        """End the terminal; the board stays."""
        os.close(self._here)
        os.close(self._there)


@contextlib.contextmanager
def serving(board: BoardRtl) -> Iterator[str]:
    """Path of a device whose board runs in a thread of its own."""
    device, stop = SerialDevice(board), Event()

    def run(poll: Callable[[], None]) -> None:
        while not stop.is_set():
            poll()

    thread = Thread(target=run, args=(device.poll,), daemon=True)
    thread.start()
    try:
        yield device.path
    finally:
        stop.set()
        thread.join()
        device.close()
