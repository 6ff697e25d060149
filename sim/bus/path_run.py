# SPDX-License-Identifier: Apache-2.0
"""A path over the bus: pysoem, unmodified, sends targets in CSP each millisecond; a report as JSON.

    unshare -rn python -m sim.bus.path_run --ticks 5000 --capture bus.pcap --curves path.npz

Everything is RTL but the robot: slave controller, Nios II system with the device's program, ASIP
with the tracking program. Master and device take turns, so that a frame comes each 1 ms of the
simulated time, to the clock. The tool is compared with the path DELAY ticks before: a target is
reached 2.5 periods after the pass that took it, and passes take it and act a tick later each.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.command import command
from asip_asm.files import replaced
from sim.bus.coe.dictionary import Device, load
from sim.bus.device import CYCLE_NS, IMAGES, DeviceRtl
from sim.bus.machine import Machine
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
from sim.bus.tap import command_line, progress_of
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints


def delay(ticks: int) -> int:
    """Control ticks from a target to the tool, so many in a cycle of the master: 2.5 cycles of the
    interpolation, and a tick until the pass that takes it."""
    return 5 * ticks // 2 + 1


MASTER_NS = 1_000_000  # cycle of the master
TICKS = MASTER_NS // CYCLE_NS
DELAY = delay(TICKS)
REST = 60  # cycles at the first and after the last target
FOLLOWING_ERROR = 0x8611
CYCLES_US = [ns / 1000 for ns in IMAGES]


@dataclass(frozen=True)
class Curves:
    """Over N ticks: wanted and exact tool (N, 3) [m], and table (N, 2) [rad]."""

    wanted: NDArray[np.float64]
    tool: NDArray[np.float64]
    wanted_table: NDArray[np.float64]
    table: NDArray[np.float64]

    @property
    def tool_error(self) -> float:
        """Largest distance [m]."""
        return float(np.linalg.norm(self.tool - self.wanted, axis=1).max())

    @property
    def table_error(self) -> float:
        """Largest of both axes [rad]."""
        return float(np.abs(self.table - self.wanted_table).max())


class Drive:
    """A master's loop over the axes, in turns with the device.

    session: its `cycle` and its device's `tick`, `inputs` and `outputs` are called for.
    ticks: of the control in a cycle of the master.
    """

    def __init__(
        self, session: Session, device: Device, machine: Machine, ticks: int = TICKS
    ) -> None:
        self.session, self.device, self.machine = session, device, machine
        self.ticks = ticks
        self.faults: set[str] = set()
        self.following = 0
        self.enabled = False

    def tick(self) -> None:
        """The robot and the device, a control period each."""
        rtl = self.session.rtl
        rtl.inputs[:] = self.machine.measured()
        before = rtl.outputs.copy()
        rtl.tick()
        self.machine.advance(before)

    def cycle(self, control: int, pose: NDArray[np.float64]) -> None:
        """A cycle of the master with this target (5,) [m, rad]."""
        targets = np.rint(pose / self.machine.increments).astype(int).tolist()
        data = outputs(
            self.device, {"controlword": control, "mode": CSP, "target_position": targets}
        )
        back = inputs(self.device, self.session.cycle(data, self.ticks, self.tick))
        states = [word & STATUS_MASK == STATUS_ENABLED for word in back["statusword"]]
        for axis, (enabled, code) in enumerate(zip(states, back["error_code"], strict=True)):
            self.following += code == FOLLOWING_ERROR
            if code or (self.enabled and not enabled):
                self.faults.add(f"axis {axis}: {code:04X}")
        self.enabled = all(states)

    def enable(self, pose: NDArray[np.float64]) -> None:
        """All axes to operation enabled, at rest. Raises RuntimeError."""
        for control in (SHUTDOWN, SWITCH_ON, *[ENABLE] * REST):
            for _ in range(3 if control != ENABLE else 1):
                self.cycle(control, pose)
        if not self.enabled:
            raise RuntimeError(f"not all axes are enabled; {', '.join(sorted(self.faults))}")

    def follow(self, wanted: NDArray[np.float64]) -> Curves:
        """Enable at the first pose (N, 5), send every `ticks`-th, rest after the last one."""
        self.enable(wanted[0])
        begin = len(self.machine.places) + delay(self.ticks)
        sent = wanted[:: self.ticks]
        progress = progress_of(len(sent), 20)
        for n, pose in enumerate(sent, start=1):
            self.cycle(ENABLE, pose)
            progress(n)
        for _ in range(REST):
            self.cycle(ENABLE, sent[-1])
        n = (len(sent) - 1) * self.ticks + 1  # ticks between the first target and the last
        places = np.array(self.machine.places)[begin : begin + n]
        return Curves(wanted[:n, :3], places[:, :3], wanted[:n, 3:], places[:, 3:])


def path_of(robot: Robot, ticks: int | None) -> SetPoints:
    """Set-points of the A-G-H path, the first ones or all."""
    return set_points(generate(parse_file(AGH, robot=robot), MotionSettings(robot)), ticks)


def poses(path: SetPoints) -> NDArray[np.float64]:
    """Of every tick (N, 5): x, y, z [m], tilt, rotation [rad]."""
    return np.concatenate((path.position, path.table_position), axis=1)


def run(robot: Robot, ticks: int | None, capture: Path | None) -> tuple[dict[str, object], Curves]:
    """Bring the device up and send the path; cycles of the master on it, errors of tool [m] and
    table [rad]. Raises RuntimeError, ControllerFault."""
    device = load()
    path = path_of(robot, ticks)
    wanted = poses(path)
    cycle_ns = round(robot.T_s * 1e9)
    rtl = DeviceRtl(cycle_ns)
    if capture:
        rtl.capture(capture)
    machine = Machine(robot, device, wanted[0].tolist())
    rtl.take_machine()
    rtl.inputs[:] = machine.measured()
    rtl.run(START_NS)
    session = Session(rtl, device)
    with session.served():
        session.bring_up()
    rtl.align()
    rtl.restart_counts()
    session.wrong = 0
    drive = Drive(session, device, machine, MASTER_NS // cycle_ns)
    curves = drive.follow(wanted)
    session.master.close()
    report = {
        "cycles": len(wanted[:: drive.ticks]),
        "whole": ticks is None,
        "wrong_counters": session.wrong,
        "following_errors": drive.following,
        "faults": sorted(drive.faults),
        "tool": curves.tool_error,
        "table": curves.table_error,
        "longest_pass": rtl.counts()["longest"],
        "frames": rtl.counts()["sent"],
    }
    return report, curves


@command("python -m sim.bus.path_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if every axis stayed enabled and no counter was wrong, 1 if not."""
    parser = command_line(__doc__, "path_run --ticks 2000")
    parser.add_argument("--ticks", type=int, help="of the control, of the path (default: all)")
    parser.add_argument(
        "--cycle-us", type=float, choices=CYCLES_US, default=100, help="of the control (100)"
    )
    parser.add_argument("--capture", type=Path, help="pcap file of all frames")
    parser.add_argument("--curves", type=Path, help="npz file of the curves")
    arguments = parser.parse_args(argv)
    robot = replace(Robot.load(None), T_s=arguments.cycle_us / 1e6)
    report, curves = run(robot, arguments.ticks, arguments.capture)
    if arguments.curves:
        with replaced(arguments.curves) as new:
            np.savez_compressed(new, **vars(curves))
    print(json.dumps(report))
    return 0 if not report["faults"] and not report["wrong_counters"] else 1


if __name__ == "__main__":
    sys.exit(main())
