# SPDX-License-Identifier: Apache-2.0
"""Homing and profile position of CiA 402; independent of us: Ruckig for the moves."""

from __future__ import annotations

import random
import struct

import numpy as np
import pytest
from ruckig import InputParameter, Result, Ruckig, Trajectory

from tests.ethercat.drives import CSP, ENABLE, HOMING, PLANNING, PP, QUICK_STOP, TICK, Drives
from tests.ethercat.host import AXES


@pytest.mark.parametrize("method", [35, 37])
def test_homing__the_present_position_becomes_the_home_offset(method):
    drives = Drives(HOMING)
    drives.feedback.axis[0].position = 123_456
    drives.put(0x607C, 0, -1000)
    drives.put(0x6098, 0, method)
    drives.enable()
    assert drives.statusword() & 0x1000 == 0
    drives.step(2, control=ENABLE | 0x10)
    assert drives.statusword() & 0x3400 == 0x1400
    assert drives.inputs()[0x6064, 0] == -1000
    assert drives.command.axis[0].position == 123_456  # nothing moves
    drives.follow(100, mode=CSP, position=-1000, control=ENABLE)
    assert drives.command.axis[0].position == 123_456
    drives.follow(100, position=-900)
    assert drives.command.axis[0].position == 123_556


def duration_of_ruckig(x, v, a, target, limits) -> float:
    """In units that suit its tolerances; its limits a little wider than the state at its start."""
    x, v, a, target = (value * 1e-6 for value in (x, v, a, target))
    limits = [limit * 1e-6 for limit in limits]
    otg, given = Ruckig(1), InputParameter(1)
    given.current_position, given.current_velocity = [x], [v]
    given.current_acceleration, given.target_position = [a], [target]
    given.max_velocity, given.max_acceleration = [limits[0]], [limits[1] * (1 + 1e-6)]
    given.max_jerk = [limits[2]]
    found = Trajectory(1)
    assert otg.calculate(given, found) in (Result.Working, Result.Finished)
    return found.duration


LIMITS = (5_000_000, 100_000_000, 10_000_000_000)  # velocity, acceleration, jerk


