# SPDX-License-Identifier: Apache-2.0
"""A source whose ticks a test gives, and a scope that shows it on this computer."""

from __future__ import annotations

import asyncio
import queue
import threading

import numpy as np

from sim.debug import guard
from sim.debug.scope import server
from sim.debug.scope.source import (
    Applied,
    Block,
    Channel,
    Command,
    Commit,
    Description,
    End,
    Event,
    Gain,
    SourceError,
    StepInput,
)

ABOUT = Description(
    title="a test",
    period=1e-3,
    channels=[Channel("sine", "m", "a"), Channel("ramp", "1", "a"), Channel("count", "count", "b")],
    shown=["sine", "ramp"],
    gains=[Gain("K", "1", 2.0, "constant"), Gain("T", "s", 0.5, "constant")],
    steps=[StepInput("u", "m", "sine", 1.0)],
    inputs=["u"],
)


def rows(first: int, ticks: int) -> Block:
    """Ticks of the three channels; values that a short decimal does not hold."""
    tick = np.arange(first, first + ticks)
    return Block(first, np.stack([np.sin(tick / 7), tick / 3, -tick.astype(float)], axis=1))


class FakeSource:
    """Events come from `events`, commands go to `sent`."""

    def __init__(self) -> None:
        self.description = ABOUT
        self.events: queue.Queue[Event] = queue.Queue()
        self.sent: list[Command] = []

    def wait(self) -> Event:
        return self.events.get()

    def check(self, values) -> None:
        if values.get("K", 0.0) > 100.0:
            raise SourceError("K = 101: must be at most 100")

    def send(self, command: Command) -> None:
        self.sent.append(command)
        if isinstance(command, Commit):
            self.events.put(Applied(0, command.version, command.values))

    def close(self) -> None:
        self.events.put(End())


class Scope:
    """A server in a thread; a context manager."""

    def __init__(self, source) -> None:
        self.source = source
        self._listening, self.token = server.bind(), guard.new_token()
        self.address = self._listening.getsockname()
        self.url = server.address(self._listening, self.token)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        self._task = self._loop.create_task(server.serve(self.source, self._listening, self.token))
        try:
            self._loop.run_until_complete(self._task)
        except asyncio.CancelledError:
            pass

    def __enter__(self) -> Scope:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(10)
