# SPDX-License-Identifier: Apache-2.0
"""Current sensing: both rates against weighted sums of bits; the overcurrent comparator."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.seed import SEED
from tests.servo.clocked import Clocked, signed

CLOCKS_PER_BIT = 6
SLOW, FAST = 64, 8
FAST_FULL = FAST**3 // 2


def weights(rate: int) -> np.ndarray:
    """Of sinc3: a box of `rate` bits, three times."""
    box = np.ones(rate, dtype=np.int64)
    return np.convolve(np.convolve(box, box), box)


def timing(clocks: int, window: np.ndarray | int = 0) -> dict[str, np.ndarray]:
    """Outputs of sinc3_timing."""
    outputs = ("mclk", "strobe", "corner", "done", "fast", "fast_valid")
    return Clocked("sinc3_timing", ("window",), outputs).run(clocks, window=window)


def modulated(values: np.ndarray) -> np.ndarray:
    """Bits of a second-order sigma-delta modulator for values of -1 .. 1 (full scale)."""
    first = second = 0.0
    bits = np.zeros(len(values), dtype=np.int64)
    for index, value in enumerate(values):
        bits[index] = second >= 0
        back = 2 * bits[index] - 1
        first += value - back
        second += first - 2 * back
    return bits


def sense(bits_a: np.ndarray, bits_b: np.ndarray, limit: int, window: np.ndarray | int = 0):
    """(outputs of current_sense, its timing) for bits that change with the modulators' clock."""
    clocks = len(bits_a) * CLOCKS_PER_BIT
    when = timing(clocks, window)
    block = Clocked(
        "current_sense",
        ("bit_a", "bit_b", "strobe", "corner", "fast", "fast_valid", "limit"),
        ("slow_a", "slow_b", "over"),
    )
    found = block.run(
        clocks,
        bit_a=np.repeat(bits_a, CLOCKS_PER_BIT),
        bit_b=np.repeat(bits_b, CLOCKS_PER_BIT),
        limit=limit,
        **{name: when[name] for name in ("strobe", "corner", "fast", "fast_valid")},
    )
    return found, when


def test_timing__bits_corners_and_fast_values():
    starts = [100, 2000, 2500, 4001]  # the third cuts the second short
    found = timing(6000, np.isin(np.arange(6000), starts))
    strobes = np.flatnonzero(found["strobe"])
    assert (np.diff(strobes) == CLOCKS_PER_BIT).all()
    assert (found["mclk"].reshape(-1, CLOCKS_PER_BIT).sum(axis=1) == CLOCKS_PER_BIT // 2).all()
    fast = np.flatnonzero(found["fast_valid"])
    assert set(np.diff(fast)) == {FAST * CLOCKS_PER_BIT} and set(fast - 4) <= set(strobes)
    corners = []
    for start, end in zip(starts, [*starts[1:], 6000], strict=True):
        first = strobes[strobes >= start][0]
        corners += [c for c in first + np.arange(4) * SLOW * CLOCKS_PER_BIT if c < end]
    assert np.flatnonzero(found["corner"] & 1).tolist() == [c + 1 for c in corners]
    assert np.flatnonzero(found["corner"] >> 2 & 1).tolist() == [c + 3 for c in corners]
    done = np.flatnonzero(found["done"]).tolist()
    assert (
        done == [corners[3] + 4, corners[-5] + 4, corners[-1] + 4][: len(done)] and len(done) == 3
    )


def test_slow_values__are_the_weighted_sums_of_the_windows_bits():
    random = np.random.default_rng(SEED)
    bits = random.integers(0, 2, (2, 4000))
    bits[:, 1000:1500], bits[:, 1500:2000] = 0, 1  # both ends of the scale
    found, when = sense(*bits, 0, np.arange(4000 * CLOCKS_PER_BIT) % 1250 == 7)
    strobes = np.flatnonzero(when["strobe"]).tolist()
    checked = []
    for done in np.flatnonzero(when["done"]):
        last = strobes.index(done - 4) - 2  # two registers after the first integrator
        for name, row in zip(("slow_a", "slow_b"), bits, strict=True):
            part = row[last - 3 * SLOW + 3 : last + 1]
            want = int(weights(SLOW) @ part) - SLOW**3 // 2
            assert signed(found[name], 19)[done] == want
            checked.append(want)
    assert len(checked) > 30 and min(checked) == -(SLOW**3) // 2 and max(checked) == SLOW**3 // 2


def test_fast_values__are_the_weighted_sums_of_all_bits():
    random = np.random.default_rng(SEED)
    row = random.integers(0, 2, 2000)
    row[500:600], row[600:700] = 0, 1
    clocks = len(row) * CLOCKS_PER_BIT
    when = timing(clocks)
    block = Clocked("sinc3_filter", ("bit", "strobe", "corner", "fast"), ("slow", "fast"))
    found = block.run(
        clocks,
        bit=np.repeat(row, CLOCKS_PER_BIT),
        strobe=when["strobe"],
        corner=when["corner"],
        fast=when["fast"],
    )
    strobes = np.flatnonzero(when["strobe"]).tolist()
    seen = set()
    for valid in np.flatnonzero(when["fast_valid"])[8:]:
        last = strobes.index(valid - 4) - 2
        part = row[last - 3 * FAST + 3 : last + 1]
        want = int(weights(FAST) @ part) - FAST_FULL
        assert signed(found["fast"], 10)[valid] == want
        seen.add(want)
    assert {-FAST_FULL, FAST_FULL} <= seen


@pytest.mark.parametrize("phase", ["a", "b", "c"])
@pytest.mark.parametrize("sign", [1, -1])
def test_overcurrent__a_step_to_the_limit_is_seen_in_2_us(phase, sign):
    limit, step, calm = 150, 0.85, 0.25  # of full scale 256: 59 %, beyond it, well below
    at = 1000
    values = np.full((2, 1400), 0.0)
    shares = {"a": (1.0, -0.5), "b": (-0.5, 1.0), "c": (-0.5, -0.5)}[phase]
    for row, share in zip(values, shares, strict=True):
        row[:at], row[at:] = sign * calm * share, sign * step * share
    bits = np.array([modulated(row) for row in values])
    found, _ = sense(*bits, limit)
    settled = 100 * CLOCKS_PER_BIT
    over = settled + np.flatnonzero(found["over"][settled:])
    first = over[0] / CLOCKS_PER_BIT - at  # bits after the step
    assert 0 <= first < 40, "2 us are 40 bits at 20 MHz"
    assert found["over"][-200:].all()


def test_overcurrent__limit_0_never_trips_and_the_limit_is_exact():
    ones, zeros = np.ones(200, dtype=np.int64), np.zeros(200, dtype=np.int64)
    for limit, want in ((0, 0), (FAST_FULL, 1), (FAST_FULL + 1, 0)):
        found, _ = sense(
            ones, zeros, limit
        )  # full scale and its opposite: the third phase has none
        assert found["over"][-1] == want
