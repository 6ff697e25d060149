# SPDX-License-Identifier: Apache-2.0
"""Operands for the arithmetic units: corner values and exponent-correlated random numbers.

All functions return uint32 arrays of binary32 bits, one row per case where there are several
operands. Random ones take a `numpy.random.Generator` (see `tests.fpu.tb.generator`).
"""

from __future__ import annotations

import numpy as np

SIGN = np.uint32(0x8000_0000)

POSITIVE_CORNERS = np.array(
    [
        0x00000000,  # zero
        0x00000001,  # smallest subnormal
        0x00000002,
        0x00000003,
        0x00400000,  # half of the smallest normal
        0x003FFFFF,
        0x00555555,
        0x007FFFFE,
        0x007FFFFF,  # largest subnormal
        0x00800000,  # smallest normal
        0x00800001,
        0x00FFFFFF,
        0x01000000,
        0x01000001,
        0x0B800000,  # 2^-104
        0x1A000000,  # square is near the subnormal boundary
        0x1FFFFFFF,
        0x20000000,  # square is the smallest normal
        0x20000001,
        0x33000000,  # 2^-25, tie against one
        0x33800000,  # 2^-24
        0x33800001,
        0x34000000,  # 2^-23, ulp of one
        0x3EFFFFFF,
        0x3F000000,  # half
        0x3F000001,
        0x3F7FFFFF,  # one minus ulp/2
        0x3F800000,  # one
        0x3F800001,  # one plus ulp
        0x3FC00000,  # three halves
        0x3FFFFFFF,  # all-ones significand
        0x40000000,  # two
        0x40400000,  # three
        0x4B000000,  # 2^23
        0x4B7FFFFF,  # 2^24 - 1
        0x4B800000,  # 2^24
        0x4B800001,
        0x4EFFFFFF,  # largest below 2^31
        0x4F000000,  # 2^31
        0x4F7FFFFF,  # largest below 2^32
        0x5F7FFFFF,
        0x5F800000,  # square overflows
        0x7E800000,
        0x7EFFFFFF,
        0x7F000000,
        0x7F7FFFFE,
        0x7F7FFFFF,  # largest normal
        0x7F800000,  # infinity
        0x7F800001,  # signalling NaN
        0x7FBFFFFF,  # signalling NaN
        0x7FC00000,  # canonical NaN
        0x7FFFFFFF,  # quiet NaN with payload
    ],
    dtype=np.uint32,
)


def corners() -> np.ndarray:
    """Every corner value with both signs."""
    return np.concatenate((POSITIVE_CORNERS, POSITIVE_CORNERS | SIGN))


def cross(*columns: np.ndarray) -> np.ndarray:
    """Cross product of the columns, shape (product of lengths, number of columns)."""
    grids = np.meshgrid(*columns, indexing="ij")
    return np.stack([grid.ravel() for grid in grids], axis=1).astype(np.uint32)


def corner_rows(rng: np.random.Generator, columns: int) -> np.ndarray:
    """Corner values, every pair of them for two or three operands; the third is a random one."""
    rows = cross(*[corners()] * min(columns, 2))
    if columns < 3:
        return rows
    third = rng.choice(corners(), (len(rows), 1))
    return rng.permuted(np.concatenate((rows, third), axis=1), axis=1)


