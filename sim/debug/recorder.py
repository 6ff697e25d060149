# SPDX-License-Identifier: Apache-2.0
"""The scope over a link: set up, armed, its records drained or streamed."""

from __future__ import annotations

from sim.debug.link import Link
from sim.debug.requests import DebugError, Requests
from sim.debug.state import REGISTER, REGMAP, RING, RING_WORDS, Records, ScopeSetup, code, word_of


class Recorder(Requests):
    """The scope of a debug block."""

    def __init__(self, link: Link, timeout: float = 2.0) -> None:
        super().__init__(link, timeout)
        self._setup: ScopeSetup | None = None
        self._taken = 0  # records drained since arm

    def configure(self, setup: ScopeSetup) -> None:
        """Set the scope up; it is frozen until `arm`. Raises ValueError (ScopeSetup.check)."""
        setup.check()
        self._control("freeze")
        trigger, registers = setup.trigger, REGMAP.registers
        type_name = setup.channels[trigger.channel].type
        words = [channel.word() for channel in setup.channels]
        self.write_words(REGISTER["CHANNEL"], words)
        last = len(setup.channels) - 1
        record = registers["RECORD"].word(last_channel=last, skip=setup.decimation - 1)
        kind = code("trigger_kind", trigger.kind)
        when = registers["TRIGGER"].word(
            kind=kind, channel=trigger.channel, float=int(type_name == "float")
        )
        low, high = word_of(trigger.low, type_name), word_of(trigger.high, type_name)
        around = registers["AROUND"].word(pre=setup.pre, post=setup.post)
        self.write_words(REGISTER["RECORD"], [record, when, low, high, around])
        self._setup = setup

    def arm(self) -> None:
        """Empty the ring and record from the next run on; over a serial line the records come by
        themselves from here on."""
        if self.link.streams:
            self._set_uart(stream=1)
        self._control("arm")
        self._taken = 0
        self._streamed.clear()

    def freeze(self) -> None:
        """Stop recording; the ring keeps what it has."""
        self._control("freeze")

    def trigger(self) -> None:
        """Trigger a scope that waits."""
        self._control("trigger")

    def triggered_at(self) -> int | None:
        """Number of the record that triggered, None if none has since `arm`."""
        return self._read("TRIGGERED_AT") if self.state().triggered else None

    def drain(self) -> Records:
        """Records since the last call, or since `arm`; `lost` are those that the ring or the
        line dropped. Raises DebugError before `configure`."""
        if self._setup is None:
            raise DebugError("configure the scope first")
        if self.link.streams:
            return self._drain_stream()
        total = self._read("RECORDS")
        first = max(self._taken, total - self._setup.capacity)
        words = self.ring(first, total - first)
        # What was overwritten while the ring was being read.
        gone = max(0, self._read("RECORDS") - self._setup.capacity - first)
        lost = first + min(gone, len(words)) - self._taken
        self._taken = total
        return Records(first + gone, words[gone:], lost)

    def ring(self, first: int, count: int) -> list[tuple[int, ...]]:
        """Records by number, out of the ring: after a fault or trigger, what is before it."""
        if self._setup is None:
            raise DebugError("configure the scope first")
        size, channels = self._setup.size, len(self._setup.channels)
        at, left, words = first * size % RING_WORDS, count * size, []
        while left:
            part = min(left, RING_WORDS - at)
            words += self.read_words(RING + at, part)
            at, left = 0, left - part
        return [tuple(words[n : n + channels]) for n in range(0, len(words), size)]

    def _drain_stream(self) -> Records:
        self.poll()
        parts, self._streamed = self._streamed, []
        if not parts:
            return Records(self._taken, [])
        # A gap ends what is returned now; the rest comes with the next call.
        words, first = list(parts[0].words), parts[0].first
        for n, part in enumerate(parts[1:], 1):
            if part.first != first + len(words):
                self._streamed = parts[n:] + self._streamed
                break
            words += part.words
        # Numbers that go back: someone else has armed the scope, they count from 0.
        lost = first - self._taken if first >= self._taken else first
        self._taken = first + len(words)
        return Records(first, words, lost)
