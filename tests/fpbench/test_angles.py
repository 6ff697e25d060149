# SPDX-License-Identifier: Apache-2.0
"""The check of sine and cosine: its double reference against MPFR, its verdict on bad results."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from sim.core.fpbench import Unit
from sim.core.fpbench.native import RTL, angle_bound
from sim.core.fpbench.report import REPORT
from sim.core.fpbench.selfcheck import double_error
from tests.bench.copies import edited_folder

# What a double below one ulp of error can be off, in ulp of binary32 (see angles.h).
TRUSTED = 2.0**-28
NEAREST_TO_ROOT = 0x437CE5F1  # cosine closest to zero in range


def worst_operands(op: str) -> list[int]:
    """Worst of a random run, of the last campaign if there is one, and the closest to zeros."""
    unit = Unit("fp_sincos")
    found = [unit.run(op, "random", count=20_000, seed=3).angles.worst_at, NEAREST_TO_ROOT]
    if REPORT.exists():
        angles = json.loads(REPORT.read_text())["angles"]
        found += [angles[op]["worst_at"]] if op in angles else []
    multiples = (np.arange(1, 325) * (np.pi / 4)).astype(np.float32).view(np.uint32)
    return [*found, *(int(x) for x in multiples)]


@pytest.mark.parametrize("op", ["sin", "cos"])
def test_double_reference__worst_operands_and_zeros__as_good_as_claimed(op: str) -> None:
    unit = Unit("fp_sincos")
    worst = max((double_error(unit, op, x), x) for x in worst_operands(op))
    assert worst[0] < TRUSTED, f"{op} {worst[1]:08x}: double is off by {worst[0]} ulp of binary32"


def test_symmetry__pairs__counted_and_exact() -> None:
    unit = Unit("fp_sincos")
    start = 2 * 0x3F490FDB  # pi / 4
    for op in ("sin", "cos"):
        report = unit.run(op, "exhaustive", start=start, count=20_000)
        assert report.good, report.failures
        assert report.angles.symmetric_pairs == report.angles.in_range // 2 == 10_000


@pytest.mark.full
def test_judge__bound_below_the_units_error__is_a_mismatch(tmp_path: Path) -> None:
    bound, wrong = r"error below [0-9.]+ ulp", "error below 0.4 ulp"
    copy = edited_folder(RTL, tmp_path / "fpu", "fp_sincos.sv", bound, wrong)
    assert angle_bound(copy) == 0.4 < angle_bound()
    report = Unit("fp_sincos", copy).run("sin", "random", count=2000)
    assert report.mismatches and report.angles.worst > 0.4
