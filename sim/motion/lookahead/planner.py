# SPDX-License-Identifier: Apache-2.0
"""Look-ahead planner: moves in, set-points out, both as streams of any length.

Joints of moves are rounded by blends (sim/motion/geometry/blend.py) whose apex is at most G64's P
from the programmed corner, in path space (x, y, z, table axes times TABLE_RADIUS): for tool and
table together. A joint is a stop under G61, at a reversal, and where no blend fits; lines or
arcs that continue each other need neither. Limits of tool and joints are turned into limits of the
speed along each piece (limits.py), and these into a motion (speed.py).

Memory: the moves within the stopping distance and some `depth` more. Work per move: constant.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry import blend
from sim.motion.geometry.blend import SCALE
from sim.motion.geometry.curves import Arc, FloatArray
from sim.motion.geometry.moves import Dwell, Move
from sim.motion.geometry.smoothed import Smoothed
from sim.motion.geometry.workspace import Workspace
from sim.motion.lookahead.choice import LONGEST_CELL
from sim.motion.lookahead.elements import Element, evaluate, pieces_of
from sim.motion.lookahead.joints import Joint, Joints
from sim.motion.lookahead.limits import speeds
from sim.motion.lookahead.segment import Segment
from sim.motion.lookahead.segments import Segments
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.lookahead.speed import Cell, Corner, SpeedPlanner, Stop, Stretch

LARGEST_TURN = 0.2  # turn of an arc's cell [rad]
BLOCK = 20_000  # most set-points made together


@dataclass(frozen=True, eq=False)
class Setpoints:
    """n consecutive ticks: SI units, axes x, y, z, alpha, gamma.

    first: number of the first tick; position, velocity, acceleration (n, 5); line (n,) of text;
    move (n,): number in the stream of the move under way, or of the last one before a rest.
    """

    first: int
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    line: NDArray[np.int64]
    move: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.position)


@dataclass
class Summary:
    """Counts of a run: moves, joints by kind, duration [s], length in path space [m], cells."""

    moves: int = 0
    blends: int = 0
    turns: int = 0
    smooth: int = 0
    stops: int = 0
    duration: float = 0.0
    length: float = 0.0
    cells: int = 0


class Lookahead:
    """One run over a stream of moves. `joints`, if a list is given, collects a record per corner.

    file: name for messages. The stages raise what the stream of moves raises, and OutsideError.
    """

    def __init__(
        self,
        items: Iterable[Move | Dwell],
        settings: LookaheadSettings | None = None,
        joints: list[Joint] | None = None,
        file: str = "<text>",
    ) -> None:
        self.items = items
        self.file = file
        self.settings = settings or LookaheadSettings()
        self.joints = joints
        self.summary = Summary()
        limits = self.settings.limits
        fastest = limits.tool.speed + limits.table.speed * blend.TABLE_RADIUS * 2
        self._speed_planner = SpeedPlanner(limits.window, fastest, 4 * self.settings.depth)
        self._elements: deque[Element] = deque()  # not passed by the motion yet
        self._begin = 0.0  # of the first of them, from the origin of the stretch
        self._rest: FloatArray | None = None
        self._last: Segment | None = None

    # Stages: items -> segments -> cells -> stretches -> set-points

    def stretches(self) -> Iterator[Stretch]:
        """The motion along the path, without its points: for the time alone, nothing is sampled."""
        for stretch in self._speed_planner.run(self._cells()):
            self.summary.duration += stretch.duration
            yield stretch
            self._drop(stretch)

    @property
    def planned(self) -> int:
        """Cells planned so far, repeats counted: the work done."""
        return self._speed_planner.planned

    def duration(self) -> float:
        """Time of the whole path [s]."""
        for _ in self.stretches():
            pass
        return self.summary.duration

    def setpoints(self) -> Iterator[Setpoints]:
        """Set-points of all ticks, in blocks; the last tick is at rest at the end."""
        period = self.settings.period
        tick, ahead = 0, 0.0  # next tick, and its time from the start of the stretch
        for stretch in self.stretches():
            count = max(0, math.ceil((stretch.duration - ahead) / period - 1e-9))
            for first in range(0, count, BLOCK):
                numbers = np.arange(first, min(first + BLOCK, count))
                yield self._sample(stretch, ahead + period * numbers.astype(float), tick + first)
            tick += count
            ahead += count * period - stretch.duration
        if self.summary.moves and self._last is not None:
            point = (self._last.end / SCALE)[None, :]
            zero = np.zeros((1, 5))
            last = np.array([self._last.line]), np.array([self._last.move])
            yield Setpoints(tick, point, zero, zero, *last)

    # Cells

    def _cells(self) -> Iterator[Cell | Corner | Stop]:
        before: Segment | None = None
        cut = 0.0  # length of `before` that its first blend has taken
        batch: list[Segment] = []
        held = 0  # moves of it
        early: list[Dwell] = []  # before the first move, when the place is not known yet
        workspace = Workspace.of(self.settings.robot)
        limits = None if self.settings.only_blends else self.settings.limits
        segments = Segments(self.items, workspace, self.settings.rapid, self.file, limits)
        for item in segments:
            self.summary.moves = segments.moves
            if self._rest is None:
                if isinstance(item, Dwell):
                    early.append(item)
                    continue
                self._rest = item.start
                for dwell in early:
                    self._elements.append(Element(0.0, dwell.line, item.move))
                    yield Stop(dwell.seconds)
            if isinstance(item, Segment):
                self._last = item
                batch.append(item)
                held += item.count
                if held < self.settings.depth:
                    continue
            rest = item if isinstance(item, Dwell) else None
            before, cut, cells = self._batch(before, cut, batch, rest)
            batch, held = [], 0
            yield from cells
        self.summary.moves = segments.moves
        _, _, cells = self._batch(before, cut, batch, Dwell(0, "", 0.0))
        yield from cells

    def _batch(
        self, before: Segment | None, cut: float, batch: list[Segment], dwell: Dwell | None
    ) -> tuple[Segment | None, float, list[Cell | Corner | Stop]]:
        """Cells of the segments up to a dwell, or without the last one, which is handed back."""
        segments = [before, *batch] if before is not None else batch
        if not segments:
            if self._last is None or dwell is None or dwell.seconds <= 0.0:
                return None, 0.0, []
            self._elements.append(Element(0.0, dwell.line, self._last.move))
            return None, 0.0, [Stop(dwell.seconds)]
        joints = Joints(segments, self.settings)
        self.summary.blends += int(np.sum(joints.blend >= 0))
        self.summary.turns += len(joints.turns)
        self.summary.stops += int(np.sum(joints.stop))
        same = np.array(
            [a.move == b.first_move for a, b in pairwise(segments)], dtype=bool
        )  # a joint inside a move, where a run begins or ends
        smooth = ~joints.stop & (joints.blend < 0) & ~same
        self.summary.smooth += int(np.sum(smooth)) - len(joints.turns)
        kept = len(segments) if dwell is not None else len(segments) - 1
        elements: list[Element] = []
        for k in range(kept):
            segment = segments[k]
            begin = cut if k == 0 else joints.distance[k - 1]
            last = k == len(segments) - 1
            end = segment.length - (0.0 if last else joints.distance[k])
            if end - begin > 1e-12:
                elements += _elements(segment, float(begin), float(end))
            self.summary.smooth += segment.count - 1
            if last:
                break
            if joints.blend[k] >= 0:
                index = int(joints.blend[k])
                length = float(joints.blends.length[index])
                elements.append(
                    Element(length, segment.line, segment.move, blends=joints.blends, index=index)
                )
            elif k in joints.turns:
                turn = joints.turns[k][0]
                elements.append(Element(2 * turn.half, segment.line, segment.move, turn=turn))
            elif joints.stop[k]:
                elements.append(Element(0.0, segment.line, segment.move))
        cells = self._limited(elements, joints)
        self._elements.extend(elements)
        if dwell is not None:
            self._elements.append(Element(0.0, dwell.line, segments[-1].move))
            cells.append(Stop(dwell.seconds))
            return None, 0.0, cells
        return segments[-1], float(joints.distance[-1]) if len(segments) > 1 else cut, cells

    def _limited(self, elements: list[Element], joints: Joints) -> list[Cell | Corner | Stop]:
        """Cells of the elements, with their greatest speeds and accelerations."""
        parts: list[tuple[Element, float, float]] = []  # element, begin, end on its segment
        for element in elements:
            segment = element.segment
            if segment is None:
                parts.append((element, 0.0, element.length))
                continue
            pieces = math.ceil(element.length / min(LONGEST_CELL, segment.cell))
            if isinstance(segment.curve, Arc):
                turn = abs(segment.curve.sweep) * element.length / segment.length
                pieces = max(pieces, math.ceil(turn / LARGEST_TURN))
            if pieces == 1:
                parts.append((element, element.offset, element.offset + element.length))
                continue
            edges = element.offset + np.linspace(0.0, element.length, pieces + 1)
            parts += [
                (element, float(a), float(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)
            ]
        found = self._speeds(parts, joints)
        cells: list[Cell | Corner | Stop] = []
        turns = iter(joints.turns.values())
        for (element, begin, end), limit in zip(parts, found, strict=True):
            if element.kind == "stop":
                cells.append(Stop(0.0))
                continue
            self.summary.length += end - begin
            if element.turn is not None:
                half, (_, acceleration, before, after) = element.turn.half, next(turns)
                cells += [Cell(half, *before), Corner(acceleration), Cell(half, *after)]
                continue
            cells.append(Cell(end - begin, *limit))
        if self.joints is not None:
            self.joints.extend(joints.records)
        self.summary.cells += len(cells)
        return cells

    def _speeds(
        self, parts: list[tuple[Element, float, float]], joints: Joints
    ) -> list[tuple[float, float]]:
        limits, robot = self.settings.limits, self.settings.robot
        result: list[tuple[float, float]] = [(0.0, 0.0)] * len(parts)
        for kind in ("line", "arc", "run", "blend"):
            numbers = [n for n, (element, _, _) in enumerate(parts) if element.kind == kind]
            if not numbers:
                continue
            if kind == "blend":
                for n in numbers:
                    result[n] = joints.found[parts[n][0].index]
                continue
            pieces = pieces_of([parts[n] for n in numbers])
            c, a = speeds(pieces, limits, robot)
            for number, speed, acceleration in zip(numbers, c.tolist(), a.tolist(), strict=True):
                result[number] = (speed, acceleration)
        return result

    # Set-points

    def _sample(self, stretch: Stretch, times: FloatArray, tick: int) -> Setpoints:
        k = np.searchsorted(stretch.time, times, side="right") - 1
        d = times - stretch.time[k]
        a0, j = stretch.acceleration[k], stretch.jerk[k]
        v0 = stretch.speed[k]
        s = stretch.position[k] + d * (v0 + d * (a0 / 2 + d * j / 6))
        v, a = v0 + d * (a0 + d * j / 2), a0 + d * j
        count, end = 0, self._begin
        begins: list[float] = []
        top = float(s[-1])
        for element in self._elements:
            if element.length == 0.0 or (begins and end > top):
                break
            begins.append(end)
            end += element.length
            count += 1
        if not count:  # a dwell at the start of the path
            element = self._elements[0]
            place = self._rest / SCALE
            zero = np.zeros((len(times), 5))
            line, move = (np.full(len(times), n) for n in (element.line, element.move))
            return Setpoints(tick, zero + place, zero, zero, line, move)
        elements = list(islice(self._elements, count))
        owner = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, count - 1)
        local = s - np.array(begins)[owner]
        local = np.clip(local, 0.0, np.array([e.length for e in elements])[owner])
        q, d1, d2 = evaluate(elements, owner, local)
        velocity = d1 * v[:, None]
        acceleration = d1 * a[:, None] + d2 * (v * v)[:, None]
        line, move = (
            np.array([getattr(e, name) for e in elements])[owner] for name in ("line", "move")
        )
        return Setpoints(tick, q / SCALE, velocity / SCALE, acceleration / SCALE, line, move)

    def _drop(self, stretch: Stretch) -> None:
        """Drops the elements that the motion has passed."""
        elements = self._elements
        if stretch.stopped:
            last: Element | None = None
            while elements:
                element = elements.popleft()
                if element.length == 0.0:
                    break
                last = element
            if last is not None:
                self._rest = last.end()
            self._begin = 0.0
            return
        reached = float(stretch.position[-1]) if len(stretch.position) else 0.0
        while elements and elements[0].length and self._begin + elements[0].length < reached:
            self._begin += elements.popleft().length
        self._begin -= stretch.shift


def _elements(segment: Segment, begin: float, end: float) -> list[Element]:
    """A segment between two lengths of it, as an element of each of its moves."""
    curve = segment.curve
    if not isinstance(curve, Smoothed):
        return [Element(end - begin, segment.line, segment.move, segment, begin)]
    elements = []
    for line, move, first, last in zip(
        curve.lines, curve.moves, curve.ends[:-1], curve.ends[1:], strict=True
    ):
        low, high = max(begin, float(first)), min(end, float(last))
        if high - low > 1e-12:
            elements.append(Element(high - low, line, move, segment, low))
    return elements
