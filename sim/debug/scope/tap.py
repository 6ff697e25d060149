# SPDX-License-Identifier: Apache-2.0
"""The way from a control loop in one process to the scope in another.

The loop holds a `Tap`: every tick goes in, commands are carried out between two ticks. The scope
holds the `TapSource` at the other end of a local socket. Nothing is lost: a loop that is faster
than the scope waits for it. If the scope ends, the loop goes on alone.
"""

from __future__ import annotations

import contextlib
import secrets
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Client, Connection, Listener
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.debug.scope.source import (
    Applied,
    Block,
    Command,
    Commit,
    Description,
    End,
    Event,
    Fault,
    Pace,
    Put,
    Step,
    Stepped,
)

BLOCK_TICKS = 256
BLOCK_S = 0.05  # a block is sent after this time at the latest [s]
LISTEN_TICKS = 16  # ticks between two looks for commands
LONGEST_NAP = 0.05  # s
HELD_S = 30.0
"""A loop that waits for the first page begins after this time all the same [s]."""

Place = tuple[str, bytes]
"""Name of the local socket and the key that it asks for."""


@dataclass(frozen=True)
class Tuned:
    """Gains that can be put in force together: all of them by name with their values, and the words
    of bank K, by index, that hold them."""

    values: Mapping[str, float]
    words: Mapping[int, int]


class Tuner(Protocol):
    """Finds the words for gains. Raises SourceError for values that cannot be."""

    def tuned(self, values: Mapping[str, float]) -> Tuned:
        """For these changes on top of what has been committed."""

    def commit(self, values: Mapping[str, float]) -> Tuned:
        """The same, stored."""


@dataclass(frozen=True)
class _Words:
    """A commit as the loop takes it."""

    commit: Commit
    tuned: Tuned


