# SPDX-License-Identifier: Apache-2.0
"""fp_i2f against Berkeley SoftFloat."""

import numpy as np

from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import Operation, Unit, by_hand, check, check_reset, generator

UNIT = Unit("fp_i2f", (("unsigned_i", 1), ("a_i", 32)))
SIGNED = Operation("signed", UNIT, ("a_i",), reference.i32_to_f32, {"unsigned_i": 0})
UNSIGNED = Operation("unsigned", UNIT, ("a_i",), reference.u32_to_f32, {"unsigned_i": 1})


def integers(rng: np.random.Generator, count: int) -> np.ndarray:
    """Powers of two and their neighbours, every tie position, then random lengths and signs."""
    powers = (1 << np.arange(32, dtype=np.uint64))[:, None] + np.arange(-3, 4)
    # 24 significant bits and a half: |1.x..x y|1 0..0| at every length, with the last bit varied
    lengths = np.arange(25, 33)[:, None, None]
    tops = np.array([0x800000, 0x800001, 0xAAAAAA, 0xAAAAAB, 0xFFFFFE, 0xFFFFFF])[None, :, None]
    nudge = np.arange(-1, 2)[None, None, :]
    ties = (tops << (lengths - 24)) + (1 << (lengths - 25)) + nudge
    random = rng.integers(0, 1 << 32, count) >> rng.integers(0, 32, count)
    values = np.concatenate((powers.ravel(), ties.ravel(), random)).astype(np.int64)
    return (np.concatenate((values, -values)) & 0xFFFFFFFF).astype(np.uint32)


def test_i2f__signed_integers__match_reference() -> None:
    random = integers(generator("i2f signed"), 60_000)
    check(SIGNED, np.concatenate((by_hand(SIGNED, "i2f")[:, 0], random)))


def test_i2f__unsigned_integers__match_reference() -> None:
    check(UNSIGNED, integers(generator("i2f unsigned"), 60_000))


def test_i2f__random_gaps__valid_follows_by_the_latency() -> None:
    rng = generator("i2f gaps")
    check(SIGNED, stimulus.raw_bits(rng, 2000, 1), issue=stimulus.gaps(rng, 2000))


def test_i2f__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)
