# SPDX-License-Identifier: Apache-2.0
"""fp_f2i against Berkeley SoftFloat, except for the saturation results that we fix ourselves."""

import numpy as np
import pytest

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator

UNIT = Unit("fp_f2i", (("truncate_i", 1), ("a_i", 32)))
OPERATIONS = {
    name: Operation(
        name,
        UNIT,
        ("a_i",),
        reference.f32_to_i32_saturated(mode),
        {"truncate_i": int(name == "truncate")},
    )
    for name, mode in reference.MODES.items()
}


def operands(rng: np.random.Generator, count: int) -> np.ndarray:
    """Corners, every half and its neighbours, around 2^31, integers plus fractions."""
    halves = (np.arange(-300, 300) + 0.5).astype(np.float32).view(np.uint32)
    fractions = np.array([0.0, 0.25, 0.5, 0.75, 1.5], dtype=np.float64)
    large = (2.0 ** np.arange(0, 32)[:, None] + fractions).astype(np.float32).ravel()
    large = np.concatenate((large, -large)).view(np.uint32)
    edges = np.concatenate((halves, large)).astype(np.int64)
    edges = (edges[:, None] + np.arange(-1, 2)).ravel() & 0xFFFFFFFF
    random = stimulus.with_exponents(rng, rng.integers(120, 162, count))
    ties = stimulus.with_exponents(rng, rng.integers(126, 151, count // 4))
    keep = np.uint32(0xFFFFFFFF) << np.clip(149 - (ties >> 23 & 0xFF), 0, 22).astype(np.uint32)
    parts = (
        stimulus.corners(),
        edges,
        random,
        ties & keep,
        stimulus.mixed(rng, count // 2, 1)[:, 0],
    )
    return np.concatenate(parts).astype(np.uint32)


@pytest.mark.parametrize("name", OPERATIONS)
def test_f2i__named_corners_ties_and_random_operands__match_reference(name: str) -> None:
    named = by_hand(OPERATIONS[name], "f2it" if name == "truncate" else "f2i")[:, 0]
    check(OPERATIONS[name], np.concatenate((named, operands(generator(f"f2i {name}"), 60_000))))


def test_f2i__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("f2i gaps")
    check(OPERATIONS["truncate"], stimulus.mixed(rng, 2000, 1), issue=stimulus.gaps(rng, 2000))


def test_f2i__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
