# SPDX-License-Identifier: Apache-2.0
"""The bench finds faults: each test plants one in a copy of the RTL and the short set must fail."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sim.core.fpbench import BenchError, Unit, quick
from tests.bench.faults import copy, load

CASES = 200_000
FAULTS = {
    fault.breaks.replace(" ", "_"): fault for fault in load(Path(__file__).with_name("faults.toml"))
}


@pytest.mark.quick("round_*")
@pytest.mark.parametrize("name", FAULTS)
def test_quick__fault_planted__is_found(name: str, tmp_path: Path) -> None:
    (op,) = FAULTS[name].found
    report = quick(op, copy(tmp_path, [FAULTS[name]], part="fpu"), cases=CASES)
    assert not report.good
    if name == "result_not_at_the_stated_latency":
        assert "the latency is 10 clocks" in report.protocol  # one of them is the bench's own
    else:
        assert report.failures and not report.protocol


def test_quick__mismatch__can_be_replayed_alone(tmp_path: Path) -> None:
    folder = copy(tmp_path, [FAULTS["tininess_does_not_look_at_the_rounding"]], part="fpu")
    failure = quick("mul", folder, cases=CASES).failures[0]
    assert re.fullmatch(r"mul [0-9a-f]{8} [0-9a-f]{8}", failure.arguments)
    alone = Unit("fp_mul", folder).run_list("mul", [failure.operands])
    assert alone.failures == [failure]
    assert Unit("fp_mul").run_list("mul", [failure.operands]).good


def test_unit__folder_without_rtl__says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(
        BenchError, match=r"no file fp_mul\.sv.*give a folder with the files of rtl"
    ):
        Unit("fp_mul", tmp_path)