def pp_drives(velocity: int = LIMITS[0], acceleration: int = LIMITS[1], jerk: int = LIMITS[2]):
    """Drives enabled in profile position."""
    drives = Drives(PP)
    drives.put(0x6081, 0, velocity)
    drives.put(0x6083, 0, acceleration)
    drives.put(0x6084, 0, acceleration)
    drives.put(0x60A4, 1, jerk // 1000)
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    return drives


@pytest.mark.parametrize(
    ("length", "velocity", "acceleration", "jerk"),
    [
        *((length, *LIMITS) for length in (3_000_000, -3_000_000, 400_000, 20_000, 1)),
        (5_000_000, 2_000_000, 400_000_000, 2_000_000_000),
        (100_000_000, 50_000_000, 400_000_000, 100_000_000_000),
    ],
)
def test_profile_position__in_the_time_of_ruckig_within_the_limits(
    length, velocity, acceleration, jerk
):
    drives = pp_drives(velocity, acceleration, jerk)
    drives.set(position=length, control=ENABLE | 0x10)
    wanted = duration_of_ruckig(0, 0, 0, length, (velocity, acceleration, jerk))
    rows = drives.follow(round(wanted / TICK) + 60)
    assert drives.statusword() & 0x1400 == 0x1400 and rows[-1, 0] == length
    moving = np.nonzero(rows[:, 0] != rows[-1, 0])[0][-1] + 2 - PLANNING
    creep = (6 / jerk) ** (1 / 3)  # the last increment, which binary32 rounds away, takes as long
    assert -creep - 3 * TICK - 1e-4 * wanted < moving * TICK - wanted < 3 * TICK + 1e-4 * wanted
    assert np.abs(rows[:, 1]).max() <= velocity * (1 + 1e-5)
    assert np.abs(rows[:, 2]).max() <= acceleration * (1 + 1e-5)
    assert np.abs(np.diff(rows[:, 2])).max() <= jerk * TICK * 1.001
    step = np.abs(np.diff(rows[:, 0]) - (rows[1:, 1] + rows[:-1, 1]) / 2 * TICK)
    assert step.max() <= jerk * TICK**3 + 2e-7 * abs(length) + 0.02


def test_profile_position__new_targets_in_motion():
    """At once (bit 5) in motion: no jump, in about the time of Ruckig from that state."""
    rng = random.Random(11)
    for _ in range(12):
        drives = pp_drives()
        first, second = rng.randrange(-(10**6), 10**6), rng.randrange(-(10**6), 10**6)
        rows = drives.follow(rng.randrange(50, 1500), position=first, control=ENABLE | 0x10)
        rows = np.vstack([rows, drives.follow(10, control=ENABLE)])
        planned = drives.follow(PLANNING, position=second, control=ENABLE | 0x30)
        rows = np.vstack([rows, planned])
        wanted = duration_of_ruckig(*rows[-1], second, LIMITS)
        rest = drives.follow(round(wanted / TICK * 1.3) + 100)
        rows = np.vstack([rows, rest])
        assert rows[-1, 0] == second
        took = (np.nonzero(rest[:, 0] != second)[0][-1] + 2) * TICK if rest[0, 0] != second else 0
        creep = (6 / LIMITS[2]) ** (1 / 3)
        assert wanted - 3 * TICK - creep <= took <= wanted * 1.02 + 15 * TICK, (first, second)
        assert np.abs(rows[:, 1]).max() <= LIMITS[0] * (1 + 1e-4)
        assert np.abs(rows[:, 2]).max() <= LIMITS[1] * (1 + 1e-4)
        assert np.abs(np.diff(rows[:, 2])).max() <= LIMITS[2] * TICK * 1.05


def test_profile_position__targets_one_after_the_other_and_relative():
    drives = pp_drives()
    drives.follow(20, position=100_000, control=ENABLE | 0x10)
    assert drives.statusword() & 0x1000
    drives.follow(20, control=ENABLE)
    assert not drives.statusword() & 0x1400  # free for the next, not there yet
    # Relative to the first, which goes on.
    drives.follow(20, position=-30_000, control=ENABLE | 0x50)
    rows = drives.follow(3000, control=ENABLE)
    assert rows[:, 0].max() == 100_000 and rows[-1, 0] == 70_000
    assert drives.statusword() & 0x1400 == 0x0400


def test_profile_position__axes_plan_one_after_the_other_and_none_waits_for_a_dead_one():
    drives = Drives(PP)
    for n in range(AXES):
        drives.put(0x6065 + 0x800 * n, 0, 0xFFFFFFFF)
        drives.enable(n)
    for n in range(AXES):
        drives.set(n, position=100_000 * (n + 1), control=ENABLE | 0x10)
    drives.outputs(drives.values)
    began = {}
    for cycle in range(6 * PLANNING):
        if cycle == 10:  # the first one faults while it plans
            drives.feedback.axis[0].fault = 0x5441
        drives.cycle()
        for n in range(AXES):
            if drives.command.axis[n].velocity:
                began.setdefault(n, cycle)
    assert list(began) == [1, 2, 3, 4]
    starts = list(began.values())
    assert 10 + PLANNING <= starts[0] <= 12 + PLANNING
    assert all(PLANNING - 1 <= b - a <= PLANNING for a, b in zip(starts, starts[1:], strict=False))
    drives.follow(2000)
    assert [drives.inputs()[0x6064 + 0x800 * n, 0] for n in range(AXES)] == [
        0, 200_000, 300_000, 400_000, 500_000,
    ]  # fmt: skip


def test_profile_position__target_that_comes_while_one_is_planned():
    drives = pp_drives()
    drives.follow(10, position=1_000_000, control=ENABLE | 0x30)
    drives.follow(2, control=ENABLE | 0x20)
    rows = drives.follow(6000, position=-50_000, control=ENABLE | 0x30)
    assert rows[-1, 0] == -50_000
    assert np.abs(np.diff(rows[:, 0])).max() <= 5_000_000 * TICK * 1.001


def test_halt__stops_on_the_ramp():
    drives = pp_drives()
    drives.follow(1500, position=3_000_000, control=ENABLE | 0x10)
    rows = drives.follow(800, control=ENABLE | 0x100)
    assert rows[-1, 1] == 0 and rows[-1, 0] < 3_000_000
    assert np.diff(rows[:, 1]).min() >= -100_000_000 * TICK * 1.01
    assert drives.statusword() & 0x0400 and drives.state() == "OPERATION ENABLED"


def test_halt__target_reached_only_when_it_stands():
    drives = pp_drives()
    drives.follow(1500, position=3_000_000, control=ENABLE | 0x10)
    drives.step(control=ENABLE | 0x100)
    seen = 0
    while drives.command.axis[0].velocity:
        assert not drives.statusword() & 0x0400, drives.command.axis[0].velocity
        drives.step()
        seen += 1
    assert seen > 100
    drives.step()
    assert drives.statusword() & 0x0400


class Mapped(Drives):
    """The first axis alone, with profile velocity, acceleration and deceleration (which
    is as great) in its process data."""

    def __init__(self, velocity: int, acceleration: int) -> None:
        self.limits = (velocity, acceleration)
        super().__init__(PP)
        self.put(0x6065, 0, 0xFFFFFFFF)
        self.enable()

    def process_managers(self, outputs: int = 0) -> None:
        self.put(0x1C12, 0, 0)
        self.put(0x1600, 0, 0)
        entries = (0x60400010, 0x60600008, 8, 0x607A0020, 0x60810020, 0x60830020, 0x60840020)
        for n, entry in enumerate(entries):
            self.put(0x1600, n + 1, entry)
        self.put(0x1600, 0, len(entries))
        self.put(0x1C12, 1, 0x1600)
        self.put(0x1C12, 0, 1)
        super().process_managers(outputs=20)

    def outputs(self, values=None) -> None:
        values = values or {}
        words = [values.get((index, 0), 0) for index in (0x6040, 0x6060, 0x607A)]
        self.write(0x1200, struct.pack("<HbxiIII", *words, *self.limits, self.limits[1]))


@pytest.mark.parametrize(("velocity", "acceleration"), [(0, 100_000_000), (5_000_000, 0), (0, 0)])
def test_mapped_limits_of_0__are_held_at_1_and_nothing_jumps(velocity, acceleration):
    drives = Mapped(velocity, acceleration)
    assert drives.get(0x6081) == max(1, velocity) and drives.get(0x6083) == max(1, acceleration)
    rows = drives.follow(3000, position=1_000_000, control=ENABLE | 0x10)
    assert np.abs(rows[:, 1]).max() <= max(1, velocity) and np.abs(np.diff(rows[:, 0])).max() < 2
    assert 0 < rows[-1, 0] < 2
    drives.limits = (5_000_000, 100_000_000)
    drives.step(position=100, control=ENABLE)
    assert drives.follow(3000, control=ENABLE | 0x30)[-1, 0] == 100


@pytest.mark.parametrize("way", ["halt", "quick stop", "fault"])
def test_mapped_acceleration_of_0__every_ramp_ends(way):
    drives = Mapped(20_000, 100_000_000)
    drives.put(0x605A, 0, 1)
    drives.put(0x605E, 0, 1)
    drives.follow(1000, position=1_000_000, control=ENABLE | 0x10)
    assert drives.command.axis[0].velocity == 20_000
    drives.limits = (20_000, 0)
    drives.set(control={"halt": ENABLE | 0x100, "quick stop": QUICK_STOP, "fault": ENABLE}[way])
    drives.feedback.axis[0].fault = 0x5441 if way == "fault" else 0
    speeds = drives.follow(3000)[2:, 1]
    assert speeds[0] > 10_000 and (np.diff(speeds) < 0).all()
    drives.limits = (20_000, 100_000)
    drives.follow(2 * 10_000)
    assert drives.command.axis[0].velocity == 0
    assert drives.command.axis[0].power == (way == "halt")
