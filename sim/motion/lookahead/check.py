# SPDX-License-Identifier: Apache-2.0
"""What a stream of set-points demands of tool, legs and table, and how far it leaves the program.

Nothing here knows how the set-points were made: the legs come from sim/robot/kinematics.py, speeds,
accelerations and jerks are first, second and third differences over the period. A difference is an
average of the derivative, so a motion within its limits has its differences within them.
Distances are from the moves as programmed, in path space (sim/motion/geometry/blend.py) [m].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.blend import SCALE
from sim.motion.geometry.curves import Arc, FloatArray, curve_of, to_si
from sim.motion.geometry.moves import Move
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Setpoints
from sim.robot.kinematics import inverse
from sim.robot.parameters import Robot

QUANTITIES = ("speed", "acceleration", "jerk")
GROUPS = ("tool", "leg", "table")
ROUNDING = 1e-12  # rounding of a distance [m]


@dataclass
class Demand:
    """Greatest speed, acceleration and jerk of tool [m], legs [m] and table [rad], per s, s2, s3.

    lines: the line of the text where each occurs.
    """

    greatest: dict[tuple[str, str], float]
    lines: dict[tuple[str, str], int]
    ticks: int = 0

    def ratios(self, limits: MachineLimits) -> dict[tuple[str, str], float]:
        """Greatest values by their limits."""
        return {
            (group, quantity): value / getattr(getattr(limits, group), quantity)
            for (group, quantity), value in self.greatest.items()
        }


def demand(stream: Iterable[Setpoints], robot: Robot, period: float) -> Demand:
    """Greatest differences of a whole stream; period [s]. Rest is assumed before its first tick."""
    result = Demand({(g, q): 0.0 for g in GROUPS for q in QUANTITIES}, {}, 0)
    tail: FloatArray | None = None
    for points in stream:
        result.ticks += len(points)
        before = np.repeat(points.position[:1], 3, axis=0) if tail is None else tail
        q = np.concatenate([before, points.position])
        tail = q[-3:]
        legs = inverse(robot, q[:, :3])
        for group, values in (("tool", q[:, :3]), ("leg", legs), ("table", q[:, 3:])):
            for order, quantity in enumerate(QUANTITIES, start=1):
                change = np.diff(values, order, axis=0)[3 - order :] / period**order
                size = (
                    np.linalg.norm(change, axis=1)
                    if group == "tool"
                    else np.abs(change).max(axis=1)
                )
                worst = int(size.argmax())
                if not size[worst] <= result.greatest[group, quantity]:
                    result.greatest[group, quantity] = float(size[worst])
                    result.lines[group, quantity] = int(points.line[worst])
    return result


class Deviation:
    """Distances of set-points from the path of `moves`, whose lines ascend, by `watched`.

    path: greatest distance of a set-point from the moves about it, less the largest P (or Q) of
    these; corner: greatest distance from an end of a move to the path run, less the P there. Both
    in m, at most 0 if P is met; -inf where G64 without P allows any.
    """

    ABOUT = (-1, 0, 1, 2)  # checked moves, relative to the move of a set-point

    def __init__(self, moves: Sequence[Move]) -> None:
        if any(first.line >= second.line for first, second in pairwise(moves)):
            raise ValueError("the lines of the moves do not ascend: one block, one move")
        moves = [move for move in moves if move.start != move.end or move.motion.is_arc]
        self._lines = np.array([move.line for move in moves])
        self._start = np.array([to_si(move.start) for move in moves]) * SCALE
        self._end = np.array([to_si(move.end) for move in moves]) * SCALE
        curves = {k: curve_of(move) for k, move in enumerate(moves) if move.motion.is_arc}
        self._arcs = {k: curve for k, curve in curves.items() if isinstance(curve, Arc)}
        tolerance = np.array([move.tolerance for move in moves]) / 1e3
        self._allowed = np.maximum(tolerance, [move.merge / 1e3 for move in moves])
        self._corner = np.minimum(tolerance[:-1], tolerance[1:])
        self._nearest = np.full(len(self._corner), np.inf)
        self._before = np.zeros((0, 5)), np.zeros(0, dtype=np.int64)
        self.path = -np.inf

    def watched(self, stream: Iterable[Setpoints]) -> Iterator[Setpoints]:
        """Pass the stream on unchanged, and examine it."""
        for points in stream:
            self._see(points.position * SCALE, points.line)
            yield points

    @property
    def corner(self) -> float:
        """See the class; complete once the stream is."""
        return float((self._nearest - self._corner).max(initial=-np.inf))

    @property
    def corner_line(self) -> int:
        """Line of the move that ends at the worst corner."""
        return int(self._lines[(self._nearest - self._corner).argmax()])

    def _see(self, q: FloatArray, lines: NDArray[np.int64]) -> None:
        own = np.minimum(np.searchsorted(self._lines, lines), len(self._lines) - 1)
        about = np.clip(own[:, None] + self.ABOUT, 0, len(self._lines) - 1)
        distance = self._from_move(q, own)
        rows = np.flatnonzero(distance > ROUNDING)  # on a blend
        for moves in about[rows].T:
            distance[rows] = np.minimum(distance[rows], self._from_move(q[rows], moves))
        over = distance - self._allowed[about].max(axis=1)
        worst = int(over.argmax())
        if not over[worst] <= self.path:
            self.path = float(over[worst])
        # Corners, from the straight lines between neighbouring set-points. The path run bends away
        # from such a line towards the corner, by an eighth of the acceleration times the period
        # squared: of the second differences about it, and what they change by in a period.
        before, before_own = self._before
        q, own = np.concatenate([before, q]), np.concatenate([before_own, own])
        self._before = q[-4:], own[-4:]
        second = np.diff(q, 2, axis=0)
        change = np.linalg.norm(np.diff(second, axis=0, prepend=second[:1]), axis=1)
        bend = (np.linalg.norm(second, axis=1) + change) / 8
        # Corners from the start of the move of the first point to the end of the move after that
        # of the second: short moves between or after them may have no set-point.
        counts = own[1:] - own[:-1] + 3
        rows = np.repeat(np.arange(len(counts)), counts)
        corner = (
            own[rows] - 1 + np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
        )
        there = (corner >= 0) & (corner < len(self._nearest))
        rows, corner = rows[there], corner[there]
        off = from_line(self._end[corner], q[rows], q[rows + 1])
        if len(bend):
            off -= np.maximum(
                bend[np.clip(rows - 1, 0, len(bend) - 1)],
                bend[np.clip(rows, 0, len(bend) - 1)],
            )
        np.minimum.at(self._nearest, corner, off)

    def _from_move(self, q: FloatArray, moves: NDArray[np.int64]) -> FloatArray:
        distance = from_line(q, self._start[moves], self._end[moves])
        for k in self._arcs.keys() & set(moves.tolist()):
            rows = np.flatnonzero(moves == k)
            distance[rows] = _from_arc(q[rows], self._arcs[k])
        return distance


def from_line(q: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Distances of points from the lines from start to end, (..., d) each or one for all."""
    way = end - start
    square = np.sum(way * way, axis=-1)
    along = np.sum((q - start) * way, axis=-1) / np.where(square > 0.0, square, 1.0)
    return np.linalg.norm(q - start - np.clip(along, 0.0, 1.0)[..., None] * way, axis=-1)


def _from_arc(q: FloatArray, curve: Arc) -> FloatArray:
    """Distances (n,) of points (n, 5) from an arc: the nearest of many places, then Newton.

    In both halves, because a full circle has two places for the points about its start.
    """
    count = 16 * math.ceil(abs(curve.sweep) / (2 * math.pi))
    places = np.linspace(0.0, curve.length, 2 * count + 1)
    points = curve.evaluate(places)[0] * SCALE
    away = np.linalg.norm(q[:, None] - points, axis=2)
    found = []
    for half in (slice(0, count + 1), slice(count, 2 * count + 1)):
        s = places[half][away[:, half].argmin(axis=1)]
        for _ in range(5):
            point, first, second = (value * SCALE for value in curve.evaluate(s))
            off = point - q
            slope = np.sum(first * first, axis=1) + np.sum(off * second, axis=1)
            s -= np.sum(off * first, axis=1) / np.maximum(slope, 1e-9)
            s = np.clip(s, 0.0, curve.length)
        found.append(np.linalg.norm(curve.evaluate(s)[0] * SCALE - q, axis=1))
    return np.minimum(*found)
