# SPDX-License-Identifier: Apache-2.0
"""pysoem, unmodified, against the whole device in RTL: its program answers; a report as JSON.

    unshare -rn python -m sim.bus.device_run

Scan, mapping by CoE, SAFEOP, OP; the dictionary read by SDO and browsed; five axes enabled and
moved in CSP. Then frames come at exact times, and the cycles of the control passes are counted.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

import pysoem

from asip_asm.command import command
from asip_asm.project import ROOT
from sim.bus.coe.dictionary import Device, load
from sim.bus.coe.page import table
from sim.bus.datagram import LRW, single
from sim.bus.device import CYCLE_CLOCKS, DeviceRtl
from sim.bus.machine import FLAGS, POWER
from sim.bus.session import (
    CSP,
    ENABLE,
    SHUTDOWN,
    START_NS,
    STATUS_ENABLED,
    STATUS_MASK,
    SWITCH_ON,
    Session,
    inputs,
    outputs,
)
from sim.bus.tap import command_line, in_namespace
from sim.report.marks import write_between_marks

PAGE = ROOT / "docs/ethercat_application.md"
WAIT_PS = 500_000_000
GOAL = 20_000  # increments, of all axes
PERIODS_US = (1000, 100, 62.5)
# Each frame comes this much earlier than its period says. So 200 frames meet the tick of 100 us at
# 200 phases 0.5 us apart, and at 50 phases 2 us apart with a period of 62.5 us.
EARLIER_NS = 500


class Trial(Session):
    """What is tried with a device that runs."""

    def dictionary(self, step: int) -> dict[str, object]:
        """Every `step`-th object read and described; what differs from the source."""
        slave, different, entries = self.master.slaves[0], [], 0
        listed = slave.od
        indices = [o.index for o in listed]
        if indices != [o.index for o in self.device.objects]:
            different.append("list of objects")
        for found, one in list(zip(listed, self.device.objects, strict=True))[::step]:
            name = found.name.decode() if isinstance(found.name, bytes) else found.name
            if name != one.name:
                different.append(f"{one.index:04X} name {name!r}")
            for entry in one.entries:
                # The watchdog and the limit of lost outputs want them to go on.
                self.exchange(controlword=ENABLE, mode=CSP, target_position=GOAL)
                data = slave.sdo_read(one.index, entry.subindex, size=entry.bytes)
                entries += 1
                if data != entry.data() and entry.access != "ro" and entry.pdo != "rx":
                    different.append(f"{one.index:04X}:{entry.subindex:02X} {data.hex()}")
        return {"objects": len(indices), "entries_read": entries, "different": different}

    def label(self) -> bool:
        """480 bytes there and back, in segments; an abort is reported by its code."""
        slave, text = self.master.slaves[0], bytes(33 + n % 90 for n in range(480))
        slave.sdo_write(0x2020, 0, text)
        try:
            slave.sdo_read(0x3000, 0)
            return False
        except pysoem.SdoError as error:
            return (
                slave.sdo_read(0x2020, 0, size=len(text)) == text and error.abort_code == 0x06020000
            )

    def drive(self) -> dict[str, object]:
        """All axes to operation enabled, then a way in CSP; where the first one ends."""
        for control in (SHUTDOWN, SWITCH_ON, ENABLE):
            for _ in range(8):
                data = self.exchange(controlword=control, mode=CSP)
                self.rtl_wait()
        words = inputs(self.device, data)["statusword"]
        for position in range(0, GOAL + 1, 200):
            self.exchange(controlword=ENABLE, mode=CSP, target_position=position)
            self.rtl_wait()
        for _ in range(60):
            data = self.exchange(controlword=ENABLE, mode=CSP, target_position=GOAL)
            self.rtl_wait()
        return {
            "enabled": [word & STATUS_MASK == STATUS_ENABLED for word in words],
            "actual_position": inputs(self.device, data)["position_actual"][0],
        }

    def rtl_wait(self) -> None:
        """Let the device's time go on, which it does while the master sleeps."""
        before = self.rtl.now
        while self.rtl.now - before < WAIT_PS:
            time.sleep(0.001)


