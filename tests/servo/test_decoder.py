# SPDX-License-Identifier: Apache-2.0
"""Quadrature decoder against the true position of an encoder whose edges jitter."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked, signed

LATENCY = 4  # clocks from a line to position_o, and filter_i more
INPUTS = ("a", "b", "z", "filter", "clear", "time")
OUTPUTS = (
    *("position", "edge_time", "index", "index_position"),
    *("illegal", "illegal_count"),
)


def block() -> Clocked:
    return Clocked("quadrature_decoder", INPUTS, OUTPUTS)


def lines(position: np.ndarray) -> dict[str, np.ndarray]:
    """A and B of a position: 00, 10, 11, 01 upwards."""
    quarter = position & 3
    return {"a": (quarter == 1) | (quarter == 2), "b": (quarter == 2) | (quarter == 3)}


def journey(random: np.random.Generator, clocks: int, filter_: int) -> np.ndarray:
    """A position per clock that moves by 1 as fast as is legal, and slower, turning at times.

    A line changes with every other edge, or at a turn with two in a row.
    """
    turns = random.random(clocks) < 0.1
    least = np.where(turns, filter_ + 1, (filter_ + 2) // 2)
    gaps = least + random.geometric(random.choice([0.9, 0.5, 0.1], clocks), clocks) - 1
    at = np.cumsum(gaps)
    at = at[at < clocks]
    moves = np.zeros(clocks, dtype=np.int64)
    moves[at] = np.cumprod(np.where(turns, -1, 1))[: len(at)]
    return np.cumsum(moves)


@pytest.mark.parametrize("filter_", [0, 1, 3, 7, 15])
def test_legal_lines_with_jitter__count_is_the_true_position(filter_):
    random = np.random.default_rng([SEED, filter_])
    true = journey(random, 40_000, filter_)
    found = block().run(len(true), **lines(true), filter=filter_)
    late = LATENCY + filter_
    assert np.ptp(true) > 50
    np.testing.assert_array_equal(signed(found["position"], 32)[8 + late :], true[8:-late])
    assert not found["illegal"].any() and not found["illegal_count"].any()


def test_highest_rate__an_edge_in_four_clocks_with_jitter_of_a_clock():
    random = np.random.default_rng(SEED)
    edges = 4 * np.arange(1, 20_000) + random.integers(-1, 2, 19_999) + 16
    moves = np.zeros(edges[-1] + 30, dtype=np.int64)
    moves[edges] = 1
    found = block().run(len(moves), **lines(np.cumsum(moves)), filter=1)
    assert signed(found["position"], 32)[-1] == 19_999 and not found["illegal"].any()


def test_glitch_shorter_than_the_filter__changes_nothing():
    random = np.random.default_rng(SEED)
    a = np.zeros(5000, dtype=bool)
    for at in range(20, 4900, 7):
        a[at : at + random.integers(1, 6)] = True  # 6 clocks would count
    found = block().run(5000, a=a, filter=5)
    assert not found["position"].any() and a.any()


def test_both_lines_at_once__is_flagged_and_counted_and_does_not_move():
    a = np.zeros(6000, dtype=bool)
    at = 20 + 16 * np.arange(300)
    for one in at:
        a[one:] ^= True
    found = block().run(6000, a=a, b=a, clear=np.arange(6000) == 5500)
    seen = found["illegal_count"]
    assert not found["position"].any()
    for number, one in enumerate(at, 1):
        assert seen[one + LATENCY - 1] == min(number - 1, 255)
        assert seen[one + LATENCY] == min(number, 255)
    assert found["illegal"][5500] and not found["illegal"][5501:].any() and seen[-1] == 0


@pytest.mark.parametrize("start", [0, 1, 2, 3])
def test_lines_at_reset__are_the_zero(start):
    true = np.full(100, start)
    true[40:] += 1
    found = block().run(100, **lines(true), filter=0)
    assert not found["illegal"].any()
    assert signed(found["position"], 32)[-1] == 1 and not found["position"][:40].any()


def test_index__latches_the_same_position_from_both_sides():
    up = np.repeat(np.arange(0, 60), 8)
    true = np.concatenate([up, up[::-1]])
    z = (true >= 41) & (true <= 43)  # A and B are high at 42
    found = block().run(len(true), **lines(true), z=z, filter=2)
    index = found["index"].astype(bool)
    assert index[-1] and not index[: 8 * 42].any()
    assert set(signed(found["index_position"][index], 32)) == {42}


def test_edge_time__is_the_time_of_the_last_count():
    random = np.random.default_rng(SEED)
    true = journey(random, 3000, 0)
    time = np.arange(3000) * 7 + 5
    found = block().run(3000, **lines(true), time=time)
    position = found["position"]
    for now in np.flatnonzero(np.diff(position)) + 1:
        assert found["edge_time"][now] == time[now - 1]
