# SPDX-License-Identifier: Apache-2.0
"""fp_fma against Berkeley SoftFloat: every kind and sign of the operation."""

import numpy as np
import pytest

from sim.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, check, check_reset, generator, package_constant, single

UNIT = Unit(
    "fp_fma",
    (
        ("kind_i", 2),
        ("neg_product_i", 1),
        ("neg_addend_i", 1),
        ("a_i", 32),
        ("b_i", 32),
        ("c_i", 32),
    ),
)


def _controls(kind: str, neg_product: int, neg_addend: int) -> dict[str, int]:
    return {
        "kind_i": package_constant(f"FMA_KIND_{kind}"),
        "neg_product_i": neg_product,
        "neg_addend_i": neg_addend,
    }


_PRODUCT = {"kind_i": package_constant("FMA_KIND_MUL")}
_ABC, _AB, _AC = ("a_i", "b_i", "c_i"), ("a_i", "b_i"), ("a_i", "c_i")
OPERATIONS = {
    operation.name: operation
    for operation in (
        Operation("fmadd", UNIT, _ABC, reference.mul_add, _controls("FMA", 0, 0)),
        Operation("fmsub", UNIT, _ABC, reference.mul_sub, _controls("FMA", 0, 1)),
        Operation("fnmadd", UNIT, _ABC, reference.neg_mul_sub, _controls("FMA", 1, 1)),
        Operation("fnmsub", UNIT, _ABC, reference.neg_mul_add, _controls("FMA", 1, 0)),
        Operation("mul", UNIT, _AB, reference.mul, {**_PRODUCT, "neg_product_i": 0}),
        Operation("nmul", UNIT, _AB, reference.neg_mul, {**_PRODUCT, "neg_product_i": 1}),
        Operation("add", UNIT, _AC, reference.add, _controls("ADD", 0, 0)),
        Operation("sub", UNIT, _AC, reference.sub, _controls("ADD", 0, 1)),
    )
}
ONE, MINUS_ONE = 0x3F800000, 0xBF800000

# name -> operation, operands, result bits, flags
DIRECTED = {
    "mul_rounds_up_to_smallest_normal_but_is_tiny": (
        ("mul", (0x00FFFFFF, 0x3F000000)),
        (0x00800000, 0b00011),
    ),
    "mul_subnormal_operand_rounds_to_normal_not_tiny": (
        ("mul", (0x007FFFFF, 0x3F800001)),
        (0x00800000, 0b00001),
    ),
    "fmadd_same_product_plus_zero_is_tiny": (
        ("fmadd", (0x00FFFFFF, 0x3F000000, 0x00000000)),
        (0x00800000, 0b00011),
    ),
    "fmadd_same_product_plus_zero_not_tiny": (
        ("fmadd", (0x007FFFFF, 0x3F800001, 0x00000000)),
        (0x00800000, 0b00001),
    ),
    "fmadd_zero_times_infinity_plus_quiet_nan_is_invalid": (
        ("fmadd", (0x00000000, 0x7F800000, 0x7FC00001)),
        (0x7FC00000, 0b10000),
    ),
    "fmadd_infinity_minus_infinity_is_invalid": (
        ("fmadd", (0x7F800000, ONE, 0xFF800000)),
        (0x7FC00000, 0b10000),
    ),
    "fmadd_quiet_nan_factor_hides_opposite_infinities": (
        ("fmadd", (0x7F800000, 0x7FC00000, 0xFF800000)),
        (0x7FC00000, 0b00000),
    ),
    "fmadd_exact_cancellation_is_plus_zero": (
        ("fmadd", (0x40000000, MINUS_ONE, 0x40000000)),
        (0x00000000, 0b00000),
    ),
    "fmadd_single_rounding_keeps_low_product": (
        ("fmadd", (0x3F800001, 0x3F800001, 0xBF800002)),
        (0x28800000, 0b00000),
    ),
    "fmadd_product_far_below_smallest_normal_addend": (
        ("fmadd", (0x80000001, 0x00000001, 0x00800000)),
        (0x00800000, 0b00001),
    ),
    "fmadd_zero_product_of_huge_factor_keeps_addend": (
        ("fmadd", (0x00000000, 0x7F7FFFFF, 0x00000001)),
        (0x00000001, 0b00000),
    ),
    "nmul_of_zero_is_minus_zero": (("nmul", (0x00000000, ONE)), (0x80000000, 0b00000)),
    "add_of_minus_zeros_is_minus_zero": (
        ("add", (0x80000000, 0x80000000)),
        (0x80000000, 0b00000),
    ),
}


def _directed(operation: str) -> np.ndarray:
    rows = [case[0][1] for case in DIRECTED.values() if case[0][0] == operation]
    return np.array(rows, dtype=np.uint32).reshape(-1, len(OPERATIONS[operation].operands))


@pytest.mark.parametrize("name", DIRECTED)
def test_reference__named_case__gives_the_stated_result(name: str) -> None:
    (operation, operands), want = DIRECTED[name]
    assert single(OPERATIONS[operation].reference, *operands) == want


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__named_and_corner_operands__match_reference(name: str) -> None:
    corners = stimulus.corners()
    rows = stimulus.cross(*[corners] * len(OPERATIONS[name].operands))
    rows = stimulus.thinned(rows, generator(f"fma corners {name}"), 100_000)
    check(OPERATIONS[name], np.concatenate((_directed(name), rows)))


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__random_operands__match_reference(name: str) -> None:
    rng = generator(f"fma random {name}")
    columns = len(OPERATIONS[name].operands)
    correlated = {"add": stimulus.add_pairs, "sub": stimulus.add_pairs}.get(
        name, stimulus.fma_triples if columns == 3 else stimulus.mul_pairs
    )
    rows = (correlated(rng, 100_000), stimulus.mixed(rng, 30_000, columns))
    check(OPERATIONS[name], np.concatenate(rows))


def test_fmadd__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("fma gaps")
    check(OPERATIONS["fmadd"], stimulus.fma_triples(rng, 2000), issue=stimulus.gaps(rng, 2000))


def test_fma__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
