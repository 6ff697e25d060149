# SPDX-License-Identifier: Apache-2.0
"""Speed along a path of any length under limits that change along it, with bounded work per cell.

A cell is a stretch of the path with a greatest speed c and a greatest acceleration A along it.

Method. First the fastest profile with steps of the acceleration (backward pass, forward pass),
then the average over a window of length T, which turns each step into a ramp: jerk <= A / T.
The averaged motion keeps the limits of every cell if the first one keeps them on the cell extended
by c T / 2 at both ends: while the averaged position is in the cell, the whole window is in the
extended one. (If a share f of the window is before it, the average of the position is before
the cell by at least c T / 2 - c T (1 - f)^2 / 2 >= 0; the same after it.) Two rules remain:
between acceleration and deceleration the speed stays constant for T, so no ramp goes from +A to -A,
and a stop rests for T. A single move that reaches A comes out as the time-optimal S-curve; a
shorter one takes up to 2 T longer than it could.

A corner is a rest for no time. Averaged over the window as a vector, the motion about it is that
of a turn (sim/motion/geometry/turn.py), if the acceleration is the corner's for T before and after.
Whoever adds a corner must see to that.

Stream. The profile up to its last rise is final whatever follows, because every later plan is at
least as fast; only the rest is planned again when more cells have come. So the result does not
depend on the number of cells looked at, and it is that of the whole path known at once.

Units: m, s.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from sim.motion.geometry.curves import FloatArray

# Phases that last less are joined to their neighbours [s].
SHORTEST_PHASE = 1e-9
# Part of a time or speed that is rounding.
ROUNDING = 1e-9


class Cell(NamedTuple):
    """`length` [m] of path with its greatest speed [m/s] and acceleration along the path [m/s2]."""

    length: float
    speed: float
    acceleration: float


class Corner(NamedTuple):
    """A rest for no time, with this acceleration [m/s2] before and after it."""

    acceleration: float


class Stop(NamedTuple):
    """A rest on the path of at least `dwell` [s]."""

    dwell: float


@dataclass(frozen=True, eq=False)
class Stretch:
    """A final part of the motion: phases of constant jerk.

    time, position, speed, acceleration, jerk (n,): states at the start of the phases, times from
    the start of this stretch, positions from its origin; duration [s] of all; shift [m]: the next
    stretch has its origin so much farther along the path; stopped: it ends at rest, as the path
    or at a Stop.
    """

    time: FloatArray
    position: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    jerk: FloatArray
    duration: float
    shift: float
    stopped: bool


@dataclass
class _Ramp:
    """Constant acceleration between two positions; sign +1, 0, -1."""

    s0: float
    s1: float
    v0: float
    v1: float
    a: float
    sign: int
    final: bool = False  # a constant speed that is the limit


@dataclass
class _Extended:
    """A cell with the range on which its limits hold."""

    begin: float
    end: float
    speed: float
    acceleration: float


@dataclass
class SpeedPlanner:
    """Feed it cells and stops, take stretches; `window` T [s], 0 for steps of the acceleration.

    depth: cells read at a time; fastest [m/s]: bound of all cells' speeds.
    """

    window: float
    fastest: float
    depth: int = 1024
    _cells: list[_Extended] = field(default_factory=list)
    _corners: list[float] = field(default_factory=list)  # places of rests for no time
    _floor: float = -math.inf  # place of the last of them
    _end: float = 0.0
    _speed: float = 0.0
    _next: int = 0
    planned: int = 0  # cells planned, repeats counted: for checks of the work done

    def __post_init__(self) -> None:
        self._filter = _Average(self.window)

    def run(self, items: Iterable[Cell | Corner | Stop]) -> Iterator[Stretch]:
        """Stretches of the motion along the cells, from rest to rest."""
        self._filter = _Average(self.window)
        self._next = self.depth
        for item in items:
            if isinstance(item, Stop):
                yield self._finish(item.dwell)
                continue
            if isinstance(item, Corner):
                self._add_corner(item)
                continue
            if not item.length > 0.0:
                continue
            reach = item.speed * self.window / 2
            self._cells.append(
                _Extended(
                    max(self._end - reach, self._floor),
                    self._end + item.length + reach,
                    item.speed,
                    item.acceleration,
                )
            )
            self._end += item.length
            if len(self._cells) >= self._next:
                stretch = self._advance()
                if stretch is not None:
                    yield stretch
                self._next = len(self._cells) + max(self.depth, len(self._cells))
        if self._cells:
            yield self._finish(0.0)

    def _add_corner(self, corner: Corner) -> None:
        """No window about a place beyond a corner reaches farther than its turn."""
        place, reach = self._end, corner.acceleration * self.window**2 / 2
        for cell in reversed(self._cells):
            if cell.end <= place - self.fastest * self.window / 2:
                break
            cell.end = min(cell.end, place)
        self._cells.append(_Extended(place - reach, place + reach, math.inf, corner.acceleration))
        self._corners.append(place)
        self._floor = place

    def _finish(self, dwell: float) -> Stretch:
        ramps = self._plan(self._end) if self._cells else []
        length = self._end
        self._cells, self._corners, self._floor = [], [], -math.inf
        self._end, self._speed, self._next = 0.0, 0.0, self.depth
        rest = self.window + dwell
        ramps.append(_Ramp(length, length, 0.0, 0.0, 0.0, 0))
        return self._filter.add(ramps, length, rest)

    def _advance(self) -> Stretch | None:
        # Cells to come reach back by at most this; a plan that rests there is slower than any.
        known = self._end - self.fastest * self.window / 2
        if known <= 0.0:
            return None
        ramps = self._plan(known)
        keep = len(ramps)
        while keep and ramps[keep - 1].sign <= 0:
            keep -= 1
        while keep < len(ramps) and ramps[keep].final:
            keep += 1
        ramps = ramps[:keep]
        # Less than a phase would be no motion; it comes with the next part.
        lasting = (_duration(ramp) for ramp in ramps if ramp.s1 > ramp.s0)
        if not sum(d for d in lasting if d >= SHORTEST_PHASE) > 2 * SHORTEST_PHASE:
            return None
        cut = ramps[-1].s1
        self._speed = ramps[-1].v1
        self._end -= cut
        self._floor -= cut
        self._corners = [place - cut for place in self._corners if place > cut]
        self._cells = [
            _Extended(cell.begin - cut, cell.end - cut, cell.speed, cell.acceleration)
            for cell in self._cells
            if cell.end > cut
        ]
        return self._filter.add(ramps, cut, None)

    # One plan

    def _plan(self, end: float) -> list[_Ramp]:
        """The fastest motion from the present speed to rest at `end`."""
        self.planned += len(self._cells)
        places, speeds, accelerations = self._limits(end)
        squares = self._passes(places, speeds, accelerations, set(self._corners))
        ramps: list[_Ramp] = []
        for k, (c, a) in enumerate(zip(speeds, accelerations, strict=True)):
            _ramps_of(ramps, places[k], places[k + 1], squares[k], squares[k + 1], c, a)
        return _flattened(ramps, self.window) if self.window > 0.0 else ramps

    def _limits(self, end: float) -> tuple[list[float], list[float], list[float]]:
        """Places 0 = p0 < p1 < ... = end, and least speed and acceleration between them."""
        cells = sorted(
            (
                (max(0.0, cell.begin), min(end, cell.end), cell)
                for cell in self._cells
                if cell.begin < end
            ),
            key=lambda entry: entry[0],
        )
        corners = {place for place in self._corners if place < end}
        marks = sorted({0.0, end, *corners, *(c[0] for c in cells), *(c[1] for c in cells)})
        places = [0.0]
        speeds: list[float] = []
        accelerations: list[float] = []
        slow: list[tuple[float, float]] = []
        weak: list[tuple[float, float]] = []
        following = 0
        for place, after in zip(marks[:-1], marks[1:], strict=True):
            while following < len(cells) and cells[following][0] <= place:
                _, last, cell = cells[following]
                heapq.heappush(slow, (cell.speed, last))
                heapq.heappush(weak, (cell.acceleration, last))
                following += 1
            while slow[0][1] <= place:
                heapq.heappop(slow)
            while weak[0][1] <= place:
                heapq.heappop(weak)
            c, a = slow[0][0], weak[0][0]
            if speeds and speeds[-1] == c and accelerations[-1] == a and place not in corners:
                places[-1] = after
            else:
                places.append(after)
                speeds.append(c)
                accelerations.append(a)
        return places, speeds, accelerations

    def _passes(
        self,
        places: list[float],
        speeds: list[float],
        accelerations: list[float],
        corners: set[float],
    ) -> list[float]:
        """Squares of the speeds at the places."""
        count = len(speeds)
        squares = [0.0] * (count + 1)
        value = 0.0
        for k in range(count - 1, -1, -1):
            value = min(
                value + 2 * accelerations[k] * (places[k + 1] - places[k]),
                speeds[k] ** 2,
                speeds[k - 1] ** 2 if k else math.inf,
            )
            if places[k] in corners:
                value = 0.0
            squares[k] = value
        value = squares[0] = min(squares[0], self._speed**2)
        for k in range(count):
            value = min(value + 2 * accelerations[k] * (places[k + 1] - places[k]), squares[k + 1])
            squares[k + 1] = value
        return squares


def _ramps_of(
    ramps: list[_Ramp], s0: float, s1: float, w0: float, w1: float, c: float, a: float
) -> None:
    """Adds rise, constant speed and fall of one stretch; w0, w1: squares of the end speeds."""
    v0, v1 = math.sqrt(w0), math.sqrt(w1)
    top = min(c * c, (w0 + w1) / 2 + a * (s1 - s0))
    top = max(top, w0, w1)
    up, down = (top - w0) / (2 * a), (top - w1) / (2 * a)
    # Differences that are rounding are none.
    tiny = 1e-13 * (s1 - s0) + 1e-18
    up, down = up if up > tiny else 0.0, down if down > tiny else 0.0
    vt = math.sqrt(top)
    if up and s1 - s0 - up - down < tiny:
        up = s1 - s0 - down
    if down and s1 - s0 - up - down < tiny:
        down = s1 - s0 - up
    if up > 0.0:
        _join(ramps, _Ramp(s0, s0 + up, v0, vt, a, 1))
    if s1 - down > s0 + up:
        _join(ramps, _Ramp(s0 + up, s1 - down, vt, vt, 0.0, 0, top >= c * c))
    if down > 0.0:
        _join(ramps, _Ramp(s1 - down, s1, vt, v1, a, -1))


def _duration(ramp: _Ramp) -> float:
    """Time of a ramp of some length [s]."""
    return 2 * (ramp.s1 - ramp.s0) / (ramp.v0 + ramp.v1)


def _join(ramps: list[_Ramp], ramp: _Ramp) -> None:
    """Adds a ramp; it extends the last one if that continues in the same way."""
    last = ramps[-1] if ramps else None
    if last and last.sign == ramp.sign and last.a == ramp.a and last.final == ramp.final:
        last.s1, last.v1 = ramp.s1, ramp.v1
    else:
        ramps.append(ramp)


def _flattened(ramps: list[_Ramp], window: float) -> list[_Ramp]:
    """Lowers every peak until the speed is constant there for `window` [s]."""
    out: list[_Ramp] = []
    i, count = 0, len(ramps)
    while i < count:
        ramp = ramps[i]
        if ramp.sign >= 0:
            out.append(ramp)
            i += 1
            continue
        first = len(out)
        while first and out[first - 1].sign == 0:
            first -= 1
        begin = out[first].s0 if first < len(out) else ramp.s0
        rises = first > 0 and out[first - 1].sign > 0
        if not rises or ramp.s0 - begin >= ramp.v0 * window * (1 - ROUNDING):
            out.append(ramp)
            i += 1
            continue
        del out[first:]
        i = _lower(out, ramps, i, begin, ramp.s0, ramp.v0, window)
    return out


def _lower(
    out: list[_Ramp], ramps: list[_Ramp], i: int, begin: float, end: float, v: float, window: float
) -> int:
    """Lowers the peak of speed v from begin to end between out[-1] and ramps[i]; next i."""
    while True:
        rise = out[-1] if out and out[-1].sign > 0 else None
        fall = ramps[i] if i < len(ramps) and ramps[i].sign < 0 else None
        if rise is None or fall is None or end - begin >= v * window * (1 - ROUNDING):
            break
        low = max(rise.v0, fall.v1)
        k = 0.5 / rise.a + 0.5 / fall.a
        width = end - begin
        if width + k * (v * v - low * low) >= low * window:
            total = width + k * v * v
            x = 2 * total / (window + math.sqrt(window * window + 4 * k * total))
            x = min(max(x, low), v)
        else:
            x = low
        begin = rise.s0 if x <= rise.v0 else rise.s0 + (x * x - rise.v0**2) / (2 * rise.a)
        end = fall.s1 if x <= fall.v1 else fall.s1 - (x * x - fall.v1**2) / (2 * fall.a)
        end = max(begin, end)
        v = x
        if x <= rise.v0:
            out.pop()
            while out and out[-1].sign == 0:
                begin = out.pop().s0
        else:
            rise.s1, rise.v1 = begin, x
        if x <= fall.v1:
            i += 1
            while i < len(ramps) and ramps[i].sign == 0:
                end = ramps[i].s1
                i += 1
        else:
            fall.s0, fall.v0 = end, x
    if end > begin:
        out.append(_Ramp(begin, end, v, v, 0.0, 0))
    return i


class _Average:
    """Turns ramps into the phases of constant jerk of the motion averaged over the window."""

    def __init__(self, window: float) -> None:
        self.window = window
        # History of the unaveraged motion, from `window` before the present on; rest at first.
        self.time = [-window, 0.0] if window > 0.0 else [0.0]
        self.position = [0.0] * len(self.time)
        self.speed = [0.0] * len(self.time)
        self.rate = [0.0] * (len(self.time) - 1)
        self.reached = 0.0

    def add(self, ramps: list[_Ramp], shift: float, rest: float | None) -> Stretch:
        """Phases up to the end of the ramps; rest: duration of their last one [s]."""
        for ramp in ramps:
            duration = _duration(ramp) if ramp.s1 > ramp.s0 else 0.0
            if duration >= SHORTEST_PHASE:
                self._append(self.time[-1] + duration, ramp.s1, ramp.v1)
        if rest is not None:
            end = self.time[-1]
            self.position[-1], self.speed[-1] = ramps[-1].s1, 0.0
            if rest > 0.0:
                self._append(end + rest, ramps[-1].s1, 0.0)
        stretch = self._phases(shift, rest is not None)
        self._forget(shift)
        return stretch

    def _append(self, time: float, position: float, speed: float) -> None:
        duration = time - self.time[-1]
        # From the position, so that the length is met; both agree except for rounding.
        self.rate.append((speed - self.speed[-1]) / duration)
        self.time.append(time)
        self.position.append(position)
        self.speed.append(speed)

    def _phases(self, shift: float, stopped: bool) -> Stretch:
        t, s, v = np.array(self.time), np.array(self.position), np.array(self.speed)
        a = np.array(self.rate)
        end = t[-1]
        if self.window == 0.0:
            return Stretch(t[:-1], s[:-1], v[:-1], a, np.zeros_like(a), end, shift, stopped)
        window = self.window
        marks = np.unique(np.concatenate([[0.0], t, t + window]))
        marks = marks[(marks >= 0.0) & (marks < end - SHORTEST_PHASE)]
        marks = marks[np.concatenate([[True], np.diff(marks) > SHORTEST_PHASE])]
        middles = (marks + np.append(marks[1:], end)) / 2

        def state(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(a) - 1)
            d = times - t[k]
            return s[k] + d * (v[k] + d * a[k] / 2), v[k] + d * a[k], a[k]

        (s1, v1, _), (s0, v0, _) = state(marks), state(marks - window)
        speed, acceleration = (s1 - s0) / window, (v1 - v0) / window
        jerk = (state(middles)[2] - state(middles - window)[2]) / window
        d = np.diff(np.append(marks, end))
        steps = d * (speed + d * (acceleration / 2 + d * jerk / 6))
        position = self.reached + np.concatenate([[0.0], np.cumsum(steps)])
        self.reached = s[-1] if stopped else float(position[-1])
        return Stretch(marks, position[:-1], speed, acceleration, jerk, end, shift, stopped)

    def _forget(self, shift: float) -> None:
        """Stores the last window of the history; times from the present, positions from shift."""
        end = self.time[-1]
        first = len(self.time) - 1
        while first > 0 and self.time[first] > end - self.window:
            first -= 1
        self.time = [time - end for time in self.time[first:]]
        self.position = [position - shift for position in self.position[first:]]
        self.speed = self.speed[first:]
        self.rate = self.rate[first:]
        self.reached -= shift
