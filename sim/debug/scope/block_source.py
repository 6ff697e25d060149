# SPDX-License-Identifier: Apache-2.0
"""A core with its debug block as a source: what is shown is what the block has recorded.

A row is a record of the block's scope, one per run or per so many runs, of at most 8 channels; over
a serial line they come by themselves. Gains are the program's live parameters, staged and committed
in the block. If nothing answers any more, the link is made again until something does.
"""

from __future__ import annotations

import math
import queue
import re
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from asip_asm.diagnostics import closest
from asip_asm.image import Image
from sim.core.backends import number
from sim.core.fault import Fault as CoreFault
from sim.core.fault import fault_text
from sim.debug.backend import BlockBackend
from sim.debug.client import Client, DebugError
from sim.debug.scope import source
from sim.debug.scope.source import CYCLES, Block, Commit, Event, Gain, Note, SourceError, checked
from sim.debug.state import REGISTER, ScopeSetup, Trigger
from sim.debug.state import Channel as Recorded
from sim.rtl.asip_bus import AsipError

MOST_CHANNELS = 8
QUIET_LOOKS = 3  # without a record until a fault is reported: all records before it have come then
RETRY_S = 1.0
LEVELS = {"above": 1, "below": 1, "rising": 1, "falling": 1, "inside": 2, "outside": 2}
"""Kinds of the block's trigger that people ask for, and how many levels each has."""
_REGISTER = re.compile(r"[abc]\d+|k\d+|o\d+")


def recorded(image: Image, names: Sequence[str]) -> list[Recorded]:
    """Channels by the names of the program: inputs, outputs, states, exports, 'cycles', registers.

    Raises SourceError for a name that is none, and for more than MOST_CHANNELS.
    """
    places = {e.name: (e.register, "float") for e in image.exports}
    places |= {s.name: (s.register, s.type) for s in image.states}
    places |= {o.name: (f"o{o.index}", "float") for o in image.outputs}
    places |= {e.name: (f"k{e.index}", e.type) for e in image.inputs}
    places |= {e.name: (f"k{e.index}", e.type) for e in image.constants}
    places |= {CYCLES: (CYCLES, "int")}
    for name in names:
        if name not in places and not _REGISTER.fullmatch(name):
            known = closest(name, list(places)) or f"it has {', '.join(places)}"
            raise SourceError(f"the program has no '{name}'; {known}")
    if not 1 <= len(set(names)) == len(names) <= MOST_CHANNELS:
        raise SourceError(
            f"{len(names)} channels; the block records 1 to {MOST_CHANNELS}, each once"
        )
    found = [(name, *places.get(name, (name, "float"))) for name in names]
    return [Recorded(place, name=name, type=kind) for name, place, kind in found]


def first_channels(image: Image) -> list[str]:
    """What to record if nobody says: outputs, then states, then inputs."""
    names = [output.name for output in image.outputs]
    names += [state.name for state in image.states]
    names += [entry.name for entry in image.inputs]
    return names[: MOST_CHANNELS - 1] + [CYCLES]


def block_trigger(text: str, channels: Sequence[Recorded]) -> Trigger:
    """Trigger of the block in words: 'y rising 5', 'sum inside -1 1'. Raises SourceError."""
    name, _, rest = text.strip().partition(" ")
    kind, *levels = rest.split() or [""]
    names = [channel.name for channel in channels]
    if name not in names:
        raise SourceError(f"trigger '{text}': no channel '{name}'; recorded: {', '.join(names)}")
    if kind not in LEVELS or len(levels) != LEVELS[kind]:
        forms = ", ".join(f"{kind}{' LEVEL' * count}" for kind, count in LEVELS.items())
        raise SourceError(f"trigger '{text}': expected CHANNEL and one of {forms}")
    try:
        low, high = (*map(float, levels), 0.0)[:2]
    except ValueError:
        raise SourceError(f"trigger '{text}': levels are numbers") from None
    if not (math.isfinite(low) and math.isfinite(high)):
        raise SourceError(f"trigger '{text}': levels are finite numbers")
    return Trigger(kind, names.index(name), low, high)


