# SPDX-License-Identifier: Apache-2.0
"""Look-ahead planner: moves in, set-points out, both as streams of any length.

Joints of moves are rounded by blends (sim/motion/blend.py) whose apex is at most G64's P from the
programmed corner, in path space (x, y, z, table axes times TABLE_RADIUS): for tool and table
together. A joint is a stop under G61, at a reversal, and where no blend fits; lines or
arcs that continue each other need neither. Limits of tool and joints are turned into limits of the
speed along each piece (lookahead_limits.py), and these into a motion (lookahead_speed.py).

Memory: the moves within the stopping distance and some `depth` more. Work per move: constant.
"""

from __future__ import annotations

import math
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from sim.model.parameters import Robot
from sim.motion import blend
from sim.motion.blend import SCALE, Blends
from sim.motion.gcode_arcs import ARC_TOLERANCE_MM
from sim.motion.lookahead_limits import (
    SHARE_ANGLES,
    SHARES,
    MachineLimits,
    Pieces,
    speeds,
)
from sim.motion.lookahead_speed import Cell, SpeedPlanner, Stop, Stretch
from sim.motion.moves import Dwell, Motion, Move
from sim.motion.path import FULL_TURN_BELOW, Arc, Curve, Line, curve_of, to_si
from sim.motion.trajectory import WORKSPACE_ROUNDING, Workspace

FloatArray = NDArray[np.float64]

DEPTH = 256  # moves looked at together, and least depth of the look-ahead
LONGEST_CELL = 0.02  # of a line [m]; the directions to the legs change by some 3 %
LARGEST_TURN = 0.2  # of an arc's cell [rad]
# Shorter lines [m] are run as one line with the next one if P allows to miss the joint by that.
SHORTEST_MOVE = 1e-7
SHORTEST_BLEND = 1e-7  # distance from the corner [m] below which the joint is a stop
SMOOTH = 1e-8  # angle [rad] and relative change of curvature that need no blend
LARGEST_ANGLE = math.radians(175.0)  # between directions; beyond, the joint is a stop
MERGED_AT_MOST = 64  # points of lines joined by Q
BLOCK = 20_000  # most set-points made together


@dataclass(frozen=True)
class LookaheadSettings:
    """How moves are run: period of the set-points [s], machine limits, rapid rate [m/s] (None: that

    of the tool's limit), depth (moves), robot.
    """

    period: float = 100e-6
    limits: MachineLimits = field(default_factory=MachineLimits)
    rapid: float | None = None
    depth: int = DEPTH
    robot: Robot = field(default_factory=Robot.load)

    def __post_init__(self) -> None:
        for name in ("period", "rapid"):
            value = getattr(self, name)
            if value is not None and not (value > 0.0 and math.isfinite(value)):
                raise ValueError(f"{name} = {value!r} is outside its limit: {name} > 0")
        if self.depth < 2:
            raise ValueError(f"depth = {self.depth!r} is outside its limit: depth >= 2")


class OutsideError(ValueError):
    """A move leaves the workspace; the text has file, line, coordinate and limit."""


