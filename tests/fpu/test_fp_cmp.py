# SPDX-License-Identifier: Apache-2.0
"""fp_cmp against SoftFloat comparisons and the selection rules of IEEE 754-2019 on top of them."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.isa import default_isa
from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator, package_constant

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


@pytest.mark.quick("EQ", "LT", "MIN")
@pytest.mark.parametrize("name", reference.COMPARISONS)
def test_cmp__corners_and_random_operands__match_reference(name: str) -> None:
    columns = reference.COMPARISONS[name][0]
    rng = generator(f"cmp {name}")
    crossed = stimulus.corner_rows(rng, columns)
    random = [neighbours(rng, CASES, columns), stimulus.mixed(rng, CASES // 2, columns)]
    named = by_hand(operation(name), default_isa().comparisons[name].name)
    check(operation(name), np.concatenate([crossed, *random, named]).astype(np.uint32))


def test_cmp__every_opcode__is_distinct() -> None:
    codes = [package_constant(f"FP_CMP_{name}") for name in reference.COMPARISONS]
    assert codes == [r.control["cmp_op"] for r in default_isa().comparisons.values()]
    assert len(set(codes)) == len(codes)


def test_cmp__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("cmp gaps")
    check(operation("MAX"), stimulus.mixed(rng, 2000, 2), issue=stimulus.gaps(rng, 2000))


def test_cmp__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
