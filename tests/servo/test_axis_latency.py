# SPDX-License-Identifier: Apache-2.0
"""Samples to values of one axis on the RTL: constant, and within what a loop of 100 kHz allows."""

from __future__ import annotations

import pytest

from sim.laws.drive.clocks import CLOCK
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from tests.servo.axis_latency import latency

SETTING = Setting(Robot.load().resolution)


@pytest.mark.quick("small-*")
@pytest.mark.parametrize(("configuration", "most"), [("fast", 1.5e-6), ("small", 3e-6)])
def test_latency__is_the_same_in_each_period(configuration, most):
    found = latency(Drives.load(), SETTING, configuration)
    assert len(found) == 3 and len(set(found)) == 1
    assert found[0] * CLOCK <= most
