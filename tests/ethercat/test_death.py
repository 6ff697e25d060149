# SPDX-License-Identifier: Apache-2.0
"""pysoem that stops in OP, with controller, processor and program in RTL."""

from __future__ import annotations

import pytest

from tests.bench.needs import needs
from tests.ethercat.masters import report_of

pytestmark = [pytest.mark.full, needs("tap")]
SAFEOP, OP, ERROR = 4, 8, 16
LIMIT_TICKS = 200  # 20 cycles of 1 ms
STATUS_FAULT = 0x08  # under the mask 4Fh


@pytest.fixture(scope="module")
def report() -> dict:
    return report_of("death_run", timeout=3000)


def test_death__falls_to_safeop_with_its_code_and_counter(report):
    assert (report["state"], report["code"]) == (SAFEOP | ERROR, 0x001A)
    assert report["watchdog"] == 1


def test_death__faults_every_axis_and_takes_its_power(report):
    assert report["moving"] > 0 and report["powered"]
    assert report["error_codes"] == [0x7500] * 5
    assert report["emergencies"] == [0x7500] * 5
    assert [word & 0x4F for word in report["statuswords"]] == [STATUS_FAULT] * 5
    # 10F1:02 faults the axes after 20 missed cycles, before the watchdog; then they stop.
    assert LIMIT_TICKS <= report["stopped_at"] <= report["unpowered_at"] <= LIMIT_TICKS + 100


def test_death__the_master_that_comes_again_brings_it_to_op(report):
    assert report["again"] == OP