class Tap:
    """The loop's end; a row per tick.

    write: puts words into bank K of the core, by index.
    """

    def __init__(
        self, place: Place, columns: int, write: Callable[[Mapping[int, int]], None]
    ) -> None:
        self._link: Connection | None = Client(place[0], authkey=place[1])
        self._write = write
        self._rows = np.empty((BLOCK_TICKS, columns))
        self._filled = 0
        self._tick = 0
        self._step: Step | None = None
        self._step_begin = self._step_end = self._rested = 0
        self._puts: dict[str, float] = {}
        self._pace = Pace(paused=True)
        self._sent = self._due = time.monotonic()
        self.version = 0
        self.touched: list[str] = []  # what was done to the loop, for people
        self._listen(time.monotonic() + HELD_S)

    # ------------------------------------------------------------------ before a tick
    def inputs(self) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """What to do to the inputs of the next tick, by name: offsets to add, values to put."""
        if self._link is not None and self._tick % LISTEN_TICKS == 0:
            self._listen()
        offsets: dict[str, float] = {}
        if self._step is not None and self._step_begin <= self._tick < self._step_end:
            offsets[self._step.name] = self._step.amplitude
        puts, self._puts = self._puts, {}
        return offsets, puts

    @property
    def row(self) -> NDArray[np.float64]:
        """Row of the next tick, to be filled before `done`."""
        return self._rows[self._filled]

    # ------------------------------------------------------------------ after a tick
    def done(self) -> None:
        """The row is complete."""
        self._filled += 1
        self._tick += 1
        if self._filled == BLOCK_TICKS or time.monotonic() - self._sent > BLOCK_S:
            self._flush()
        if self._pace.rate is not None:
            self._keep_rate(self._pace.rate)

    def fault(self, text: str) -> None:
        """The core stopped in the tick whose row has been filled last."""
        self._flush()
        self._say(Fault(self._tick - 1, text))

    def end(self, text: str) -> None:
        """No tick comes any more."""
        self._flush()
        self._say(End(text))
        if self._link is not None:
            self._link.close()
            self._link = None

    # ------------------------------------------------------------------ inside
    def _flush(self) -> None:
        if self._filled:
            self._say(Block(self._tick - self._filled, self._rows[: self._filled].copy()))
            self._filled = 0
        self._sent = time.monotonic()

    def _say(self, event: Event) -> None:
        if self._link is None:
            return
        try:
            self._link.send(event)
        except OSError:
            self._alone()

    def _alone(self) -> None:
        """The scope has gone: as fast as before, with the gains as they are."""
        self._link = None
        self._pace = Pace(paused=False)

    def _listen(self, deadline: float | None = None) -> None:
        """Carry out what has come; while the loop is held wait for more, until the deadline."""
        try:
            while self._link is not None:
                if self._pace.paused:
                    self._flush()
                    if not self._link.poll(deadline and max(deadline - time.monotonic(), 0.0)):
                        self._pace = Pace(paused=False)
                        return
                    deadline = None
                elif not self._link.poll():
                    return
                self._carry_out(self._link.recv())
        except (OSError, EOFError):
            self._alone()

    def _carry_out(self, command: Pace | _Words | Step | Put) -> None:
        match command:
            case Pace():
                self._pace = command
                self._due = time.monotonic()
            case _Words(commit=commit, tuned=tuned):
                self._write(tuned.words)
                self.version = commit.version
                self._note(", ".join(f"{name} = {v:g}" for name, v in commit.values.items()))
                self._say(Applied(self._tick, commit.version, tuned.values))
            case Step(name=name, amplitude=amplitude, ticks=ticks):
                # The way back from the last step gets as much time as the step had.
                self._step, self._step_begin = command, max(self._tick, self._rested)
                self._step_end = self._step_begin + ticks
                self._rested = self._step_end + ticks
                self._note(f"step of {amplitude:g} on {name}")
                self._say(Stepped(self._step_begin, name, amplitude, ticks))
            case Put(name=name, value=value):
                self._puts[name] = value
                self._note(f"{value:g} put on {name}")

    def _note(self, what: str) -> None:
        self.touched.append(f"tick {self._tick}: {what}")

    def _keep_rate(self, rate: float) -> None:
        self._due += 1.0 / rate
        ahead = self._due - time.monotonic()
        if ahead < -1.0:  # it cannot keep up: do not hurry later
            self._due = time.monotonic()
        while ahead > 0.001:
            if self._filled and time.monotonic() - self._sent > BLOCK_S:
                self._flush()
            time.sleep(min(ahead, LONGEST_NAP))
            self._listen()
            ahead = self._due - time.monotonic()


class TapSource:
    """The scope's end."""

    def __init__(self, description: Description, tuner: Tuner) -> None:
        self.description = description
        self._tuner = tuner
        self._folder = tempfile.TemporaryDirectory(prefix="asip-scope-")
        name, key = str(Path(self._folder.name) / "tap"), secrets.token_bytes(32)
        self._listener = Listener(name, authkey=key)
        self.place: Place = (name, key)
        self._link: Connection | None = None
        self._waiting: list[Command | _Words] = []
        self._lock = threading.Lock()

    def wait(self) -> Event:
        """The next event; a loop that ends without a word gives an End."""
        try:
            if self._link is None:
                link = self._listener.accept()
                with self._lock:
                    self._link = link
                    for command in self._waiting:
                        link.send(command)
            return self._link.recv()
        except (OSError, EOFError):
            return End("the loop has ended")

    def check(self, values: Mapping[str, float]) -> None:
        """Raises SourceError."""
        self._tuner.tuned(values)

    def send(self, command: Command) -> None:
        """To the loop, now or when it comes."""
        sent: Command | _Words = command
        if isinstance(command, Commit):
            sent = _Words(command, self._tuner.commit(command.values))
        with self._lock:
            if self._link is None:
                self._waiting.append(sent)
                return
            try:
                self._link.send(sent)
            except OSError:
                return  # it has ended; wait() reports it

    def close(self) -> None:
        """Forget the loop; it goes on alone."""
        with contextlib.suppress(OSError):  # the other process has closed it
            self._listener.close()
        if self._link is not None:
            self._link.close()
        self._folder.cleanup()
