# SPDX-License-Identifier: Apache-2.0
"""Control ticks of the device in RTL follow SYNC0, while the clock of the master drifts."""

from __future__ import annotations

import numpy as np
import pytest

from sim.bus.datagram import APRD, APWR, answer, single
from sim.bus.device import BEFORE, CLOCK_NS, CYCLE_CLOCKS, IMAGES, DeviceRtl
from sim.bus.gen import esc_regmap
from sim.bus.register import ByteRegister
from sim.bus.session import START_NS

SYNC_NS = 500_000
TICK_NS = CYCLE_CLOCKS * CLOCK_NS
TICKS = SYNC_NS // TICK_NS  # from SYNC0 to SYNC0
SHARE_NS = 100_000  # from one system time of the master to the next
SETTLED, COUNTED = 40, 20  # SYNC0 until the ticks count, and that count
APART = 600  # clocks from SYNC0 to the nearest tick at the beginning
NEAR = 1  # clocks, besides what the clocks drift


def write(device: DeviceRtl, register: ByteRegister, value: int) -> None:
    data = (value % (1 << 8 * register.width)).to_bytes(register.width, "little")
    device.send(single(APWR, 0, register.address, data))


@pytest.mark.parametrize("ppm", (100, -100))
def test_ticks__begin_with_sync0_while_the_masters_clock_drifts(ppm: int):
    device = DeviceRtl()
    device.run(START_NS)
    device.align()
    tick = device.time() + BEFORE * CLOCK_NS  # one is due then
    write(device, esc_regmap.SPEED_FILTER, 8)
    write(device, esc_regmap.SYNC0_CYCLE, SYNC_NS)
    device.run(50_000)
    begin, zero = device.now, device.time()
    write(device, esc_regmap.SPEED_START, 0x1000)
    write(device, esc_regmap.START_TIME, tick + 10 * TICK_NS + APART * CLOCK_NS)
    device.run(20_000)
    write(device, esc_regmap.SYNC_ACTIVATION, esc_regmap.SYNC_ACTIVATION.word(cyclic=1, sync0=1))
    device.restart_counts()
    while device.now < begin + (SETTLED + COUNTED) * SYNC_NS * 1000:
        device.run(SHARE_NS)
        elapsed = (device.now - begin) // 1000
        write(device, esc_regmap.SYSTEM_TIME, zero + elapsed + elapsed * ppm // 1_000_000)
    syncs, dues = device.begun(1 << 12)
    first = dues[np.searchsorted(dues, syncs[0]) - 1 : np.searchsorted(dues, syncs[0]) + 1]
    assert abs(min(abs(first - syncs[0])) - APART) < APART // 10
    syncs = syncs[-COUNTED:]
    drift = abs(ppm) * SYNC_NS // 1_000_000 // CLOCK_NS
    assert abs(np.diff(syncs).mean() - SYNC_NS / CLOCK_NS * (1 - ppm * 1e-6)) < 2
    nearest = np.array([dues[np.argmin(abs(dues - sync))] for sync in syncs])
    assert abs(nearest - syncs).max() <= drift + NEAR, nearest - syncs
    assert set(np.diff(np.searchsorted(dues, nearest))) == {TICKS}
    assert device.counts()["overrun"] == 0
    assert device.counts()["longest"] < CYCLE_CLOCKS


@pytest.mark.parametrize("image", ["ethercat", "ethercat_16khz"])
@pytest.mark.parametrize("period_ns", [100_000, 62_500])
def test_period__that_is_not_the_programs_cycle_keeps_the_device_in_init(
    monkeypatch: pytest.MonkeyPatch, period_ns: int, image: str
):
    wanted = {"ethercat": 10000, "ethercat_16khz": 6250}[image]
    right = period_ns == wanted * CLOCK_NS
    monkeypatch.setitem(IMAGES, period_ns, image)
    device = DeviceRtl(period_ns)
    device.run(START_NS + 12_000_000)
    write(device, esc_regmap.AL_CONTROL, 2)  # PREOP
    device.run(2_000_000)
    device.received()
    found = []
    for register in (esc_regmap.AL_STATUS, esc_regmap.AL_STATUS_CODE):
        device.send(single(APRD, 0, register.address, bytes(2)))
        device.run(100_000)
        found += [answer(frame, 2)[0] for frame in device.received()]
    # There is no mailbox: 0016.
    assert found == [0x11, 0x0016 if right else 0x8001]
    text = f"The control ticks do not come each {wanted} clocks"
    assert device.console == "" if right else text in device.console
