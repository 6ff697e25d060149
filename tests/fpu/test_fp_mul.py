# SPDX-License-Identifier: Apache-2.0
"""fp_mul against Berkeley SoftFloat."""

import numpy as np

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator

UNIT = Unit("fp_mul", (("a_i", 32), ("b_i", 32)))
MUL = Operation("mul", UNIT, ("a_i", "b_i"), reference.mul)


def test_mul__named_and_corner_pairs__match_reference() -> None:
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    check(MUL, np.concatenate((by_hand(MUL, "fmul"), corners)))


def test_mul__random_pairs__match_reference() -> None:
    rng = generator("mul")
    check(MUL, np.concatenate((stimulus.mul_pairs(rng, 100_000), stimulus.mixed(rng, 50_000, 2))))


def test_mul__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("mul gaps")
    check(MUL, stimulus.mul_pairs(rng, 2000), issue=stimulus.gaps(rng, 2000))


def test_mul__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
