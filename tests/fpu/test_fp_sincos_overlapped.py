# SPDX-License-Identifier: Apache-2.0
"""fp_sincos_overlapped against fp_sincos: the same bits at every distance of operations.

Operands are those of fp_sincos, whose error is measured: the units must not differ.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from sim.core.fpbench.quick import run_parts
from sim.core.fpbench.variants import bench_unit
from tests.bench.seed import SEED
from tests.fpu.tb import generator
from tests.fpu.test_fp_sincos import (
    INTERVAL,
    ITERATIVE,
    LATENCY,
    OVERLAPPED,
    edges,
    near_multiples,
    random_angles,
    stream,
)

CASES = 40_000
BENCH_SHARE = 150_000  # random cases per operation; a quarter as many again with gaps


def same_as_iterative(cosine: np.ndarray, operands: np.ndarray, idle: np.ndarray | int) -> None:
    """Results and flags of the two units for the same operations do not differ."""
    got, got_flags = stream(OVERLAPPED, cosine, operands, idle)
    want, want_flags = stream(ITERATIVE, cosine, operands)
    wrong = np.flatnonzero((got != want) | (got_flags != want_flags))
    assert not len(wrong), f"SEED={SEED}, {len(wrong)} differ: " + ", ".join(
        f"{'cos' if cosine[i] else 'sin'} {operands[i]:08x} {got[i]:08x} for {want[i]:08x}"
        for i in wrong[:4]
    )


def mixed(name: str, operands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Operands of any kind in random order, each for sine or cosine."""
    rng = generator(name)
    return rng.integers(0, 2, len(operands)).astype(bool), rng.permutation(operands)


def any_operands(name: str, count: int) -> np.ndarray:
    """Angles in range, near multiples of eighth turns, edges, and all other bit patterns."""
    rng = generator(name)
    words = rng.integers(0, 2**32, count // 8, dtype=np.uint32)
    return np.concatenate((random_angles(rng, count), near_multiples(), edges(), words))


def test_overlapped__at_its_interval__gives_the_bits_of_the_iterative_unit() -> None:
    same_as_iterative(*mixed("overlapped", any_operands("overlapped operands", CASES)), idle=0)


def test_overlapped__random_gaps__gives_the_bits_of_the_iterative_unit() -> None:
    cosine, operands = mixed("overlapped gaps", any_operands("gap operands", CASES // 4))
    idle = generator("overlapped idle").integers(0, 2 * LATENCY[OVERLAPPED], len(operands))
    same_as_iterative(cosine, operands, np.where(idle < LATENCY[OVERLAPPED], idle, 0))


def test_overlapped__every_triple_of_distances__gives_the_bits_of_the_iterative_unit() -> None:
    # What an operation shares with others depends on the distances to those before and after it,
    # never on their operands; from LATENCY on it shares nothing.
    choices = range(LATENCY[OVERLAPPED] - INTERVAL[OVERLAPPED])
    idle = np.array(list(itertools.product(choices, choices, (0, 1, 2, 3, 4, 5, 11)))).ravel()
    cosine, operands = mixed("triples", random_angles(generator("triple operands"), len(idle)))
    same_as_iterative(cosine, operands, idle)


@pytest.mark.parametrize("op", ["sin", "cos"])
def test_overlapped__short_set_of_the_fast_bench__is_within_the_bound(op: str) -> None:
    report = run_parts(bench_unit(OVERLAPPED), op, cases=BENCH_SHARE)
    assert report.good, [report.protocol, *map(str, report.failures)]
    assert report.cases >= BENCH_SHARE * 5 // 4
