# SPDX-License-Identifier: Apache-2.0
"""Time-optimal moves under limits of speed, acceleration and jerk, from any speed to any other.

Method. From (v0, a0) the end speed ve is reached soonest by one pulse of acceleration; this direct
transition covers the length d. A longer way is run by accelerating first, a shorter one by
decelerating first, which is the same mirrored. With acceleration first the jerk has the signs
+ 0 - (cruise) - 0 +, and one number is left, the peak speed:

- cruise at the limit, if the distance allows it: nothing to solve;
- both pulses reach the acceleration limit: quadratic equation of the peak speed;
- no pulse does: with x, y the jerk times of the pulses, u = x + y and D = x^2 - y^2 known,
  J/4 u^4 + (v0 + ve) u^2 - L u - J/4 D^2 = 0; for v0 = ve a cubic, solved by sinh;
- one does: quartic of the jerk time of the other.

The quartics are solved by Newton's method inside a bracket, because Ferrari's formula loses digits.
An initial acceleration is traced back (or forward) to the state with acceleration 0 on the same
jerk, so the same equations hold. Where it is negative and may not pass 0 (jerk + - 0 +), the
remaining number is the acceleration at which the jerk turns; its equation is solved by bisection
and secants.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from sim.motion.planner.phases import Profile, State, Step, run
from sim.motion.planner.scurve import SCurveError, require

# Ways that differ by less, relative to the length run there and back, are the same.
SAME_LENGTH = 1e-12
# Speeds that differ by less, relative to what they were computed from, are the same.
SAME_SPEED = 1e-14
# Part of a speed or acceleration limit that is rounding.
ROUNDING = 1e-12


@dataclass(frozen=True)
class Limits:
    """Greatest |speed| [unit/s], |acceleration| [unit/s2], |jerk| [unit/s3]; positive, finite."""

    speed: float
    acceleration: float
    jerk: float

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "jerk"):
            value = getattr(self, name)
            require(value > 0.0, f"limit of {name}", value, "> 0")


class TooShortError(SCurveError):
    """The distance is too short to change the speed; `needed` is enough [unit]."""

    def __init__(self, length: float, needed: float, v0: float, a0: float, ve: float) -> None:
        self.needed = needed
        super().__init__(
            f"length = {length!r} is too short to go from speed v0 = {v0!r} (acceleration "
            f"a0 = {a0!r}) to ve = {ve!r} within the limits: needs at least {needed!r}"
        )


def time_optimal(
    length: float,
    v0: float,
    ve: float,
    limits: Limits,
    a0: float = 0.0,
    *,
    reverse: bool = False,
) -> Profile:
    """Fastest profile from position 0, speed v0, acceleration a0 to length, speed ve at rest of a.

    A speed v0 above the limit (or an acceleration that will carry it there) is first brought down
    as fast as the other limits allow. Raises SCurveError for parameters outside the limits, and
    TooShortError where the distance could only be met by passing the end and coming back, unless
    `reverse` allows that; with it length and speeds may be of either sign.
    """
    for name, value in (("length", length), ("v0", v0), ("a0", a0)):
        require(True, name, value, "finite")
    require(
        abs(ve) <= limits.speed * (1 + ROUNDING), "ve", ve, f"|ve| <= limit of speed {limits.speed}"
    )
    am = limits.acceleration
    require(abs(a0) <= am * (1 + ROUNDING), "a0", a0, f"|a0| <= limit of acceleration {am!r}")
    if not reverse:
        require(length >= 0.0, "length", length, "length >= 0")
        require(v0 >= 0.0, "v0", v0, "v0 >= 0")
        require(ve >= 0.0, "ve", ve, "ve >= 0")
    a0 = min(max(a0, -am), am)
    start, end = State(0.0, v0, a0), State(length, ve, 0.0)
    direct = transition(v0, a0, ve, limits)
    way = _way(v0, a0, direct)
    if abs(length - way) <= SAME_LENGTH * (abs(length) + _path(v0, a0, direct)):
        return Profile(start, direct, end)
    if length > way:
        return Profile(start, _accelerating(length, v0, a0, ve, limits), end)
    if not reverse:
        raise TooShortError(length, way, v0, a0, ve)
    mirrored = _accelerating(-length, -v0, -a0, -ve, limits)
    return Profile(start, [Step(time, -jerk) for time, jerk in mirrored], end)


def transition(v0: float, a0: float, v1: float, limits: Limits) -> list[Step]:
    """Fastest change from speed v0, acceleration a0 (in its limit) to speed v1, acceleration 0.

    Jerk, constant acceleration, opposite jerk; the last alone where that suffices.
    """
    j, am = limits.jerk, limits.acceleration
    missing = v1 - (v0 + a0 * abs(a0) / (2 * j))
    if abs(missing) <= SAME_SPEED * (abs(v0) + a0 * a0 / j):
        # Bringing the acceleration to 0 is all: the root below would turn the rounding of the
        # speeds into a time, and a way, of the order of its square root.
        return [Step(abs(a0) / j, -math.copysign(j, a0))]
    sign = math.copysign(1.0, missing)
    rise, a = sign * (v1 - v0), sign * a0
    peak = math.sqrt(max(j * rise + a * a / 2, 0.0))
    peak = max(peak, a)  # rounding where no jerk in this direction is needed
    hold = 0.0
    if peak > am:
        peak = am
        hold = (rise - (am * am - a * a / 2) / j) / am
    return [Step((peak - a) / j, sign * j), Step(max(hold, 0.0), 0.0), Step(peak / j, -sign * j)]


def stopping_length(v0: float, a0: float, v1: float, limits: Limits) -> float:
    """Length of the fastest change from speed v0, acceleration a0 to speed v1 [unit]."""
    return _way(v0, a0, transition(v0, a0, v1, limits))


def _way(v0: float, a0: float, steps: list[Step]) -> float:
    return run(State(0.0, v0, a0), steps).position


def _path(v0: float, a0: float, steps: list[Step]) -> float:
    """Scale of the length run, for comparisons."""
    state, total = State(0.0, v0, a0), 0.0
    for step in steps:
        after = state.after(*step)
        total += step.duration * (abs(state.speed) + abs(after.speed))
        state = after
    return total


def _accelerating(length: float, v0: float, a0: float, ve: float, limits: Limits) -> list[Step]:
    """Steps with positive jerk first; the length exceeds that of the direct transition."""
    j, vm = limits.jerk, limits.speed
    coasting = v0 + a0 * abs(a0) / (2 * j)  # speed once the acceleration is brought to 0
    if coasting > vm:
        return _braking(length, v0, a0, ve, limits)
    if a0 < 0.0 and ve < coasting:
        steps = _turning(length, v0, a0, ve, limits)
        if steps is not None:
            return steps
    to_limit = transition(v0, a0, vm, limits)
    from_limit = transition(vm, 0.0, ve, limits)
    rest = length - _way(v0, a0, to_limit) - _way(vm, 0.0, from_limit)
    if rest >= 0.0:
        return [*to_limit, Step(rest / vm, 0.0), *from_limit]
    return _peak(length, v0, a0, ve, limits)


def _braking(length: float, v0: float, a0: float, ve: float, limits: Limits) -> list[Step]:
    """The speed exceeds its limit: brought down as fast as possible, before anything else."""
    vm = limits.speed
    brake = transition(v0, a0, vm, limits)
    down = brake[:-1]
    state = run(State(0.0, v0, a0), down)
    turning = _turning(length - state.position, state.speed, state.acceleration, ve, limits)
    if turning is not None:
        return [*down, *turning]
    after = transition(vm, 0.0, ve, limits)
    rest = length - _way(v0, a0, brake) - _way(vm, 0.0, after)
    return [*brake, Step(max(0.0, rest / vm), 0.0), *after]


def _turning(length: float, v0: float, a0: float, ve: float, limits: Limits) -> list[Step] | None:
    """a0 < 0 is raised to an acceleration below 0, then the speed falls to ve (jerk + - 0 +).

    None if the length is greater than what this covers.
    """
    j, am = limits.jerk, limits.acceleration

    def steps(turn: float) -> list[Step]:
        fall = v0 - ve + (turn * turn - a0 * a0 / 2) / j  # from the virtual start without a
        peak = math.sqrt(max(j * fall, turn * turn))
        hold = 0.0
        if peak > am:
            hold = max(0.0, (fall - am * am / j) / am)
            peak = am
        up, down = (turn - a0) / j, (peak + turn) / j
        return [Step(up, j), Step(max(down, 0.0), -j), Step(hold, 0.0), Step(peak / j, j)]

    def missing(turn: float) -> float:
        return _way(v0, a0, steps(turn)) - length

    # Where speeds below 0 shorten the path again, three solutions may exist; the first is soonest.
    first = a0
    for last in (*_longest_and_shortest(v0 - a0 * a0 / (2 * j), a0, ve, limits), 0.0):
        if missing(last) >= 0.0:
            return steps(_root(missing, first, last))
        first = last
    return None


def _longest_and_shortest(vb: float, a0: float, ve: float, limits: Limits) -> list[float]:
    """Turning accelerations in a0..0, rising, between which the distance is monotone.

    With p the peak of the deceleration, the derivative of the distance by the turning acceleration
    q has the sign of J vb + q^2 + q p / 2. vb is the speed when the acceleration has become 0; p is
    am, or p^2 = J (vb - ve) + q^2.
    """
    j, am = limits.jerk, limits.acceleration
    c, e = j * vb, j * (vb - ve)
    places = []
    discriminant = am * am / 4 - 4 * c
    if discriminant >= 0.0:
        root = math.sqrt(discriminant)
        places += [(-am / 2 - root) / 2, (-am / 2 + root) / 2]
    half = c - e / 8  # squared: 3/4 w^2 + 2 half w + c^2 = 0 for w = q^2
    discriminant = half * half - 0.75 * c * c
    if discriminant >= 0.0:
        root = math.sqrt(discriminant)
        places += [-math.sqrt(w) for w in ((-half + root) / 0.75, (-half - root) / 0.75) if w > 0]
    return sorted(place for place in places if a0 < place < 0.0)


def _peak(length: float, v0: float, a0: float, ve: float, limits: Limits) -> list[Step]:
    """No cruise, acceleration passes 0 at the peak speed (jerk + 0 - 0 +)."""
    j, am = limits.jerk, limits.acceleration
    # The state without acceleration on the same jerk, before or after the start.
    shift = -a0 / j
    at_rest = State(0.0, v0, a0).after(shift, j)
    way = length - at_rest.position
    vs = v0 - a0 * a0 / (2 * j)
    low, high = min(vs, ve), max(vs, ve)
    pulse = am * am / j  # speed won by a pulse that just reaches the limit
    least = max(v0 + a0 * abs(a0) / (2 * j), high)  # of the peak: nothing below can be a solution

    def covered(peak: float) -> float:
        return _half(low, peak - low, limits) + _half(high, peak - high, limits)

    if high + pulse <= least or way >= covered(high + pulse):
        peak = _quadratic(
            pulse, pulse * (low + high) / 2 - (low * low + high * high) / 2 - am * way
        )
        rises = peak - low, peak - high
        pulses = [(am, max(0.0, rise / am - am / j)) for rise in rises]
    elif low + pulse > least and way < covered(low + pulse):
        x, y = _short(way, low, high, least, limits)
        pulses = [(j * x, 0.0), (j * y, 0.0)]
    else:
        y = _mixed(way, low, high, least, limits)
        pulses = [(am, max(0.0, (high - low + j * y * y) / am - am / j)), (j * y, 0.0)]
    if vs > ve:
        pulses.reverse()
    (up, up_hold), (down, down_hold) = pulses
    # With a0 > 0 part of the first jerk phase has already been run.
    first = max(0.0, up / j + shift)
    return [
        Step(first, j),
        Step(up_hold, 0.0),
        Step(up / j, -j),
        Step(down / j, -j),
        Step(down_hold, 0.0),
        Step(down / j, j),
    ]


def _half(speed: float, rise: float, limits: Limits) -> float:
    """Length of a pulse from `speed` up by `rise`, or down again."""
    j, am = limits.jerk, limits.acceleration
    rise = max(rise, 0.0)
    time = rise / am + am / j if rise * j >= am * am else 2 * math.sqrt(rise / j)
    return (speed + rise / 2) * time


def _quadratic(b: float, c: float) -> float:
    """Greater root of x^2 + b x + c, b > 0."""
    root = math.sqrt(max(b * b / 4 - c, 0.0))
    return -c / (b / 2 + root) if c < 0.0 else root - b / 2


def _short(
    way: float, low: float, high: float, least: float, limits: Limits
) -> tuple[float, float]:
    """Jerk times of two pulses that stay below the acceleration limit, of low and high speed."""
    j, am = limits.jerk, limits.acceleration
    gap = (high - low) / j
    if gap == 0.0 and low >= 0.0:
        u = _cubic(8 * low / j, 4 * way / j)
    else:
        first = math.sqrt((least - low) / j) + math.sqrt((least - high) / j)
        u = _newton((j / 4, 0.0, low + high, -way, -j * gap * gap / 4), first, 2 * am / j)
    other = gap / u if u > 0.0 else 0.0
    return (u + other) / 2, max(0.0, (u - other) / 2)


def _cubic(p: float, q: float) -> float:
    """Root of x^3 + p x = q for p, q >= 0."""
    if p == 0.0 or q * q > 1e24 * p**3:
        return math.cbrt(q)
    root = math.sqrt(p / 3)
    return 2 * root * math.sinh(math.asinh(q / (2 * root**3)) / 3)


def _mixed(way: float, low: float, high: float, least: float, limits: Limits) -> float:
    """Jerk time of the pulse of the high speed; the other one reaches the limit."""
    j, am = limits.jerk, limits.acceleration
    least = max(least - high, low - high + am * am / j)
    return _newton(
        (
            j * j / (2 * am),
            j,
            high * j / am + am / 2,
            2 * high,
            (high * high - low * low) / (2 * am) + am * (high + low) / (2 * j) - way,
        ),
        math.sqrt(least / j),
        am / j,
    )


def _newton(coefficients: tuple[float, ...], low: float, high: float) -> float:
    """Root of a polynomial that rises through 0 between low and high."""
    x = high
    for _ in range(200):
        value = slope = 0.0
        for coefficient in coefficients:
            slope = slope * x + value
            value = value * x + coefficient
        if value == 0.0:
            return x
        if value > 0.0:
            high = x
        else:
            low = x
        following = x - value / slope if slope > 0.0 else low
        if not low < following < high:
            following = (low + high) / 2
            if not low < following < high:
                return x
        if abs(following - x) <= 2e-16 * x:
            return following
        x = following
    return x


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that rises through 0 between low and high (regula falsi, Illinois)."""
    at_low, at_high = function(low), function(high)
    if at_low >= 0.0:
        return low
    if at_high <= 0.0:
        return high
    side = 0
    for count in range(200):
        x = high - at_high * (high - low) / (at_high - at_low)
        if count % 4 == 3 or not low < x < high:
            x = (low + high) / 2
            if not low < x < high:
                break
        value = function(x)
        if value == 0.0:
            return x
        if value > 0.0:
            high, at_high = x, value
            if side > 0:
                at_low /= 2
            side = 1
        else:
            low, at_low = x, value
            if side < 0:
                at_high /= 2
            side = -1
    return (low + high) / 2
