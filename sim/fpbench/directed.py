# SPDX-License-Identifier: Apache-2.0
"""Directed cases with their results written out, each named by what goes wrong in a faulty unit."""

from __future__ import annotations

# name -> operation, operands, result, flags {nv,dz,of,uf,nx}
DIRECTED: dict[str, tuple[str, tuple[int, ...], int, int]] = {
    # The pair that separates tininess after rounding from tininess before: both round up to the
    # least normal number, but with unbounded exponent only the first would still be below it.
    "tiny_after_rounding_underflows": ("mul", (0x00FFFFFF, 0x3F000000), 0x00800000, 0b00011),
    "not_tiny_after_rounding_is_inexact_alone": (
        "mul",
        (0x007FFFFF, 0x3F800001),
        0x00800000,
        0b00001,
    ),
    "fused_tiny_after_rounding_underflows": (
        "fma_mul",
        (0x00FFFFFF, 0x3F000000),
        0x00800000,
        0b00011,
    ),
    "fused_not_tiny_after_rounding_is_inexact_alone": (
        "fma_mul",
        (0x007FFFFF, 0x3F800001),
        0x00800000,
        0b00001,
    ),
    "least_normal_minus_a_tiny_product_underflows_not": (
        "mul_add",
        (0x00800000, 0x80000001, 0x00800000),
        0x00800000,
        0b00001,
    ),
    "exact_subnormal_difference_raises_nothing": ("sub", (0x00800001, 0x00800000), 0x00000001, 0),
    "exact_cancellation_gives_plus_zero": ("sub", (0xBF800000, 0xBF800000), 0x00000000, 0),
    "sum_of_negative_zeros_keeps_the_sign": ("add", (0x80000000, 0x80000000), 0x80000000, 0),
    "largest_number_plus_half_ulp_overflows": (
        "add",
        (0x7F7FFFFF, 0x73000000),
        0x7F800000,
        0b00101,
    ),
    "tie_goes_to_even": ("add", (0x3F800000, 0x33800000), 0x3F800000, 0b00001),
    "tie_goes_up_to_even": ("add", (0x3F800001, 0x33800000), 0x3F800002, 0b00001),
    "zero_times_infinity_with_quiet_nan_is_invalid": (
        "mul_add",
        (0x00000000, 0x7F800000, 0x7FC00001),
        0x7FC00000,
        0b10000,
    ),
    "one_third": ("div", (0x3F800000, 0x40400000), 0x3EAAAAAB, 0b00001),
    "number_over_zero": ("div", (0xBF800000, 0x00000000), 0xFF800000, 0b01000),
    "zero_over_zero": ("div", (0x00000000, 0x80000000), 0x7FC00000, 0b10000),
    "quotient_rounds_up_to_the_least_normal_and_underflows": (
        "div",
        (0x00FFFFFF, 0x40000000),
        0x00800000,
        0b00011,
    ),
    "root_of_minus_zero": ("sqrt", (0x80000000,), 0x80000000, 0),
    "root_of_a_negative_number": ("sqrt", (0xBF800000,), 0x7FC00000, 0b10000),
    "root_of_the_least_subnormal": ("sqrt", (0x00000001,), 0x1A3504F3, 0b00001),
    "signum_of_minus_zero": ("sgn", (0x80000000,), 0x00000000, 0),
    "negation_keeps_a_signalling_nan": ("neg", (0x7F800001,), 0xFF800001, 0),
    "integer_rounds_up_to_a_power_of_two": ("i2f", (0x7FFFFFFF,), 0x4F000000, 0b00001),
    "least_integer_is_exact": ("i2f", (0x80000000,), 0xCF000000, 0),
    "conversion_of_two_to_the_31_saturates": ("f2i", (0x4F000000,), 0x7FFFFFFF, 0b10000),
    "conversion_of_the_least_integer_is_exact": ("f2i", (0xCF000000,), 0x80000000, 0),
    "sine_of_the_largest_angle": ("sin", (0x43800000,), 0xBF7FCC19, 0b00001),
    "sine_beyond_the_largest_angle_is_invalid": ("sin", (0x43800001,), 0x7FC00000, 0b10000),
    "sine_nearest_to_a_multiple_of_a_quarter_turn": ("cos", (0x437CE5F1,), 0xB18FD1DE, 0b00001),
}


def rows_of(op: str) -> list[tuple[int, ...]]:
    """Operands of the directed cases of an operation."""
    return [operands for name, operands, _, _ in DIRECTED.values() if name == op]