class BlockSource:
    """connect: opens the core, raises LinkError; period: of a run [s]; every: runs per record.

    trigger: as of `block_trigger`; when it fires the block fills its ring, `before` of it with what
    came before, and freezes it. So that window is whole whatever the line loses. Then it waits for
    the next one.
    """

    def __init__(
        self,
        connect: Callable[[], BlockBackend],
        image: Image,
        names: Sequence[str],
        period: float,
        every: int = 1,
        trigger: str = "",
        before: float = 0.5,
    ) -> None:
        self._connect, self._image = connect, image
        self._setup = ScopeSetup(tuple(recorded(image, names)), every, Trigger("never"))
        if trigger:
            chosen = block_trigger(trigger, self._setup.channels)
            pre = min(round(before * self._setup.capacity), self._setup.capacity - 1)
            post = self._setup.capacity - pre
            self._setup = replace(self._setup, trigger=chosen, pre=pre, post=post)
        self._trigger = trigger
        self._live = {e.name: e for e in image.constants if e.name in image.parameters}
        self.description = source.Description(
            title=image.title or "a program",
            period=period * every,
            channels=[
                source.Channel(c.name, "", "recorded", f"{c.place}, {c.type}")
                for c in self._setup.channels
            ],
            shown=list(names),
            gains=[
                Gain(e.name, "", number(int(e.bits, 16), e.type), "parameter", f"word k{e.index}")
                for e in self._live.values()
            ],
            paces=False,
        )
        self._commands: queue.Queue[Commit] = queue.Queue()
        self._events: deque[Event] = deque()
        self._committing: tuple[Commit, int] | None = None
        self._offset = self._next = self._gap = self._quiet = 0
        self._faulted = self._closed = False
        self._core: BlockBackend | None = None
        self._begin()

    def close(self) -> None:
        """No more events but an End; the core goes on as it is."""
        self._closed = True

    # ------------------------------------------------------------------ commands
    def check(self, values: Mapping[str, float]) -> None:
        """Raises SourceError."""
        if len(values) > self._stage_words:
            raise SourceError(f"the block stages {self._stage_words} words at a time")
        for name, value in values.items():
            checked(name, value, self._live[name].type)

    def send(self, command: source.Command) -> None:
        """Raises SourceError for what only a simulated machine does."""
        if not isinstance(command, Commit):
            raise SourceError("a machine with a debug block takes changes of gains only")
        self._commands.put(command)

    # ------------------------------------------------------------------ events
    def wait(self) -> Event:
        """The next event. The link belongs to the thread that calls this."""
        while not self._events:
            if self._closed:
                if self._core is not None:
                    self._core.close()
                return source.End("the scope has ended")
            try:
                if self._core is None:
                    time.sleep(RETRY_S)
                    self._begin()
                    self._events.append(Note(""))
                else:
                    self._look(self._core.client)
            except (AsipError, OSError) as error:
                if self._core is not None or isinstance(error, DebugError):
                    self._events.append(Note(f"{error}; trying again"))
                if self._core is not None:
                    self._core.close()
                    self._core = None
        return self._events.popleft()

    def _begin(self) -> None:
        """Link, set-up, and records from now on."""
        core = self._connect()
        try:
            core.attach(self._image)
            core.client.configure(self._setup)
        except BaseException:
            core.close()
            raise
        self._stage_words = core.client.sizes.stage_words
        self._arm(core.client)
        self._core = core

    def _arm(self, client: Client) -> None:
        """Records have numbers from 0 again."""
        client.arm()
        self._offset = self._gap = self._next
        self._faulted, self._quiet = False, 0

    def _look(self, client: Client) -> None:
        """One look at the block: what has happened goes to the events."""
        state = client.state()
        self._commit(client)
        records = client.drain()
        if records.lost:
            self._events.append(source.Lost(self._offset + records.first, records.lost))
            self._gap = self._offset + records.first
        if records.words:
            self._events.append(self._block(records.first, records.words))
            self._next = self._offset + records.first + len(records.words)
            self._quiet = 0
            return
        self._quiet += 1
        if state.fault and not self._faulted and self._quiet >= QUIET_LOOKS:
            self._fault(client)
        elif self._faulted and not state.fault:
            self._arm(client)
        elif state.scope == "frozen" and self._trigger and not state.fault:
            if self._quiet >= QUIET_LOOKS:
                self._fired(client)
        client.link.pause()

    def _block(self, first: int, words: Sequence[tuple[int, ...]]) -> Block:
        raw = np.array(words, dtype=np.uint32)
        values: NDArray[np.float64] = np.empty(raw.shape)
        for k, channel in enumerate(self._setup.channels):
            kind = np.int32 if channel.type == "int" else np.float32
            values[:, k] = np.ascontiguousarray(raw[:, k]).view(kind)
        return Block(self._offset + first, values)

    def _fault(self, client: Client) -> None:
        """The core is in a fault: the block's ring is frozen, and complete in any case."""
        self._faulted = True
        self._whole_ring(client)
        text = fault_text(self._image, CoreFault.of(*client.fault()))
        self._events.append(source.Fault(self._next - 1, text))

    def _fired(self, client: Client) -> None:
        """The block's trigger has fired and its ring is full: show it, then wait for the next."""
        at = client.triggered_at()
        self._whole_ring(client)
        if at is not None:
            self._events.append(Note(f"trigger '{self._trigger}': tick {self._offset + at}"))
        self._arm(client)

    def _whole_ring(self, client: Client) -> None:
        """What the frozen ring has goes to the events if some of it never came."""
        total = client.read_word(REGISTER["RECORDS"])
        kept = min(total, self._setup.capacity)
        if self._gap > self._offset + total - kept or self._next != self._offset + total:
            self._events.append(self._block(total - kept, client.ring(total - kept, kept)))
            self._next = self._offset + total

    def _commit(self, client: Client) -> None:
        """Stage and commit what was requested; report when the core has it."""
        if self._committing is not None:
            commit, page = self._committing
            if client.version()[0] != page:
                self._events.append(source.Applied(self._next, commit.version, commit.values))
                self._committing = None
        elif not self._commands.empty():
            commit = self._commands.get()
            try:
                client.stage_parameters(self._image, dict(commit.values))
            except DebugError as error:  # somebody else has staged words
                client.discard()
                self._events.append(Note(str(error)))
                return
            self._committing = (commit, client.version()[0])
            client.commit()
