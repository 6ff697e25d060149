# SPDX-License-Identifier: Apache-2.0
"""The whole device in RTL with process data each 62.5 us, its control locked to SYNC0; a report as
JSON.

    unshare -rn python -m sim.bus.locked_run --cycles 1000

pysoem, unmodified, brings the device to OP with SYNC0 and enables five axes in CSP. Then frames of
process data come at exact times, a part of them at each of PHASES phases of SYNC0, and all axes
follow targets that change in each cycle.
"""

from __future__ import annotations

import json
import math
import struct
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import pysoem

from asip_asm.command import command
from sim.bus.coe.dictionary import Device, load
from sim.bus.datagram import APRD, APWR, LRW, answer, single
from sim.bus.device import CLOCK_NS, WORD_CLOCKS, DeviceRtl
from sim.bus.machine import FLAGS, POWER
from sim.bus.session import CSP, ENABLE, SHUTDOWN, START_NS, SWITCH_ON, Session, outputs
from sim.bus.tap import command_line

CYCLE_NS = 62_500
PHASES = 25  # of the frames after SYNC0, 2.5 us apart
SETTLE = 40  # cycles at a phase before they count
AMPLITUDE, TURN = 50_000, 1600  # of the targets: increments, cycles
COUNTER = 3  # outputs and inputs of one slave
MISSED = (0x1C32, 11)  # cycles of the master without new outputs
EXCEEDED = (0x1C32, 12)  # control passes longer than a cycle
AXES = range(0x6000, 0x8800, 0x800)


def set_up(master: pysoem.Master, slave: pysoem.CdefSlave) -> None:
    """SYNC0, and in each axis the cycle as 60C2 can state it. Lost outputs are no fault yet."""
    slave.sdo_write(0x1C32, 1, struct.pack("<H", 2))
    slave.sdo_write(0x10F1, 2, struct.pack("<H", 0))
    for axis in AXES:
        slave.sdo_write(axis + 0xC2, 1, bytes([math.ceil(CYCLE_NS / 1000)]))
        slave.sdo_write(axis + 0xC2, 2, struct.pack("<b", -6))
    if not master.config_dc():
        raise RuntimeError("pysoem found no distributed clocks")
    slave.dc_sync(True, CYCLE_NS)


def enable(session: Session) -> None:
    """Each axis to operation enabled, where it is."""
    for control in (SHUTDOWN, SWITCH_ON, ENABLE):
        for _ in range(8):
            session.exchange(controlword=control, mode=CSP)
            time.sleep(0.01)


class Frames:
    """Process data at exact times. sent, right: frames, and those that came back with COUNTER."""

    def __init__(self, rtl: DeviceRtl, device: Device) -> None:
        self.rtl, self.device = rtl, device
        self.sent = self.right = self.turned = 0
        rtl.received()

    def cycle(self, *more: bytes) -> list[bytes]:
        """A cycle, with further frames after that of the process data; what came back of them."""
        target = round(AMPLITUDE * math.sin(2 * math.pi * self.turned / TURN))
        values = {"controlword": ENABLE, "mode": CSP, "target_position": target}
        # At logical address 0 SOEM has put outputs, then inputs.
        bytes_in, data = self.device.bytes("tx"), outputs(self.device, values)
        self.rtl.send(single(LRW, 0, 0, data + bytes(bytes_in)))
        for one in more:
            self.rtl.send(one)
        self.rtl.run(CYCLE_NS)
        self.sent, self.turned = self.sent + 1, self.turned + 1
        back = self.rtl.received()
        mine = [one for one in back if one[16] == LRW]
        self.right += sum(answer(one, len(data) + bytes_in)[1] == COUNTER for one in mine)
        return [one for one in back if one[16] != LRW]

    def cycles(self, count: int) -> None:
        for _ in range(count):
            self.cycle()

    def upload(self, index: int, subindex: int) -> int:
        """A number by SDO. Raises RuntimeError if the device does not give it."""
        coe = struct.pack("<HBHB4x", 2 << 12, 0x40, index, subindex)
        request = struct.pack("<HHBB", len(coe), 0, 0, 3) + coe
        self.cycle(single(APWR, 0, 0x1000, request.ljust(256, b"\0")))
        for _ in range(200):
            self.cycles(20)
            for back in self.cycle(single(APRD, 0, 0x1100, bytes(256))):
                if answer(back, 256)[1] and struct.unpack_from("<HB", back, 26 + 9) == (
                    index,
                    subindex,
                ):
                    return int.from_bytes(back[26 + 12 : 26 + 16], "little")
        raise RuntimeError(f"no answer for {index:04X}:{subindex:02X}")


def align(rtl: DeviceRtl) -> None:
    """Let time pass until SYNC0 begins: how long pysoem worked is not the same each time."""
    before = rtl.begun(1)[0][-1]
    while rtl.begun(1)[0][-1] == before:
        rtl.run(CLOCK_NS)


def phases(frames: Frames, cycles: int) -> Iterator[dict[str, int]]:
    """The counts of each phase, from frames that begin with SYNC0 on."""
    rtl = frames.rtl
    for _ in range(PHASES):
        frames.cycles(SETTLE)
        missed = frames.upload(*MISSED)
        rtl.restart_counts()
        frames.sent = frames.right = 0
        frames.cycles(cycles)
        counts = rtl.counts()
        found = {
            "wrong": frames.sent - frames.right,
            "late": counts["late"],
            "ticks": counts["ticks"],
            "longest": counts["longest"],
        }
        found["missed"] = frames.upload(*MISSED) - missed
        yield found
        rtl.run(CYCLE_NS // PHASES)


def apart(rtl: DeviceRtl, cycles: int) -> int:
    """Greatest distance of a SYNC0 from the tick next to it, clocks, over the last cycles."""
    syncs, dues = rtl.begun(cycles)
    at = np.clip(np.searchsorted(dues, syncs), 1, len(dues) - 1)
    return int(np.minimum(abs(dues[at] - syncs), abs(dues[at - 1] - syncs))[1:-1].max())


def run(cycles: int) -> dict[str, Any]:
    """So many cycles at each phase; the sums and worst values.

    Raises RuntimeError when the device does not come to OP or an axis loses its power.
    """
    device = load()
    rtl = DeviceRtl(CYCLE_NS)
    rtl.run(START_NS)
    session = Session(rtl, device)
    with session.served():
        session.bring_up(partial(set_up, session.master))
        enable(session)
    align(rtl)
    frames = Frames(rtl, device)
    before = frames.upload(*EXCEEDED)
    rows = list(phases(frames, cycles))
    exceeded = frames.upload(*EXCEEDED) - before
    session.master.close()
    if not (rtl.outputs[FLAGS] & POWER).all():
        raise RuntimeError("an axis lost its power")
    return {
        "cycles": PHASES * cycles,
        **{name: sum(row[name] for row in rows) for name in ("wrong", "late", "ticks", "missed")},
        "exceeded": exceeded,
        "longest": max(row["longest"] for row in rows),
        "limit": rtl.cycle_clocks - WORD_CLOCKS,
        "apart": apart(rtl, PHASES * cycles),
        "missed_by_phase": [row["missed"] for row in rows],
        "console": rtl.console,
    }


@command("python -m sim.bus.locked_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0."""
    parser = command_line(__doc__, "locked_run --cycles 1000")
    parser.add_argument("--cycles", type=int, default=40, help="cycles at each phase (40)")
    print(json.dumps(run(parser.parse_args(argv).cycles)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
