# SPDX-License-Identifier: Apache-2.0
"""The machine on the bus, in a namespace of its own: slave, drives and law in RTL, the robot.

    unshare -rn python -m sim.bus.linuxcnc.machine FOLDER     started by `microtick linuxcnc`

A period of 1 ms passes for each frame that the master sends; nothing passes without one. It starts
the master, says `ready` when the drives are in OP, then how many periods have passed. FAULT is what
happens as soon as the file `fault_now` is there.
"""

from __future__ import annotations

import argparse
import json
import os
import select
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.bus.coe.dictionary import Device, load
from sim.bus.datagram import APRD, DATA_AT, LRD, answer, single
from sim.bus.device import DeviceRtl
from sim.bus.gen import esc_regmap
from sim.bus.machine import AXES, FLAGS, POWER, Machine
from sim.bus.path_run import TICKS
from sim.bus.register import ByteRegister
from sim.bus.session import START_NS, inputs
from sim.bus.tap import open_tap
from sim.robot.parameters import Robot

DRIVE_AXIS, DRIVE_ERROR = 2, 0x5441  # the drive that fails, and how
AFTER_TICKS = 2000  # without a master, at the end
STATE_AND_ERROR = sum(esc_regmap.AL_STATUS.fields[name].mask for name in ("state", "error"))
FAULT_NOW = "fault_now"
SHOWN = 10  # periods between two reports
ANSWER_NS = 500_000


class Words(Protocol):
    """The device's side of the machine: words of a control tick."""

    inputs: NDArray[np.uint32]
    outputs: NDArray[np.uint32]

    def tick(self) -> None:
        """One control pass."""


class Recorded:
    """Device and robot, tick by tick. fault_tick: since when the machine's part of the fault acts.

    places (5,), powered: of each tick, the exact places at its begin, and whether all axes have
    power.
    """

    def __init__(self, words: Words, machine: Machine, fault: str) -> None:
        self.words, self.machine, self.fault = words, machine, fault
        self.places: list[tuple[float, ...]] = []
        self.powered: list[bool] = []
        self.fault_tick: int | None = None

    def begin_fault(self) -> None:
        """Now."""
        self.fault_tick = len(self.places)

    def tick(self) -> None:
        """A control period of the robot and the device."""
        words, plant = self.words, self.machine.plant
        words.inputs[:] = self.machine.measured()
        if self.fault == "drive" and self.fault_tick is not None:
            words.inputs[AXES + DRIVE_AXIS] |= np.uint32(DRIVE_ERROR << 16)
        self.places.append((*plant.tool, *plant.table))
        before = words.outputs.copy()
        words.tick()
        self.machine.advance(before)
        self.powered.append(bool((words.outputs[FLAGS] & POWER).all()))

    def save(self, folder: Path) -> None:
        """To the file that `result.Run` reads."""
        places, powered = np.array(self.places), np.array(self.powered)
        np.savez(folder / "machine.npz", places=places, powered=powered)


class Rig:
    """The machine in RTL, and the master's process."""

    def __init__(self, folder: Path, robot_file: Path, fault: str) -> None:
        self.folder, self.fault = folder, fault
        self.device, robot = load(), Robot.load(robot_file)
        self.rtl = DeviceRtl()
        self.rtl.capture(folder / "bus.pcap")
        machine = Machine(robot, self.device, robot.start)
        self.recorded = Recorded(self.rtl, machine, fault)
        self.rtl.take_machine()
        self.rtl.inputs[:] = machine.measured()
        self.rtl.run(START_NS)
        self.tap = open_tap()
        command = [sys.executable, "-m", f"{__package__}.master", str(folder), str(robot_file)]
        with self.rtl.served(self.tap):
            self.master = subprocess.Popen(
                command, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
            assert self.master.stdin and self.master.stdout
            if self.master.stdout.readline().strip() != "OP":
                raise RuntimeError("the master did not bring the drives to OP")
        self.rtl.align()
        self.rtl.restart_counts()
        self.master.stdin.write("go\n")
        self.master.stdin.flush()

    def period(self) -> bool:
        """With the master's frame; whether it still sends. The cable may be pulled."""
        recorded = self.recorded
        if self.fault and recorded.fault_tick is None and (self.folder / FAULT_NOW).exists():
            recorded.begin_fault()
            if self.fault == "master":
                self.master.kill()
        cut = self.fault == "cable" and recorded.fault_tick is not None
        while not select.select([self.tap], [], [], 0.2)[0]:
            if self.master.poll() is not None:
                return False
        if cut:
            os.read(self.tap, 2048)
        else:
            self.rtl.take(self.tap)
        for _ in range(TICKS):
            recorded.tick()
        if not cut:
            self.rtl.give(self.tap)
        return True

    def run(self) -> dict[str, object]:
        """Until the master is gone; what the machine came to."""
        periods = 0
        print("ready", flush=True)
        while self.period():
            periods += 1
            if periods % SHOWN == 0:
                print(periods, flush=True)
        for _ in range(AFTER_TICKS if self.fault == "master" else 0):
            self.recorded.tick()
        self.recorded.save(self.folder)
        counts = self.rtl.counts()
        return {
            "frames": periods,
            "fault_tick": self.recorded.fault_tick,
            "longest_pass": counts["longest"],
            **self.state(),
        }

    def ask(self, frame: bytes) -> bytes:
        """The answer to a frame on the wire, with no master there."""
        mine, wire = os.pipe()
        try:
            self.rtl.send(frame)
            self.rtl.run(ANSWER_NS)
            self.rtl.give(wire)
            return os.read(mine, 2048)
        finally:
            os.close(mine)
            os.close(wire)

    def state(self) -> dict[str, object]:
        """Of the slave and of the drives, read from the bus at the end."""

        def register(which: ByteRegister) -> int:
            request = single(APRD, 0, which.address, bytes(which.width))
            return answer(self.ask(request), which.width)[0]

        device: Device = self.device
        size, skip = device.bytes("rx") + device.bytes("tx"), device.bytes("rx")
        data = self.ask(single(LRD, 0, 0, bytes(size)))[DATA_AT + skip : DATA_AT + size]
        drives = inputs(device, data)
        return {
            "al_state": register(esc_regmap.AL_STATUS) & STATE_AND_ERROR,
            "al_code": register(esc_regmap.AL_STATUS_CODE),
            "statuswords": drives["statusword"],
            "error_codes": drives["error_code"],
        }


def main(argv: Sequence[str] | None = None) -> None:
    """Command line: the folder, the robot's file, the fault."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("robot", type=Path)
    parser.add_argument("--fault", default="")
    arguments = parser.parse_args(argv)
    report = Rig(arguments.folder, arguments.robot, arguments.fault).run()
    print(json.dumps(report), flush=True)


if __name__ == "__main__":
    main()
