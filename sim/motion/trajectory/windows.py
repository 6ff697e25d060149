# SPDX-License-Identifier: Apache-2.0
"""Windows of a path too long to be simulated as a whole, found while the plan runs by.

The last ticks of the plan are stored, so a window may begin before the moment that requests it.
So the memory does not depend on the length of the path. The windows are joined to one path that a
machine can run: from rest it runs in on the planned path, runs the window as planned, runs out,
and a straight line leads to the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sim.motion.geometry.moves import Move
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.path_limits import FEED
from sim.motion.trajectory.ticks import Ticks, at_rest, joined, run_in, run_out, transit

WINDOW = 1.0  # s
LONGEST_WINDOW = 20_000  # ticks
RUN_IN = 0.5  # s; the planned path of half of it is run in that time
MOST_EVEN = 12  # windows at equal distances
HARDER = 1.0005  # factor by which a moment must exceed the hardest so far


@dataclass(eq=False)
class Window:
    """Ticks begin to end - 1 of a plan, and why; the parts also hold ticks about them, from `first`

    on. moves: by number, those under way.
    """

    why: str
    begin: int
    end: int
    first: int
    last: int  # the tick after those wanted
    parts: list[Ticks] = field(default_factory=list)
    moves: dict[int, Move] = field(default_factory=dict)

    @property
    def reached(self) -> int:
        """The tick after those held."""
        return self.first + sum(map(len, self.parts))


@dataclass(frozen=True)
class Place:
    """Where a window is: its first tick in the path run, its ticks, its first tick in the plan."""

    why: str
    tick: int
    ticks: int
    planned: int


class Windows:
    """Takes the ticks of a plan in their order. Ticks count from the rest at the start on.

    fixed: first tick and end of the only window, None: windows at equal distances, at both ends and
    at the hardest moments; names: of the ratios to the limits by which these are found.
    """

    def __init__(
        self, period: float, names: Sequence[str], fixed: tuple[int, int] | None = None
    ) -> None:
        self._names, self._fixed = names, fixed
        self.lead = max(2, round(RUN_IN / 2 / period))
        self.window = min(LONGEST_WINDOW, max(2, round(WINDOW / period)))
        self._stride = 4 * self.window
        self._recent: list[Ticks] = []
        self._count = 0  # ticks seen
        self._even: list[Window] = []
        self._hardest: dict[str, tuple[float, Window]] = {}
        self._only = self._asked("as chosen", *fixed) if fixed else None

    @property
    def oldest(self) -> int:
        """The first tick held for windows to come."""
        return self._count - sum(map(len, self._recent))

    @property
    def oldest_move(self) -> int:
        """The number of the first move that windows to come need."""
        return int(self._recent[0].move[0]) if self._recent else -1

    @property
    def _all(self) -> list[Window]:
        hardest = [window for _, window in self._hardest.values()]
        return [*([self._only] if self._only else []), *self._even, *hardest]

    def _asked(self, why: str, begin: int, end: int) -> Window:
        """A window; where the plan begins within its lead, it begins there."""
        begin = max(begin, 0)
        if begin - self.lead <= 0:
            begin = 0
        first = max(begin - self.lead, 0)
        return Window(why, begin, end, first, end + self.lead)

    def see(self, part: Ticks, ratios: Mapping[str, np.ndarray], moves: Mapping[int, Move]) -> None:
        """The next ticks, with their ratios to limits; moves: by number, those that are held."""
        begin, end = self._count, self._count + len(part)
        self._recent.append(part)
        self._count = end
        if not self._fixed:
            for k in range(-(-begin // self._stride), -(-end // self._stride)):
                place = k * self._stride
                window = self._asked("at equal distances", place, place + self.window)
                self._even.append(window)
            if len(self._even) > MOST_EVEN:
                self._even, self._stride = self._even[::2], 2 * self._stride
            for name, values in ratios.items():
                worst = int(values.argmax())
                before = self._hardest[name][0] if name in self._hardest else 0.0
                if name != FEED and values[worst] > HARDER * before:
                    place = max(begin + worst - self.window // 2, self.oldest + self.lead)
                    window = self._asked(f"largest {name}", place, place + self.window)
                    self._hardest[name] = float(values[worst]), window
        for window in self._all:
            self._fill(window, moves)
        while self._recent and self.oldest + len(self._recent[0]) <= end - self._kept:
            self._recent.pop(0)

    @property
    def _kept(self) -> int:
        return 2 * (self.window + self.lead)

    def _fill(self, window: Window, moves: Mapping[int, Move]) -> None:
        """Copies what is held of a window and not in it yet."""
        place = self.oldest
        for part in self._recent:
            begin, end = max(window.reached, place), min(window.last, place + len(part))
            if begin < end:
                taken = joined([part.part(begin - place, end - place)])
                window.parts.append(taken)
                window.moves |= {n: moves[n] for n in np.unique(taken.move).tolist() if n >= 0}
            place += len(part)

    def found(self, moves: Mapping[int, Move]) -> list[Window]:
        """The windows in their order, each with all of its ticks; those that meet are one."""
        if not self._fixed:
            last = self._asked("end of the path", self._count - self.window, self._count)
            self._even.append(last)
            self._fill(last, moves)
        found: list[Window] = []
        for window in sorted(self._all, key=lambda each: each.begin):
            if window.begin >= self._count:
                continue
            window.end = min(window.end, self._count)
            if window.reached - window.end < self.lead:  # where the plan ends
                window.end = window.reached
            if found and window.first <= found[-1].reached:
                _add(found[-1], window)
            else:
                found.append(window)
        return found


def _add(window: Window, other: Window) -> None:
    """Makes a window and a later one that meets it one."""
    more = joined(other.parts).part(window.reached - other.first, None)
    if len(more):
        window.parts.append(more)
    window.moves |= other.moves
    window.end = max(window.end, other.end)
    window.last = window.reached
    if other.why not in window.why.split(", "):
        window.why += f", {other.why}"


def path_of(
    windows: Sequence[Window], limits: MachineLimits, period: float, rest: int
) -> tuple[Ticks, tuple[Place, ...]]:
    """The windows as one path from rest, with `rest` ticks of rest before each run-in."""
    parts: list[Ticks] = []
    places: list[Place] = []
    count = 0

    def add(part: Ticks) -> None:
        nonlocal count
        parts.append(part)
        count += len(part)

    for number, window in enumerate(windows):
        ticks = joined(window.parts)
        start = ticks.position[0]
        if parts:
            add(transit(parts[-1].position[-1], start, limits, period))
        if parts or window.begin > 0:
            add(at_rest(start, rest, -1))
        begin, end = window.begin - window.first, window.end - window.first
        if begin > 0:
            add(run_in(ticks.part(0, begin + 1), period))
        places.append(Place(window.why, count, end - begin, window.begin))
        add(ticks.part(begin, end))
        if number + 1 < len(windows) and end < len(ticks):
            add(run_out(ticks.part(end - 1, None), period))
    return joined(parts), tuple(places)
