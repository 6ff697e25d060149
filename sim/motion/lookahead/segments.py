# SPDX-License-Identifier: Apache-2.0
"""First stage of the look-ahead planner: moves become segments of path space.

Moves that go nowhere are left out, very short ones are joined to the next, lines with gentle
corners between them become curves (runs.py), and other lines are merged within Q of G64. Every
move is checked against the workspace.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from operator import le

import numpy as np

from sim.motion.gcode.arcs import ARC_TOLERANCE_MM
from sim.motion.geometry.blend import SCALE, TABLE_RADIUS
from sim.motion.geometry.curves import (
    FULL_TURN_BELOW,
    MISSES,
    Arc,
    Curve,
    FloatArray,
    Line,
    TurnedArc,
    curve_of,
    feed_of,
    to_si,
)
from sim.motion.geometry.moves import Dwell, Motion, Move, Pose
from sim.motion.geometry.rotation import Rotation
from sim.motion.geometry.workspace import NAMES, Workspace, shown
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.runs import Runs
from sim.motion.lookahead.segment import Segment

# Shorter lines [m] are run as one line with the next one if P allows to miss the joint by that.
SHORTEST_MOVE = 1e-7
_CHECKED_EACH_RADIAN = 64  # further points of a turned arc: off by 3e-5 of the radius at most
MERGED_AT_MOST = 64  # points of lines joined by Q


class OutsideError(ValueError):
    """A move leaves the workspace; the text has file, line, coordinate and limit."""


class Segments:
    """The segments and rests of a stream of moves, one pass; `moves` counts those read.

    rapid: rate of G0 [m/s], None: as fast as the limits allow; file: name for messages; limits: for
    runs, None: there are none. Raises what the stream raises, and OutsideError.
    """

    def __init__(
        self,
        items: Iterable[Move | Dwell],
        workspace: Workspace,
        rapid: float | None,
        file: str,
        limits: MachineLimits | None = None,
    ) -> None:
        self._limits = limits
        self._items, self._workspace, self._rapid, self._file = items, workspace, rapid, file
        self.moves = 0
        self._last: tuple[Pose | None, FloatArray, bool] = None, np.zeros(5), False
        self._lower = (np.array(workspace.lower) * SCALE).tolist()
        self._upper = (np.array(workspace.upper) * SCALE).tolist()

    def _segments(self) -> Iterator[Segment | Dwell]:
        held: tuple[Move, int] | None = None  # too short to be run alone, and its number
        for item in self._items:
            if isinstance(item, Dwell):
                if held is not None:
                    yield from self._segment(*held)
                    held = None
                yield item
                continue
            number = self.moves
            self.moves += 1
            if held is not None:
                if _may_be_one(held[0], item):
                    item = replace(item, start=held[0].start)
                else:
                    yield from self._segment(*held)
            held = None
            if not item.motion.is_arc and item.tolerance > 0.0:
                if _is_short(item) and 0.0 < _way_of(item) < SHORTEST_MOVE:
                    held = item, number
                    continue
            yield from self._segment(item, number)
        if held is not None:
            yield from self._segment(*held)

    def _segment(self, move: Move, number: int) -> Iterator[Segment]:
        (_, start, inside), (_, end, end_inside) = self._at(move.start), self._at(move.end)
        direction, curve_kept = np.zeros(5), None
        if not move.motion.is_arc:
            x, y, z, a, c = way = end - start
            along = math.hypot(a, c) / TABLE_RADIUS if move.turns_only_the_table else 0.0
            along = along or math.hypot(x, y, z)
            if not along > 0.0:
                return
            if not (inside and end_inside):
                self._check(move, Line(start / SCALE, end / SCALE, along))
            length = math.sqrt(way @ way)
            ratio, direction = length / along, way / length
        else:
            move = _on_its_circle(move)
            curve = curve_of(move)
            if curve is None or not curve.length > 0.0:
                return
            self._check(move, curve)
            tangent = curve.evaluate(np.zeros(1))[1][0] * SCALE
            ratio = math.sqrt(tangent @ tangent)
            length = curve.length * ratio
            curve_kept = curve if isinstance(curve, Arc) else None
        feed = feed_of(move, self._rapid or math.inf)
        yield Segment(
            move.line,
            number,
            start,
            end,
            length,
            feed * ratio,
            math.inf if move.turns_only_the_table else feed,
            move.tolerance / 1e3,
            move.merge / 1e3,
            move.inner,
            direction,
            curve_kept,
            ratio,
        )

    def _at(self, pose: Pose) -> tuple[Pose | None, FloatArray, bool]:
        """A pose, itself in path space, and whether it is inside the workspace for certain.

        Most moves begin where the last one has ended.
        """
        if pose != self._last[0]:
            place = to_si(pose) * SCALE
            values = place.tolist()
            inside = all(map(le, self._lower, values)) and all(map(le, values, self._upper))
            self._last = pose, place, inside
        return self._last

    def _check(self, move: Move, curve: Curve) -> None:
        """Inside the workspace is a curve whose ends are, and an arc's outermost points too."""
        places = [0.0, curve.length]
        if isinstance(curve, Arc):
            quarters = np.sort([curve.first_angle, curve.first_angle + curve.sweep]) / (np.pi / 2)
            outer = np.arange(math.ceil(quarters[0]), math.floor(quarters[1]) + 1) * (np.pi / 2)
            places[1:1] = ((outer - curve.first_angle) / curve.sweep * curve.length).tolist()
        if isinstance(curve, TurnedArc):  # outermost points of a helix are between the quarters
            count = math.ceil(abs(curve.sweep) * _CHECKED_EACH_RADIAN)
            places += np.linspace(0.0, curve.length, count + 1).tolist()
        poses = curve.evaluate(np.array(places))[0]
        outside = self._workspace.outside(poses)
        if outside is not None:
            place, axis = outside
            low, high = self._workspace.lower[axis], self._workspace.upper[axis]
            raise OutsideError(
                f"{self._file}:{move.line}: error: the move leaves the workspace; "
                f"got {NAMES[axis]} = {shown(axis, poses[place, axis], '.4f')}; expected "
                f"{shown(axis, low).split()[0]} to {shown(axis, high)}\n"
                f"{move.line:5d} |   {move.source}"
            )

    def __iter__(self) -> Iterator[Segment | Dwell]:
        """The stage; lines are joined while the corners are within Q of the straight line."""
        first: Segment | None = None
        corners: list[FloatArray] = []
        segments = self._segments()
        for item in segments if self._limits is None else Runs(segments, self._limits):
            if first is not None:
                joined = self._joined(first, corners, item)
                if joined is not None:
                    corners.append(first.end)
                    first = joined
                    continue
                yield first
                first = None
            if isinstance(item, Segment) and item.merge > 0.0 and item.curve is None:
                first, corners = item, []
            else:
                yield item
        if first is not None:
            yield first

    def _joined(
        self, first: Segment, corners: list[FloatArray], item: Segment | Dwell
    ) -> Segment | None:
        if (
            not isinstance(item, Segment)
            or item.curve is not None
            or not math.isclose(item.feed, first.feed, rel_tol=1e-12)  # by their own lengths
            or item.merge != first.merge
            or item.tolerance != first.tolerance
            or len(corners) >= MERGED_AT_MOST
        ):
            return None
        way = item.end - first.start
        length = math.sqrt(way @ way)
        if length < SHORTEST_MOVE:
            return None
        direction = way / length
        points = np.array([*corners, first.end]) - first.start
        along = points @ direction
        off = points - along[:, None] * direction
        order = np.diff(np.concatenate([[0.0], along, [length]]))
        # Lines joined and blends share the distance that is allowed.
        most = max(first.allowed / 2, first.allowed - first.tolerance)
        missed = math.sqrt(np.sum(off * off, axis=1).max())
        if missed > min(first.merge, most) or (order < 0.0).any():
            return None
        return replace(
            first,
            end=item.end,
            length=length,
            direction=direction,
            off=missed,
            line=item.line,
            move=item.move,
        )


