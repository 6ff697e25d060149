# SPDX-License-Identifier: Apache-2.0
"""Masters, unmodified, on a TAP device: one slave and three, to OP, counters right."""

from __future__ import annotations

import pytest

from sim.bus import ethercrab_master
from tests.bench.needs import needs
from tests.ethercat.masters import report_of

pytestmark = needs("tap")


def run(slaves: int, cycles: int, timeout: float, master: str = "pysoem") -> dict:
    options = ("--master", master, "--slaves", slaves, "--cycles", cycles)
    return report_of("master_loop", *options, timeout=timeout)


@pytest.mark.parametrize("slaves", (1, 3))
def test_master__brings_slaves_to_op_and_counts_right(slaves: int):
    found = run(slaves, 40, 300)
    assert found["state"] == "OP" and found["expected_counter"] == 3 * slaves
    assert found["wrong_counters"] == found["torn_inputs"] == 0
    assert found["echoes"] > 20 * slaves


def test_kickcat__brings_a_slave_to_op_and_counts_right():
    found = run(1, 40, 600, "kickcat")
    assert found["state"] == "OP"
    assert found["wrong_counters"] == found["torn_inputs"] == 0
    assert found["echoes"] > 20


@pytest.mark.full
@needs("cargo")
@pytest.mark.parametrize(("slaves", "cycles"), ((1, 10_000), (3, 10_000)))
def test_ethercrab__brings_slaves_to_op_and_counts_right(slaves: int, cycles: int):
    """With distributed clocks, as it sets them up by itself."""
    ethercrab_master.build()  # here, where the network is
    found = run(slaves, cycles, 7200, "ethercrab")
    assert found["state"] == "OP" and found["expected_counter"] == 3 * slaves
    assert found["wrong_counters"] == found["torn_inputs"] == 0
    assert found["echoes"] > (cycles - 20) * slaves


@pytest.mark.full
@pytest.mark.parametrize("slaves", (1, 3))
def test_master__hundred_thousand_cycles(slaves: int):
    assert run(slaves, 100_000, 7200)["wrong_counters"] == 0
