# SPDX-License-Identifier: Apache-2.0
"""The trigger of an oscilloscope, on ticks as they come.

auto shows the latest ticks until something fires; normal shows the last window that fired; single
holds its window until it is armed again. A window has `span` ticks, the share `pre` of them before
the tick that fired.
"""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

Mode = Literal["auto", "normal", "single"]
Kind = Literal["rising", "falling", "leave", "enter", "fault"]
LEAST_SPAN, MOST_SPAN = 10, 1 << 15  # ticks


class Settings(msgspec.Struct, frozen=True):
    """rising, falling: `channel` crosses `level`; leave, enter: it leaves or enters the window
    low..high; fault: the core stops."""

    mode: Mode = "auto"
    kind: Kind = "rising"
    channel: str = ""
    level: float = 0.0
    low: float = 0.0
    high: float = 0.0
    pre: float = 0.25
    span: int = 2000

    def problem(self, names: list[str]) -> str:
        """Why the settings cannot be, '' if they can."""
        if self.kind != "fault" and self.channel not in names:
            return f"no channel {self.channel!r} to trigger on"
        if not LEAST_SPAN <= self.span <= MOST_SPAN:
            return f"span is {self.span} ticks, must be {LEAST_SPAN} to {MOST_SPAN}"
        if not 0.0 <= self.pre <= 1.0:
            return f"pre is {self.pre}, must be 0 to 1, the share before the trigger"
        if self.kind in ("leave", "enter") and not self.low < self.high:
            return f"window is {self.low} to {self.high}, low must be less than high"
        return ""

    @property
    def before(self) -> int:
        """Ticks of the window before the one that fires."""
        return round(self.pre * (self.span - 1))


class Trigger:
    """State of the trigger: armed, or fired at `at` and waiting for the rest of its window."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self.armed = bool(self.settings.channel) or self.settings.kind == "fault"
        self.at: int | None = None
        self._last: float | None = None

    def look(self, first: int, values: NDArray[np.float64]) -> None:
        """The next ticks of the channel, values (n,). Fires at the first one that fits."""
        last, self._last = self._last, float(values[-1])
        if not self.armed or self.at is not None or self.settings.kind == "fault":
            return
        before = np.concatenate([[values[0] if last is None else last], values[:-1]])
        hits = np.flatnonzero(_fits(self.settings, before, values))
        if hits.size:
            self.at = first + int(hits[0])

    def fault(self, tick: int) -> None:
        """The core has stopped in this tick: fires a trigger on faults."""
        if self.armed and self.at is None and self.settings.kind == "fault":
            self.at = tick

    def window(self, end: int, over: bool = False) -> tuple[int, int, int] | None:
        """(begin, end, tick that fired) once ticks up to `end` are there, else None.

        over: no more ticks will come. The next window can fire then, except for single."""
        if self.at is None:
            return None
        begin = self.at - self.settings.before
        stop = begin + self.settings.span
        if end < stop and not over:
            return None
        found, self.at = (begin, stop, self.at), None
        self.armed = self.settings.mode != "single"
        return found

    @property
    def state(self) -> str:
        """In a word, for people."""
        if self.at is not None:
            return "fired"
        return "armed" if self.armed else "held" if self.settings.mode == "single" else "off"


def _fits(
    s: Settings, before: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.bool_]:
    if s.kind == "rising":
        return (before < s.level) & (values >= s.level)
    if s.kind == "falling":
        return (before > s.level) & (values <= s.level)
    inside = (values >= s.low) & (values <= s.high)
    inside_before = (before >= s.low) & (before <= s.high)
    return (inside_before & ~inside) if s.kind == "leave" else (~inside_before & inside)
