# SPDX-License-Identifier: Apache-2.0
"""fp_mul against Berkeley SoftFloat."""

import numpy as np
import pytest

from sim.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, check, check_reset, generator, single

UNIT = Unit("fp_mul", (("a_i", 32), ("b_i", 32)))
MUL = Operation("mul", UNIT, ("a_i", "b_i"), reference.mul)

# name -> operands, result bits, flags
DIRECTED = {
    "rounds_up_to_smallest_normal_but_is_tiny": (0x00FFFFFF, 0x3F000000, 0x00800000, 0b00011),
    "subnormal_operand_rounds_to_normal_not_tiny": (0x007FFFFF, 0x3F800001, 0x00800000, 0b00001),
    "zero_times_infinity_is_invalid": (0x00000000, 0x7F800000, 0x7FC00000, 0b10000),
    "smallest_subnormals_underflow_to_zero": (0x00000001, 0x00000001, 0x00000000, 0b00011),
    "largest_squared_overflows": (0x7F7FFFFF, 0xFF7FFFFF, 0xFF800000, 0b00101),
    "signalling_nan_raises_invalid": (0x7F800001, 0x3F800000, 0x7FC00000, 0b10000),
    "quiet_nan_is_silent": (0xFFC12345, 0x3F800000, 0x7FC00000, 0b00000),
}


@pytest.mark.parametrize("name", DIRECTED)
def test_mul__reference_agrees_with_named_case(name: str) -> None:
    a, b, bits, flags = DIRECTED[name]
    assert single(reference.mul, a, b) == (bits, flags)


def test_mul__named_and_corner_pairs__match_reference() -> None:
    named = np.array([case[:2] for case in DIRECTED.values()], dtype=np.uint32)
    check(MUL, np.concatenate((named, stimulus.cross(stimulus.corners(), stimulus.corners()))))


def test_mul__random_pairs__match_reference() -> None:
    rng = generator("mul")
    check(MUL, np.concatenate((stimulus.mul_pairs(rng, 100_000), stimulus.mixed(rng, 50_000, 2))))


def test_mul__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("mul gaps")
    check(MUL, stimulus.mul_pairs(rng, 2000), issue=stimulus.gaps(rng, 2000))


def test_mul__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
