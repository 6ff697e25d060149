# SPDX-License-Identifier: Apache-2.0
"""Geometry of the moves of a program: curves in the five coordinates (x, y, z, alpha, gamma).

SI units: m and rad. A curve is parametrised by its own length: metres of tool path, and the table
axes follow in proportion; a move that turns only the table has no tool path and is measured in rad,
the root of the squares of both angles (NISTIR 6556, 2.1.2.5).

Speed along a curve: the programmed feed, or the rapid rate for G0, lowered where needed so that no
table axis turns faster than its own limit.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.moves import GcodeProgram, Motion, Move, Pose
from sim.motion.geometry.rotation import Rotation

FloatArray = NDArray[np.float64]

# LinuxCNC's CIRCLE_FUZZ: an arc that turns less is a full turn.
FULL_TURN_BELOW = 1e-6
# m; greatest difference of the radii at both ends with which an arc is no spiral.
MISSES = 5e-6
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_PLACES, _WEIGHTS = (_PLACES + 1) / 2, _WEIGHTS / 2
# m; a shorter arc, as cutter compensation leaves of a hole of the tool's size, is none.
POINT = 1e-12


class Curve(Protocol):
    """Curve of `length` with its five coordinates as functions of the length run so far."""

    @property
    def length(self) -> float: ...

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Point, first and second derivative by s, each (n, 5), for s (n,) in 0..length."""
        ...


def check_positive(error: type[ValueError] = ValueError, **values: float) -> None:
    """Raises the error with name and value for one that is not positive or not finite."""
    for name, value in values.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise error(f"{name} = {value!r} is outside its limit: {name} > 0")


def _between(start: FloatArray, end: FloatArray, share: FloatArray) -> FloatArray:
    """Straight connection (n, 5), exact at both ends and where start equals end."""
    part, way = share[:, np.newaxis], end - start
    return np.where(part < 0.5, start + way * part, end - way * (1.0 - part))


@dataclass(frozen=True, eq=False)
class Line:
    """Straight line from start to end (5,), of tool path if it has any, else of the table."""

    start: FloatArray
    end: FloatArray
    length: float

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        point = _between(self.start, self.end, s / self.length)
        direction = np.broadcast_to((self.end - self.start) / self.length, point.shape)
        return point, direction, np.zeros_like(point)


@dataclass(frozen=True, eq=False)
class Arc:
    """Circular arc or helix from start to end (5,): sweep [rad] > 0 turns axes[0] to axes[1].

    The end programmed may miss the circle by MISSES at most; that rest is spread evenly over the
    arc, so the arc ends at the stated point.
    """

    start: FloatArray
    end: FloatArray
    axes: tuple[int, int]
    centre: tuple[float, float]
    radius: float
    first_angle: float
    sweep: float
    length: float

    def _circle(self, share: FloatArray) -> tuple[FloatArray, FloatArray]:
        angle = self.first_angle + self.sweep * share
        return np.cos(angle), np.sin(angle)

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        share = s / self.length
        cos, sin = self._circle(share)
        point = _between(self.start, self.end, share)
        direction = np.tile((self.end - self.start) / self.length, (len(s), 1))
        bend = np.zeros_like(point)
        end_cos, end_sin = self._circle(np.array([0.0, 1.0]))
        rate = self.sweep / self.length
        for axis, centre, value, ends, slope in (
            (self.axes[0], self.centre[0], cos, end_cos, -sin),
            (self.axes[1], self.centre[1], sin, end_sin, cos),
        ):
            ideal = centre + self.radius * ends
            rest = self.start[axis] - ideal[0], self.end[axis] - ideal[1]
            point[:, axis] = (
                centre + self.radius * value + rest[0] * (1.0 - share) + rest[1] * share
            )
            direction[:, axis] = self.radius * rate * slope + (rest[1] - rest[0]) / self.length
            bend[:, axis] = -self.radius * rate**2 * value
        return point, direction, bend

    def third(self, s: FloatArray) -> FloatArray:
        """Third derivative by s (n, 5): the circular part of the first, turned twice."""
        first = self.evaluate(s)[1]
        others = [n for n in range(5) if n not in self.axes]
        first[:, others] = 0.0
        return -((self.sweep / self.length) ** 2) * first


