# SPDX-License-Identifier: Apache-2.0
"""fp_cmp against SoftFloat comparisons and the selection rules of IEEE 754-2019 on top of them."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.isa import default_isa
from sim.fpbench import softfloat as reference
from tests.asip import operation_cases
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, check, check_reset, generator, package_constant, single

UNIT = Unit("fp_cmp", (("op_i", 4), ("a_i", 32), ("b_i", 32), ("c_i", 32)))
CASES = 100_000


def operation(name: str) -> Operation:
    count, function = reference.COMPARISONS[name]
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
                [near, first, near ^ stimulus.SIGN],
                stimulus.finite(rng, count),
            ).astype(np.uint32)
        )
    return np.stack(rows, axis=1)


@pytest.mark.parametrize("name", reference.COMPARISONS)
def test_cmp__corners_and_random_operands__match_reference(name: str) -> None:
    columns = reference.COMPARISONS[name][0]
    rng = generator(f"cmp {name}")
    crossed = stimulus.corner_rows(rng, columns)
    random = [neighbours(rng, CASES, columns), stimulus.mixed(rng, CASES // 2, columns)]
    check(operation(name), np.concatenate([crossed, *random, by_hand(name)]).astype(np.uint32))


def by_hand(name: str) -> np.ndarray:
    """Operands of the operation's cases in operation_cases, whose results the reference gives."""
    mnemonic = default_isa().comparisons[name].name
    cases = [case[1:] for case in operation_cases.CASES if case[0] == mnemonic]
    rows = np.array([operands for operands, _, _ in cases], dtype=np.uint32)
    bits, flags = reference.COMPARISONS[name][1](*rows.T)
    assert [(int(b), int(f)) for b, f in zip(bits, flags, strict=True)] == [c[1:] for c in cases]
    return rows


def test_cmp__every_opcode__is_distinct() -> None:
    codes = [package_constant(f"FP_CMP_{name}") for name in reference.COMPARISONS]
    assert codes == [r.control["cmp_op"] for r in default_isa().comparisons.values()]
    assert len(set(codes)) == len(codes)


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
    assert single(reference.COMPARISONS[op][1], *operands) == (bits, flags)
    check(operation(op), np.array([operands]))


def test_cmp__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("cmp gaps")
    check(operation("MAX"), stimulus.mixed(rng, 2000, 2), issue=stimulus.gaps(rng, 2000))


def test_cmp__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
