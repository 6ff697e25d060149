# SPDX-License-Identifier: Apache-2.0
"""Faults planted into the chain: found in time, and a fault that is not found counts as missed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scripts import drive
from sim.bench.drive import guards
from sim.bench.drive.goals import Rows
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

ROBOT, DRIVES = Robot.load(), Drives.load()


@pytest.mark.full
def test_campaign__a_lost_sensor_is_found_and_nothing_is_not():
    nothing = guards.Fault("nothing", lambda system, drives: None)
    stuck, none = guards.campaign(
        ROBOT, DRIVES, lambda text: None, [guards.FAULTS[0], nothing], last=60
    )
    assert stuck.in_time and stuck.halves < 60
    assert not none.in_time and none.tripped == 0 and none.halves == 60
    assert 0.4 < none.current < 0.6 and none.speed < 0.01


def test_outcome__each_limit_counts():
    good = guards.Outcome("a", 1.9, 0.009, 31, 10)
    assert good.in_time
    for change in ({"current": 2.0}, {"speed": 0.01}, {"tripped": 30}):
        assert not replace(good, **change).in_time


def test_goal__counts_the_faults_that_were_missed(monkeypatch):
    good = guards.Outcome("a", 1.9, 0.009, 31, 10)
    found = [good, replace(good, tripped=0), replace(good, current=3.0)]
    monkeypatch.setattr(drive, "campaign_of_guards", lambda robot, drives, report: found)
    rows = Rows()
    drive.guards(ROBOT, DRIVES, rows, print)
    assert [(row.met, row.value) for row in rows][0] == (False, 2)
    monkeypatch.setattr(drive, "campaign_of_guards", lambda robot, drives, report: [good])
    rows = Rows()
    drive.guards(ROBOT, DRIVES, rows, print)
    assert rows[0].met
