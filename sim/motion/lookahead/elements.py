# SPDX-License-Identifier: Apache-2.0
"""Pieces of the path that the look-ahead planner runs: parts of segments, blends, stops."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.blend import Blends
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.smoothed import Smoothed
from sim.motion.geometry.turn import Turn
from sim.motion.lookahead.limits import SHARES, Pieces
from sim.motion.lookahead.segment import Segment

SAME_FEED = 1e-3  # relative
EXAMINED = 9  # points of a part of a run


def kind_of(segment: Segment) -> str:
    """line, arc or run."""
    if segment.curve is None:
        return "line"
    return "run" if isinstance(segment.curve, Smoothed) else "arc"


@dataclass(eq=False)
class Element:
    """A piece of the path run, of one segment, blend or turn; a stop has none of them."""

    length: float
    line: int
    move: int
    segment: Segment | None = None
    offset: float = 0.0  # the piece's start on its segment
    blends: Blends | None = None
    index: int = 0
    turn: Turn | None = None

    @property
    def kind(self) -> str:
        """line, arc, run, blend, turn or stop."""
        if self.turn is not None:
            return "turn"
        if self.segment is not None:
            return kind_of(self.segment)
        return "stop" if self.blends is None else "blend"

    @property
    def own_segment(self) -> Segment:
        """The segment of a line, an arc or a run."""
        assert self.segment is not None, f"line {self.line}: a {self.kind} has no segment"
        return self.segment

    def end(self) -> FloatArray:
        """Last point in path space; not of a stop."""
        if self.turn is not None:
            return self.turn.end
        if self.segment is not None:
            return self.segment.at(np.array([self.offset + self.length]))[0][0]
        assert self.blends is not None
        return self.blends.at_parameters(np.array([self.index]), np.ones(1), 1)[0][0]


def pieces_of(parts: list[tuple[Element, float, float]]) -> Pieces:
    """Lines, arcs or runs (all of one kind), examined at some points each."""
    share = np.full(len(parts), SHARES[0])
    segments = [element.own_segment for element, _, _ in parts]
    feed = np.array([segment.feed for segment in segments])
    if segments[0].curve is None:
        begins = np.array([begin for _, begin, _ in parts])
        ends = np.array([end for _, _, end in parts])
        s = np.stack([begins, (begins + ends) / 2, ends], axis=1)
        start = np.array([segment.start for segment in segments])
        direction = np.array([segment.direction for segment in segments])
        q = start[:, None] + s[..., None] * direction[:, None]
        d1 = np.broadcast_to(direction[:, None], q.shape)
        zero = np.zeros_like(q)
        return Pieces(q, d1, zero, zero, feed, share)
    if parts[0][0].kind == "run":
        found = []
        for segment, group in groupby(parts, key=lambda part: part[0].own_segment):
            edges = np.array([part[1:] for part in group])
            if isinstance(segment.curve, Smoothed):
                found.append(segment.curve.examined(edges[:, 0], edges[:, 1], EXAMINED))
        q, d1, d2, d3 = (np.concatenate(each) for each in zip(*found, strict=True))
        # Where feeds of the lines differ, that of the tool is the limit (runs.py).
        tool_feed = np.array([segment.tool_feed for segment in segments])
        tool_feed = np.where(feed > tool_feed * (1 + SAME_FEED), tool_feed, np.inf)
        return Pieces(q, d1, d2, d3, feed, share, tool_feed)
    values = []
    for element, begin, end in parts:
        s = np.array([begin, (begin + end) / 2, end])
        values.append((*element.own_segment.at(s), element.own_segment.third(s)))
    q, d1, d2, d3 = (np.array(each) for each in zip(*values, strict=True))
    return Pieces(q, d1, d2, d3, feed, share)


def evaluate(
    elements: list[Element], owner: NDArray[np.int64], s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Point and two derivatives by the length at s (n,) of the elements `owner` (n,)."""
    q, d1, d2 = (np.zeros((len(s), 5)) for _ in range(3))
    kinds = np.array([element.kind for element in elements])
    kind = kinds[owner]
    rows = np.flatnonzero(kind == "line")
    if len(rows):
        lines = np.flatnonzero(kinds == "line")
        place = np.zeros(len(elements), dtype=np.int64)
        place[lines] = np.arange(len(lines))
        start = np.array([elements[n].own_segment.start for n in lines])
        direction = np.array([elements[n].own_segment.direction for n in lines])
        offset = np.array([elements[n].offset for n in lines])
        own = place[owner[rows]]
        q[rows] = start[own] + (s[rows] + offset[own])[:, None] * direction[own]
        d1[rows] = direction[own]
    for n in np.unique(owner[kind == "turn"]):
        rows, turn = np.flatnonzero(owner == n), elements[n].turn
        assert turn is not None
        q[rows], d1[rows], d2[rows] = turn.at(s[rows])
    for n in np.unique(owner[kind == "arc"]):
        rows = np.flatnonzero(owner == n)
        element = elements[n]
        q[rows], d1[rows], d2[rows] = element.segment.at(s[rows] + element.offset)
    rows = np.flatnonzero(kind == "run")
    if len(rows):
        runs = {id(element.segment): element.segment for element in elements if element.segment}
        run = np.array([id(element.segment) for element in elements])[owner[rows]]
        offset = np.array([element.offset for element in elements])[owner[rows]]
        for number in np.unique(run):
            own = rows[run == number]
            q[own], d1[own], d2[own] = runs[number].at(s[own] + offset[run == number])
    rows = np.flatnonzero(kind == "blend")
    if len(rows):
        sources = {id(e.blends): e.blends for e in elements if e.blends is not None}
        source = np.array([id(e.blends) for e in elements])[owner[rows]]
        index = np.array([e.index for e in elements])[owner[rows]]
        for key, blends in sources.items():
            own = source == key
            if own.any():
                q[rows[own]], d1[rows[own]], d2[rows[own]] = blends.at(index[own], s[rows[own]])
    return q, d1, d2
