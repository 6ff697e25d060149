# SPDX-License-Identifier: Apache-2.0
"""fp_add against Berkeley SoftFloat: addition and subtraction."""

import numpy as np
import pytest

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator

UNIT = Unit("fp_add", (("sub_i", 1), ("a_i", 32), ("b_i", 32)))
OPERATIONS = {
    "add": Operation("add", UNIT, ("a_i", "b_i"), reference.add, {"sub_i": 0}),
    "sub": Operation("sub", UNIT, ("a_i", "b_i"), reference.sub, {"sub_i": 1}),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation__named_and_corner_pairs__match_reference(name: str) -> None:
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    check(OPERATIONS[name], np.concatenate((by_hand(OPERATIONS[name], f"f{name}"), corners)))


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