@dataclass(frozen=True, eq=False)
class Spiral(Arc):
    """Arc whose radius grows evenly with its angle, by `growth` in all, as LinuxCNC runs an arc

    whose ends are not equally far from its centre. The other axes follow the angle.
    """

    growth: float = 0.0

    def _rate(self, u: FloatArray) -> FloatArray:
        """Length per share u of the angle."""
        c = self.growth**2 + (self.end - self.start)[3 - sum(self.axes)] ** 2
        return np.sqrt((self.sweep * (self.radius + self.growth * u)) ** 2 + c)

    def whole(self) -> float:
        """Length of the curve; Gauss's rule is exact to rounding, because the rate bends little."""
        return float(self._rate(_PLACES) @ _WEIGHTS)

    def _derivatives(self, s: FloatArray) -> tuple[FloatArray, list[FloatArray], list[FloatArray]]:
        """Shares u at the lengths s, derivatives of u by s and of the point by u, up to third."""
        u = s / self.length
        for _ in range(4):
            run = self._rate(u[:, None] * _PLACES) @ _WEIGHTS * u
            u = np.clip(u - (run - s) / self._rate(u), 0.0, 1.0)
        f, g, w = self._rate(u), self.growth, self.sweep
        radius = self.radius + g * u
        bent = w * w * radius * g
        by_length = [1 / f, -bent / f**4, ((2 * bent / f**3) ** 2 - (w * g / f**2) ** 2) / f]
        cos, sin = self._circle(u)
        points = [np.zeros((len(s), 5)) for _ in range(4)]
        points[0], points[1] = _between(self.start, self.end, u), points[1] + self.end - self.start
        for axis, centre, out, along in (
            (self.axes[0], self.centre[0], cos, -sin),
            (self.axes[1], self.centre[1], sin, cos),
        ):
            points[0][:, axis] = centre + radius * out
            points[1][:, axis] = g * out + radius * w * along
            points[2][:, axis] = 2 * g * w * along - radius * w * w * out
            points[3][:, axis] = -3 * g * w * w * out - radius * w**3 * along
        ends = np.where(u[:, None] < 0.5, self.start, self.end)
        points[0] = np.where((u[:, None] == 0.0) | (u[:, None] == 1.0), ends, points[0])
        return u, [value[:, None] for value in by_length], points

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        _, (u1, u2, _), (point, p1, p2, _) = self._derivatives(s)
        return point, p1 * u1, p2 * u1**2 + p1 * u2

    def third(self, s: FloatArray) -> FloatArray:
        _, (u1, u2, u3), (_, p1, p2, p3) = self._derivatives(s)
        return p3 * u1**3 + 3 * p2 * u1 * u2 + p1 * u3


