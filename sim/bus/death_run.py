# SPDX-License-Identifier: Apache-2.0
"""pysoem stops in OP while the axes move: what the device in RTL and its program do then.

    unshare -rn python -m sim.bus.death_run

After the silence the master comes again, reads states and counters, and brings the device back to
OP. Prints a report as JSON.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Sequence

import numpy as np
import pysoem

from asip_asm.command import command
from sim.bus.coe.dictionary import load
from sim.bus.device import DeviceRtl
from sim.bus.device_run import GOAL, Trial
from sim.bus.gen import esc_regmap
from sim.bus.machine import AXES, FLAGS, POWER
from sim.bus.pysoem_master import read
from sim.bus.register import ByteRegister
from sim.bus.session import CSP, ENABLE, START_NS
from sim.bus.tap import command_line

AXIS_STEP = 0x800
STATE_AND_ERROR = sum(esc_regmap.AL_STATUS.fields[name].mask for name in ("state", "error"))
ERROR_CODE, STATUSWORD = 0x603F, 0x6041
TICK_NS = 100_000
STEP = 500  # increments of a target to the next
CYCLES = 40
ANSWER_US = 5_000_000
POLLS = 4 * AXES


def silence(rtl: DeviceRtl, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the first axis and whether any axis has power, tick by tick."""
    positions, power = [], []
    for _ in range(ticks):
        rtl.run(TICK_NS)
        positions.append(int(rtl.outputs[:1].view(np.int32)[0]))
        power.append(bool((rtl.outputs[FLAGS] & POWER).any()))
    return np.array(positions), np.array(power)


def first(condition: np.ndarray) -> int | None:
    """The first index at which it holds from there on."""
    if not len(condition) or not condition[-1]:
        return None
    return int(len(condition) - np.argmin(condition[::-1])) if not condition.all() else 0


def run(ticks: int) -> dict[str, object]:
    """The report. Raises RuntimeError when the device does not come to OP.

    state, code: 0130 and 0134 after the silence; watchdog: by how much 0442 rose; error_codes,
    statuswords: of each axis; emergencies: their codes. From the last frame on, in control ticks
    of 100 us: moving: increments of the first axis in a tick, at first; moved: in all; stopped_at:
    it is at rest from there on, unpowered_at: no axis has power any more, None: never. again: the
    state that the device was brought back to.
    """
    rtl = DeviceRtl()
    rtl.run(START_NS)
    session = Trial(rtl, load())

    def register(which: ByteRegister) -> int:
        return read(session.master.slaves[0], which, ANSWER_US)

    emergencies: list[int] = []
    with session.served():
        session.bring_up()
        session.master.slaves[0].add_emergency_callback(
            lambda message: emergencies.append(message.error_code)
        )
        session.drive()
        for n in range(CYCLES):
            session.exchange(controlword=ENABLE, mode=CSP, target_position=GOAL + STEP * n)
            session.rtl_wait()
        before = register(esc_regmap.WATCHDOG_DATA_COUNT)
        session.exchange(controlword=ENABLE, mode=CSP, target_position=GOAL + STEP * CYCLES)
    positions, power = silence(rtl, ticks)
    speed = np.abs(np.diff(positions))
    with session.served():
        slave = session.master.slaves[0]
        state = register(esc_regmap.AL_STATUS) & STATE_AND_ERROR
        code = register(esc_regmap.AL_STATUS_CODE)
        watchdog = register(esc_regmap.WATCHDOG_DATA_COUNT) - before
        for _ in range(POLLS):  # SOEM takes an emergency for no answer to an SDO
            slave.mbx_receive()
            session.rtl_wait()
        words = [
            [
                struct.unpack("<H", slave.sdo_read(index + AXIS_STEP * n, 0, size=2))[0]
                for n in range(AXES)
            ]
            for index in (ERROR_CODE, STATUSWORD)
        ]
        session.exchange(mode=CSP)  # OP needs outputs first
        slave.state = pysoem.OP_STATE | pysoem.STATE_ACK
        slave.write_state()
        for _ in range(POLLS):
            session.exchange(mode=CSP)
            if (again := register(esc_regmap.AL_STATUS)) == pysoem.OP_STATE:
                break
            session.rtl_wait()
    session.master.close()
    return {
        "moving": int(speed[:10].max()),
        "powered": bool(power[0]),
        "moved": int(positions[-1] - positions[0]),
        "stopped_at": first(speed == 0),
        "unpowered_at": first(~power),
        "state": state,
        "code": code,
        "watchdog": watchdog,
        "error_codes": words[0],
        "statuswords": words[1],
        "emergencies": emergencies,
        "again": again,
    }


@command("python -m sim.bus.death_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 when the device came back to OP."""
    parser = command_line(__doc__, "death_run")
    parser.add_argument(
        "--ticks", type=int, default=1200, help="of silence, 100 us each (default 1200)"
    )
    report = run(parser.parse_args(argv).ticks)
    print(json.dumps(report))
    return 0 if report["again"] == pysoem.OP_STATE else 1


if __name__ == "__main__":
    sys.exit(main())
