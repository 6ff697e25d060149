# SPDX-License-Identifier: Apache-2.0
"""What a start-up does with three Hall lines alone: their wiring, their angles, the position.

A host sees the count of `hall_decoder` and its counter of wrong states. The sector of the count is
the state of the lines; the count between two edges is a guess, so no estimator uses it. The rotor
is at a known angle in the instant of an edge: a current vector that drags the rotor over all edges
in both directions gives the angle of each edge, and later the edges give the position.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.axis.alignment import SHARE, TURN, SafeLoop, drag, eased, wrapped
from sim.bench.drive.axis.bench import MILLISECOND, Bench, BringUpError
from sim.bench.drive.axis.motor_file import HALL_BITS, SECTORS
from sim.laws.drive.clocks import LOOP_PERIOD

SECTOR = 1 << HALL_BITS  # counts
STATES = ("101", "100", "110", "010", "011", "001")  # u, v, w of each sector
SOFT = 500.0  # crossover [rad/s] of a loop that lets the resistance damp the rotor
SOFT_TIME = 400 * MILLISECOND
EXTRA = np.pi / 3  # of the drag before the first edge and after the last one [rad]
MOST_LAG = np.radians(30.0)  # electrical, between the edge of one direction and of the other
MOST_UNEVEN = np.radians(25.0)  # electrical, of an edge from its place
MOST_WRONG = np.radians(15.0)  # electrical, of an entered offset
LIMITS = {
    "alignment without motion": "the pulses of current move the rotor by a degree, and Hall lines "
    "show 60 electrical degrees; the drag around a turn replaces it",
    "check of pole_pairs": "Hall lines count electrical turns, not turns of the shaft; compare a "
    "turn by hand",
    "position after a move": "at rest the position is known to 60 electrical degrees; the "
    "commands for position need another encoder",
}
"""Steps of the start-up that Hall lines do not allow, and why."""


def edges(counts: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First rows of new sectors, and the boundaries crossed there, in sectors from count 0."""
    sectors = np.floor(counts / SECTOR).astype(np.int64)
    rows = np.flatnonzero(np.diff(sectors)) + 1
    return rows, np.maximum(sectors[rows], sectors[rows - 1])


