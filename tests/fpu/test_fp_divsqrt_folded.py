# SPDX-License-Identifier: Apache-2.0
"""fp_divsqrt_folded against Berkeley SoftFloat, and in the fast bench against the host.

Operands are those of fp_divsqrt: the units must not differ.
"""

from dataclasses import replace

import numpy as np
import pytest

from asip_asm.machine import load_machine
from sim.core.fpbench.quick import run_parts
from sim.core.fpbench.variants import bench_unit
from tests.fpu import stimulus, tb, test_fp_divsqrt
from tests.fpu.tb import by_hand, check, check_reset, generator, run
from tests.fpu.test_fp_divsqrt import check_interleaved, quotients, radicands

NAME = "fp_divsqrt_folded"
INTERVAL = load_machine("small").units["divsqrt"].interval
UNIT = replace(test_fp_divsqrt.UNIT, name=NAME, interval=INTERVAL)
DIV, SQRT = (replace(op, unit=UNIT) for op in (test_fp_divsqrt.DIV, test_fp_divsqrt.SQRT))
BENCH_SHARE = 2_000_000  # random cases per operation; a quarter as many again with gaps


def with_gaps(rng: np.random.Generator, cases: int) -> np.ndarray:
    """Issue pattern with distances from the interval to three times the latency, often short."""
    extra = np.where(rng.integers(0, 2, cases) == 0, 0, rng.integers(0, 3 * UNIT.latency, cases))
    issue = np.zeros(int((INTERVAL + extra).sum()) + 1, dtype=bool)
    issue[np.concatenate(([0], np.cumsum(INTERVAL + extra)[:-1]))] = True
    return issue


def test_folded__named_corner_and_random_pairs__match_reference() -> None:
    rng = generator("folded div")
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    corners = stimulus.thinned(corners, rng, 4000)
    check(DIV, np.concatenate((by_hand(DIV, "fdiv"), corners, quotients(rng, 12_000))))


def test_folded__named_corner_and_random_radicands__match_reference() -> None:
    rng = generator("folded sqrt")
    rows = (by_hand(SQRT, "fsqrt")[:, 0], stimulus.corners(), radicands(rng, 12_000))
    check(SQRT, np.concatenate(rows)[:, None])


def test_folded__operations_interleaved_with_gaps__match_reference() -> None:
    check_interleaved(UNIT, "folded mix", with_gaps)


def test_folded__start_before_its_turn__stops_the_simulation() -> None:
    early = np.zeros(3 * INTERVAL, dtype=bool)
    early[[0, INTERVAL - 1]] = True
    inputs = {"a_i": np.full(2, 0x40400000), "b_i": 0x40000000, "sqrt_i": 0}
    with pytest.raises(AssertionError, match=f"starts less than {INTERVAL} clocks after another"):
        run(UNIT, inputs, issue=early)


def test_folded__clocks_without_a_result__outputs_are_zero() -> None:
    issue = np.zeros(4 * UNIT.latency, dtype=bool)
    issue[[0, INTERVAL, 2 * UNIT.latency]] = True
    rows = tb._rows(UNIT, {}, issue, generator("folded idle outputs"))
    rows[issue.nonzero()[0], 1:] = [0, 0x3F800000, 0x40400000]  # 1 / 3, inexact
    response = tb._simulate(UNIT, rows)[0][1:]  # the first row is not reset yet
    valid = response[:, 0] == 1
    assert valid.sum() == 3
    assert response[valid, 1:].all() and not response[~valid, 1:].any()


def test_folded__reset_in_flight__clears_valid() -> None:
    check_reset(UNIT)


@pytest.mark.quick("div")
@pytest.mark.parametrize("op", ["div", "sqrt"])
def test_folded__short_set_of_the_fast_bench__agrees_with_the_host(op: str) -> None:
    report = run_parts(bench_unit(NAME), op, cases=BENCH_SHARE)
    assert report.good, [report.protocol, *map(str, report.failures)]
    assert report.cases >= BENCH_SHARE * 5 // 4
