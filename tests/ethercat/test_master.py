# SPDX-License-Identifier: Apache-2.0
"""Masters, unmodified, on a TAP device: one slave and three, to OP, counters right."""

from __future__ import annotations

import json

import pytest

from sim.ethercat.line import library
from sim.ethercat.tap import in_namespace
from tests.bench.needs import needs

MODULE = "sim.ethercat.master_loop"
pytestmark = needs("tap")


def run(slaves: int, cycles: int, timeout: float, master: str = "pysoem") -> dict:
    library()  # built here: the master's clock runs in the other process
    options = ["--master", master, "--slaves", str(slaves), "--cycles", str(cycles)]
    done = in_namespace(MODULE, options, timeout=timeout)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])  # KickCAT prints lines of its own


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
@pytest.mark.parametrize("slaves", (1, 3))
def test_master__hundred_thousand_cycles(slaves: int):
    assert run(slaves, 100_000, 7200)["wrong_counters"] == 0
