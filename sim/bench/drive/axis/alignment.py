# SPDX-License-Identifier: Apache-2.0
"""The electrical angle at count 0 of a motor without a brake: without motion, and with it.

Without motion: short doublets of current in directions all around, the second derivative of a
smooth bump. Each moves the rotor along that bump, by a few counts and back; how far goes with the
sine of the angle between current and magnets, so a sine fitted to the moves gives the angle, its
sign included. Friction makes small moves smaller, the same for opposite directions, and leaves the
angle.

With motion: a current vector drags the rotor around one electrical turn and back. The rotor lags by
friction, to either side; the mean of both ways has no lag, and a turn no cogging. The way also
shows wrong pole pairs, counts or swapped phases.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.axis.bench import MILLISECOND, Bench, BringUpError
from sim.laws.drive.clocks import LOOP_PERIOD

DIRECTIONS = 12
SHARE = 0.8  # of the rated current
LEAST_MOVE, LEAST_ANGLE = 12.0, np.radians(1.0)  # of a doublet: counts, and electrical angle
SHORTEST, LONGEST = 100, 10_000  # half periods of a doublet
GROWTH, TRIES = 1.25, 4
STEEPEST = 8.0  # slope of a doublet's current by its size and length
RISE = 0.15  # of the bus voltage, for that slope
MOST_OFF = 0.25  # largest distance from the sine as a share of its size
REST, LONGEST_REST = 3 * MILLISECOND, 120 * MILLISECOND
STILL = np.radians(0.02)  # electrical, in REST
TURN = 0.5  # s of an electrical turn
MOST_APART = 15.0  # degrees between the offset in the file and the answer to currents
MOST_WAY = 0.05  # largest error of the way of a turn, as a share


@dataclass(frozen=True)
class SafeLoop:
    """Gains of a current loop that needs the inductance alone, and that roughly."""

    inductance: float
    crossover: float = 1e4  # rad/s

    @property
    def gains(self) -> dict[str, float]:
        """Columns of `ORDERS`; the integral begins at a tenth of the crossover, for any R."""
        gain = self.inductance * self.crossover
        return {"gain": gain, "share": gain * self.crossover / 10 * LOOP_PERIOD}


@dataclass(frozen=True)
class Still:
    """angle: electrical, at count 0 [rad]; moved: largest way of the rotor, electrical [rad]."""

    angle: float
    moved: float


def wrapped(angle: float) -> float:
    """-pi .. pi."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def without_motion(bench: Bench, loop: SafeLoop) -> Still:
    """By doublets. Raises BringUpError if the rotor does not answer, or not as a motor does."""
    per_count = bench.one.motor.wave * bench.one.resolution
    target, length = max(LEAST_MOVE, LEAST_ANGLE / per_count), SHORTEST
    for _ in range(TRIES):
        length = _long_enough(bench, loop, target, length)
        angle, size, off, moved = _fitted(bench, loop, length)
        if off <= MOST_OFF * size + 2.0:
            return Still(angle, moved * per_count)
        target *= 2  # static friction was too large a part
    raise BringUpError(
        f"the rotor moved by {size:.1f} counts, {off:.1f} off a sine of the current's direction; "
        "check that all phases are connected and that nothing else moves the motor"
    )


def _long_enough(bench: Bench, loop: SafeLoop, target: float, length: int) -> int:
    """Half periods of a doublet that moves the rotor by so many counts. Raises BringUpError."""
    one = bench.one
    while True:
        pilots = [
            _doublet(bench, loop, direction, length)
            for direction in (0.0, np.pi, np.pi / 2, 1.5 * np.pi)
        ]
        size = math.hypot(*(pilots[k][0] - pilots[k + 1][0] for k in (0, 2))) / 2
        if size >= target:
            return length
        length = round(length * GROWTH)
        if length > LONGEST:
            raise BringUpError(
                f"{SHARE * one.motor.i_max:.3g} A for {LONGEST * LOOP_PERIOD:g} s moved "
                f"the encoder by {size:.1f} counts, {target:.0f} are needed; check motor cable and "
                "encoder, a closed brake, or enter a larger rated_current"
            )