@dataclass(eq=False)
class _Segment:
    """A move in path space [m]."""

    line: int
    start: FloatArray
    end: FloatArray
    length: float
    feed: float  # [m/s] of path space
    tool_feed: float  # [m/s] of the tool; inf for a move of the table alone
    tolerance: float  # [m]
    merge: float  # [m]
    inner: bool
    direction: FloatArray | None = None  # of a line
    curve: Curve | None = None  # of an arc
    ratio: float = 1.0  # length in path space per length of the curve

    def at(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Point, first and second derivative by the length, (n, 5), in path space."""
        if self.curve is None:
            zero = np.zeros((len(s), 5))
            return self.start + s[:, None] * self.direction, zero + self.direction, zero
        point, first, second = self.curve.evaluate(s / self.ratio)
        return point * SCALE, first * SCALE / self.ratio, second * SCALE / self.ratio**2


@dataclass(eq=False)
class Joint:
    """What became of the joint between two moves, for reports: lengths in m.

    apex: distance from the corner to the path run; speed: greatest speed allowed there [m/s].
    """

    line: int
    angle: float
    tolerance: float
    apex: float
    speed: float
    corner: FloatArray


@dataclass(eq=False)
class _Element:
    """A piece of the path run, of one segment or one blend; a stop has neither."""

    length: float
    line: int
    segment: _Segment | None = None
    offset: float = 0.0  # of the piece's start on its segment
    blends: Blends | None = None
    index: int = 0

    def end(self) -> FloatArray:
        """Last point in path space; not of a stop."""
        if self.segment is not None:
            return self.segment.at(np.array([self.offset + self.length]))[0][0]
        return self.blends.at_parameters(np.array([self.index]), np.ones(1), 1)[0][0]


@dataclass(frozen=True, eq=False)
class Setpoints:
    """n consecutive ticks: SI units, axes x, y, z, alpha, gamma.

    first: number of the first tick; position, velocity, acceleration (n, 5); line (n,) of text.
    """

    first: int
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    line: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.position)


@dataclass
class Summary:
    """Counts of a run: moves, joints by kind, duration [s], length in path space [m], cells."""

    moves: int = 0
    blends: int = 0
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
        self._workspace = Workspace.of((settings or LookaheadSettings()).robot)
        self.settings = settings or LookaheadSettings()
        self.joints = joints
        self.summary = Summary()
        self._elements: deque[_Element] = deque()

    # Stages: items -> segments -> cells -> stretches -> set-points

    def stretches(self) -> Iterator[Stretch]:
        """The motion along the path, without its points: for the time alone, nothing is sampled."""
        self._speeds_planner = self._planner()
        for stretch in self._speeds_planner.run(self._cells()):
            self.summary.duration += stretch.duration
            yield stretch
            self._drop(stretch)

    @property
    def planned(self) -> int:
        """Cells planned so far, repeats counted: the work done."""
        return self._speeds_planner.planned if self._speeds_planner else 0

    def duration(self) -> float:
        """Time of the whole path [s]."""
        for _ in self.stretches():
            pass
        return self.summary.duration

    def setpoints(self) -> Iterator[Setpoints]:
        """Set-points of all ticks, in blocks; the last tick is at rest at the end."""
        period = self.settings.period
        tick, ahead = 0, 0.0  # next tick, and its time from the start of the stretch
        self._begin = 0.0
        for stretch in self.stretches():
            count = max(0, math.ceil((stretch.duration - ahead) / period - 1e-9))
            for first in range(0, count, BLOCK):
                numbers = np.arange(first, min(first + BLOCK, count))
                yield self._sample(stretch, ahead + period * numbers, tick + first)
            tick += count
            ahead += count * period - stretch.duration
        if self.summary.moves and self._last is not None:
            point = (self._last / SCALE)[None, :]
            zero = np.zeros((1, 5))
            yield Setpoints(tick, point, zero, zero, np.array([self._last_line]))

    def _planner(self) -> SpeedPlanner:
        limits = self.settings.limits
        fastest = limits.tool.speed + limits.table.speed * blend.TABLE_RADIUS * 2
        return SpeedPlanner(limits.window, fastest, 4 * self.settings.depth)

    # Segments

    def _segments(self) -> Iterator[_Segment | Dwell]:
        held: Move | None = None  # too short to be run alone
        for item in self.items:
            if isinstance(item, Dwell):
                if held is not None:
                    yield from self._segment(held)
                    held = None
                yield item
                continue
            self.summary.moves += 1
            if held is not None:
                if _may_be_one(held, item):
                    item = replace(item, start=held.start)
                else:
                    yield from self._segment(held)
            held = None
            if not item.motion.is_arc and item.tolerance > 0.0:
                if 0.0 < _way_of(item) < SHORTEST_MOVE:
                    held = item
                    continue
            yield from self._segment(item)
        if held is not None:
            yield from self._segment(held)

    def _segment(self, move: Move) -> Iterator[_Segment]:
        move = _on_its_circle(move)
        curve = curve_of(move)
        if curve is None or not curve.length > 0.0:
            return
        start, end = to_si(move.start) * SCALE, to_si(move.end) * SCALE
        self._check(move, curve)
        if isinstance(curve, Line):
            way = end - start
            length = math.sqrt(way @ way)
            ratio, direction, curve_kept = length / curve.length, way / length, None
        else:
            tangent = curve.evaluate(np.zeros(1))[1][0] * SCALE
            ratio = math.sqrt(tangent @ tangent)
            length, direction, curve_kept = curve.length * ratio, None, curve
        if move.motion is Motion.RAPID:
            feed = math.inf if move.turns_only_the_table else self.settings.rapid or math.inf
        elif move.turns_only_the_table:
            feed = math.radians(move.feed) / 60
        else:
            feed = move.feed / 60e3
        yield _Segment(
            move.line,
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

    def _check(self, move: Move, curve: Curve) -> None:
        """Inside the workspace is a curve whose ends are, and an arc's outermost points too."""
        places = [0.0, curve.length]
        if isinstance(curve, Arc):
            quarters = np.sort([curve.first_angle, curve.first_angle + curve.sweep]) / (np.pi / 2)
            outer = np.arange(math.ceil(quarters[0]), math.floor(quarters[1]) + 1) * (np.pi / 2)
            places[1:1] = ((outer - curve.first_angle) / curve.sweep * curve.length).tolist()
        tool = curve.evaluate(np.array(places))[0][:, :3]
        lower, upper = np.array(self._workspace.lower), np.array(self._workspace.upper)
        outside = (tool < lower - WORKSPACE_ROUNDING) | (tool > upper + WORKSPACE_ROUNDING)
        if outside.any():
            place, axis = (int(n) for n in np.argwhere(outside)[0])
            raise OutsideError(
                f"{self.file}:{move.line}: error: the move leaves the workspace; "
                f"got {'xyz'[axis]} = {tool[place, axis] * 1e3:.4f} mm; expected "
                f"{lower[axis] * 1e3:g} to {upper[axis] * 1e3:g} mm\n"
                f"{move.line:5d} |   {move.source}"
            )

    def _merged(self) -> Iterator[_Segment | Dwell]:
        """Joins lines whose corners are within Q of the line from the first to the last point."""
        first: _Segment | None = None
        corners: list[FloatArray] = []
        for item in self._segments():
            if first is not None:
                joined = self._joined(first, corners, item)
                if joined is not None:
                    corners.append(first.end)
                    first = joined
                    continue
                yield first
                first = None
            if isinstance(item, _Segment) and item.merge > 0.0 and item.curve is None:
                first, corners = item, []
            else:
                yield item
        if first is not None:
            yield first

    def _joined(
        self, first: _Segment, corners: list[FloatArray], item: _Segment | Dwell
    ) -> _Segment | None:
        if (
            not isinstance(item, _Segment)
            or item.curve is not None
            or item.feed != first.feed
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
        if (np.sum(off * off, axis=1) > first.merge**2).any() or (order < 0.0).any():
            return None
        return replace(first, end=item.end, length=length, direction=direction, line=item.line)

    # Cells

    def _cells(self) -> Iterator[Cell | Stop]:
        self._last, self._last_line = None, 0
        before: _Segment | None = None
        cut = 0.0  # length of `before` that its first blend has taken
        batch: list[_Segment] = []
        early: list[Dwell] = []  # before the first move, when the place is not known yet
        for item in self._merged():
            if self._rest is None:
                if isinstance(item, Dwell):
                    early.append(item)
                    continue
                self._rest = item.start
                for dwell in early:
                    self._elements.append(_Element(0.0, dwell.line))
                    yield Stop(dwell.seconds)
            if isinstance(item, _Segment):
                self._last, self._last_line = item.end, item.line
                batch.append(item)
                if len(batch) < self.settings.depth:
                    continue
            dwell = item if isinstance(item, Dwell) else None
            before, cut, cells = self._batch(before, cut, batch, dwell)
            batch = []
            yield from cells
        _, _, cells = self._batch(before, cut, batch, Dwell(0, "", 0.0))
        yield from cells

    def _batch(
        self, before: _Segment | None, cut: float, batch: list[_Segment], dwell: Dwell | None
    ) -> tuple[_Segment | None, float, list[Cell | Stop]]:
        """Cells of the segments up to a dwell, or without the last one, which is handed back."""
        segments = [before, *batch] if before is not None else batch
        if not segments:
            cells: list[Cell | Stop] = (
                [Stop(dwell.seconds)] if dwell and dwell.seconds > 0.0 else []
            )
            if cells:
                self._elements.append(_Element(0.0, dwell.line))
            return None, 0.0, cells
        joints = _Joints(segments, self.settings)
        self._count(joints, segments)
        kept = len(segments) if dwell is not None else len(segments) - 1
        elements: list[_Element] = []
        for k in range(kept):
            segment = segments[k]
            begin = cut if k == 0 else joints.distance[k - 1]
            last = k == len(segments) - 1
            end = segment.length - (0.0 if last else joints.distance[k])
            if end - begin > 1e-12:
                elements.append(_Element(end - begin, segment.line, segment, begin))
            if last:
                break
            if joints.blend[k] >= 0:
                index = int(joints.blend[k])
                length = float(joints.blends.length[index])
                elements.append(_Element(length, segment.line, blends=joints.blends, index=index))
            elif joints.stop[k]:
                elements.append(_Element(0.0, segment.line))
        cells = self._limited(elements, joints)
        self._elements.extend(elements)
        if dwell is not None:
            self._elements.append(_Element(0.0, dwell.line))
            cells.append(Stop(dwell.seconds))
            return None, 0.0, cells
        return segments[-1], float(joints.distance[-1]) if len(segments) > 1 else cut, cells

    def _count(self, joints: _Joints, segments: list[_Segment]) -> None:
        self.summary.blends += int(np.sum(joints.blend >= 0))
        self.summary.stops += int(np.sum(joints.stop))
        self.summary.smooth += int(np.sum(~joints.stop & (joints.blend < 0)))

    def _limited(self, elements: list[_Element], joints: _Joints) -> list[Cell | Stop]:
        """Cells of the elements, with their greatest speeds and accelerations."""
        parts: list[tuple[_Element, float, float]] = []  # element, begin, end on its segment
        for element in elements:
            segment = element.segment
            if segment is None:
                parts.append((element, 0.0, element.length))
                continue
            pieces = 1
            if segment.curve is None:
                pieces = math.ceil(element.length / LONGEST_CELL)
            else:
                turn = abs(segment.curve.sweep) * element.length / segment.length
                pieces = max(
                    math.ceil(turn / LARGEST_TURN), math.ceil(element.length / LONGEST_CELL)
                )
            edges = element.offset + np.linspace(0.0, element.length, pieces + 1)
            parts += [
                (element, float(a), float(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)
            ]
        found = self._speeds(parts, joints)
        cells: list[Cell | Stop] = []
        for (element, begin, end), limit in zip(parts, found, strict=True):
            if element.segment is None and element.blends is None:
                cells.append(Stop(0.0))
                continue
            cells.append(Cell(end - begin, *limit))
            self.summary.length += end - begin
            if self.joints is not None and element.blends is not None:
                joints.records[element.index].speed = limit[0]
        if self.joints is not None:
            self.joints += joints.records
        self.summary.cells += len(cells)
        return cells

    def _speeds(
        self, parts: list[tuple[_Element, float, float]], joints: _Joints
    ) -> list[tuple[float, float]]:
        limits, robot = self.settings.limits, self.settings.robot
        result: list[tuple[float, float]] = [(0.0, 0.0)] * len(parts)
        groups: dict[str, list[int]] = {"line": [], "arc": [], "blend": []}
        for number, (element, _, _) in enumerate(parts):
            if element.segment is not None:
                groups["line" if element.segment.curve is None else "arc"].append(number)
            elif element.blends is not None:
                groups["blend"].append(number)
        for kind, numbers in groups.items():
            if not numbers:
                continue
            if kind == "blend":
                pieces = joints.pieces(np.array([parts[n][0].index for n in numbers]))
            else:
                pieces = _pieces([parts[n] for n in numbers])
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
        begins = []
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
            return Setpoints(tick, zero + place, zero, zero, np.full(len(times), element.line))
        elements = list(islice(self._elements, count))
        owner = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, count - 1)
        local = s - np.array(begins)[owner]
        local = np.clip(local, 0.0, np.array([e.length for e in elements])[owner])
        q, d1, d2 = _evaluate(elements, owner, local)
        velocity = d1 * v[:, None]
        acceleration = d1 * a[:, None] + d2 * (v * v)[:, None]
        line = np.array([e.line for e in elements])[owner]
        return Setpoints(tick, q / SCALE, velocity / SCALE, acceleration / SCALE, line)

    _speeds_planner: SpeedPlanner | None = None
    _begin = 0.0
    _rest: FloatArray | None = None
    _last: FloatArray | None = None
    _last_line = 0

    def _drop(self, stretch: Stretch) -> None:
        """Forgets the elements that are behind the motion."""
        elements = self._elements
        if stretch.stopped:
            while elements:
                element = elements.popleft()
                if element.length == 0.0:
                    break
                self._rest = element.end()
            self._begin = 0.0
            return
        reached = float(stretch.position[-1]) if len(stretch.position) else 0.0
        while elements and elements[0].length and self._begin + elements[0].length < reached:
            self._begin += elements.popleft().length
        self._begin -= stretch.shift


class _Joints:
    """The joints between consecutive segments: distances taken from both sides, blends, stops."""

    def __init__(self, segments: list[_Segment], settings: LookaheadSettings) -> None:
        count = len(segments) - 1
        self.distance = np.zeros(count)
        self.stop = np.zeros(count, dtype=bool)
        self.blend = np.full(count, -1)
        self.records: list[Joint] = []
        if count <= 0:
            return
        self.segments = segments
        limits = settings.limits
        first, second = self._ends()
        t0, t1, k0, k1 = first[1], second[1], first[2], second[2]
        self.angle = 2 * np.arctan2(
            np.linalg.norm(t1 - t0, axis=1), np.linalg.norm(t1 + t0, axis=1)
        )
        jump = np.linalg.norm(k1 - k0, axis=1)
        tolerance = np.array([segment.tolerance for segment in segments])
        inner = np.array([segment.inner for segment in segments[1:]])
        within = np.minimum(tolerance[:-1], tolerance[1:])
        within = np.where(inner, np.maximum(within, INNER_TOLERANCE), within)
        curvature = np.maximum(np.linalg.norm(k0, axis=1), np.linalg.norm(k1, axis=1))
        smooth = (self.angle <= SMOOTH) & (jump <= SMOOTH * np.maximum(1.0, curvature))
        if not limits.jerk_limited:
            smooth |= (self.angle <= SMOOTH) & (within == 0.0)
        length = np.array([segment.length for segment in segments])
        room = np.minimum(length[:-1], length[1:]) / 2
        room = np.minimum(room, 0.25 / np.maximum(curvature, 1e-9))
        feed, tool_feed = (
            np.array([getattr(segment, name) for segment in segments])
            for name in ("feed", "tool_feed")
        )
        self.feed = np.minimum(feed[:-1], feed[1:])
        self.tool_feed = np.minimum(tool_feed[:-1], tool_feed[1:])
        wanted = np.flatnonzero(~smooth & (within > 0.0) & (self.angle < LARGEST_ANGLE))
        distance = np.zeros(count)
        if len(wanted):
            distance[wanted] = self._distances(
                wanted, within[wanted], room[wanted], jump[wanted], settings
            )
        blended = np.flatnonzero(distance >= SHORTEST_BLEND)
        if len(blended):
            points, blended = self._fitted(blended, distance, within, first[0])
        self.stop = ~smooth
        if len(blended):
            self.distance[blended] = distance[blended]
            self.stop[blended] = False
            self.blend[blended] = np.arange(len(blended))
            self.blends = Blends(points)
            apex = _apexes(self.blends, first[0][blended])
            for n, k in enumerate(blended):
                self.records.append(
                    Joint(
                        segments[k].line,
                        float(self.angle[k]),
                        float(within[k]),
                        float(apex[n]),
                        0.0,
                        first[0][k] / SCALE,
                    )
                )
            self.which = blended

    def _ends(self) -> tuple[list[FloatArray], list[FloatArray]]:
        ends, starts = [], []
        for segment in self.segments:
            if segment.curve is None:
                zero = np.zeros(5)
                ends.append((segment.end, segment.direction, zero))
                starts.append((segment.start, segment.direction, zero))
            else:
                both = segment.at(np.array([0.0, segment.length]))
                starts.append(tuple(value[0] for value in both))
                ends.append(tuple(value[1] for value in both))
        return (
            [np.array(values) for values in zip(*ends[:-1], strict=True)],
            [np.array(values) for values in zip(*starts[1:], strict=True)],
        )

    def _distances(
        self,
        wanted: NDArray[np.int64],
        within: FloatArray,
        room: FloatArray,
        jump: FloatArray,
        settings: LookaheadSettings,
    ) -> FloatArray:
        """First estimates of the distances from the corners to the ends of the blends."""
        angle = self.angle[wanted]
        per_distance = np.maximum(_apex_per_distance(angle), 1e-12)
        # The nearest set-point may be half a period's way beside the apex.
        reach = within / per_distance
        tool = settings.limits.tool
        speed = np.minimum(self.feed[wanted], np.sqrt(tool.acceleration * reach / angle.clip(1e-3)))
        beside = np.minimum(speed, tool.speed) * settings.period / 2
        share = np.where(beside < within, beside / np.maximum(within, 1e-300), 0.0)
        within = within * np.sqrt(1.0 - np.minimum(share**2, 0.5)) * 0.999
        # apex = e d + jump d^2 / 12
        bow = jump / 12
        unlimited = np.isinf(within)
        within = np.where(unlimited, 0.0, within)
        root = np.sqrt(per_distance**2 + 4 * bow * within)
        distance = np.where(unlimited, np.inf, 2 * within / (per_distance + root))
        return np.minimum(distance, room)

    def _fitted(
        self,
        blended: NDArray[np.int64],
        distance: FloatArray,
        within: FloatArray,
        corners: FloatArray,
    ) -> tuple[FloatArray, NDArray[np.int64]]:
        """Control points of the blends; distances at arcs are lowered until the apex is within."""
        points = self._controls(blended, distance)
        curved = np.array(
            [
                self.segments[k].curve is not None or self.segments[k + 1].curve is not None
                for k in blended
            ]
        )
        for _ in range(40):
            rows = np.flatnonzero(curved)
            if not len(rows):
                break
            apex = _apexes(Blends(points[rows]), corners[blended[rows]])
            high = apex > within[blended[rows]]
            rows = rows[high]
            distance[blended[rows]] *= np.clip(within[blended[rows]] / apex[high], 0.3, 0.95)
            points[rows] = self._controls(blended[rows], distance)
            curved[:] = False
            curved[rows] = True
        kept = (distance[blended] >= SHORTEST_BLEND) & ~curved
        return points[kept], blended[kept]

    def _controls(self, which: NDArray[np.int64], distance: FloatArray) -> FloatArray:
        ends: list[list[FloatArray]] = [[], [], [], [], [], []]
        for k in which:
            first, second, d = self.segments[k], self.segments[k + 1], distance[k]
            if first.curve is None and second.curve is None:
                zero = np.zeros(5)
                values = (
                    (first.end - d * first.direction, first.direction, zero),
                    (second.start + d * second.direction, second.direction, zero),
                )
            else:
                values = tuple(
                    tuple(value[0] for value in segment.at(np.array([s])))
                    for segment, s in ((first, first.length - d), (second, d))
                )
            for n in range(3):
                ends[2 * n].append(values[0][n])
                ends[2 * n + 1].append(values[1][n])
        arrays = [np.array(values).reshape(-1, 5) for values in ends]
        return blend.control_points(
            (arrays[0], arrays[1]),
            (arrays[2], arrays[3]),
            (arrays[4], arrays[5]),
            distance[which],
            self.angle[which],
        )

    def pieces(self, numbers: NDArray[np.int64]) -> Pieces:
        """The blends `numbers`, examined at their nodes."""
        count = len(blend.EXAMINED)
        u = np.tile(blend.EXAMINED, len(numbers))
        values = self.blends.at_parameters(numbers.repeat(count), u)
        values = [value.reshape(len(numbers), count, 5) for value in values]
        joint = self.which[numbers]
        # The tool's part of the way may be greater within a blend than at both its ends.
        tool = np.linalg.norm(values[1][..., :3], axis=2).max(axis=1)
        return Pieces(
            *values,
            feed=np.minimum(self.feed[joint], self.tool_feed[joint] / np.maximum(tool, 1e-12)),
            share=np.interp(self.angle[joint], SHARE_ANGLES, SHARES),
        )


INNER_TOLERANCE = 2e-6  # of joints inside one block [m]
_ANGLES = np.radians(np.arange(0.0, 176.0))


def _unit_apexes() -> FloatArray:
    """Distance from the corner to the apex of a blend between lines, per distance of its ends."""
    angle = _ANGLES
    t0, t1 = np.zeros((len(angle), 5)), np.zeros((len(angle), 5))
    t0[:, 0] = 1.0
    t1[:, 0], t1[:, 1] = np.cos(angle), np.sin(angle)
    zero = np.zeros_like(t0)
    points = blend.control_points((-t0, t1), (t0, t1), (zero, zero), np.ones(len(angle)), angle)
    weights = np.array([1, 5, 10, 10, 5, 1]) / 32
    return np.linalg.norm(np.einsum("i,nid->nd", weights, points), axis=1)


_PER_SINE = _unit_apexes()[1:] / np.sin(_ANGLES[1:] / 2)


def _apex_per_distance(angle: FloatArray) -> FloatArray:
    return np.interp(angle, _ANGLES[1:], _PER_SINE) * np.sin(angle / 2)


def _apexes(blends: Blends, corners: FloatArray) -> FloatArray:
    """Least distances from the corners (n, 5) to the blends, at 65 points."""
    u = np.linspace(0.0, 1.0, 65)
    which = np.arange(len(blends)).repeat(len(u))
    points = blends.at_parameters(which, np.tile(u, len(blends)), 1)[0]
    ways = points.reshape(len(blends), len(u), 5) - corners[:, None, :]
    return np.linalg.norm(ways, axis=2).min(axis=1)


def _pieces(parts: list[tuple[_Element, float, float]]) -> Pieces:
    """Lines or arcs (all of one kind), examined at three points each."""
    share = np.full(len(parts), SHARES[0])
    feed = np.array([element.segment.feed for element, _, _ in parts])
    if parts[0][0].segment.curve is None:
        begin = np.array([b for _, b, _ in parts])
        end = np.array([e for _, _, e in parts])
        s = np.stack([begin, (begin + end) / 2, end], axis=1)
        start = np.array([element.segment.start for element, _, _ in parts])
        direction = np.array([element.segment.direction for element, _, _ in parts])
        q = start[:, None] + s[..., None] * direction[:, None]
        d1 = np.broadcast_to(direction[:, None], q.shape)
        zero = np.zeros_like(q)
        return Pieces(q, d1, zero, zero, feed, share)
    values = []
    for element, begin, end in parts:
        s = np.array([begin, (begin + end) / 2, end])
        q, d1, d2 = element.segment.at(s)
        # A circle's third derivative: the circular part of the first, turned twice.
        rate = element.segment.curve.sweep / element.segment.length
        circular = d1.copy()
        others = [n for n in range(5) if n not in element.segment.curve.axes]
        circular[:, others] = 0.0
        values.append((q, d1, d2, -(rate**2) * circular))
    return Pieces(*(np.array(v) for v in zip(*values, strict=True)), feed=feed, share=share)


def _evaluate(
    elements: list[_Element], owner: NDArray[np.int64], s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Point and two derivatives by the length at s (n,) of the elements `owner` (n,)."""
    q, d1, d2 = (np.zeros((len(s), 5)) for _ in range(3))
    kinds = np.array(
        [2 if e.blends is not None else int(e.segment.curve is not None) for e in elements]
    )
    kind = kinds[owner]
    rows = np.flatnonzero(kind == 0)
    if len(rows):
        lines = np.flatnonzero(kinds == 0)
        place = np.zeros(len(elements), dtype=np.int64)
        place[lines] = np.arange(len(lines))
        start = np.array([elements[n].segment.start for n in lines])
        direction = np.array([elements[n].segment.direction for n in lines])
        offset = np.array([elements[n].offset for n in lines])
        own = place[owner[rows]]
        q[rows] = start[own] + (s[rows] + offset[own])[:, None] * direction[own]
        d1[rows] = direction[own]
    for n in np.unique(owner[kind == 1]):
        rows = np.flatnonzero(owner == n)
        element = elements[n]
        q[rows], d1[rows], d2[rows] = element.segment.at(s[rows] + element.offset)
    rows = np.flatnonzero(kind == 2)
    if len(rows):
        sources = {id(e.blends): e.blends for e in elements if e.blends is not None}
        source = np.array([id(e.blends) for e in elements])[owner[rows]]
        index = np.array([e.index for e in elements])[owner[rows]]
        for key, blends in sources.items():
            own = source == key
            if own.any():
                q[rows[own]], d1[rows[own]], d2[rows[own]] = blends.at(index[own], s[rows[own]])
    return q, d1, d2


def _way_of(move: Move) -> float:
    """Distance in path space from start to end of a move [m]."""
    way = (to_si(move.end) - to_si(move.start)) * SCALE
    return math.sqrt(way @ way)


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
    first, second = move.plane.axes
    ax, ay = move.start[first], move.start[second]
    bx, by = move.end[first], move.end[second]
    ux, uy = bx - ax, by - ay
    square = ux * ux + uy * uy
    cx, cy = move.centre
    radius = math.hypot(ax - cx, ay - cy)
    if math.sqrt(square) <= FULL_TURN_BELOW * radius:
        return move
    off = ((cx - (ax + bx) / 2) * ux + (cy - (ay + by) / 2) * uy) / square
    moved = abs(off) * math.sqrt(square)
    left = ux * (cy - ay) - uy * (cx - ax)  # > 0: the centre is on the left of the chord
    less_than_half = left > 0.0 if move.motion is Motion.ARC_CCW else left < 0.0
    if moved > (0.1 * radius if less_than_half else ARC_TOLERANCE_MM):
        return move
    return replace(move, centre=(cx - off * ux, cy - off * uy))


if __name__ == "__main__":
    from sim.motion.command import interruptible
    from sim.motion.lookahead_cli import main

    sys.exit(interruptible(main))
