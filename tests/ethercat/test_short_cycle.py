# SPDX-License-Identifier: Apache-2.0
"""The application built for a control cycle of 62.5 us: process data at 16 kHz, locked to SYNC0."""

from __future__ import annotations

import struct
from typing import Self

import pytest

from sim.bus.gen.esc_regmap import SYNC0_CYCLE, SYNC_ACTIVATION
from tests.ethercat.drives import CSP, ENABLE, PP, PV, Drives
from tests.ethercat.host import ERROR, OP, PREOP, SAFEOP, AbortedError, Short
from tests.ethercat.test_cia402_cyclic import check_quintic

CYCLE_NS = Short.CYCLE_NS
TICK = CYCLE_NS * 1e-9


class ShortDrives(Drives):
    """In OP with SYNC0 of `sync0_ns`; the master states its cycle in whole microseconds."""

    CYCLE_NS = CYCLE_NS

    def __init__(self, mode: int = CSP, sync0_ns: int = CYCLE_NS, stated_us: int = 63) -> None:
        self.sync0_ns, self.stated_us = sync0_ns, stated_us
        super().__init__(mode)

    def to_safeop(self) -> Self:
        self.to_preop()
        self.put(0x1C32, 1, 2)
        for axis in range(0x6000, 0x8800, 0x800):
            self.put(axis + 0xC2, 1, self.stated_us)
            self.put(axis + 0xC2, 2, -6)
        self.write(SYNC0_CYCLE.address, struct.pack("<I", self.sync0_ns))
        on = SYNC_ACTIVATION.word(cyclic=1, sync0=1)
        self.write(SYNC_ACTIVATION.address, bytes([on]))
        self.process_managers()
        assert self.ask(SAFEOP) == (SAFEOP, 0)
        return self


@pytest.mark.parametrize(("cycle", "served"), [(62_500, True), (125_000, True), (100_000, False)])
def test_sync0__of_whole_control_cycles_is_served_another_is_0035(cycle, served):
    if served:
        assert ShortDrives(sync0_ns=cycle, stated_us=-(-cycle // 1000)).status == (OP, 0)
        return
    host = Short().to_preop()
    host.process_managers()
    host.put(0x1C32, 1, 2)
    host.write(SYNC0_CYCLE.address, struct.pack("<I", cycle))
    host.write(SYNC_ACTIVATION.address, bytes([SYNC_ACTIVATION.word(cyclic=1, sync0=1)]))
    assert host.ask(SAFEOP) == (PREOP | ERROR, 0x0035)


def test_least_cycle__is_in_the_objects_and_60c2_refuses_less():
    host = Short().to_preop()
    assert host.get(0x1C32, 5) == host.get(0x1C33, 5) == CYCLE_NS
    host.put(0x60C2, 1, 63)
    host.put(0x60C2, 2, -6)
    with pytest.raises(AbortedError, match="06090030"):
        host.put(0x60C2, 1, 62)
    assert host.get(0x60C2, 1) == 63


@pytest.mark.parametrize(("cycles", "stated_us"), [(1, 63), (2, 125), (3, 187), (3, 188)])
def test_csp__runs_the_quintic_of_scipy_at_the_cycle_of_sync0(cycles, stated_us):
    """60C2 states 62.5 and 187.5 us in whole microseconds."""
    check_quintic(ShortDrives(sync0_ns=cycles * CYCLE_NS, stated_us=stated_us), cycles)


def test_csp__the_velocity_is_that_of_the_targets():
    drives = ShortDrives()
    drives.put(0x6065, 0, 0xFFFFFFFF)
    drives.enable()
    rows = drives.follow(8, every=1)
    for n in range(400):
        rows = drives.follow(1, every=1, position=250 * n)
    assert rows[0, 1] == pytest.approx(250 / TICK, rel=1e-6)
    assert drives.get(0x1C32, 2) == CYCLE_NS and drives.get(0x1C32, 11) == 0


def test_60c2__a_microsecond_from_sync0_is_the_period():
    """126 us stay 126 us beside a SYNC0 of 125 us. The interpolation may run 1/512 faster."""
    found = {}
    for stated in (125, 126):
        drives = ShortDrives(sync0_ns=125_000, stated_us=stated)
        drives.put(0x6065, 0, 0xFFFFFFFF)
        drives.enable()
        for n in range(100):
            rows = drives.follow(2, every=2, position=250 * n)
        found[stated] = rows[-1, 1]
    assert found[125] == pytest.approx(250 / 125e-6, rel=1 / 511)
    assert found[126] / found[125] == pytest.approx(125 / 126, rel=1e-3)


def test_profile_velocity__accelerates_in_seconds():
    drives = ShortDrives(mode=PV)
    drives.put(0x6083, 0, 40_000_000)
    drives.put(0x60A4, 1, 4_000_000_000)
    drives.enable()
    rows = drives.follow(1600, every=1, velocity=100_000_000)  # 0.1 s
    gained = rows[-1, 1] - rows[799, 1]
    assert gained == pytest.approx(40_000_000 * 0.05, rel=1e-3)
    assert rows[-1, 0] - rows[-2, 0] == pytest.approx(rows[-1, 1] * TICK, rel=1e-3)


def test_profile_position__takes_the_time_of_its_profile():
    """A way at 6081 with ramps of 6083 and 6084 and much jerk: distance / speed + speed / ramp."""
    speed, ramp, way = 2_000_000, 100_000_000, 1_000_000
    drives = ShortDrives(mode=PP)
    for index, value in ((0x6081, speed), (0x6083, ramp), (0x6084, ramp)):
        drives.put(index, 0, value)
    drives.put(0x60A4, 1, 4_000_000_000)
    drives.enable()
    rows = drives.follow(16_000, every=1, position=way, control=ENABLE | 0x10)
    moving = (abs(rows[:, 1]) > 0).nonzero()[0]
    assert rows[-1, 0] == way and rows[:, 1].max() == pytest.approx(speed, rel=1e-4)
    wanted = way / speed + speed / ramp + ramp / 4e12
    assert (moving[-1] - moving[0] + 1) * TICK == pytest.approx(wanted, abs=3 * TICK)


def test_following_error__counts_milliseconds():
    drives = ShortDrives()
    drives.put(0x6065, 0, 1000)
    drives.put(0x6066, 0, 10)
    drives.enable()
    drives.held.add(0)
    drives.set(position=10_000)
    ticks = 0
    while drives.state() == "OPERATION ENABLED":
        drives.step()
        ticks += 1
    assert 160 <= ticks <= 170


def test_sync0__that_stops_is_002c():
    drives = ShortDrives()
    drives.library.double_sync0(False)
    drives.follow(4, every=1)
    assert drives.status == (SAFEOP | ERROR, 0x002C)
