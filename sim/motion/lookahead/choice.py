# SPDX-License-Identifier: Apache-2.0
"""The fastest way past each corner: a stop, a turn (sim/motion/geometry/turn.py) or a blend.

A blend of small P is slow, because of the limit of the jerk, and may take longer than a stop. The
times compared are those of half a line before and half a line after the corner. So a choice depends
on its two moves only, not on how many are known.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.motion.geometry.blend import SCALE
from sim.motion.geometry.curves import FloatArray
from sim.motion.geometry.turn import Turn
from sim.motion.lookahead.elements import Element, kind_of, pieces_of
from sim.motion.lookahead.limits import MARGIN, speeds
from sim.motion.lookahead.segment import Segment
from sim.motion.lookahead.settings import LookaheadSettings
from sim.robot.kinematics import inverse_velocity

LONGEST_CELL = 0.02  # cell of a line [m]; the directions to the legs change by some 3 %
Line = tuple[FloatArray, FloatArray, FloatArray]
"""Lengths, greatest speeds and accelerations (n,) of lines next to corners."""
Limits = tuple[float, float]
# Weight of the time with stops at the next corners, where it is against the blend. Greater and
# smaller weights are slower on the paths of paths.py.
WEIGHT = 2.0
# Share of the greatest acceleration of a turn, because the limits change along the lines.
CAUTION = 0.99


def end_limits(
    segments: Sequence[Segment], at_end: bool, settings: LookaheadSettings
) -> tuple[FloatArray, FloatArray]:
    """Speed and acceleration (n,) of the last, or first, cells of the segments."""
    speed, acceleration = np.zeros(len(segments)), np.zeros(len(segments))
    for kind in ("line", "arc", "run"):
        rows = [n for n, each in enumerate(segments) if kind_of(each) == kind]
        if not rows:
            continue
        parts = []
        for n in rows:
            segment = segments[n]
            length = min(segment.length, LONGEST_CELL, segment.cell)
            begin = segment.length - length if at_end else 0.0
            element = Element(length, segment.line, segment.move, segment, begin)
            parts.append((element, begin, begin + length))
        speed[rows], acceleration[rows] = speeds(pieces_of(parts), settings.limits, settings.robot)
    return speed, acceleration


def run_time(
    length: FloatArray, end: FloatArray, speed: FloatArray, acceleration: FloatArray, window: float
) -> FloatArray:
    """Time (n,) of lines with the speed `end` at both ends, of at most a speed.

    Between a rise and a fall the speed is constant for a window. A negative length is one that the
    ends take twice.
    """
    end = np.minimum(end, speed)
    half = acceleration * window / 2
    peak = np.sqrt(half**2 + acceleration * np.maximum(length, 0.0) + end**2) - half
    peak = np.minimum(np.maximum(peak, end), speed)
    rise = (peak**2 - end**2) / acceleration
    return 2 * (peak - end) / acceleration + (length - rise) / peak


def blend_gains(
    arc: FloatArray,
    speed: FloatArray,
    distance: FloatArray,
    lines: tuple[Line, Line],
    window: float,
) -> FloatArray:
    """Time (n,) of blends of a length and speed, less that of stops [s].

    distance: from the corner to their ends. Two times count: `single`, with stops at the next
    corners, and `chained`, with blends there too. A blend that gains as a single one is taken.
    """
    chained, single = arc / speed, arc / speed
    for length, greatest, acceleration in lines:
        zero = np.zeros(len(length))
        stops = run_time(length, zero, greatest, acceleration, window) / 2
        left = length - 2 * distance - speed * window
        chained = chained + run_time(left, speed, greatest, acceleration, window) / 2 - stops
        gain, half = speed / acceleration, acceleration * window / 2
        peak = np.sqrt(half**2 + acceleration * length) - half
        price = np.where(peak < greatest, 1.0 / (peak + half), 1.0 / greatest)  # s of a metre more
        saved = distance + speed * window / 2 - speed * gain / 2
        single = single - gain - saved * np.minimum(price, 1.0 / speed)
    return np.where(single < 0.0, single, chained + WEIGHT * single)


def turn_gain(acceleration: float, lines: tuple[Limits, Limits], window: float) -> float:
    """Time of a turn with an acceleration, less that of a stop [s]; lines: their limits."""
    total = -window
    for speed, of_line in lines:
        lost = 1.0 - acceleration / of_line
        total += lost * window * (1.0 - acceleration * window / 2 / speed)
    return total


def turn(
    first: Segment,
    second: Segment,
    ends: tuple[Limits, Limits],
    within: float,
    settings: LookaheadSettings,
) -> tuple[Turn, float] | None:
    """The turn between two lines and its acceleration, None where it does not fit.

    ends: greatest speed and acceleration of both next to the corner. The motion about a turn is
    only that of a turn if nothing else limits it there, so the lines must be long enough.
    """
    limits, robot, window = settings.limits, settings.robot, settings.limits.window
    if window <= 0.0 or first.curve is not None or second.curve is not None:
        return None
    for segment, (greatest, _) in zip((first, second), ends, strict=True):
        if segment.length / 2 < greatest * window:
            return None
    both = (first.direction + second.direction) / SCALE
    most = CAUTION * min(rate for _, rate in ends)
    legs = inverse_velocity(robot, (first.end / SCALE)[None, :3], both[None, :3])[0]
    for size, jerk in (
        (float(np.linalg.norm(both[:3])), limits.tool.jerk),
        (float(np.abs(legs).max()), limits.leg.jerk),
        (float(np.abs(both[3:]).max()), limits.table.jerk),
    ):
        if size * most / window > CAUTION * MARGIN * jerk:
            most = CAUTION * MARGIN * jerk * window / size
    if min(speed for speed, _ in ends) < most * window:
        return None
    for segment, (greatest, _) in zip((first, second), ends, strict=True):
        if segment.length / 2 < (3 * most * window + greatest) * window:
            return None
    found = Turn(first.end, first.direction, second.direction, float(most) * window**2 / 6)
    beside = most * window / 4 * settings.period  # half the way of a period at the apex, at most
    if np.hypot(found.apex, beside) > within:
        return None
    return found, float(most)
