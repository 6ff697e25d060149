# SPDX-License-Identifier: Apache-2.0
"""The whole device in RTL at a cycle of 62.5 us, locked to SYNC0."""

from __future__ import annotations

import pytest

from sim.bus import locked_run
from tests.ethercat.masters import report_of


@pytest.mark.full
def test_process_data__each_62_5_us_at_every_phase_of_sync0():
    found = report_of("locked_run", "--cycles", 40, timeout=1200)
    assert found["cycles"] == 40 * locked_run.PHASES
    # A tick is counted when its pass ends, at some phases about when the count of the cycles does.
    assert abs(found["ticks"] - found["cycles"]) <= locked_run.PHASES
    assert not (found["wrong"] or found["late"] or found["exceeded"] or found["console"]), found
    assert found["apart"] <= 1 and found["longest"] < found["limit"], found
    assert found["missed"] == 0, found
