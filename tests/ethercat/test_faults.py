# SPDX-License-Identifier: Apache-2.0
"""Planted faults in the slave controller (faults.toml): each must make its test fail.

One fault: `pytest -m full tests/ethercat/test_faults.py -k "3-ethercat_slave"`.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from sim.ethercat import line
from tests.bench.faults import copy, load
from tests.bench.one_test import exit_status

HERE = Path(__file__).parent
FAULTS = load(HERE / "faults.toml")


def test_table__names_tests_that_exist() -> None:
    for fault in FAULTS:
        (test,) = fault.found
        module, _, name = test.partition(".")
        assert hasattr(import_module(f"tests.ethercat.{module}"), name.partition("[")[0])


@pytest.mark.full
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_fault__is_caught(fault, tmp_path, monkeypatch) -> None:
    (test,) = fault.found
    folder = copy(tmp_path / "rtl", [fault], part="ethercat")
    monkeypatch.setattr(line, "FOLDERS", (folder, ROOT / "rtl/gen"))
    status = exit_status(HERE, test)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
