# SPDX-License-Identifier: Apache-2.0
"""Planted faults in the redundancy and the plausibility record (faults.toml): each must be found.

One fault: `pytest -m full tests/asip/test_planted_faults.py -k 3`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.asip import resilient_bench, test_plausible, test_resilient_faults
from tests.bench.faults import copy, load

TESTS = {
    module.__name__.rpartition(".")[2]: module for module in (test_plausible, test_resilient_faults)
}
FAULTS = load(Path(__file__).with_name("faults.toml"))


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of pytest for one test on the sources in `folder` instead of rtl/asip."""
    module, _, test = name.partition(".")
    monkeypatch.setattr(resilient_bench, "RTL", folder)
    resilient_bench.core.cache_clear()
    try:
        options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:randomly", "--no-header"]
        return int(pytest.main([*options, f"{TESTS[module].__file__}::{test}"]))
    finally:
        resilient_bench.core.cache_clear()


def test_table__names_tests_that_exist() -> None:
    for fault in FAULTS:
        for name in fault.found:
            module, _, test = name.partition(".")
            assert hasattr(TESTS[module], test), name


@pytest.mark.full
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: str(fault.number))
def test_fault__is_caught(fault, tmp_path, monkeypatch) -> None:
    folder = copy(tmp_path / "rtl", [fault], part="asip")
    (test,) = fault.found
    status = run(test, folder, monkeypatch)
    assert status == pytest.ExitCode.TESTS_FAILED, f"{fault.breaks}: {test} gave {status}"
