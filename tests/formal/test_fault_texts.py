# SPDX-License-Identifier: Apache-2.0
"""Planted faults of the proofs still find their text in the RTL; needs neither solver nor Yosys."""

from pathlib import Path

import pytest

from tests.bench.faults import RTL, Fault, load

FAULTS = load(Path(__file__).with_name("faults.toml"))


def test_faults__are_found() -> None:
    assert len(FAULTS) > 40


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_fault__its_text_stands_in_the_unit(fault: Fault) -> None:
    assert fault.right in (RTL / fault.file).read_text(encoding="utf-8")
