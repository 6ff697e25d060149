# SPDX-License-Identifier: Apache-2.0
"""Greatest speed and acceleration along a piece of path that keep the limits of tool and joints.

With q(s) the path and s(t) the motion along it, a coordinate x (a tool axis, a leg, a table axis)
has the derivatives

  x' v,   x'' v^2 + x' a,   x''' v^3 + 3 x'' v a + x' j      (v, a, j: those of s; ' = d/ds)

The legs follow from l^2 = |r|^2, r from the leg's base to the tool (sim/robot/kinematics.py):
l l' = r.q',  l'^2 + l l'' = q'.q' + r.q'',  3 l' l'' + l l''' = 3 q'.q'' + r.q'''.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.blend import TABLE_RADIUS
from sim.motion.geometry.curves import FloatArray
from sim.motion.planner.optimal import Limits
from sim.robot.kinematics import inverse, inverse_acceleration, inverse_velocity
from sim.robot.parameters import Robot

# Limits used for planning, relative to those given: what the points examined may have missed.
MARGIN = 0.998
# Share of the acceleration reserved for the speed along the path, by the angle of a blend [rad].
SHARE_ANGLES = np.radians([0.0, 20.0, 80.0, 180.0])
SHARES = np.array([0.3, 0.3, 0.01, 0.01])
# Of the greatest speed: such a change of speed is fastest if its jerk phases just meet.
SLOW_SHARE = 0.02
LEAST, GREATEST = 1e-6, 1e12  # range of a limit
SHORTEST_WINDOW, LONGEST_WINDOW = 1e-6, 100.0  # s
PARTS = 16  # parts of a blend, each with its own bounds
_BISECTIONS = 16


@dataclass(frozen=True)
class MachineLimits:
    """Limits of tool [m], each leg [m] and each table axis [rad]: speed, acceleration, jerk.

    Those of the tool are limits of its vectors. They are never exceeded; what a program asks beyond
    is run slower. With jerk_limited False the acceleration steps and the jerk limits do not count.
    """

    tool: Limits
    leg: Limits
    table: Limits
    jerk_limited: bool = True

    @classmethod
    def of(cls, robot: Robot, jerk_limited: bool = True) -> MachineLimits:
        """The limits among a robot's parameters."""
        return cls(
            Limits(robot.v_max_tool, robot.a_max_tool, robot.j_max_tool),
            Limits(robot.v_max_leg, robot.a_max_leg, robot.j_max_leg),
            Limits(robot.v_max_table, robot.a_max_table, robot.j_max_table),
            jerk_limited,
        )

    def __post_init__(self) -> None:
        for group in ("tool", "leg", "table"):
            for name, value in vars(getattr(self, group)).items():
                if not LEAST <= value <= GREATEST:
                    raise ValueError(
                        f"limit of {name} of the {group} = {value!r} is outside its limit: "
                        f"{LEAST:g} to {GREATEST:g} (m or rad, s)"
                    )
        if self.jerk_limited and not SHORTEST_WINDOW <= self.window <= LONGEST_WINDOW:
            raise ValueError(
                f"acceleration / jerk = {self.window!r} s is outside its limit: "
                f"{SHORTEST_WINDOW:g} to {LONGEST_WINDOW:g} s; expected jerks by which it rises in "
                "that time, or no limit of jerk (--steps)"
            )

    @property
    def window(self) -> float:
        """Duration T of a change of the acceleration from 0 to its limit [s].

        The tool's acceleration / jerk. A coordinate of lower jerk J gets the acceleration J T only,
        so T is not shorter than its acceleration / jerk, or than SLOW_SHARE of its speed needs.
        """
        if not self.jerk_limited:
            return 0.0
        others = (
            min(x.acceleration / x.jerk, math.sqrt(SLOW_SHARE * x.speed / x.jerk))
            for x in (self.leg, self.table)
        )
        return max(self.tool.acceleration / self.tool.jerk, *others)


@dataclass(frozen=True, eq=False)
class Pieces:
    """n pieces of path examined at k points each: q and its derivatives by the length, (n, k, 5).

    Path space (table axes times TABLE_RADIUS). feed (n,): greatest requested speed [m/s]; share
    (n,): of the acceleration along the path, reserved at the greatest speed; tool_feed (n,): as
    feed, of the tool.
    """

    q: FloatArray
    d1: FloatArray
    d2: FloatArray
    d3: FloatArray
    feed: FloatArray
    share: FloatArray
    tool_feed: FloatArray | float = math.inf


def _greatest(values: FloatArray) -> FloatArray:
    """Bounds (n, b) of |f| in b parts of each piece, from equally spaced values (n, k).

    Between two values f exceeds the straight line by at most h^2/8 max|f''|, here from differences.
    """
    bow = np.abs(np.diff(values, 2, axis=1)) / 8
    size = np.abs(values)
    size[:, 1:-1] += bow
    size[:, 0] += bow[:, 0]
    size[:, -1] += bow[:, -1]
    count = values.shape[1] - 1
    step = count // PARTS if count >= PARTS else count
    top = np.maximum.reduceat(size[:, :-1], range(0, count, step), axis=1)
    return np.maximum(top, size[:, step::step])


@dataclass(frozen=True, eq=False)
class _Channel:
    """Bounds (n, b) of one coordinate: |x'|, and along it and across |x''| and |x'''|."""

    first: FloatArray
    second: tuple[FloatArray, FloatArray]
    third: tuple[FloatArray, FloatArray]
    limits: Limits


