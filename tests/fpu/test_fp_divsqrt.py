# SPDX-License-Identifier: Apache-2.0
"""fp_divsqrt against Berkeley SoftFloat."""

import math
from collections.abc import Callable

import numpy as np

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator, run

UNIT = Unit("fp_divsqrt", (("sqrt_i", 1), ("a_i", 32), ("b_i", 32)))
DIV = Operation("div", UNIT, ("a_i", "b_i"), reference.div, {"sqrt_i": 0})
SQRT = Operation("sqrt", UNIT, ("a_i",), reference.sqrt, {"sqrt_i": 1})


def quotients(rng: np.random.Generator, count: int) -> np.ndarray:
    """(a, b), a sixth each: anywhere, quotient around overflow, quotient in and below the subnormal
    range, subnormal operands, exact quotients (a = q b) and quotients next to a rounding boundary
    or next to one (a = q b rounded, moved by an ulp)."""
    part = count // 6
    anywhere = np.stack((stimulus.finite(rng, part), stimulus.finite(rng, part)), 1)
    rows = [anywhere]
    for low, high in ((250, 258), (-27, 4)):
        exponent = rng.integers(low, high, part)
        below = rng.integers(np.maximum(1, 128 - exponent), np.minimum(254, 381 - exponent) + 1)
        below = np.clip(below, 1, 254)
        rows.append(
            np.stack(
                (
                    stimulus.with_exponents(rng, np.clip(exponent + below - 127, 1, 254)),
                    stimulus.with_exponents(rng, below),
                ),
                1,
            )
        )
    small = stimulus.fractions(rng, part) >> rng.integers(0, 23, part, dtype=np.uint32)
    other = np.where(
        rng.integers(0, 2, part) == 0,
        stimulus.with_exponents(rng, rng.integers(0, 160, part)),
        small[::-1],
    )
    flip = rng.integers(0, 2, part) == 0
    rows.append(np.stack((np.where(flip, small, other), np.where(flip, other, small)), 1))
    for short in (True, False):
        q, b = (stimulus.with_exponents(rng, rng.integers(70, 180, part)) for _ in range(2))
        if short:  # 12 significant bits each: the product is exact
            q, b = q & np.uint32(0xFFFFF000), b & np.uint32(0xFFFFF000)
        a = (q.view(np.float32).astype(np.float64) * b.view(np.float32)).astype(np.float32)
        a = a.view(np.uint32)
        rows.append(np.stack((a if short else stimulus.nudged(rng, a, 1), b), 1))
    return rng.permutation(np.concatenate(rows).astype(np.uint32), axis=0)


def radicands(rng: np.random.Generator, count: int) -> np.ndarray:
    """Anywhere, exact squares, squares moved by an ulp, subnormals, one in sixteen negative."""
    part = count // 4
    root = rng.integers(1 << 11, 1 << 12, part).astype(np.float64)
    squares = (root * root * 4.0 ** rng.integers(-70, 50, part)).astype(np.float32).view(np.uint32)
    root = 1.0 + rng.integers(0, 1 << 23, part) * 2.0**-23
    near = (root * root * 2.0 ** rng.integers(-120, 120, part)).astype(np.float32).view(np.uint32)
    small = stimulus.fractions(rng, part) >> rng.integers(0, 23, part, dtype=np.uint32)
    anywhere = stimulus.finite(rng, count - 3 * part)
    rows = np.concatenate((squares, stimulus.nudged(rng, near, 1), small, anywhere))
    negative = rng.integers(0, 16, len(rows)) == 0
    return rng.permutation(np.where(negative, rows | stimulus.SIGN, rows & ~stimulus.SIGN))


def test_div__named_and_corner_pairs__match_reference() -> None:
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    check(DIV, np.concatenate((by_hand(DIV, "fdiv"), corners)))


def test_div__random_pairs__match_reference() -> None:
    rng = generator("div")
    check(DIV, np.concatenate((quotients(rng, 120_000), stimulus.mixed(rng, 50_000, 2))))


def test_sqrt__named_corner_and_random_operands__match_reference() -> None:
    rng = generator("sqrt")
    parts = (stimulus.corners(), radicands(rng, 120_000), stimulus.mixed(rng, 50_000, 1)[:, 0])
    check(SQRT, np.concatenate((by_hand(SQRT, "fsqrt")[:, 0], *parts))[:, None])


def test_sqrt__squares_of_integers__are_exact() -> None:
    squares = np.arange(1, 4096, dtype=np.float32) ** 2
    got = run(UNIT, {"a_i": squares.view(np.uint32), "sqrt_i": 1})
    assert [math.isqrt(int(x)) for x in squares] == list(got["result_o"].view(np.float32))
    assert not got["flags_o"].any()


def check_interleaved(unit: Unit, name: str, gaps: Callable[..., np.ndarray]) -> None:
    """Divisions and roots in random order, `gaps(rng, cases)` apart, match the reference."""
    rng = generator(name)
    rows, roots = stimulus.mixed(rng, 4000, 2), rng.integers(0, 2, 4000, dtype=np.uint32)
    inputs = {"sqrt_i": roots, "a_i": rows[:, 0], "b_i": rows[:, 1]}
    got = run(unit, inputs, issue=gaps(rng, 4000))
    of_div, of_sqrt = reference.div(*rows.T), reference.sqrt(rows[:, 0])
    for port, want_div, want_sqrt in zip(("result_o", "flags_o"), of_div, of_sqrt, strict=True):
        assert np.array_equal(got[port], np.where(roots == 1, want_sqrt, want_div)), port


def test_divsqrt__operations_interleaved_with_gaps__match_reference() -> None:
    check_interleaved(UNIT, "divsqrt mix", stimulus.gaps)


def test_divsqrt__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
