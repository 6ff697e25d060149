# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC against the application on this machine: no frames, so that a whole path takes minutes.

    python -m tests.ethercat.linuxcnc_host part.ngc --fault drive

Component, configuration and the drives' state machines are those of `microtick linuxcnc`; pysoem
and the RTL of the slave are left out. The law is the ASIP in RTL.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

from sim.bus.linuxcnc import page
from sim.bus.linuxcnc.config import prepare, started
from sim.bus.linuxcnc.machine import FAULT_NOW, Recorded
from sim.bus.linuxcnc.master import serve, set_up
from sim.bus.linuxcnc.result import Run
from sim.bus.machine import Machine
from sim.bus.path_run import TICKS
from sim.robot.parameters import Robot
from tests.ethercat.host import DEVICE, Host
from tests.ethercat.host_link import HostLink

FAULT_AFTER = 400
AFTER = 100  # periods without a master


class DeadMasterError(Exception):
    """The master ends here."""


def play(folder: Path, program: Path, fault: str = "", periods: int = 0) -> Run:
    """The whole run in an empty folder."""
    robot = Robot.load(None)
    prepare(folder, robot, program, periods, fault, FAULT_AFTER)
    host = Host().to_op()
    for index, value in set_up(DEVICE, robot.start):
        host.download(index, 0, value)
    link = HostLink(host)
    recorded = Recorded(link.rtl, Machine(robot, DEVICE, robot.start), fault)
    frames = 0

    def exchange(data: bytes, wait_us: int) -> bytes | None:
        nonlocal frames
        frames += 1
        if fault and recorded.fault_tick is None and (folder / FAULT_NOW).exists():
            recorded.begin_fault()
            if fault == "master":
                raise DeadMasterError
        if fault == "cable" and recorded.fault_tick is not None:
            for _ in range(TICKS):
                recorded.tick()
            return None
        return link.cycle(data, TICKS, recorded.tick)

    with (folder / "linuxcnc.log").open("w") as log, started(folder, log) as cnc:
        try:
            serve(exchange, DEVICE, folder)
        except DeadMasterError:
            for _ in range(AFTER * TICKS):
                recorded.tick()
        cnc.wait()
    recorded.save(folder)
    state, code = host.status
    words = [host.get(0x6041 + 0x800 * n) for n in range(5)]
    errors = [host.get(0x603F + 0x800 * n) for n in range(5)]
    machine = {
        "frames": frames,
        "fault_tick": recorded.fault_tick,
        "longest_pass": 0,
        "al_state": state,
        "al_code": code,
        "statuswords": words,
        "error_codes": errors,
    }
    return Run.read(folder, machine)


def main() -> None:
    """Print the report of a run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--fault", default="")
    parser.add_argument("--periods", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        begun = time.monotonic()
        run = play(Path(name), options.program, options.fault, options.periods)
        for line in run.events:
            if line["event"] != "line":
                print(json.dumps(line))
        print((Path(name) / "linuxcnc.log").read_text())
        report = run.report() | {"program": options.program.name}
        print(json.dumps(report))
        print(page.summary(report))
        print(f"{time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
