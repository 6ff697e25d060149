# SPDX-License-Identifier: Apache-2.0
"""The case generators make what they say: hard cases are hard, cross products are complete."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np
import pytest

from sim.core.fpbench import BenchError, Unit

ADD = "fp_add"  # every library holds the generators of all operations


def value(bits: int) -> Fraction:
    """Exact value of a finite binary32 number."""
    return Fraction(float(np.uint32(bits).view(np.float32)))


def odd_part(x: Fraction) -> int:
    """The odd factor of a binary fraction's significand."""
    n = abs(x.numerator)
    return n // (n & -n)


def half_ulps_off(magnitude: Fraction) -> Fraction:
    """Distance of a positive number from the nearest multiple of half an ulp, in ulp."""
    exponent = max(_floor_log2(magnitude) - 23, -149)
    halves = magnitude / Fraction(2) ** exponent * 2
    return abs(halves - round(halves)) / 2


def _floor_log2(x: Fraction) -> int:
    e = x.numerator.bit_length() - x.denominator.bit_length()
    return e if Fraction(2) ** e <= x else e - 1


@pytest.mark.parametrize("variant", range(4), ids=["above_one", "below_one", "subnormal", "short"])
def test_hard_quotients__every_variant__within_remainder_over_divisor(variant: int) -> None:
    unit = Unit(ADD)
    part = unit.size("div", "hard") // 4
    rows = unit.operands("div", "hard", variant * part + 12_345, 4000)
    assert len(rows) > 500
    subnormal = 0
    for a, b, _ in rows.tolist():
        quotient = abs(value(a) / value(b))
        off = half_ulps_off(quotient)
        significand = odd_part(value(b))
        assert 0 < off <= Fraction(8, 2 * significand) or significand < 32
        subnormal += quotient < Fraction(2) ** -126
    assert (subnormal > len(rows) // 2) == (variant == 2)


def test_hard_roots__residues__next_to_a_rounding_boundary() -> None:
    unit = Unit(ADD)
    middle = unit.size("sqrt", "hard") // 2
    rows = unit.operands("sqrt", "hard", middle - 800, 1600)
    assert len(rows) > 100
    for operand in rows[:, 0].tolist():
        x = value(operand)
        # in half ulps of the root: x = Q^2 + s with s = 8 i - 1 below 100 * 8, or four times that
        square = x / Fraction(2) ** (2 * (_floor_log2(x) // 2 - 24))
        below = isqrt(square.numerator // square.denominator)
        assert 0 < min(abs(square - below**2), abs(square - (below + 1) ** 2)) <= 4 * 8 * 100


@pytest.mark.parametrize("edge", [0, 1], ids=["normal", "subnormal_edge"])
def test_hard_cancellations__all_but_a_few_bits__cancel(edge: int) -> None:
    unit = Unit(ADD)
    part = unit.size("mul_add", "hard") // 2
    rows = unit.operands("mul_add", "hard", edge * part + 777, 4000)
    assert len(rows) > 1000
    for a, b, c in rows.tolist():
        product, addend = value(a) * value(b), value(c)
        rest = abs(product + addend)
        assert rest and odd_part(rest) <= 8  # a remainder of 1 .. 8 times a power of two
        assert rest <= abs(product) / 4


def test_random_sums__alignment__every_distance_to_sixty() -> None:
    rows = Unit(ADD).operands("add", "random", 0, 400_000)
    exponents = (rows[:, :2] >> 23 & 0xFF).astype(int)
    distance = exponents[:, 0] - exponents[:, 1]
    assert set(range(-60, 61)) <= set(distance.tolist())


def test_cross_products__levels__hold_every_pair_once() -> None:
    unit = Unit(ADD)
    for level in ("level1", "level2"):
        values = unit.operands("sqrt", level, 0, unit.size("sqrt", level))[:, 0]
        assert len(set(values.tolist())) == len(values)
        assert unit.size("add", level) == len(values) ** 2
        assert unit.size("mul_add", level) == len(values) ** 3
    pairs = unit.operands("add", "level1", 0, unit.size("add", "level1"))[:, :2]
    assert len({tuple(pair) for pair in pairs.tolist()}) == len(pairs)


def test_exhaustive__first_and_last__numbers_beside_their_negatives() -> None:
    rows = Unit(ADD).operands("sqrt", "exhaustive", 0, 4)[:, 0].tolist()
    assert rows == [0, 0x80000000, 1, 0x80000001]
    last = Unit(ADD).operands("sqrt", "exhaustive", (1 << 32) - 2, 2)[:, 0].tolist()
    assert last == [0x7FFFFFFF, 0xFFFFFFFF]


def test_random__same_seed__same_cases_and_another_differs() -> None:
    unit = Unit(ADD)
    first = unit.operands("mul", "random", 100, 1000, seed=7)
    assert np.array_equal(first, unit.operands("mul", "random", 100, 1000, seed=7))
    assert not np.array_equal(first, unit.operands("mul", "random", 100, 1000, seed=8))
    assert not np.array_equal(first, unit.operands("mul", "random", 101, 1000, seed=7))


def test_run__kind_or_range_that_does_not_exist__is_refused() -> None:
    unit = Unit(ADD)
    with pytest.raises(BenchError, match="'add' has no cases of kind 'exhaustive'"):
        unit.run("add", "exhaustive")
    with pytest.raises(BenchError, match="random cases have no end; give a count"):
        unit.run("add", "random")
    with pytest.raises(BenchError, match="is beyond"):
        unit.run("add", "level1", start=1, count=unit.size("add", "level1"))
    with pytest.raises(BenchError, match="fp_add does not execute operation 'mul'"):
        unit.run("mul", "level1")
    with pytest.raises(BenchError, match="no unit 'fp_log'; known are fp_add"):
        Unit("fp_log")
