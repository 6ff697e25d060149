# SPDX-License-Identifier: Apache-2.0
"""Records of the operations of fp_cmp against SoftFloat: the same values, the same flags."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from asip_asm.isa import default_isa
from asip_asm.isa_records import OperationRecord
from sim.core.fpbench import softfloat as reference
from tests.fpu import stimulus
from tests.fpu.tb import generator

RECORDS = default_isa().comparisons
CASES = 500
# operation, part of its record, what is there by mistake
WRONG = (
    ("LE", "a <= b", "a < b"),
    ("MIN", "negative(a)", "negative(b)"),
    ("MAX", "NAN if nan(a) and nan(b) else ", ""),
    ("ABS", "0x7fffffff", "0xffffffff"),
    ("SGN", "a > 0.0", "a >= 0.0"),
    ("SAT", "c < b", "c <= b"),
    ("SEL", "nan(a) or ", ""),
    ("SELGE", "a >= 0.0", "a > 0.0"),
    ("ISUB", "a - b", "b - a"),
)


def differences(record: OperationRecord, name: str) -> int:
    """Cases in which the record and SoftFloat give another value or other flags."""
    columns, function = reference.COMPARISONS[name]
    rng = generator(f"record {name}")
    rows = (stimulus.corner_rows(rng, columns), stimulus.mixed(rng, CASES, columns))
    rows = np.concatenate(rows).astype(np.uint32)
    (bits, flags), (want, raised) = reference.of_record(record)(*rows.T), function(*rows.T)
    return int(np.count_nonzero((bits != want) | (flags != raised)))


@pytest.mark.parametrize("name", RECORDS)
def test_record__corners_and_random_operands__is_softfloat(name: str) -> None:
    assert differences(RECORDS[name], name) == 0


@pytest.mark.parametrize(("name", "right", "wrong"), WRONG, ids=[row[0] for row in WRONG])
def test_record__planted_mistake__is_found(name: str, right: str, wrong: str) -> None:
    record = RECORDS[name]
    assert right in record.result
    assert differences(replace(record, result=record.result.replace(right, wrong)), name)


@pytest.mark.parametrize("name", [name for name in RECORDS if RECORDS[name].invalid])
def test_record__flag_forgotten__is_found(name: str) -> None:
    assert differences(replace(RECORDS[name], invalid=""), name)
