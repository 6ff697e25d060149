# SPDX-License-Identifier: Apache-2.0
"""pysoem, unmodified, and the device in RTL at a TAP device: bring-up and process data."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager

import pysoem

from sim.bus.coe.dictionary import Device
from sim.bus.device import DeviceRtl
from sim.bus.tap import INTERFACE, open_tap

START_NS = 3_000_000  # start-up of the program and loading of the SII
# A master's time-outs [us] are for hardware; simulated slaves take longer by this machine's clock.
TIMEOUTS = {
    "ret": 500_000,
    "safe": 5_000_000,
    "eeprom": 5_000_000,
    "tx_mailbox": 5_000_000,
    "rx_mailbox": 20_000_000,
    "state": 60_000_000,
}
SDO_US = 20_000_000
CSP = 8
SHUTDOWN, SWITCH_ON, ENABLE = 0x06, 0x07, 0x0F
STATUS_MASK, STATUS_ENABLED = 0x6F, 0x27
FRAME_US = 2_000_000


def outputs(device: Device, values: Mapping[str, int | Sequence[int]]) -> bytes:
    """By name of the object: a number for every axis, or one for each; what is not named is 0."""
    data = bytearray(device.bytes("rx"))
    for at, _, one, entry in device.places("rx"):
        if entry.field in values:
            value = values[entry.field]
            value = value if isinstance(value, int) else value[one.axis or 0]
            struct.pack_into(entry.format, data, at, value)
    return bytes(data)


def inputs(device: Device, data: bytes) -> dict[str, list[int]]:
    """By name of the object, a value for each axis."""
    found: dict[str, list[int]] = {}
    for at, _, _, entry in device.places("tx"):
        (value,) = struct.unpack_from(entry.format, data, at)
        found.setdefault(entry.field, []).append(value)
    return found


class Bus:
    """A master on the interface, and the device there. Raises RuntimeError when a step fails."""

    def __init__(self, device: Device) -> None:
        self.device = device
        for name, value in TIMEOUTS.items():
            setattr(pysoem.settings.timeouts, name, value)
        self.master = pysoem.Master()
        self.master.sdo_read_timeout = self.master.sdo_write_timeout = SDO_US
        self.wrong = 0

    def exchange(self, **values: int | Sequence[int]) -> bytes:
        """One cycle of process data while the device's time goes on by itself; the inputs."""
        slave = self.master.slaves[0]
        slave.output = outputs(self.device, values)
        self.master.send_processdata()
        self.count(self.master.receive_processdata(FRAME_US))
        return slave.input

    def count(self, counter: int) -> None:
        """A working counter has come."""
        self.wrong += counter != self.master.expected_wkc

    def state(self, wanted: int) -> None:
        """To that state, with process data going on."""
        self.master.state = wanted
        self.master.write_state()
        for _ in range(2000):
            self.exchange(mode=CSP)
            if self.master.state_check(wanted, 50_000) == wanted:
                return
        self.master.read_state()
        slave = self.master.slaves[0]
        raise RuntimeError(f"state {slave.state}, code {slave.al_status:04x}, not {wanted}")

    def bring_up(
        self, set_up: Callable[[pysoem.CdefSlave], None] = lambda _: None
    ) -> dict[str, object]:
        """To OP, as `exchange`; what was found on the way. set_up: writes objects in PREOP."""
        master = self.master
        master.open(INTERFACE)
        if (found := master.config_init()) != 1:
            raise RuntimeError(f"pysoem found {found} slaves, there is 1")
        slave = master.slaves[0]
        set_up(slave)
        mapped = master.config_map()
        if (state := master.state_check(pysoem.SAFEOP_STATE, 60_000_000)) != pysoem.SAFEOP_STATE:
            raise RuntimeError(f"state {state}, not SAFEOP")
        self.state(pysoem.OP_STATE)
        return {
            "name": slave.name,
            "identity": [slave.man, slave.id, slave.rev],
            "mapped_bytes": mapped,
            "expected_counter": master.expected_wkc,
            "state": "OP",
        }


class Session(Bus):
    """A master and the device in RTL in one process: each waits for the other."""

    def __init__(self, rtl: DeviceRtl, device: Device) -> None:
        super().__init__(device)
        self.rtl, self.tap = rtl, open_tap()

    def served(self) -> AbstractContextManager[None]:
        """The device's time goes on by itself, frames pass as they come."""
        return self.rtl.served(self.tap)

    def cycle(self, data: bytes, ticks: int, tick: Callable[[], None]) -> bytes:
        """One cycle of process data at exact times, while not `served`: the frame goes out, `ticks`
        control ticks pass, the inputs come back."""
        slave = self.master.slaves[0]
        slave.output = data
        self.master.send_processdata()
        if self.rtl.take(self.tap) != 1:
            raise RuntimeError("the master did not send one frame in its cycle")
        for _ in range(ticks):
            tick()
        self.rtl.give(self.tap)
        self.count(self.master.receive_processdata(FRAME_US))
        return slave.input
