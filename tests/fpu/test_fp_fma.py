# SPDX-License-Identifier: Apache-2.0
"""fp_fma against Berkeley SoftFloat: every kind and sign of the operation."""

import numpy as np
import pytest

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator, package_constant

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


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__named_and_corner_operands__match_reference(name: str) -> None:
    operation = OPERATIONS[name]
    rows = stimulus.cross(*[stimulus.corners()] * len(operation.operands))
    rows = stimulus.thinned(rows, generator(f"fma corners {name}"), 100_000)
    named = by_hand(operation, name if name.startswith("f") else f"f{name}")
    check(operation, np.concatenate((named, rows)))


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