def _fitted(bench: Bench, loop: SafeLoop, length: int) -> tuple[float, float, float, float]:
    """Angle at count 0 [rad], size of the sine, largest distance from it, largest way [counts]."""
    per_count = bench.one.motor.wave * bench.one.resolution
    directions = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    # An opposite direction after each: what cogging and friction add is the same for both.
    sequence = [d + turn for d in directions[: DIRECTIONS // 2] for turn in (0.0, np.pi)]
    moves, at, largest = np.array([_doublet(bench, loop, d, length) for d in sequence]).T
    angles = directions[: DIRECTIONS // 2] - per_count * (at[::2] + at[1::2]) / 2
    moves = (moves[::2] - moves[1::2]) / 2
    basis = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    fit, *_ = np.linalg.lstsq(basis, moves, rcond=None)
    # moves = size * sin(direction - angle)
    angle, size = wrapped(np.arctan2(-fit[0], fit[1])), float(np.hypot(*fit[:2]))
    return angle, size, float(np.abs(moves - basis @ fit).max()), float(largest.max())


def _doublet(
    bench: Bench, loop: SafeLoop, direction: float, length: int
) -> tuple[float, float, float]:
    """Size of the move along the bump [counts], counts before, largest way."""
    one = bench.one
    _rest(bench, loop)
    u = np.pi * (np.arange(length) + 0.5) / length
    profile = np.zeros(length + max(length // 2, 2 * MILLISECOND))
    profile[:length] = 3 * (np.sin(u) * np.cos(u)) ** 2 - np.sin(u) ** 4
    slope = RISE * one.U_dc * length * LOOP_PERIOD / (STEEPEST * loop.inductance)
    size = min(SHARE * one.motor.i_max, slope) * profile
    orders = {"i_alpha": size * np.cos(direction), "i_beta": size * np.sin(direction)}
    counts = bench.run(bench.orders(len(profile), **orders, **loop.gains)).counts
    moved, ideal = (counts - counts[0])[:length], np.sin(u) ** 4
    # The way that stays, by friction, is no part of the bump.
    basis = np.stack([ideal, np.linspace(0, 1, length)], axis=1)
    fit, *_ = np.linalg.lstsq(basis, moved, rcond=None)
    return float(fit[0]), float(counts[0]), float(np.abs(counts - counts[0]).max())


def _rest(bench: Bench, loop: SafeLoop) -> None:
    """Wait without current until the counts stay, `LONGEST_REST` at most: what the rotor then still
    moves is a straight line in the next move."""
    per_count = bench.one.motor.wave * bench.one.resolution
    still = max(1.0, STILL / per_count)
    for _ in range(LONGEST_REST // REST):
        counts = bench.run(bench.orders(REST, **loop.gains)).counts
        if np.ptp(counts) <= still:
            return


def eased(n: int) -> NDArray[np.float64]:
    """0 .. 1 in n rows, from rest to rest."""
    s = (np.arange(n) + 1) / n
    return s - np.sin(2 * np.pi * s) / (2 * np.pi)


def drag(
    bench: Bench, loop: SafeLoop, angles: NDArray[np.float64], sizes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Counts while a current vector of these angles [rad] and sizes [A] drags the rotor."""
    orders = {"i_alpha": sizes * np.cos(angles), "i_beta": sizes * np.sin(angles)}
    return bench.run(bench.orders(len(angles), **orders, **loop.gains)).counts


def settle(bench: Bench, loop: SafeLoop, angle: float) -> float:
    """Hold the rotor at the nearest multiple of 60 degrees, where all phases carry current.

    angle: electrical, at count 0. Returns the current's direction; no row of orders is left.
    """
    per_count = bench.one.motor.wave * bench.one.resolution
    now = bench.run(bench.orders(1, **loop.gains)).counts[0] * per_count + angle
    to = np.pi / 3 * np.round(now / (np.pi / 3))
    size = SHARE * bench.one.motor.i_max
    ramp, way = 50 * MILLISECOND, 150 * MILLISECOND
    drag(bench, loop, np.full(ramp, now), size * eased(ramp))
    drag(bench, loop, now + (to - now) * eased(way), np.full(way, size))
    drag(bench, loop, np.full(way, to), np.full(way, size))
    return float(to)


def with_motion(bench: Bench, loop: SafeLoop, begin: float) -> float:
    """Electrical angle at count 0 [rad]; the rotor is held in direction `begin`, and is again.

    Raises BringUpError if the way is not that of an electrical turn.
    """
    one, rows = bench.one, round(TURN / LOOP_PERIOD)
    per_count = one.motor.wave * one.resolution
    size = np.full(rows, SHARE * one.motor.i_max)
    turn, ways, offsets = 2 * np.pi * eased(rows), [], []
    for angles in (begin + turn, begin + turn[::-1]):
        counts = drag(bench, loop, angles, size)
        ways.append(counts[-1] - counts[0])
        weights = np.abs(np.gradient(angles))
        offsets.append(np.average(angles - per_count * counts, weights=weights))
        drag(bench, loop, np.full(rows // 2, angles[-1]), size[: rows // 2])
    turned = np.array(ways) * per_count / (2 * np.pi)
    if np.abs(turned - [1, -1]).max() > MOST_WAY:
        linear = one.kind == "linear"
        keys = "pole_pitch" if linear else "pole_pairs"
        raise BringUpError(
            f"a turn of the current moved the encoder by {turned[0]:.3f} electrical turns and back "
            f"by {turned[1]:.3f}, expected 1 and -1; "
            + (
                "exchange two phases, or the encoder's A and B"
                if abs(turned[0] + 1) < MOST_WAY
                else f"correct {keys} or encoder_counts, or free the motor"
            )
        )
    return wrapped(float(np.mean(offsets)))


def at_absolute_zero(bench: Bench, angle: float) -> float:
    """Electrical angle at position 0 of the absolute encoder [rad], from that at count 0; the motor
    is at rest."""
    one = bench.one
    way = bench.absolute() * one.absolute - bench.counts * one.resolution
    return wrapped(angle - one.motor.wave * way)


def by_the_encoder(bench: Bench, still: float) -> float:
    """Electrical angle at count 0 [rad] from the absolute position and `encoder_offset`, the motor
    at rest; still: the same by its answer to currents, as a check.

    Raises BringUpError if the two do not agree.
    """
    one = bench.one
    assert one.encoder_offset is not None
    angle = wrapped(one.encoder_offset - at_absolute_zero(bench, 0.0))
    apart = math.degrees(wrapped(angle - still))
    if abs(apart) > MOST_APART:
        raise BringUpError(
            f"encoder_offset = {one.encoder_offset:g} rad is {apart:+.0f} degrees from the "
            "magnets, by the rotor's answer to currents; correct it to about "
            f"{at_absolute_zero(bench, still):.4f}, or remove it and let the start-up find it"
        )
    return angle
