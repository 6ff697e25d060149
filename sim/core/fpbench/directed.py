# SPDX-License-Identifier: Apache-2.0
"""Directed cases with their results written out, each named by what goes wrong in a faulty unit."""

from __future__ import annotations

from sim.core.backends import FLAG_NAMES

# name: operation, operands = result, flags. The first pair separates tininess after rounding from
# tininess before: both round up to the least normal number, but with unbounded exponent only the
# first would still be below it.
_TEXT = """
tiny_after_rounding_underflows: mul 00ffffff 3f000000 = 00800000 uf nx
not_tiny_after_rounding_is_inexact_alone: mul 007fffff 3f800001 = 00800000 nx
fused_tiny_after_rounding_underflows: fma_mul 00ffffff 3f000000 = 00800000 uf nx
fused_not_tiny_after_rounding_is_inexact_alone: fma_mul 007fffff 3f800001 = 00800000 nx
least_normal_minus_a_tiny_product_underflows_not: mul_add 00800000 80000001 00800000 = 00800000 nx
exact_subnormal_difference_raises_nothing: sub 00800001 00800000 = 00000001
exact_cancellation_gives_plus_zero: sub bf800000 bf800000 = 00000000
sum_of_negative_zeros_keeps_the_sign: add 80000000 80000000 = 80000000
largest_number_plus_half_ulp_overflows: add 7f7fffff 73000000 = 7f800000 of nx
tie_goes_to_even: add 3f800000 33800000 = 3f800000 nx
tie_goes_up_to_even: add 3f800001 33800000 = 3f800002 nx
zero_times_infinity_with_quiet_nan_is_invalid: mul_add 00000000 7f800000 7fc00001 = 7fc00000 nv
one_third: div 3f800000 40400000 = 3eaaaaab nx
number_over_zero: div bf800000 00000000 = ff800000 dz
zero_over_zero: div 00000000 80000000 = 7fc00000 nv
quotient_rounds_up_to_the_least_normal_and_underflows: div 00ffffff 40000000 = 00800000 uf nx
root_of_minus_zero: sqrt 80000000 = 80000000
root_of_a_negative_number: sqrt bf800000 = 7fc00000 nv
root_of_the_least_subnormal: sqrt 00000001 = 1a3504f3 nx
signum_of_minus_zero: sgn 80000000 = 00000000
negation_keeps_a_signalling_nan: neg 7f800001 = ff800001
integer_rounds_up_to_a_power_of_two: i2f 7fffffff = 4f000000 nx
least_integer_is_exact: i2f 80000000 = cf000000
conversion_of_two_to_the_31_saturates: f2i 4f000000 = 7fffffff nv
conversion_of_the_least_integer_is_exact: f2i cf000000 = 80000000
sine_of_the_largest_angle: sin 43800000 = bf7fcc19 nx
sine_beyond_the_largest_angle_is_invalid: sin 43800001 = 7fc00000 nv
sine_nearest_to_a_multiple_of_a_quarter_turn: cos 437ce5f1 = b18fd1de nx
"""


def _case(line: str) -> tuple[str, tuple[str, tuple[int, ...], int, int]]:
    name, _, text = line.partition(": ")
    question, _, answer = text.partition(" = ")
    op, *operands = question.split()
    result, *flags = answer.split()
    raised = sum(16 >> FLAG_NAMES.index(flag) for flag in flags)
    return name, (op, tuple(int(word, 16) for word in operands), int(result, 16), raised)


# name -> operation, operands, result, flags {nv,dz,of,uf,nx}
DIRECTED = dict(map(_case, _TEXT.split("\n")[1:-1]))


def rows_of(op: str) -> list[tuple[int, ...]]:
    """Operands of the directed cases of an operation."""
    return [operands for name, operands, _, _ in DIRECTED.values() if name == op]