def between(
    counts: NDArray[np.float64], uneven: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Counts and counts a second in every row, by a spline through the edges; uneven: counts by
    which each of the six edges is late."""
    from scipy.interpolate import CubicSpline  # here: more than a second of every command

    rows, boundaries = edges(counts)
    at = boundaries * SECTOR + uneven[boundaries % SECTORS]
    spline = CubicSpline((rows - 0.5) * LOOP_PERIOD, at)
    t = np.arange(len(counts)) * LOOP_PERIOD
    return spline(t), spline(t, 1)


def speed(counts: NDArray[np.float64]) -> float:
    """Counts a second by the last two edges, less if the next one is overdue."""
    rows, boundaries = edges(counts)
    if len(rows) < 2:
        return 0.0
    way = np.sign(counts[rows[-1]] - counts[rows[-1] - 1])
    if boundaries[-1] == boundaries[-2]:  # a reversal
        return 0.0
    return float(way * SECTOR / (max(np.diff(rows)[-1], len(counts) - rows[-1]) * LOOP_PERIOD))


def _hold(bench: Bench, inductance: float, begin: float, end: float) -> None:
    """Bring a rotor to rest in a direction by a voltage that hardly follows the current."""
    soft = SafeLoop(inductance, SOFT)
    rise = eased(SOFT_TIME)
    size = SHARE * bench.one.motor.i_max
    drag(bench, soft, np.full(SOFT_TIME, begin), size * rise)
    drag(bench, soft, begin + (end - begin) * rise, np.full(SOFT_TIME, size))
    drag(bench, soft, np.full(SOFT_TIME, end), np.full(SOFT_TIME, size))


def align(bench: Bench, loop: SafeLoop) -> tuple[float, NDArray[np.float64], float]:
    """Electrical angle at count 0 [rad]; counts by which each of the six edges is late; direction
    in which the rotor is held. Raises BringUpError for lines that are wrong, and names them."""
    per_count = 2 * np.pi / (SECTORS * SECTOR)
    bench.bad()
    # From a quarter of a turn away: no rotor stays where the force of both is 0.
    _hold(bench, loop.inductance, -np.pi / 2, -EXTRA)
    way = 2 * np.pi + 2 * EXTRA
    n = round(TURN * way / (2 * np.pi) / LOOP_PERIOD)
    angles, size = way * eased(n) - EXTRA, np.full(n, SHARE * bench.one.motor.i_max)
    up = drag(bench, loop, angles, size)
    sectors = round(way / (2 * np.pi) * SECTORS)
    _checked(up, bench.bad(), sectors)
    drag(bench, loop, np.full(n // 4, angles[-1]), size[: n // 4])
    down = drag(bench, loop, angles[::-1], size)
    _checked(down, bench.bad(), -sectors)
    drag(bench, loop, np.full(n // 4, -EXTRA), size[: n // 4])
    apart: list[list[float]] = [[] for _ in range(SECTORS)]
    lags = []
    seen = [dict(zip(*edges(counts)[::-1], strict=True)) for counts in (up, down)]
    for boundary in sorted(seen[0].keys() & seen[1].keys()):
        at = angles[seen[0][boundary]], angles[::-1][seen[1][boundary]]
        lags.append((at[0] - at[1]) / 2)
        apart[boundary % SECTORS].append(sum(at) / 2 - boundary * SECTOR * per_count)
    late = max(map(abs, lags))
    if late > MOST_LAG or not all(apart):
        raise BringUpError(
            f"a current of {size[0]:.3g} A drags the rotor, which lags by {math.degrees(late):.0f} "
            "electrical degrees; free the motor, or enter a larger rated_current"
        )
    each = np.array([np.mean(found) for found in apart])
    offset = wrapped(float(np.angle(np.exp(1j * each).mean())))
    uneven = np.array([wrapped(one - offset) for one in each])
    if np.abs(uneven).max() > MOST_UNEVEN:
        worst = int(np.abs(uneven).argmax())
        raise BringUpError(
            f"the edge of the Hall lines from state {STATES[worst - 1]} to {STATES[worst]} is "
            f"{math.degrees(uneven[worst]):+.0f} electrical degrees from its place (u, v, w); "
            "check how the sensors are mounted"
        )
    return offset, uneven / per_count, -EXTRA


def by_offset(bench: Bench, loop: SafeLoop) -> tuple[float, float]:
    """`encoder_offset` of the file, checked by a sixth of an electrical turn; the direction in
    which the rotor is held.

    Raises BringUpError if the rotor is held where the lines say it is not.
    """
    one, per_count = bench.one, 2 * np.pi / (SECTORS * SECTOR)
    assert one.encoder_offset is not None
    now = bench.counts * per_count + one.encoder_offset
    held = float(np.pi / 3 * np.round(now / (np.pi / 3)))
    _hold(bench, loop.inductance, now, held)
    # A second direction: lines that count backwards may be right in one.
    for angles in (np.full(SOFT_TIME, held), held + np.pi / 3 * eased(SOFT_TIME)):
        for sweep in (angles, np.full(SOFT_TIME, angles[-1])):
            drag(bench, loop, sweep, np.full(SOFT_TIME, SHARE * one.motor.i_max))
        held = float(angles[-1])
        middle = (math.floor(bench.counts / SECTOR) + 0.5) * SECTOR * per_count
        apart = wrapped(held - middle - one.encoder_offset)
        if abs(apart) > np.pi / SECTORS + MOST_WRONG:
            raise BringUpError(
                f"encoder_offset = {one.encoder_offset:g} rad: the rotor is held {abs(apart):.2g} "
                "rad from the middle of the sector of the Hall lines, a sector has "
                f"{2 * np.pi / SECTORS:.2g} rad; remove the key and let the start-up find it, or "
                "check the order of the lines"
            )
    return one.encoder_offset, held


def _checked(counts: NDArray[np.float64], bad: int, expected: int) -> None:
    """Refuse what no three lines of a motor do while a current drags it by so many sectors."""
    sectors = np.floor(counts / SECTOR).astype(np.int64)
    states = [STATES[k] for k in np.unique(sectors % SECTORS)]
    moved = int(sectors[-1] - sectors[0])
    if not bad and abs(moved - expected) <= 1:
        return
    text = f"a turn of the current showed the states {', '.join(states)} of the Hall lines u, v, w"
    constant = [k for k in range(3) if len({state[k] for state in states}) == 1]
    missing = [state for state in STATES if state not in states]
    joined = [k for k in range(3) if all(state[k] == state[k - 1] for state in states)]
    if not bad and abs(moved + expected) <= 1:
        raise BringUpError(
            "the Hall lines have the wrong order: they count against the current; exchange two of "
            "u, v and w, or two phases of the motor"
        )
    if not bad and len(states) == 1:
        cause = "no edge; check the supply of the sensors, the motor cable, or a closed brake"
    elif len(states) == 1:
        cause = "and states with equal lines; check the supply of the sensors and each line"
    elif constant and (bad or len(constant) > 1):
        cause = " and ".join(f"{'uvw'[k]} is always {states[0][k]}" for k in constant)
        cause += "; check that line and its sensor"
        if not bad:
            cause += ", and that the motor is free"
    elif bad and joined:
        k = joined[0]
        cause = f"{'uvw'[k - 1]} and {'uvw'[k]} are always equal; check what connects the two lines"
    elif bad and len(missing) == 2 and all(a != b for a, b in zip(*missing, strict=True)):
        odd = next(k for k in range(3) if missing[0].count(missing[0][k]) == 1)
        cause = (
            f"and states with equal lines; line {'uvw'[odd]} is inverted, or its sensor is 60 "
            "degrees from the others instead of 120: invert that line"
        )
    else:
        cause = (
            f"{bad} wrong changes, and moved by {moved} sectors instead of {expected}; check each "
            "line, and that the motor is free"
        )
    raise BringUpError(f"{text}: {cause}")