def _channels(pieces: Pieces, limits: MachineLimits, robot: Robot) -> list[_Channel]:
    tool1, tool2, tool3 = (d[..., :3] for d in (pieces.d1, pieces.d2, pieces.d3))
    first = np.linalg.norm(tool1, axis=2)
    along = tool1 / np.maximum(first, 1e-12)[..., None]
    a2, a3 = (np.sum(d * along, axis=2) for d in (tool2, tool3))
    n2, n3 = (
        np.linalg.norm(d - a[..., None] * along, axis=2) for d, a in ((tool2, a2), (tool3, a3))
    )
    channels = [
        _Channel(
            _greatest(first),
            (_greatest(a2), _greatest(n2)),
            (_greatest(a3), _greatest(n3)),
            limits.tool,
        )
    ]
    zero = np.zeros_like(channels[0].first)
    dot12 = np.sum(tool1 * tool2, axis=2)
    place = pieces.q[..., :3]
    l0 = inverse(robot, place)
    l1 = inverse_velocity(robot, place, tool1)
    l2 = inverse_acceleration(robot, place, tool1, tool2)
    for leg, (x, y) in enumerate(robot.legs):
        toward = np.sum((place - (x, y, 0.0)) * tool3, axis=2)
        x1, x2 = l1[..., leg], l2[..., leg]
        x3 = (3 * dot12 + toward - 3 * x1 * x2) / l0[..., leg]
        x1, x2, x3 = map(_greatest, (x1, x2, x3))
        channels.append(_Channel(x1, (x2, zero), (x3, zero), limits.leg))
    for axis in (3, 4):
        x1, x2, x3 = (
            _greatest(d[..., axis]) / TABLE_RADIUS for d in (pieces.d1, pieces.d2, pieces.d3)
        )
        channels.append(_Channel(x1, (x2, zero), (x3, zero), limits.table))
    return channels


def _kept(channel: _Channel, c: FloatArray, a: FloatArray, window: float) -> NDArray[np.bool_]:
    """Whether acceleration and jerk of a channel are in their limits at speeds c, +-a along."""
    (a2, n2), (a3, n3) = channel.second, channel.third
    c, a = c[:, None], a[:, None]
    square = c * c
    limit = MARGIN * channel.limits.acceleration
    kept = (a2 * square + channel.first * a) ** 2 + (n2 * square) ** 2 <= limit**2
    if window > 0.0:
        cube, twist = square * c, 3 * c * a
        along = a3 * cube + a2 * twist + channel.first * a / window
        kept &= along**2 + (n3 * cube + n2 * twist) ** 2 <= (MARGIN * channel.limits.jerk) ** 2
    return np.asarray(kept.all(axis=1))


def speeds(pieces: Pieces, limits: MachineLimits, robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Greatest speed (n,) [m/s] and acceleration along the path (n,) [m/s2] of every piece.

    Both positive: with `share` s the speed is the greatest that leaves s of the acceleration that a
    slow motion has; where the feed lowers the speed, more acceleration is left.
    """
    channels = _channels(pieces, limits, robot)
    window = limits.window
    way = np.maximum(channels[0].first.max(axis=1), 1e-12)  # of the tool
    fastest = np.minimum(pieces.feed, pieces.tool_feed / way)
    strongest = np.full_like(fastest, np.inf)
    for channel in channels:
        first = np.maximum(channel.first.max(axis=1), 1e-12)
        fastest = np.minimum(fastest, MARGIN * channel.limits.speed / first)
        strongest = np.minimum(strongest, MARGIN * channel.limits.acceleration / first)
        if window > 0.0:
            strongest = np.minimum(strongest, MARGIN * channel.limits.jerk * window / first)

    def kept(c: FloatArray, a: FloatArray) -> NDArray[np.bool_]:
        result = np.ones(len(c), dtype=bool)
        for channel in channels:
            result &= _kept(channel, c, a, window)
        return result

    for channel in channels:
        # Necessary at any acceleration; a good start for the search.
        (a2, n2), (a3, n3) = channel.second, channel.third
        bend = np.maximum(np.hypot(a2, n2).max(axis=1), 1e-12)
        fastest = np.minimum(fastest, np.sqrt(MARGIN * channel.limits.acceleration / bend))
        if window > 0.0:
            twist = np.maximum(np.hypot(a3, n3).max(axis=1), 1e-12)
            fastest = np.minimum(fastest, np.cbrt(MARGIN * channel.limits.jerk / twist))
    # Only those that may be exceeded at all are searched.
    channels = [x for x in channels if not _kept(x, fastest, strongest, window).all()]
    weakest = pieces.share * strongest
    c = _greatest_kept(lambda x: kept(x, weakest), fastest)
    for _ in range(8):  # while a speed is lower than the resolution of the search
        if c.all():
            break
        fastest = np.where(c > 0.0, c, fastest * 0.5**_BISECTIONS)
        c = _greatest_kept(lambda x: kept(x, weakest), fastest)
    a = weakest + _greatest_kept(lambda x: kept(c, weakest + x), strongest - weakest)
    return c, a


def _greatest_kept(kept: Callable[[FloatArray], NDArray[np.bool_]], most: FloatArray) -> FloatArray:
    """Greatest value in 0..most (n,) for which kept is true, to 2^-16 of most; kept(0) is."""
    at_most = kept(most)
    if at_most.all():
        return most
    low, step = np.zeros_like(most), most
    for _ in range(_BISECTIONS):
        step = step / 2
        low = np.where(kept(low + step), low + step, low)
    return np.where(at_most, most, low)