def thinned(rows: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """A random subset of at most `count` rows."""
    if len(rows) <= count:
        return rows
    return rows[rng.choice(len(rows), count, replace=False)]


def raw_bits(rng: np.random.Generator, count: int, columns: int) -> np.ndarray:
    """Uniform 32-bit patterns, shape (count, columns)."""
    return rng.integers(0, 1 << 32, (count, columns), dtype=np.uint32)


def fractions(rng: np.random.Generator, count: int) -> np.ndarray:
    """23-bit fractions: uniform, few ones, runs of ones, few zeros, one random high part."""
    uniform = rng.integers(0, 1 << 23, count, dtype=np.uint32)
    other = rng.integers(0, 1 << 23, count, dtype=np.uint32)
    third = rng.integers(0, 1 << 23, count, dtype=np.uint32)
    shift = rng.integers(0, 24, count, dtype=np.uint32)
    mask = np.uint32(0x7FFFFF)
    sparse = uniform & other & third
    choice = rng.integers(0, 8, count)
    return np.select(
        [choice < 3, choice == 3, choice == 4, choice == 5, choice == 6],
        [
            uniform,
            sparse,
            sparse ^ mask,
            (mask << shift) & mask,  # 1..10..0
            mask >> shift,  # 0..01..1
        ],
        (uniform << shift) & mask,  # few significant bits: exact sums and products, ties
    ).astype(np.uint32)


def with_exponents(rng: np.random.Generator, exponents: np.ndarray) -> np.ndarray:
    """Numbers of random sign and fraction with these biased exponents, clipped to 0..254."""
    field = np.clip(exponents, 0, 254).astype(np.uint32) << np.uint32(23)
    sign = rng.integers(0, 2, len(field), dtype=np.uint32) << np.uint32(31)
    return sign | field | fractions(rng, len(field))


def finite(rng: np.random.Generator, count: int) -> np.ndarray:
    """Finite numbers of uniform biased exponent, one in sixteen subnormal."""
    exponents = rng.integers(0, 255, count)
    return with_exponents(rng, np.where(rng.integers(0, 16, count) == 0, 0, exponents))


def mixed(rng: np.random.Generator, count: int, columns: int) -> np.ndarray:
    """Rows in which each operand is a corner value, a raw pattern or a finite number."""
    shape = (count, columns)
    corner = rng.choice(corners(), shape)
    random = finite(rng, count * columns).reshape(shape)
    kind = rng.integers(0, 4, shape)
    return np.select([kind == 0, kind == 1], [corner, raw_bits(rng, *shape)], random).astype(
        np.uint32
    )


def nudged(rng: np.random.Generator, bits: np.ndarray, ulps: int) -> np.ndarray:
    """Bits moved by up to `ulps` units in the last place (magnitude clipped to finite)."""
    magnitude = (bits & ~SIGN).astype(np.int64) + rng.integers(-ulps, ulps + 1, len(bits))
    return np.clip(magnitude, 0, 0x7F7FFFFF).astype(np.uint32) | (bits & SIGN)


def add_pairs(rng: np.random.Generator, count: int) -> np.ndarray:
    """(a, b) for addition, shape (count, 2).

    A quarter each: every alignment distance 0..30, cancellation of near neighbours, ties (b is an
    odd multiple of half an ulp of a) and sums around overflow or in the subnormal range.
    """
    part = count // 4
    a = finite(rng, part)
    aligned = np.stack((a, with_exponents(rng, _exponent(a) + rng.integers(-30, 31, part))), 1)

    a = finite(rng, part)
    near = nudged(rng, a, 3) ^ SIGN
    halved = with_exponents(rng, _exponent(a) + rng.integers(-1, 2, part))
    cancelling = np.stack((a, np.where(rng.integers(0, 2, part) == 0, near, halved)), 1)

    a = with_exponents(rng, rng.integers(1, 255, part))
    tie = with_exponents(rng, _exponent(a) - 24 + rng.integers(0, 3, part))
    keep = rng.choice(np.array([0xFF800000, 0xFFC00000, 0xFFE00000], dtype=np.uint32), part)
    ties = np.stack((a, tie & keep), 1)

    rest = count - 3 * part
    high = rng.integers(0, 2, rest) == 0
    edge = [
        with_exponents(rng, np.where(high, rng.integers(230, 255, rest), rng.integers(0, 4, rest)))
        for _ in range(2)
    ]
    return _shuffled(rng, np.concatenate((aligned, cancelling, ties, np.stack(edge, 1))))


def mul_pairs(rng: np.random.Generator, count: int) -> np.ndarray:
    """(a, b) for multiplication, shape (count, 2).

    A quarter each: anywhere, product exponent around overflow, product around and below the
    subnormal boundary, a subnormal operand.
    """
    part = count // 4
    anywhere = np.stack((finite(rng, part), finite(rng, part)), 1)
    over = _with_product_exponent(rng, rng.integers(250, 258, part))
    under = _with_product_exponent(rng, rng.integers(-26, 4, part))
    rest = count - 3 * part
    subnormal = fractions(rng, rest) >> rng.integers(0, 23, rest, dtype=np.uint32)
    other = with_exponents(rng, rng.integers(96, 255, rest))
    flip = rng.integers(0, 2, rest) == 0
    pair = np.stack((np.where(flip, subnormal, other), np.where(flip, other, subnormal)), 1)
    return _shuffled(rng, np.concatenate((anywhere, over, under, pair)).astype(np.uint32))


def fma_triples(rng: np.random.Generator, count: int) -> np.ndarray:
    """(a, b, c) for a * b + c, shape (count, 3).

    A fifth each: every alignment distance -55..55 of the addend, addend cancelling the product to
    few bits or exactly, anywhere, result around overflow, result around the subnormal boundary
    (the addend may cancel there too).
    """
    part = count // 5
    pairs = mul_pairs(rng, part)
    distance = rng.integers(-55, 56, part)
    aligned = _with_addend(pairs, with_exponents(rng, _product_exponent(pairs) + distance))

    pairs = mul_pairs(rng, part)
    cancelling = _with_addend(pairs, nudged(rng, _rounded_product(pairs) ^ SIGN, 2))

    pairs = np.stack((finite(rng, part), finite(rng, part)), 1)
    anywhere = _with_addend(pairs, finite(rng, part))

    pairs = _with_product_exponent(rng, rng.integers(250, 258, part))
    over = _with_addend(pairs, with_exponents(rng, rng.integers(225, 255, part)))

    rest = count - 4 * part
    pairs = _with_product_exponent(rng, rng.integers(-50, 28, rest))
    near = nudged(rng, _rounded_product(pairs) ^ SIGN, 4)
    small = with_exponents(rng, rng.integers(0, 28, rest))
    under = _with_addend(pairs, np.where(rng.integers(0, 3, rest) == 0, near, small))
    return _shuffled(rng, np.concatenate((aligned, cancelling, anywhere, over, under)))


def gaps(rng: np.random.Generator, cases: int) -> np.ndarray:
    """Issue pattern (see `tb.run`) with `cases` valid clocks: bursts and gaps of 0..12 clocks."""
    pattern: list[bool] = []
    left = cases
    while left:
        burst = min(int(rng.integers(1, 13)), left)
        pattern += [True] * burst + [False] * int(rng.integers(0, 13))
        left -= burst
    return np.array(pattern, dtype=bool)


def _exponent(bits: np.ndarray) -> np.ndarray:
    return ((bits >> np.uint32(23)) & np.uint32(0xFF)).astype(np.int64)


def _product_exponent(pairs: np.ndarray) -> np.ndarray:
    return _exponent(pairs[:, 0]) + _exponent(pairs[:, 1]) - 127


def _with_product_exponent(rng: np.random.Generator, target: np.ndarray) -> np.ndarray:
    """Pairs of normal numbers whose biased exponents sum to `target` + 127."""
    first = rng.integers(np.maximum(1, target + 127 - 254), np.minimum(254, target + 126) + 1)
    return np.stack((with_exponents(rng, first), with_exponents(rng, target + 127 - first)), 1)


def _with_addend(pairs: np.ndarray, addend: np.ndarray) -> np.ndarray:
    return np.concatenate((pairs, addend[:, None]), axis=1).astype(np.uint32)


def _rounded_product(pairs: np.ndarray) -> np.ndarray:
    """Bits of a * b rounded once: the product of two binary32 is exact in binary64."""
    with np.errstate(over="ignore"):
        a, b = (pairs[:, i].copy().view(np.float32).astype(np.float64) for i in (0, 1))
        return (a * b).astype(np.float32).view(np.uint32)


def _shuffled(rng: np.random.Generator, rows: np.ndarray) -> np.ndarray:
    return rng.permutation(rows.astype(np.uint32), axis=0)
