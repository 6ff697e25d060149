# SPDX-License-Identifier: Apache-2.0
"""fp_add against Berkeley SoftFloat: addition and subtraction."""

import numpy as np
import pytest

from sim.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, check, check_reset, generator, single

UNIT = Unit("fp_add", (("sub_i", 1), ("a_i", 32), ("b_i", 32)))
OPERATIONS = {
    "add": Operation("add", UNIT, ("a_i", "b_i"), reference.add, {"sub_i": 0}),
    "sub": Operation("sub", UNIT, ("a_i", "b_i"), reference.sub, {"sub_i": 1}),
}
ONE = 0x3F800000

# name -> operation, operands, result bits, flags
DIRECTED = {
    "exact_cancellation_is_plus_zero": ("sub", (ONE, ONE), 0x00000000, 0b00000),
    "minus_zeros_keep_their_sign": ("add", (0x80000000, 0x80000000), 0x80000000, 0b00000),
    "infinity_minus_infinity_is_invalid": ("sub", (0x7F800000, 0x7F800000), 0x7FC00000, 0b10000),
    "tie_goes_to_even": ("add", (ONE, 0x33800000), ONE, 0b00001),
    "tie_above_odd_rounds_up": ("add", (0x3F800001, 0x33800000), 0x3F800002, 0b00001),
    "far_smaller_operand_is_only_inexact": ("sub", (ONE, 0x00000001), ONE, 0b00001),
    "difference_of_normals_may_be_subnormal": (
        "sub",
        (0x00800001, 0x00800000),
        0x00000001,
        0b00000,
    ),
    "largest_doubled_overflows": ("add", (0x7F7FFFFF, 0x7F7FFFFF), 0x7F800000, 0b00101),
    "signalling_nan_raises_invalid": ("add", (ONE, 0xFFA00000), 0x7FC00000, 0b10000),
}


@pytest.mark.parametrize("name", DIRECTED)
def test_reference__named_case__gives_the_stated_result(name: str) -> None:
    operation, operands, bits, flags = DIRECTED[name]
    assert single(OPERATIONS[operation].reference, *operands) == (bits, flags)


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__named_and_corner_pairs__match_reference(name: str) -> None:
    named = [case[1] for case in DIRECTED.values() if case[0] == name]
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    check(OPERATIONS[name], np.concatenate((np.array(named, dtype=np.uint32), corners)))


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__random_pairs__match_reference(name: str) -> None:
    rng = generator(f"add random {name}")
    rows = (stimulus.add_pairs(rng, 100_000), stimulus.mixed(rng, 50_000, 2))
    check(OPERATIONS[name], np.concatenate(rows))


def test_add__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("add gaps")
    check(OPERATIONS["add"], stimulus.add_pairs(rng, 2000), issue=stimulus.gaps(rng, 2000))


def test_add__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
