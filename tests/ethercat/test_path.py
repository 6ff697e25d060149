# SPDX-License-Identifier: Apache-2.0
"""The A-G-H path over the bus: targets each millisecond, law on the ASIP, plant in closed loop.

The application runs here as C on this machine, behind a double of the controller; with it the whole
path takes minutes. `test_device__gives_the_same_words` compares its words with the RTL's.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
import pytest

from sim.bus.coe.dictionary import load
from sim.bus.machine import AXES, FLAGS, POWER, TORQUE_ONLY, Machine
from sim.bus.path_run import Curves, Drive, path_of, poses
from sim.bus.session import inputs, outputs
from sim.robot.parameters import Robot
from tests.bench.needs import needs
from tests.ethercat.host import DEVICE, Host
from tests.ethercat.masters import report_of

TOOL, TABLE = 10e-6, 5e-4


class HostWords:
    """The words of a control tick, to and from the application on this machine."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.inputs, self.outputs = np.zeros(16, np.uint32), np.zeros(29, np.uint32)

    def tick(self) -> None:
        feedback, command = self.host.feedback, self.host.command
        axes = np.ctypeslib.as_array(feedback.axis)
        axes["position"] = self.inputs[:AXES].view(np.int32)
        axes["torque"] = self.inputs[AXES : 2 * AXES].view(np.int16)[::2]
        feedback.pose[:] = self.inputs[2 * AXES : 3 * AXES].view(np.float32).tolist()
        self.host.held = set(range(AXES))
        self.host.cycle()
        axes = np.ctypeslib.as_array(command.axis)
        names = ("position", "fraction", "velocity", "acceleration")
        self.outputs[: 4 * AXES] = np.concatenate([axes[n].copy().view(np.uint32) for n in names])
        torques = axes["torque"].astype(np.uint16)
        self.outputs[FLAGS] = torques | POWER * axes["power"] | TORQUE_ONLY * axes["torque_only"]
        place = command.setting_index << 8 | command.setting_subindex
        value = np.float32(command.setting_value).view(np.uint32)
        self.outputs[5 * AXES :] = command.digital_outputs, command.setting_number, place, value


class HostLink:
    """Process data as they come over the wire: taken by the pass behind the one they meet."""

    def __init__(self, host: Host) -> None:
        self.host, self.rtl = host, HostWords(host)
        self.words: list[np.ndarray] = []

    def cycle(self, data: bytes, ticks: int, tick: Callable[[], None]) -> bytes:
        back = self.host.read(0x1800, DEVICE.bytes("tx"))
        for n in range(ticks):
            tick()
            self.words.append(self.rtl.outputs.copy())
            if n == 0:
                self.host.write(0x1200, data)
        return back


def run(ticks: int | None) -> tuple[Drive, Curves, HostLink]:
    host = Host().to_op()
    wanted = poses(path_of(Robot.load(None), ticks))
    link = HostLink(host)
    drive = Drive(link, DEVICE, Machine(Robot.load(None), DEVICE, wanted[0].tolist()))
    return drive, drive.follow(wanted), link


def check(drive: Drive, curves: Curves) -> None:
    assert drive.faults == set() and drive.following == 0
    assert not drive.machine.stopped
    assert curves.tool_error < TOOL and curves.table_error < TABLE


def test_path__first_part_within_ten_micrometres():
    drive, curves, _ = run(4001)
    moved = np.abs(curves.wanted - curves.wanted[0]).max()
    assert moved > 1e-3  # it is no rest that is followed
    check(drive, curves)


@pytest.mark.full
def test_path__whole():
    check(*run(None)[:2])


@pytest.mark.full
@needs("tap")
def test_device__gives_the_same_words(tmp_path):
    ticks, file = 501, tmp_path / "path.npz"
    report = report_of("path_run", "--ticks", ticks, "--curves", file, timeout=3000)
    assert report["wrong_counters"] == report["following_errors"] == 0
    assert report["tool"] < TOOL and report["longest_pass"] < 10_000
    _, curves, _ = run(ticks)
    with np.load(file) as found:
        assert np.array_equal(found["tool"], curves.tool)
        assert np.array_equal(found["table"], curves.table)


def test_process_data__by_name_and_axis():
    device = load()
    data = outputs(device, {"controlword": 0x0F, "target_position": [10, 20, 30, 40, -50]})
    assert len(data) == device.bytes("rx")
    assert [struct.unpack_from("<Hbxi", data, 20 * n)[2] for n in range(AXES)] == [
        *(10, 20, 30, 40, -50)
    ]
    found = inputs(device, bytes(range(device.bytes("tx"))))
    assert len(found["statusword"]) == AXES and found["statusword"][0] == 0x0100
