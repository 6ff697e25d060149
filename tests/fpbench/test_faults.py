# SPDX-License-Identifier: Apache-2.0
"""The bench finds faults: each test plants one in a copy of the RTL and the short set must fail."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from sim.fpbench import BenchError, Unit, quick
from sim.fpbench.native import RTL

CASES = 200_000
# name -> operation, file, text (regular expression), replacement
FAULTS = {
    "round_does_not_see_the_sticky_bit": (
        "i2f",
        "fp_round.sv",
        r"(increment\s*=[^;]*?) \|\| sticky_i",
        r"\1",
    ),
    "tininess_does_not_look_at_the_rounding": (
        "mul",
        "fp_round.sv",
        r"(tiny\s*=\s*subnormal)[^;]*;",
        r"\1;",
    ),
    "two_zeros_are_not_ordered_by_sign": (
        "min",
        "fp_cmp.sv",
        r"orders_below = a\[31\];",
        "orders_below = a[31] && (|a[30:0]);",
    ),
    "result_not_at_the_stated_latency": (
        "i2f",
        "fp_pkg.sv",
        r"(FP_I2F_LATENCY = )\d+",
        r"\g<1>9",
    ),
}


def planted(folder: Path, file: str, pattern: str, replacement: str) -> Path:
    """A copy of rtl/fpu with one replacement, which must apply."""
    copy = folder / "fpu"
    shutil.copytree(RTL, copy)
    text, count = re.subn(pattern, replacement, (copy / file).read_text(), count=1)
    assert count == 1, f"{file} has no text that matches {pattern}; plant the fault elsewhere"
    (copy / file).write_text(text)
    return copy


@pytest.mark.parametrize("name", FAULTS)
def test_quick__fault_planted__is_found(name: str, tmp_path: Path) -> None:
    op, file, pattern, replacement = FAULTS[name]
    report = quick(op, planted(tmp_path, file, pattern, replacement), cases=CASES)
    assert not report.good
    if name == "result_not_at_the_stated_latency":
        assert "the latency is 10 clocks" in report.protocol  # one of them is the bench's own
    else:
        assert report.failures and not report.protocol


def test_quick__mismatch__can_be_replayed_alone(tmp_path: Path) -> None:
    op, file, pattern, replacement = FAULTS["tininess_does_not_look_at_the_rounding"]
    folder = planted(tmp_path, file, pattern, replacement)
    failure = quick(op, folder, cases=CASES).failures[0]
    assert re.fullmatch(r"OP=mul A=[0-9a-f]{8} B=[0-9a-f]{8}", failure.arguments)
    alone = Unit("fp_mul", folder).run_list(op, [failure.operands])
    assert alone.failures == [failure]
    assert Unit("fp_mul").run_list(op, [failure.operands]).good


def test_unit__folder_without_rtl__says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(
        BenchError, match=r"no file fp_mul\.sv.*give a folder with the files of rtl"
    ):
        Unit("fp_mul", tmp_path)
