# SPDX-License-Identifier: Apache-2.0
"""Facts the unit tests rely on: SoftFloat's modes, NaN results and the flag order."""

from sim.core.backends import flag_text
from sim.core.fpbench import softfloat as reference
from tests.fpu.tb import single


def test_nan_results__any_payload__canonical() -> None:
    assert single(reference.add, 0xFFC12345, 0x3F800000) == (0x7FC00000, 0)
    assert single(reference.sqrt, 0xBF800000) == (0x7FC00000, 0b10000)


def test_mul_add__zero_times_infinity_plus_quiet_nan__raises_invalid() -> None:
    assert single(reference.mul_add, 0, 0x7F800000, 0x7FC00001) == (0x7FC00000, 0b10000)


def test_flags__each_exception__has_its_own_bit() -> None:
    assert single(reference.div, 0x3F800000, 0) == (0x7F800000, 0b01000)
    assert single(reference.add, 0x7F7FFFFF, 0x7F7FFFFF) == (0x7F800000, 0b00101)
    assert single(reference.mul, 0x00800001, 0x3F000000) == (0x00400000, 0b00011)
    assert flag_text(0b00101) == "of nx"
    assert flag_text(0) == "-"


def test_tininess__rounded_up_to_smallest_normal__detected_after_rounding() -> None:
    assert single(reference.mul, 0x00FFFFFF, 0x3F000000) == (0x00800000, 0b00011)
    assert single(reference.mul, 0x007FFFFF, 0x3F800001) == (0x00800000, 0b00001)


def test_integers__conversions__round_trip_with_flags() -> None:
    assert single(reference.i32_to_f32, 0xFFFFFFFF) == (0xBF800000, 0)
    assert single(reference.i32_to_f32, 0x7FFFFFFF) == (0x4F000000, 0b00001)
    assert single(reference.f32_to_i32, 0xBFC00000) == (0xFFFFFFFF, 0b00001)
    assert single(reference.f32_to_i32, 0x4F000000) == (0x7FFFFFFF, 0b10000)


def test_comparisons__quiet_nan__only_ordered_ones_raise_invalid() -> None:
    assert single(reference.eq, 0x7FC00000, 0x3F800000) == (0, 0)
    assert single(reference.lt, 0x7FC00000, 0x3F800000) == (0, 0b10000)
    assert single(reference.le, 0x3F800000, 0x3F800000) == (1, 0)
