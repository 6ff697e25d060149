# SPDX-License-Identifier: Apache-2.0
"""The master of the bus between LinuxCNC and the drives: pysoem, unmodified, a process of its own.

    python -m sim.bus.linuxcnc.master FOLDER     started by sim.bus.linuxcnc.machine

A frame of process data for each request of LinuxCNC's component. It switches the drives on and off
by CiA 402, homes them by method 37, and hands faults on. `log` takes a record for each frame.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pysoem

from sim.bus.coe.dictionary import Device, load
from sim.bus.linuxcnc.config import DEGREE, MM, TABLE_AXES
from sim.bus.linuxcnc.link import (
    AXES,
    ENABLE,
    ENABLED,
    ESTOP_OK,
    FROM_MASTER,
    HOME,
    HOMED,
    LINK,
    REQUEST,
    TO_MASTER,
    Request,
    answer,
    receive,
)
from sim.bus.machine import increments
from sim.bus.session import (
    CSP,
    SHUTDOWN,
    STATUS_ENABLED,
    STATUS_MASK,
    SWITCH_ON,
    Bus,
    inputs,
    outputs,
)
from sim.bus.session import ENABLE as ENABLE_OPERATION
from sim.robot.parameters import Robot

HOMING, METHOD_37 = 6, 37
HOME_OFFSET, HOMING_METHOD, AXIS_STEP = 0x607C, 0x6098, 0x800
HOMING_START, HOMING_ATTAINED = 0x10, 0x1000
QUICK_STOP, FAULT_RESET = 0x02, 0x80
STATUS_FAULT, STATUS_READY, STATUS_ON = 0x08, 0x21, 0x23
RESET_PERIODS = 50
MOST_LOST = 3  # periods without process data in a row, after which the bus counts as lost
ANSWER_US, SILENT_US = 10_000_000, 20_000  # wait for an answer; of a bus that counts as lost
LOG = np.dtype(
    [
        ("number", "u4"),
        ("flags", "u4"),
        ("right", "u1"),
        ("target", "f8", AXES),
        ("position", "f8", AXES),
        ("status", "u2", AXES),
        ("error", "u2", AXES),
    ]
)
"""Of a frame: LinuxCNC's request, whether the working counter was right; positions in m, rad."""


class Drives:
    """The state machines of five drives, driven by LinuxCNC's flags, and what LinuxCNC hears."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.increments = increments(device)
        self.units = np.array([MM] * TABLE_AXES + [DEGREE] * (AXES - TABLE_AXES))
        self.status = [0] * AXES
        self.error = [0] * AXES
        self.position = np.zeros(AXES)
        self.mode = [CSP] * AXES
        self.homing = self.homed = False
        self.enabled_by = 0  # flags ENABLE with which a drive came to operation enabled
        self.faults = self.wanted = 0
        self.patience = 0  # periods that an old fault may last after switching on
        self.lost = self.silent = 0

    def outputs(self, request: Request) -> bytes:
        """Process data for a request."""
        wanted = request.flags & ENABLE if request.flags & ESTOP_OK else 0
        risen = wanted & ~self.wanted
        self.wanted = wanted
        self.faults &= ~risen
        self.patience = RESET_PERIODS if risen else max(0, self.patience - 1)
        self.enabled_by &= wanted
        if request.flags & HOME and not self.homing and not self.homed and self.all_enabled():
            self.homing = True
        words = [self._controlword(n, request.flags) for n in range(AXES)]
        mode = HOMING if self.homing else CSP
        pose = np.array(request.target) / self.units
        targets = np.rint(pose / self.increments).astype(int).tolist()
        return outputs(
            self.device, {"controlword": words, "mode": mode, "target_position": targets}
        )

    def _controlword(self, axis: int, flags: int) -> int:
        status, on = self.status[axis], flags >> axis & 1
        state = status & STATUS_MASK
        if status & STATUS_FAULT:
            return FAULT_RESET if on and not self.faults >> axis & 1 else 0
        if not flags & ESTOP_OK:
            return QUICK_STOP
        if not on:
            return SWITCH_ON if state == STATUS_ENABLED else SHUTDOWN
        if state == STATUS_ENABLED:
            begin = self.homing and self.mode[axis] == HOMING
            return ENABLE_OPERATION | (HOMING_START if begin else 0)
        return {STATUS_READY: SWITCH_ON, STATUS_ON: ENABLE_OPERATION}.get(state, SHUTDOWN)

    def all_enabled(self) -> bool:
        """Whether every drive is in operation enabled."""
        return all(word & STATUS_MASK == STATUS_ENABLED for word in self.status)

    def take(self, data: bytes) -> None:
        """Process data of the drives."""
        self.silent = 0
        back = inputs(self.device, data)
        self.status, self.error = back["statusword"], back["error_code"]
        self.mode = back["mode_display"]
        self.position = np.array(back["position_actual"]) * self.increments
        for n, word in enumerate(self.status):
            enabled = word & STATUS_MASK == STATUS_ENABLED
            if enabled:
                self.enabled_by |= self.wanted & 1 << n
            was_enabled = bool(self.enabled_by & 1 << n)
            failed = self.error[n] and (was_enabled or not self.patience)
            if self.wanted >> n & 1 and (failed or (was_enabled and not enabled)):
                self.faults |= 1 << n
        attained = all(word & HOMING_ATTAINED for word in self.status)
        if self.homing and attained and self.mode == [HOMING] * AXES:
            self.homing, self.homed = False, True

    def missed(self) -> None:
        """No process data in this period."""
        self.lost += 1
        self.silent += 1

    def answer(self, request: Request) -> bytes:
        """For LinuxCNC's component."""
        flags = LINK if self.silent < MOST_LOST else 0
        in_csp = self.mode == [CSP] * AXES
        flags |= ENABLED if self.all_enabled() and in_csp and not self.silent else 0
        flags |= HOMED if self.homed and in_csp else 0
        position = (self.position * self.units).tolist()
        return answer(request.number, flags, self.lost, self.faults, self.error, position)


