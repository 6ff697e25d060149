# SPDX-License-Identifier: Apache-2.0
"""pysoem, unmodified, against the application on this machine: services of the mailbox and states.

    unshare -rn python -m tests.ethercat.pysoem_services

A second process serves the TAP device: it executes the datagrams of each frame on the double of the
slave controller. Logical addresses are not served. Prints a report as JSON.
"""

from __future__ import annotations

import json
import os
import select
import signal
import struct
import sys
import time
from typing import Any

import pysoem

from sim.bus.coe import sii
from sim.bus.coe.firmware import firmware
from sim.bus.gen.esc_regmap import AL_CONTROL, AL_STATUS, AL_STATUS_CODE, STATION_ADDRESS
from sim.bus.tap import INTERFACE, open_tap
from tests.ethercat.host import DEVICE, Host

TYPE = b"\x88\xa4"
PASSWORD, PRODUCT = DEVICE.mailbox["foe_password"], DEVICE.device["product"]
APRD, APRW, FPRD, FPRW, BRD, BRW = 1, 3, 4, 6, 7, 9
IDENTIFICATION = 0x1234
WAIT_US = 2_000_000


def execute(host: Host, command: int, address: int, offset: int, data: bytes) -> tuple[int, bytes]:
    """A datagram at the only slave: what it adds to the working counter, and the data."""
    position = command <= APRW
    station = FPRD <= command <= FPRW and address == host.word(STATION_ADDRESS.address)
    if not (position and address == 0 or station or BRD <= command <= BRW):
        return 0, data
    kind = (command - APRD) % 3 + 1  # 1 read, 2 write, 3 both
    counter, found = 0, data
    if kind & 1 and (read := host.read(offset, len(data))) is not None:
        counter += 1
        found = bytes(a | b for a, b in zip(read, data, strict=True)) if command >= BRD else read
    if kind & 2 and host.write(offset, data):
        counter += kind - 1
    return counter, found


def answer(host: Host, frame: bytes) -> bytes:
    """The frame as it comes back."""
    found, at, more = bytearray(frame), 16, frame[12:14] == TYPE
    while more:
        command, _, address, offset, length, _ = struct.unpack_from("<BBHHHH", found, at)
        size, more = length & 0x7FF, length >> 15
        body = slice(at + 10, at + 10 + size)
        added, found[body] = execute(host, command, address, offset, bytes(found[body]))
        counter = int.from_bytes(found[body.stop : body.stop + 2], "little") + added
        found[body.stop : body.stop + 2] = counter.to_bytes(2, "little")
        if command <= APRW or command >= BRD:
            struct.pack_into("<H", found, at + 2, address + 1 & 0xFFFF)
        at = body.stop + 2
    found[6] |= 2  # the source address of a frame that a slave passed on
    return bytes(found)


def serve(host: Host, tap: int) -> None:
    image = sii.image(DEVICE)
    host.library.double_sii(image, len(image))
    while True:
        if select.select([tap], [], [], 0.001)[0]:
            os.write(tap, answer(host, os.read(tap, 2048)))
        host.cycle()


def to_state(slave: Any, state: int) -> int:
    """Request a state, acknowledging an error; the state in which the slave is then."""
    slave.state = state | 0x10
    slave.write_state()
    return slave.state_check(state, WAIT_US)


def registers(slave: Any) -> list[int]:
    """AL_STATUS and AL_STATUS_CODE."""
    return [
        int.from_bytes(slave._fprd(one.address, 2), "little") for one in (AL_STATUS, AL_STATUS_CODE)
    ]


def boot(slave: Any) -> dict[str, object]:
    """Firmware to the device and back."""
    file, other = firmware(bytes(range(256)) * 20, PRODUCT), firmware(bytes(100), PRODUCT + 1)
    to_state(slave, pysoem.BOOT_STATE)
    report: dict[str, object] = {"preop_to_boot": registers(slave)}
    report["init"] = to_state(slave, pysoem.INIT_STATE)
    report["boot"] = to_state(slave, pysoem.BOOT_STATE)
    report["written"] = slave.foe_write("firmware", PASSWORD, file, WAIT_US) > 0
    report["read_back"] = slave.foe_read("firmware", PASSWORD, len(file) + 100, WAIT_US) == file
    for name, args in {
        "other_device": ("firmware", PASSWORD, other),
        "password": ("firmware", 0, file),
        "name": ("firm", PASSWORD, file),
    }.items():
        report[name] = slave.foe_write(*args, WAIT_US)
    report["still_there"] = slave.foe_read("firmware", PASSWORD, len(file) + 100, WAIT_US) == file
    report["init_again"] = to_state(slave, pysoem.INIT_STATE)
    report["preop"] = to_state(slave, pysoem.PREOP_STATE)
    report["device_type"] = slave.sdo_read(0x1000, 0).hex()
    return report


def identify(slave: Any) -> list[int]:
    """The identification value by the registers, as a master requests it."""
    slave.sdo_write(0x2021, 0, struct.pack("<H", IDENTIFICATION))
    slave._fpwr(
        AL_CONTROL.address, AL_CONTROL.word(state=2, identification=1).to_bytes(2, "little")
    )
    time.sleep(0.05)
    found = registers(slave)
    slave._fpwr(AL_CONTROL.address, AL_CONTROL.word(state=2).to_bytes(2, "little"))
    return found


def main() -> int:
    """Print the report."""
    host, tap = Host(), open_tap()
    child = os.fork()
    if not child:
        serve(host, tap)
    try:
        master = pysoem.Master()
        master.open(INTERFACE)
        found = master.config_init()
        slave = master.slaves[0]
        slave.state_check(pysoem.PREOP_STATE, WAIT_US)
        report = {
            "found": found,
            "name": slave.name,
            "identify": identify(slave),
            "boot": boot(slave),
        }
        print(json.dumps(report))
    finally:
        os.kill(child, signal.SIGTERM)
    return 0


if __name__ == "__main__":
    sys.exit(main())