def measure(rtl: DeviceRtl, device: Device, period_us: float, cycles: int) -> dict[str, float]:
    """Clock cycles of the control passes with a frame of process data each `period_us`, less
    EARLIER_NS, so that frames meet a pass at every phase; whether all axes have power still."""
    values = {"controlword": ENABLE, "mode": CSP, "target_position": GOAL}
    # At logical address 0 SOEM has put outputs, then inputs.
    frame = single(LRW, 0, 0, outputs(device, values) + bytes(device.bytes("tx")))
    for n in range(cycles + 20):
        if n == 20:
            rtl.restart_counts()
        rtl.send(frame)
        rtl.run(round(period_us * 1000) - EARLIER_NS)
    counts = rtl.counts()
    return {
        "period_us": period_us,
        "passes": counts["ticks"],
        "powered": bool((rtl.outputs[FLAGS] & POWER).all()),
        "longest": counts["longest"],
        "mean": counts["sum"] // max(1, counts["ticks"]),
    }


def run(step: int, cycles: int) -> dict[str, Any]:
    """Everything, of the dictionary each `step`-th object; the report.

    Raises RuntimeError when the device does not come to OP.
    """
    device = load()
    rtl = DeviceRtl()
    rtl.run(START_NS)
    session = Trial(rtl, device)
    with session.served():
        report = session.bring_up()
        report["drive"] = session.drive()
        if step:
            report["dictionary"] = session.dictionary(step)
            report["segments"] = session.label()
        report["wrong_counters"] = session.wrong
    report["passes"] = [measure(rtl, device, period, cycles) for period in PERIODS_US]
    report["console"] = rtl.console
    session.master.close()
    return report


def publish() -> int:
    """Run all of it and put the figures on the page; returns the exit status."""
    done = in_namespace("sim.bus.device_run", ["--step", "1", "--cycles", "200"], timeout=3600)
    if done.returncode:
        print(done.stderr or done.stdout, file=sys.stderr)
        return 1
    report = json.loads(done.stdout)
    read = report["dictionary"]
    head = ["frames each [µs]", "control passes", "longest [cycles]", "mean [cycles]"]
    keys = ("period_us", "passes", "longest", "mean")
    rows = [[str(row[key]) for key in keys] for row in report["passes"]]
    lines = [
        f"State {report['state']}, working counter {report['expected_counter']}, "
        f"{report['wrong_counters']} wrong; {read['objects']} objects listed, "
        f"{read['entries_read']} entries read, {len(read['different'])} other than the source.",
        "",
        *table(head, rows),
        "",
        f"Each frame comes {EARLIER_NS / 1000:g} µs earlier than the period says, so that frames "
        "meet every phase of the tick. "
        f"A pass may take {CYCLE_CLOCKS} cycles: 100 µs at 100 MHz, five axes in CSP.",
    ]
    texts = {"device": "\n".join(["", *lines, "", ""])}
    write_between_marks(PAGE, texts)
    return 0


@command("python -m sim.bus.device_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the device did all, 1 if not."""
    parser = command_line(__doc__, "device_run --step 1")
    parser.add_argument(
        "--step", type=int, default=12, help="read each STEP-th object, 0: none (default 12)"
    )
    parser.add_argument("--cycles", type=int, default=50, help="frames of a measurement (50)")
    parser.add_argument("--docs", action="store_true", help="in a namespace, then to the page")
    arguments = parser.parse_args(argv)
    if arguments.docs:
        return publish()
    report = run(arguments.step, arguments.cycles)
    print(json.dumps(report))
    return 0 if not (arguments.step and report["dictionary"]["different"]) else 1


if __name__ == "__main__":
    sys.exit(main())
