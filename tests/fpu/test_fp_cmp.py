# SPDX-License-Identifier: Apache-2.0
"""fp_cmp against SoftFloat comparisons and the selection rules of IEEE 754-2019 on top of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.fpu import reference, stimulus
from tests.fpu.tb import Operation, Unit, check, check_reset, generator, package_constant

UNIT = Unit(
    "fp_cmp",
    latency=package_constant("FP_CMP_LATENCY"),
    inputs=(("op_i", 4), ("a_i", 32), ("b_i", 32), ("c_i", 32)),
)

ONE, CANON_NAN = np.uint32(0x3F800000), np.uint32(0x7FC00000)
INVALID = np.uint8(0b10000)
SIGN = stimulus.SIGN
CASES = 100_000


def _is_nan(x: np.ndarray) -> np.ndarray:
    return (x & ~SIGN) > 0x7F800000


def _is_snan(x: np.ndarray) -> np.ndarray:
    return _is_nan(x) & (x & 0x00400000 == 0)


def _as_float(compare: Callable) -> Callable:
    """A SoftFloat predicate with its 0 or 1 as 0.0 or 1.0."""

    def function(a: np.ndarray, b: np.ndarray) -> reference.Result:
        bits, flags = compare(a, b)
        return bits * ONE, flags

    return function


def _quiet(compare: Callable, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Truth of a SoftFloat predicate, flags dropped."""
    return compare(a, np.broadcast_to(np.uint32(b), a.shape))[0] == 1


def _invalid(condition: np.ndarray) -> np.ndarray:
    return np.where(condition, INVALID, 0).astype(np.uint8)


def _extremum(want_less: bool) -> Callable:
    """minimumNumber / maximumNumber: a number beats a NaN, -0 is below +0."""

    def function(a: np.ndarray, b: np.ndarray) -> reference.Result:
        zeros = ((a | b) & ~SIGN) == 0
        a_below = np.where(zeros, a > b, reference.le(a, b)[0] == 1)
        number = np.where(a_below == want_less, a, b)
        bits = np.select(
            [_is_nan(a) & _is_nan(b), _is_nan(a), _is_nan(b)], [CANON_NAN, b, a], number
        )
        return bits, _invalid(_is_snan(a) | _is_snan(b))

    return function


def _sgn(a: np.ndarray) -> reference.Result:
    bits = np.select(
        [_is_nan(a), _quiet(reference.lt, a, 0), _quiet(reference.eq, a, 0)],
        [CANON_NAN, ONE | SIGN, np.uint32(0)],
        ONE,
    )
    return bits, _invalid(_is_snan(a))


def _sat(a: np.ndarray, low: np.ndarray, high: np.ndarray) -> reference.Result:
    nan = _is_nan(a) | _is_nan(low) | _is_nan(high)
    exchanged = ~nan & _quiet(reference.lt, high, low)
    bits = np.select(
        [nan | exchanged, _quiet(reference.lt, a, low), _quiet(reference.lt, high, a)],
        [CANON_NAN, low, high],
        a,
    )
    return bits, _invalid(_is_snan(a) | _is_snan(low) | _is_snan(high) | exchanged)


def _silent(function: Callable) -> Callable:
    return lambda *operands: (
        function(*operands).astype(np.uint32),
        np.zeros(len(operands[0]), np.uint8),
    )


def _select(condition: Callable) -> Callable:
    return _silent(lambda a, b, c: np.where(condition(a), b, c))


# operation -> operand count, reference. A NaN condition of a selection takes c.
REFERENCES = {
    "EQ": (2, _as_float(reference.eq)),
    "LT": (2, _as_float(reference.lt)),
    "LE": (2, _as_float(reference.le)),
    "MIN": (2, _extremum(True)),
    "MAX": (2, _extremum(False)),
    "ABS": (1, _silent(lambda a: a & ~SIGN)),
    "NEG": (1, _silent(lambda a: a ^ SIGN)),
    "MOV": (1, _silent(lambda a: a)),
    "SGN": (1, _sgn),
    "SAT": (3, _sat),
    "SEL": (3, _select(lambda a: ~_is_nan(a) & ~_quiet(reference.eq, a, 0))),
    "SELGE": (3, _select(lambda a: reference.le(np.zeros_like(a), a)[0] == 1)),
    "SELGT": (3, _select(lambda a: reference.lt(np.zeros_like(a), a)[0] == 1)),
    "IADD": (2, _silent(lambda a, b: a + b)),
    "ISUB": (2, _silent(lambda a, b: a - b)),
}


