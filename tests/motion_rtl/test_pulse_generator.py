# SPDX-License-Identifier: Apache-2.0
"""Pulse generator against exact rational arithmetic: counts, every edge, saturation, clear."""

from __future__ import annotations

import ctypes
from fractions import Fraction

import numpy as np
import pytest

from sim.rtl.build import ROOT, build_library
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated
from tests.bench.seed import SEED

MODULUS = 16 * 100_000_000
HALF = MODULUS // 2
FOLDERS = (ROOT / "rtl",)  # where its source is; tests put changed copies first


class Generator(Verilated):
    """One pulse generator at 100 MHz, out of reset."""

    prefix, end = "pulses", "delete"

    def __init__(self) -> None:
        top, harness = "pulse_generator", ROOT / "sim/rtl/pulse_harness.cpp"
        u32, u64 = ctypes.c_uint32, ctypes.c_uint64
        super().__init__(
            build_library(top, sources_of(top, FOLDERS), harness),
            {"run": (u64, u32, u64, ctypes.c_void_p, u64), "clear": (None,), "count": (u32,)},
        )

    def run(self, rate: int, clocks: int, kept: int = 1 << 17) -> tuple[int, list[int]]:
        """Pulses of a run and the clocks of the first of them."""
        at = np.zeros(kept, dtype=np.uint64)
        count = self._call("run", rate, clocks, at.ctypes.data, kept)
        return count, at[: min(count, kept)].astype(np.int64).tolist()

    def clear(self) -> None:
        self._call("clear")

    @property
    def count(self) -> int:
        return self._call("count")


def expected(rate: int, clocks: int) -> list[int]:
    """Clocks of the pulses by definition: the first clock at or after each ideal instant."""
    found = []
    number = 1
    while True:
        instant = Fraction(MODULUS * number - HALF, rate)  # phase HALF + n rate reaches a multiple
        clock = -(-instant.numerator // instant.denominator)
        if clock > clocks:
            return found
        found.append(clock)
        number += 1


def rates(count: int) -> list[int]:
    random = np.random.default_rng(SEED)
    fixed = [1_600_000 - 1, 1_600_000, HALF, HALF - 1, HALF // 3, 16 * 40_000, 16 * 1_000_003]
    return fixed + [int(2**x) for x in random.uniform(17, np.log2(HALF), count)]


@pytest.mark.parametrize("rate", rates(20))
def test_constant_rate__every_pulse_in_the_first_clock_after_its_instant(rate):
    clocks = 200_000
    generator = Generator()
    assert generator.run(rate, clocks) == (
        (HALF + clocks * rate) // MODULUS,
        expected(rate, clocks),
    ), f"replay: SEED={SEED}, rate {rate}/16 Hz"


def test_changing_rates__pulses_are_the_exact_sum():
    random = np.random.default_rng(SEED)
    generator = Generator()
    phase = HALF
    for _ in range(300):
        rate, clocks = int(random.integers(0, HALF + 1)), int(random.integers(1, 400))
        count, _ = generator.run(rate, clocks)
        phase += rate * clocks
        assert count == phase // MODULUS, f"replay: SEED={SEED}"
        phase %= MODULUS
    # The counter is one clock after the pulse.
    generator.run(0, 1)
    before = generator.count
    count, _ = generator.run(HALF, 1001)
    generator.run(0, 1)
    assert generator.count - before == count


def test_lowest_rate__first_pulse_after_half_a_period():
    generator = Generator()
    count, at = generator.run(16 * 5_000, 10_000)
    assert (count, at) == (1, [10_000])
    assert generator.run(0, 50_000) == (0, [])


@pytest.mark.parametrize("rate", [HALF + 1, HALF * 5 // 4, 16 * 67_000_000, MODULUS, 0xFFFFFFFF])
def test_rates_above_half_the_clock__a_pulse_every_other_clock_and_none_owed_after(rate):
    generator = Generator()
    count, at = generator.run(rate, 2001)
    assert count in (1000, 1001)
    assert np.all(np.diff(at) == 2)
    # Saturated pulses are not made up for: at most one is due when the rate falls.
    assert generator.run(0, 1000)[0] <= 1
    generator.clear()
    assert generator.run(HALF // 2, 4000)[0] == 1000


def test_clear__starts_from_half_a_pulse():
    generator = Generator()
    generator.run(HALF // 7, 12345)
    generator.clear()
    assert generator.run(HALF // 7, 1000)[1] == expected(HALF // 7, 1000)


@pytest.mark.full
@pytest.mark.parametrize("rate", [1, 3, 16 * 12_345 + 7])
def test_sixteen_seconds__count_is_the_rate_word(rate):
    """16 s at R/16 Hz are R pulses, none more and none less."""
    generator = Generator()
    assert generator.run(rate, 16 * 100_000_000, kept=0)[0] == rate


@pytest.mark.full
def test_a_billion_pulses__none_lost():
    generator = Generator()
    rate = HALF - 12_345
    clocks = -(-(1_000_000_000 * MODULUS - HALF) // rate)
    assert generator.run(rate, clocks, kept=0)[0] == 1_000_000_000
