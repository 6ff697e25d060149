# SPDX-License-Identifier: Apache-2.0
"""pysoem at both ends of a ring of three: a pulled cable costs no cycle."""

from __future__ import annotations

import pytest

from tests.bench.needs import needs
from tests.ethercat.masters import report_of

pytestmark = needs("tap")


@pytest.mark.quick("1-60")
# With a cable at the master pulled, it waits its whole time-out each cycle.
@pytest.mark.parametrize(("cable", "cycles"), ((0, 12), (1, 60), (2, 60), (3, 12)))
def test_ring__with_a_pulled_cable_stays_in_op_and_counts_right(cable: int, cycles: int):
    found = report_of("redundant", "--cycles", cycles, "--cable", cable)
    assert (found["state"], found["expected_counter"]) == ("OP", 9)
    assert found["wrong_counters"] == {"whole": 0, "broken": 0, "mended": 0}
    assert found["torn_inputs"] == 0 and found["echoes"] > 3 * (cycles - 5)
    near = [[int(cable == n), int(cable == n + 1)] for n in range(3)]
    assert found["lost_links"] == near


def test_ring__with_two_pulled_cables_loses_the_slave_between_them():
    found = report_of("redundant", "--cycles", 9, "--cable", 1, 2, status=1)
    assert found["wrong_counters"]["whole"] == 0
    assert found["wrong_counters"]["broken"] == 3