@dataclass(frozen=True, eq=False)
class TurnedArc(Arc):
    """Arc or spiral whose plane is turned about Z, by `turn`.

    `flat` is the curve before that turn, and so are all fields of it that are here too.
    """

    flat: Arc
    turn: Rotation

    def evaluate(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        point, first, second = map(self.turn.turned_rows, self.flat.evaluate(s))
        return point, first, second

    def third(self, s: FloatArray) -> FloatArray:
        return self.turn.turned_rows(self.flat.third(s))


@dataclass(frozen=True)
class RateLimits:
    """Rates of the machine: rapid tool path [m/s], each table axis [rad/s]; both positive."""

    rapid: float = 0.04
    table: float = math.pi / 2

    def __post_init__(self) -> None:
        check_positive(rapid=self.rapid, table=self.table)


@dataclass(frozen=True, eq=False)
class Block:
    """One move with its curve and speed limit, m/s of tool path or rad/s for table-only moves."""

    move: Move
    curve: Curve
    speed: float

    @property
    def measures_tool_path(self) -> bool:
        return not self.move.turns_only_the_table


def to_si(pose: Pose) -> FloatArray:
    """Pose [mm, degree] as (5,) array [m, rad]."""
    x, y, z, tilt, rotation = pose
    return np.array([x / 1e3, y / 1e3, z / 1e3, math.radians(tilt), math.radians(rotation)])


def _arc(move: Move) -> Arc:
    if move.plane_turn:
        plane = Rotation(move.plane_turn)
        ends = plane.turned_back(move.start), plane.turned_back(move.end)
        flat = _arc(replace(move, plane_turn=0.0, start=ends[0], end=ends[1]))
        same = {field.name: getattr(flat, field.name) for field in dataclasses.fields(Arc)}
        return TurnedArc(**same, flat=flat, turn=plane)
    start, end = to_si(move.start), to_si(move.end)
    axes, (across, up) = move.circle
    first, second = axes
    centre = across / 1e3, up / 1e3
    radius = math.hypot(start[first] - centre[0], start[second] - centre[1])
    begin = math.atan2(start[second] - centre[1], start[first] - centre[0])
    finish = math.atan2(end[second] - centre[1], end[first] - centre[0])
    turn = finish - begin if move.motion is Motion.ARC_CCW else begin - finish
    sweep = turn % (2 * math.pi)
    if sweep < FULL_TURN_BELOW:
        sweep += 2 * math.pi
    sweep += 2 * math.pi * (move.turns - 1)
    if move.motion is Motion.ARC_CW:
        sweep = -sweep
    rise = end[3 - first - second] - start[3 - first - second]
    length = math.hypot(radius * sweep, rise)
    arc = Arc(start, end, axes, centre, radius, begin, sweep, length)
    growth = math.hypot(end[first] - centre[0], end[second] - centre[1]) - radius
    if abs(growth) <= MISSES:
        return arc
    spiral = Spiral(**vars(arc), growth=growth)
    return replace(spiral, length=spiral.whole())


def curve_of(move: Move) -> Line | Arc | None:
    """Curve of a move, None if the move stays where it is."""
    if move.motion.is_arc:
        arc = _arc(move)
        return arc if arc.length > POINT else None
    start, end = to_si(move.start), to_si(move.end)
    way = end - start
    length = math.hypot(*way[3:] if move.turns_only_the_table else way[:3])
    return Line(start, end, length) if length > 0.0 else None


def feed_of(move: Move, rapid: float = math.inf) -> float:
    """Requested speed of a move: m/s of the tool, rad/s where only the table turns.

    rapid: of the tool under G0 [m/s]; the table then turns as fast as its limit lets it.
    """
    if move.motion is Motion.RAPID:
        return math.inf if move.turns_only_the_table else rapid
    return math.radians(move.rate) / 60 if move.turns_only_the_table else move.rate / 60e3


def _speed(move: Move, curve: Curve, rates: RateLimits) -> float:
    speed = feed_of(move, rates.rapid)
    start, end = to_si(move.start), to_si(move.end)
    turn = max(abs(end[3:] - start[3:]))
    return min(speed, rates.table * curve.length / turn) if turn > 0.0 else speed


def blocks_of(moves: Iterable[Move], rates: RateLimits) -> Iterator[Block]:
    """Curves and speeds of the moves that go anywhere, in order."""
    curves = ((move, curve_of(move)) for move in moves)
    return (Block(move, curve, _speed(move, curve, rates)) for move, curve in curves if curve)


def build_path(program: GcodeProgram, rates: RateLimits | None = None) -> tuple[Block, ...]:
    """As `blocks_of`, of a whole program."""
    return tuple(blocks_of(program.moves, rates or RateLimits()))