def set_up(device: Device, pose: Sequence[float]) -> list[tuple[int, bytes]]:
    """Objects before OP: each axis homes where it is, which is this pose [m, rad]."""
    found = []
    for axis, (place, increment) in enumerate(zip(pose, increments(device), strict=True)):
        offset = round(place / increment).to_bytes(4, "little", signed=True)
        found.append((HOME_OFFSET + AXIS_STEP * axis, offset))
        found.append((HOMING_METHOD + AXIS_STEP * axis, bytes([METHOD_37])))
    return found


def serve(exchange: Callable[[bytes, int], bytes | None], device: Device, folder: Path) -> None:
    """Answer LinuxCNC until it goes away.

    exchange: a frame with these outputs, and how long to wait for the inputs [us]; None: lost.
    """
    drives = Drives(device)
    record = np.zeros(1, LOG)
    with (
        (folder / "log").open("wb", buffering=0) as log,
        (folder / TO_MASTER).open("rb", buffering=0) as to_master,
        (folder / FROM_MASTER).open("wb", buffering=0) as from_master,
    ):
        while len(data := receive(to_master, REQUEST.size)) == REQUEST.size:
            request = Request.unpack(data)
            wait = ANSWER_US if drives.silent < MOST_LOST else SILENT_US
            back = exchange(drives.outputs(request), wait)
            if back is None:
                drives.missed()
            else:
                drives.take(back)
            target = np.array(request.target) / drives.units
            record[0] = (
                *(request.number, request.flags, back is not None, target),
                *(drives.position, drives.status, drives.error),
            )
            log.write(record.tobytes())
            try:
                from_master.write(drives.answer(request))
            except BrokenPipeError:  # LinuxCNC ended while it waited
                return


def main() -> None:
    """To OP, then to LinuxCNC's orders. Says OP, and waits for a line before it serves."""
    folder = Path(sys.argv[1])
    device, robot = load(), Robot.load(Path(sys.argv[2]))
    bus = Bus(device)

    def write(slave: pysoem.CdefSlave) -> None:
        for index, value in set_up(device, robot.start):
            slave.sdo_write(index, 0, value)

    bus.bring_up(write)
    print("OP", flush=True)
    sys.stdin.readline()

    def exchange(data: bytes, wait_us: int) -> bytes | None:
        slave, master = bus.master.slaves[0], bus.master
        slave.output = data
        master.send_processdata()
        right = master.receive_processdata(wait_us) == master.expected_wkc
        return slave.input if right else None

    serve(exchange, device, folder)


if __name__ == "__main__":
    main()
