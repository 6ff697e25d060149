# SPDX-License-Identifier: Apache-2.0
"""Geometry of the moves of a program: curves in the five coordinates (x, y, z, alpha, gamma).

SI units: m and rad. A curve is parametrised by its own length: metres of tool path, and the table
axes follow in proportion; a move that turns only the table has no tool path and is measured in rad,
the root of the squares of both angles (NISTIR 6556, 2.1.2.5).

Speed along a curve: the programmed feed, or the rapid rate for G0, lowered where needed so that no
table axis turns faster than its own limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.path.moves import Motion, Move, Pose, Program

FloatArray = NDArray[np.float64]

# LinuxCNC's CIRCLE_FUZZ: an arc that turns less is a full turn.
FULL_TURN_BELOW = 1e-6
# m; a shorter arc, as cutter compensation leaves of a hole of the tool's size, is none.
POINT = 1e-12


class Curve(Protocol):
    """Curve of `length` with its five coordinates as functions of the length run so far."""

    length: float

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

    The end programmed may miss the circle by the tolerance of the reader; that rest is spread
    evenly over the arc, so the arc ends where it was told to.
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
    start, end = to_si(move.start), to_si(move.end)
    first, second = axes = move.plane.axes
    centre = move.centre[0] / 1e3, move.centre[1] / 1e3
    radius = math.hypot(start[first] - centre[0], start[second] - centre[1])
    begin = math.atan2(start[second] - centre[1], start[first] - centre[0])
    finish = math.atan2(end[second] - centre[1], end[first] - centre[0])
    turn = finish - begin if move.motion is Motion.ARC_CCW else begin - finish
    sweep = turn % (2 * math.pi)
    if sweep < FULL_TURN_BELOW:
        sweep += 2 * math.pi
    if move.motion is Motion.ARC_CW:
        sweep = -sweep
    rise = end[3 - first - second] - start[3 - first - second]
    length = math.hypot(radius * sweep, rise)
    return Arc(start, end, axes, centre, radius, begin, sweep, length)


def curve_of(move: Move) -> Curve | None:
    """Curve of a move, None if the move stays where it is."""
    if move.motion.is_arc:
        arc = _arc(move)
        return arc if arc.length > POINT else None
    start, end = to_si(move.start), to_si(move.end)
    way = end - start
    length = math.hypot(*way[3:] if move.turns_only_the_table else way[:3])
    return Line(start, end, length) if length > 0.0 else None


def feed_of(move: Move, rapid: float = math.inf) -> float:
    """Speed that a move asks for: m/s of the tool, rad/s where only the table turns.

    rapid: of the tool under G0 [m/s]; the table then turns as fast as its limit lets it.
    """
    if move.motion is Motion.RAPID:
        return math.inf if move.turns_only_the_table else rapid
    return math.radians(move.feed) / 60 if move.turns_only_the_table else move.feed / 60e3


def _speed(move: Move, curve: Curve, rates: RateLimits) -> float:
    speed = feed_of(move, rates.rapid)
    start, end = to_si(move.start), to_si(move.end)
    turn = max(abs(end[3:] - start[3:]))
    return min(speed, rates.table * curve.length / turn) if turn > 0.0 else speed


def build_path(program: Program, rates: RateLimits | None = None) -> tuple[Block, ...]:
    """Curves and speeds of all moves of a program that go anywhere, in order."""
    rates = rates or RateLimits()
    curves = ((move, curve_of(move)) for move in program.moves)
    return tuple(Block(move, curve, _speed(move, curve, rates)) for move, curve in curves if curve)
