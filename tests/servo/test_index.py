# SPDX-License-Identifier: Apache-2.0
"""The check of the index, alone: counts from index to index, and an index that does not come."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked

AXES, DISTANCE, TOLERANCE, PLACE = 2, 64, 2, 5
SLOW = 20  # clocks of a count: each axis is looked at once in 4 AXES
INPUTS = ("position", "index_position", "passes", "distance", "tolerance", "clear")
WORD = (1 << 32) - 1


def lost(
    counted: np.ndarray,
    true: np.ndarray | None = None,
    silent: bool = False,
    clear: int = -1,
    distance: int = DISTANCE,
) -> np.ndarray:
    """lost_o of axis 1 after each count (n,), whose counter is at `counted` and whose encoder at
    `true`; silent: no index comes; clear: after this count. Axis 0 has an index in each count."""
    true = counted if true is None else true
    clocks = SLOW * (len(counted) + 3)
    at, index, passes = (np.zeros(clocks, dtype=np.int64) for _ in range(3))
    clears = np.zeros(clocks, dtype=np.int64)
    at[:] = last = counted[0]
    for n, (position, place) in enumerate(zip(counted.tolist(), true.tolist(), strict=True)):
        clock = SLOW * (n + 1)
        at[clock:] = position
        if place % DISTANCE == PLACE and not silent:
            passes[clock] = 2
            last = position
        index[clock + 1 :] = last
        passes[clock] |= 1
        if n == clear:
            clears[clock + SLOW - 1] = 3
    block = Clocked("index_check", INPUTS, ("lost",), {"Axes": AXES})
    found = block.run(
        clocks,
        position=(at & WORD) << 32,
        index_position=(index & WORD) << 32,
        passes=passes,
        distance=distance << 24 | distance,
        tolerance=TOLERANCE << 8 | TOLERANCE,
        clear=clears,
    )["lost"]
    assert not (found & 1).any(), "axis 0 rests"
    return found[SLOW * 2 - 1 :: SLOW][: len(counted)] >> 1


def tour(seed: int, steps: int = 6000) -> np.ndarray:
    """A random walk over many indices with many reversals at them."""
    draw = np.random.default_rng([SEED, seed])
    speed = np.repeat(draw.choice([-1, 1], steps // 50, p=[0.35, 0.65]), 50)
    jitter = draw.random(steps) < 0.3
    return np.cumsum(np.where(jitter, -speed, speed))


@pytest.mark.parametrize("start", [0, -(2**23) - 100, 2**31 - 500])
def test_index__a_tour_with_reversals_is_never_reported(start):
    walk = tour(1)
    assert np.abs(np.diff(walk[walk % DISTANCE == PLACE])).max() == DISTANCE
    at = walk - walk[0] + start - start % DISTANCE
    assert not lost(at).any()


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("slip", [TOLERANCE, TOLERANCE + 1, -TOLERANCE, -TOLERANCE - 1])
def test_index__counts_that_are_lost_or_too_many_are_found_at_the_next_index(way, slip):
    true = way * np.arange(400)
    at = np.flatnonzero(true % DISTANCE == PLACE)
    counted = true + np.where(np.arange(400) > at[1] + 20, slip, 0)
    found = lost(counted, true)
    if abs(slip) <= TOLERANCE:
        assert not found.any()
    else:
        assert np.flatnonzero(found)[0] == at[2] and found[-1]


def test_index__slips_within_the_tolerance_add_up():
    """A count is lost between any two indices: the third loss is beyond the tolerance of two."""
    true = np.arange(500)
    at = np.flatnonzero(true % DISTANCE == PLACE)
    found = lost(true - np.searchsorted(at + 9, true), true)
    assert np.flatnonzero(found)[0] == at[3]


@pytest.mark.parametrize("way", [1, -1])
def test_index__that_does_not_come_is_found_a_distance_later(way):
    """Before the first index from where the count began, and after one from there."""
    silent = lost(way * np.arange(200), silent=True)
    assert np.flatnonzero(silent)[0] == DISTANCE + TOLERANCE + 1
    true = way * np.arange(300)
    at = np.flatnonzero(true % DISTANCE == PLACE)
    later = true + DISTANCE // 2 * (np.arange(300) > at[1])  # no index from there on
    found = lost(true, np.where(np.arange(300) > at[1], np.full(300, PLACE + 1), later))
    assert np.flatnonzero(found)[0] == at[1] + DISTANCE + TOLERANCE + 1
    assert not lost(true, silent=True, distance=0).any(), "0: never"


def test_index__clear_forgets_report_and_reference():
    true = np.arange(400)
    counted = true + np.where(true > 200, 30, 0)
    assert lost(counted, true)[-1]
    assert not lost(counted, true, clear=201).any(), "the next index is the first one"
    found = lost(counted, true, clear=300)
    assert found[299] and not found[302:].any()
