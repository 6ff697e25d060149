# SPDX-License-Identifier: Apache-2.0
"""Joints of the segments of the look-ahead planner: rounded, turned, smooth, or a stop.

Of the ways past a corner that its tolerance allows, the fastest one is taken (choice.py).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry import blend
from sim.motion.geometry.blend import Blends
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.turn import Turn
from sim.motion.lookahead import choice
from sim.motion.lookahead.limits import SHARE_ANGLES, SHARES, Pieces, speeds
from sim.motion.lookahead.segment import Segment
from sim.motion.lookahead.settings import LookaheadSettings

SHORTEST_BLEND = 1e-7  # distance from the corner [m] below which the joint is a stop
SMOOTH = 1e-8  # angle [rad] and relative change of curvature that need no blend
LARGEST_ANGLE = math.radians(175.0)  # between directions; beyond, the joint is a stop
SLOWEST = 12  # joints listed in reports
INNER_TOLERANCE = 2e-6  # tolerance of joints inside one block [m]


Limit = tuple[float, float]
"""Greatest speed and acceleration along the path."""


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


class SlowestJoints(list[Joint]):
    """The SLOWEST slowest of all joints added, so that a long program does not fill the memory."""

    def extend(self, others: Iterable[Joint]) -> None:
        self[:] = heapq.nsmallest(SLOWEST, [*self, *others], key=lambda joint: joint.speed)


class Joints:
    """The joints between consecutive segments: distances taken from both sides, blends, stops."""

    def __init__(self, segments: list[Segment], settings: LookaheadSettings) -> None:
        count = len(segments) - 1
        self.distance = np.zeros(count)
        self.stop = np.zeros(count, dtype=bool)
        self.blend = np.full(count, -1)
        # By joint: the turn, its acceleration, speed and acceleration of the lines at both sides.
        self.turns: dict[int, tuple[Turn, float, Limit, Limit]] = {}
        self.found: list[Limit] = []  # speed and acceleration of each blend
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
        inner = np.array([segment.inner for segment in segments[1:]])
        within = self._lesser("rounding")
        within = np.where(inner, np.maximum(within, INNER_TOLERANCE), within)
        curvature = np.maximum(np.linalg.norm(k0, axis=1), np.linalg.norm(k1, axis=1))
        smooth = (self.angle <= SMOOTH) & (jump <= SMOOTH * np.maximum(1.0, curvature))
        if not limits.jerk_limited:
            smooth |= (self.angle <= SMOOTH) & (within == 0.0)
        ends = [segment.room(at_end=True) for segment in segments[:-1]]
        starts = [segment.room(at_end=False) for segment in segments[1:]]
        room = np.minimum(np.minimum(ends, starts), 0.25 / np.maximum(curvature, 1e-9))
        self.feed, self.tool_feed = self._lesser("feed"), self._lesser("tool_feed")
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
        self.which = blended
        if len(blended):
            self.distance[blended] = distance[blended]
            self.stop[blended] = False
            self.blend[blended] = np.arange(len(blended))
            self.blends = Blends(points)
            found = speeds(self.pieces(np.arange(len(blended))), limits, settings.robot)
            self.found = list(zip(*(values.tolist() for values in found), strict=True))
        self._choose(np.flatnonzero(~smooth & (within > 0.0)), within, settings)
        self._record(within, first[0])

    def _choose(
        self, corners: NDArray[np.int64], within: FloatArray, settings: LookaheadSettings
    ) -> None:
        """Takes a turn or a stop where it is faster than the blend."""
        if settings.only_blends or not len(corners):
            return
        window = settings.limits.window
        sides = []
        for shift, at_end in ((0, True), (1, False)):
            own = [self.segments[k + shift] for k in corners]
            length = np.array([segment.length for segment in own])
            sides.append((length, *choice.end_limits(own, at_end, settings)))
        gains = np.zeros(len(corners))
        rows = np.flatnonzero(self.blend[corners] >= 0)
        if len(rows):
            blends = self.blend[corners[rows]]
            speed = np.array([self.found[n][0] for n in blends])
            left, right = ((a[rows], b[rows], c[rows]) for a, b, c in sides)
            distance = self.distance[corners[rows]]
            gains[rows] = choice.blend_gains(
                self.blends.length[blends], speed, distance, (left, right), window
            )
        for row, k in enumerate(corners.tolist()):
            first, last = ((float(speed[row]), float(rate[row])) for _, speed, rate in sides)
            before, after = self.segments[k], self.segments[k + 1]
            chosen = choice.turn(before, after, (first, last), within[k], settings)
            if chosen is not None:
                turn, acceleration = chosen
                gain = choice.turn_gain(acceleration, (first, last), window)
                if gain < min(0.0, gains[row]):
                    self.turns[k] = turn, acceleration, first, last
                    self.distance[k], self.stop[k], self.blend[k] = turn.half, False, -1
                    continue
            if gains[row] > 0.0:
                self.distance[k], self.stop[k], self.blend[k] = 0.0, True, -1

    def _record(self, within: FloatArray, corners: FloatArray) -> None:
        """Records of the corners that are not stops."""
        rounded = np.flatnonzero(self.blend >= 0)
        if len(rounded):
            apexes = _apexes(self.blends, corners[self.which])[self.blend[rounded]]
            for k, apex in zip(rounded.tolist(), apexes.tolist(), strict=True):
                speed = self.found[self.blend[k]][0]
                self.records.append(self._joint(k, within, apex, speed))
        for k, (turn, acceleration, *_) in self.turns.items():
            speed = math.sqrt(6 * turn.half * acceleration) / 4 * math.cos(self.angle[k] / 2)
            self.records.append(self._joint(k, within, turn.apex, speed))

    def _joint(self, k: int, within: FloatArray, apex: float, speed: float) -> Joint:
        line = self.segments[k].line
        return Joint(line, float(self.angle[k]), float(within[k]), apex, speed)

    def _lesser(self, name: str) -> FloatArray:
        """The lesser value of both segments of each joint."""
        values = np.array([getattr(segment, name) for segment in self.segments])
        return np.minimum(values[:-1], values[1:])

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
        # The set-point nearest to the corner may miss the apex by half a period's way. The blend
        # bends away from the corner, which adds to the distance of that set-point.
        reach = within / per_distance
        tool = settings.limits.tool
        bent = np.interp(angle, _ANGLES[1:], _BENT) / angle.clip(1e-3)
        radius = reach * bent
        speed = np.minimum(self.feed[wanted], np.sqrt(tool.acceleration * radius))
        beside = np.minimum(speed, tool.speed) * settings.period / 2
        share = np.where(beside < within, beside / np.maximum(within, 1e-300), 0.0)
        share = share * np.sqrt(1.0 + per_distance / bent)
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
        ends: list[tuple[FloatArray, ...]] = []
        for k in which:
            first, second, d = self.segments[k], self.segments[k + 1], distance[k]
            if first.curve is None and second.curve is None:
                zero = np.zeros(5)
                ends.append(
                    (
                        *(first.end - d * first.direction, second.start + d * second.direction),
                        *(first.direction, second.direction, zero, zero),
                    )
                )
            else:
                sides = first.at(np.array([first.length - d])), second.at(np.array([d]))
                ends.append(tuple(value[0] for pair in zip(*sides, strict=True) for value in pair))
        p, q, t, u, b, c = np.array(ends).reshape(-1, 6, 5).transpose(1, 0, 2)
        return blend.control_points((p, q), (t, u), (b, c), distance[which], self.angle[which])

    def pieces(self, numbers: NDArray[np.int64]) -> Pieces:
        """The blends `numbers`, examined at their nodes."""
        count = len(blend.EXAMINED)
        u = np.tile(blend.EXAMINED, len(numbers))
        values = self.blends.at_parameters(numbers.repeat(count), u)
        q, d1, d2, d3 = (value.reshape(len(numbers), count, 5) for value in values)
        joint = self.which[numbers]
        # The tool's share of the path may be greater within a blend than at both its ends.
        tool = np.linalg.norm(d1[..., :3], axis=2).max(axis=1)
        return Pieces(
            *(q, d1, d2, d3),
            feed=np.minimum(self.feed[joint], self.tool_feed[joint] / np.maximum(tool, 1e-12)),
            share=np.interp(self.angle[joint], SHARE_ANGLES, SHARES),
        )


_ANGLES = np.radians(np.arange(0.0, 176.0))


def _unit_apexes() -> tuple[FloatArray, FloatArray]:
    """Of a blend between lines, per distance of its ends: distance from the corner to the apex, and
    radius of curvature there times the angle [rad]."""
    angle = _ANGLES
    t0, t1 = np.zeros((len(angle), 5)), np.zeros((len(angle), 5))
    t0[:, 0] = 1.0
    t1[:, 0], t1[:, 1] = np.cos(angle), np.sin(angle)
    zero = np.zeros_like(t0)
    points = blend.control_points((-t0, t1), (t0, t1), (zero, zero), np.ones(len(angle)), angle)
    half = np.full(len(angle), 0.5)
    apex, _, bend = Blends(points).at_parameters(np.arange(len(angle)), half, 2)
    radius = 1.0 / np.maximum(np.linalg.norm(bend, axis=1), 1e-300)
    return np.linalg.norm(apex, axis=1), radius * angle


_APEX, _BENT = (values[1:] for values in _unit_apexes())
_PER_SINE = _APEX / np.sin(_ANGLES[1:] / 2)


def _apex_per_distance(angle: FloatArray) -> FloatArray:
    return np.interp(angle, _ANGLES[1:], _PER_SINE) * np.sin(angle / 2)


def _apexes(blends: Blends, corners: FloatArray) -> FloatArray:
    """Least distances from the corners (n, 5) to the blends, at 65 points."""
    u = np.linspace(0.0, 1.0, 65)
    which = np.arange(len(blends)).repeat(len(u))
    points = blends.at_parameters(which, np.tile(u, len(blends)), 1)[0]
    ways = points.reshape(len(blends), len(u), 5) - corners[:, None, :]
    return np.linalg.norm(ways, axis=2).min(axis=1)