def operation(name: str) -> Operation:
    count, function = REFERENCES[name]
    opcode = package_constant(f"FP_CMP_{name}")
    return Operation(name, UNIT, ("a_i", "b_i", "c_i")[:count], function, {"op_i": opcode})


def neighbours(rng: np.random.Generator, count: int, columns: int) -> np.ndarray:
    """Rows whose operands are equal, a few ulps apart, of opposite sign, or unrelated."""
    first = stimulus.finite(rng, count)
    rows = [first]
    for _ in range(columns - 1):
        near = stimulus.nudged(rng, first, 2)
        kind = rng.integers(0, 8, count)
        rows.append(
            np.select(
                [kind < 4, kind == 4, kind == 5],
                [near, first, near ^ SIGN],
                stimulus.finite(rng, count),
            ).astype(np.uint32)
        )
    return np.stack(rows, axis=1)


@pytest.mark.parametrize("name", REFERENCES)
def test_cmp__corners_and_random_operands__match_reference(name: str) -> None:
    columns = REFERENCES[name][0]
    rng = generator(f"cmp {name}")
    crossed = stimulus.cross(*[stimulus.corners()] * min(columns, 2))
    if columns == 3:
        third = rng.choice(stimulus.corners(), (len(crossed), 1))
        crossed = rng.permuted(np.concatenate((crossed, third), axis=1), axis=1)
    random = [neighbours(rng, CASES, columns), stimulus.mixed(rng, CASES // 2, columns)]
    check(operation(name), np.concatenate([crossed, *random]).astype(np.uint32))


def test_cmp__every_opcode__is_distinct() -> None:
    codes = [package_constant(f"FP_CMP_{name}") for name in REFERENCES]
    assert sorted(codes) == list(range(len(codes)))


# name -> operation, operands, result, flags: the rules stated in fp_pkg, written out
DIRECTED = {
    "eq_quiet_nan_is_silent": ("EQ", (0x7FC00000, 0x7FC00000), 0, 0),
    "lt_quiet_nan_is_invalid": ("LT", (0x7FC00000, 0x3F800000), 0, 16),
    "zeros_are_equal": ("EQ", (0x80000000, 0), 0x3F800000, 0),
    "min_orders_zeros": ("MIN", (0, 0x80000000), 0x80000000, 0),
    "max_orders_zeros": ("MAX", (0x80000000, 0), 0, 0),
    "min_prefers_number_and_reports_signalling": ("MIN", (0x7F800001, 0x40000000), 0x40000000, 16),
    "max_of_nans_is_canonical": ("MAX", (0x7FC12345, 0xFFC00001), 0x7FC00000, 0),
    "abs_keeps_payload": ("ABS", (0xFF812345,), 0x7F812345, 0),
    "sgn_drops_sign_of_zero": ("SGN", (0x80000000,), 0, 0),
    "sat_exchanged_limits_are_invalid": ("SAT", (0x3F800000, 0x40000000, 0), 0x7FC00000, 16),
    "sat_equal_limits_clamp": ("SAT", (0x3F800000, 0x40000000, 0x40000000), 0x40000000, 0),
    "sel_nan_condition_takes_c": ("SEL", (0x7FC00000, 1, 2), 2, 0),
    "selge_negative_zero_takes_b": ("SELGE", (0x80000000, 1, 2), 1, 0),
    "selgt_zero_takes_c": ("SELGT", (0, 1, 2), 2, 0),
    "iadd_wraps": ("IADD", (0xFFFFFFFF, 2), 1, 0),
}


@pytest.mark.parametrize("name", DIRECTED)
def test_cmp__directed__unit_and_reference_agree_with_named_case(name: str) -> None:
    op, operands, bits, flags = DIRECTED[name]
    row = np.array([operands], dtype=np.uint32)
    got_bits, got_flags = REFERENCES[op][1](*row.T)
    assert (int(got_bits[0]), int(got_flags[0])) == (bits, flags)
    check(operation(op), row)


def test_cmp__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("cmp gaps")
    check(operation("MAX"), stimulus.mixed(rng, 2000, 2), issue=stimulus.gaps(rng, 2000))


def test_cmp__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
