# SPDX-License-Identifier: Apache-2.0
"""Runs of lines with gentle corners become one curve (sim/motion/geometry/smoothed.py).

The width of the averaging depends on feed, P and the tool's limits alone: with it, a corner that
deviates by the share of P just goes at the feed. A corner is gentle if it deviates by that at most,
together with all others within its reach. A run ends at any other corner, where it meets the
programmed corner; that corner is then one of joints.py. So the curve in a place depends only on
the lines about it, and runs may be of any length.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.moves import Dwell
from sim.motion.geometry.smoothed import PEAK, REACH, Smoothed, weights, within
from sim.motion.lookahead.elements import SAME_FEED
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.segment import Segment

SHARE = 0.25  # share of P for the corners of a run; twice that about its ends
MOST_TURN = 0.8  # sum of the changes of direction within reach
# Of the feeds in path space where that of the tool is the same: the table turns more, or less.
NEAR_FEED = 0.25
TOGETHER = 64  # lines of one curve
LONG = 8.0  # widths from which on the middle of a line stays a line
CLEAR = REACH * 1.001  # widths from a corner to where the path is straight again


def width_of(segment: Segment, limits: MachineLimits) -> float:
    """Width of the averaging [m], 0 where the segment cannot be in a run."""
    if segment.curve is not None or segment.inner or limits.window <= 0.0:
        return 0.0
    if not 0.0 < segment.tolerance < np.inf:
        return 0.0
    off, tool = SHARE * segment.tolerance / PEAK, limits.tool
    feed = min(segment.feed, tool.speed)
    # With d = off / width the change of direction: feed^3 d / width^2 is the jerk's limit, and
    # feed^2 0.75 d / width that of the acceleration.
    by_jerk = feed * (off / tool.jerk) ** (1 / 3)
    return float(max(by_jerk, feed * np.sqrt(0.75 * off / tool.acceleration)))


class Runs:
    """The segments of a stream, where lines of runs are replaced by parts of their curve."""

    def __init__(self, items: Iterable[Segment | Dwell], limits: MachineLimits) -> None:
        self._items, self._limits = items, limits
        self._lines: list[Segment] = []
        self._done = 0  # of them
        self._begins = True  # with the first of them; else those before it are forgotten
        self._width = 0.0

    def __iter__(self) -> Iterator[Segment | Dwell]:
        for item in self._items:
            if self._lines and not self._goes_on(item):
                yield from self._finish()
            if not isinstance(item, Segment):
                yield item
                continue
            if not self._lines:
                self._width = width_of(item, self._limits)
                if self._width == 0.0:
                    yield item
                    continue
            self._lines.append(item)
            # Corners within reach of the next part's corners decide where it ends.
            if len(self._lines) - self._done >= 2 * TOGETHER:
                yield from self._advance()
        if self._lines:
            yield from self._finish()

    def _goes_on(self, item: Segment | Dwell) -> bool:
        first = self._lines[0]
        return (
            isinstance(item, Segment)
            and item.curve is None
            and not item.inner
            and (item.tolerance, item.merge) == (first.tolerance, first.merge)
            and _like(item, first)
        )

    def _finish(self) -> Iterator[Segment]:
        lines, done, begins = self._lines, self._done, self._begins
        self._lines, self._done, self._begins = [], 0, True
        yield from _parts(lines, done, len(lines), self._width, begins, True)

    def _advance(self) -> Iterator[Segment]:
        """Takes what no line to come changes."""
        stop, ahead = len(self._lines), 0.0
        while stop > self._done and ahead < 2 * CLEAR * self._width:
            stop -= 1
            ahead += self._lines[stop].length
        stop = min(stop, self._done + TOGETHER)
        if stop <= self._done:
            return
        yield from _parts(self._lines, self._done, stop, self._width, self._begins, False)
        keep, back = stop, 0.0
        while keep > 0 and back < 3 * CLEAR * self._width:
            keep -= 1
            back += self._lines[keep].length
        self._begins = self._begins and keep == 0
        self._lines = self._lines[keep:]
        self._done = stop - keep


def _like(line: Segment, first: Segment) -> bool:
    """Whether the feeds of two lines may be in one run."""
    if math.isclose(line.feed, first.feed, rel_tol=SAME_FEED):
        return True
    if not line.tool_feed == first.tool_feed < math.inf:
        return False
    return math.isclose(line.feed, first.feed, rel_tol=NEAR_FEED)


def _hard(places: FloatArray, sizes: FloatArray, width: float, most: float) -> FloatArray:
    """Deviations (n,) of the corners of a run, infinite for those that end it [m]."""
    alone = (PEAK * width * sizes > most) | (sizes > MOST_TURN)
    index, there = within(places, places, REACH * width)
    weight = np.where(there & ~alone[index], sizes[index], 0.0)
    found = width * (weights((places[index] - places[:, None]) / width)[0] * weight).sum(axis=1)
    ends = alone | (found > most) | (weight.sum(axis=1) > MOST_TURN)
    return np.where(ends, np.inf, found)


def _parts(
    lines: list[Segment], start: int, stop: int, width: float, begins: bool, ends: bool
) -> Iterator[Segment]:
    """Segments of lines[start:stop]; begins, ends: whether the path does with the lines."""
    count = len(lines)
    lengths = np.array([line.length for line in lines])
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    directions = np.array([line.direction for line in lines])
    changes = np.diff(directions, axis=0)
    most = SHARE * lines[0].tolerance
    off = np.concatenate(
        [[np.inf], _hard(places[1:-1], np.linalg.norm(changes, axis=1), width, most), [np.inf]]
    )
    marks = [k for k in range(1, count) if off[k] == np.inf]
    edges = ([0] if begins else [-1]) + marks + ([count] if ends else [count + 1])
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        low, high = max(first, start), min(last, stop)
        if low >= high:
            continue
        if last - first == 1:
            yield lines[low]
            continue
        # Corners of this run, and their reflections in the ends that it meets.
        own = np.arange(max(first, 0) + 1, min(last, count))
        corners, turns = [places[own]], [changes[own - 1]]
        for edge in (first, last):
            if 0 <= edge <= count:
                corners.append(2 * places[edge] - places[own])
                turns.append(-changes[own - 1])
        narrow = width
        if first >= 0 and last <= count:
            # No reflection of a reflection is within reach.
            narrow = min(width, float(places[last] - places[first]) / REACH)
        order = np.argsort(np.concatenate(corners), kind="stable")
        run = _Run(
            lines,
            places,
            directions,
            off,
            narrow,
            np.concatenate(corners)[order],
            np.concatenate(turns)[order],
        )
        yield from run.between(low, high, first == low, last == high)


class _Run:
    """A run of lines: its curve in parts, and lines where the path is straight."""

    def __init__(
        self,
        lines: list[Segment],
        places: FloatArray,
        directions: FloatArray,
        off: FloatArray,
        width: float,
        corners: FloatArray,
        changes: FloatArray,
    ) -> None:
        self.lines, self.places, self.directions, self.off = lines, places, directions, off
        self.width, self.corners, self.changes = width, corners, changes

    def between(self, low: int, high: int, begins: bool, ends: bool) -> Iterator[Segment]:
        """Segments of the lines low to high - 1; begins, ends: the run does there."""
        clear = CLEAR * self.width
        at, first = self.places[low], low
        for k in range(low, high):
            line = self.lines[k]
            if line.length <= LONG * self.width:
                continue
            left = self.places[k] + (0.0 if begins and k == low else clear)
            right = self.places[k + 1] - (0.0 if ends and k + 1 == high else clear)
            if left > at:
                yield self.curve(first, k + 1, at, left)
            start = line.start + (left - self.places[k]) * line.direction
            end = line.end - (self.places[k + 1] - right) * line.direction
            # Not merged with lines about it, whose directions differ.
            yield replace(line, start=start, end=end, length=float(right - left), merge=0.0)
            at, first = right, k
        if self.places[high] > at:
            yield self.curve(first, high, at, self.places[high])

    def curve(self, first: int, last: int, begin: float, end: float) -> Segment:
        """The curve between two places on the lines first to last - 1."""
        inner = self.places[first + 1 : last]
        places = np.concatenate([[begin], inner, [end]])
        number = np.append(np.arange(first, last), last - 1)
        if end == self.places[last] and last < len(self.lines) and self.off[last] < np.inf:
            number[-1] = last  # the direction after a corner at the end
        starts = np.array([self.lines[k].start for k in number])
        points = starts + (places - self.places[number])[:, None] * self.directions[number]
        reach = REACH * self.width
        near = (self.corners >= begin - reach) & (self.corners <= end + reach)
        own = self.lines[first:last]
        curve = Smoothed(
            places - begin,
            points,
            self.directions[number],
            self.corners[near] - begin,
            self.changes[near],
            self.width,
            [line.line for line in own],
            [line.move for line in own],
        )
        ends = curve.derivatives(np.array([0.0, end - begin]), 1)[0]
        off = self.off[first : last + 1]
        feeds = [line.feed for line in own]
        # Where they differ more, the feed of the tool limits every place.
        same = max(feeds) <= min(feeds) * (1 + SAME_FEED)
        return replace(
            own[-1],
            start=ends[0],
            end=ends[1],
            length=curve.length,
            feed=min(feeds) if same else max(feeds),
            tool_feed=min(line.tool_feed for line in own),
            direction=np.zeros(5),
            curve=curve,
            ratio=1.0,
            # Reflections in an end at most double what a corner deviates.
            off=2 * float(off[off < np.inf].max(initial=0.0)),
        )