def _way_of(move: Move) -> float:
    """Distance in path space from start to end of a move [m]."""
    way = (to_si(move.end) - to_si(move.start)) * SCALE
    return math.sqrt(way @ way)


def _is_short(move: Move) -> bool:
    """Whether the tool's way may be shorter than SHORTEST_MOVE."""
    return all(
        abs(end - start) < SHORTEST_MOVE * 1e3
        for start, end in zip(move.start[:3], move.end[:3], strict=True)
    )


def _may_be_one(short: Move, move: Move) -> bool:
    """Whether a short line may be run as one line with the next move: P of both must allow to miss

    the joint, and a move of the table alone keeps its feed, which is in degrees.
    """
    if move.motion.is_arc or (move.turns_only_the_table and not short.turns_only_the_table):
        return False
    return _way_of(short) <= min(short.tolerance, move.tolerance) / 1e3


def _on_its_circle(move: Move) -> Move:
    """The arc with its centre moved to equal distance from both ends, so that it is a true circle.

    Along the chord, by the difference of the radii times radius / chord. More than half a turn is
    moved as a whole by that, so there it may be ARC_TOLERANCE_MM at most; an arc beyond (nearly a
    full turn) stays as it is, and its curve spreads the difference evenly.
    """
    if not move.motion.is_arc:
        return move
    (first, second), (cx, cy) = move.circle
    turn = Rotation(move.plane_turn)
    begin, finish = turn.turned_back(move.start), turn.turned_back(move.end)
    ax, ay = begin[first], begin[second]
    bx, by = finish[first], finish[second]
    ux, uy = bx - ax, by - ay
    square = ux * ux + uy * uy
    radius = math.hypot(ax - cx, ay - cy)
    growth = math.hypot(bx - cx, by - cy) - radius
    if math.sqrt(square) <= FULL_TURN_BELOW * radius or abs(growth) > MISSES * 1e3:
        return move
    off = ((cx - (ax + bx) / 2) * ux + (cy - (ay + by) / 2) * uy) / square
    moved = abs(off) * math.sqrt(square)
    left = ux * (cy - ay) - uy * (cx - ax)  # > 0: the centre is on the left of the chord
    less_than_half = left > 0.0 if move.motion is Motion.ARC_CCW else left < 0.0
    less_than_half &= move.turns == 1
    if moved > (0.1 * radius if less_than_half else ARC_TOLERANCE_MM):
        return move
    return replace(move, centre=(cx - off * ux, cy - off * uy))
