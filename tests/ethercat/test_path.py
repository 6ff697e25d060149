# SPDX-License-Identifier: Apache-2.0
"""The A-G-H path over the bus: targets each millisecond, law on the ASIP, plant in closed loop.

The application runs here as C on this machine, after a double of the controller; with it the whole
path takes minutes. `test_device__gives_the_same_words` compares its words with the RTL's.
"""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest

from sim.bus.coe.dictionary import load
from sim.bus.machine import AXES, Machine
from sim.bus.path_run import MASTER_NS, Curves, Drive, path_of, poses
from sim.bus.session import inputs, outputs
from sim.robot.parameters import Robot
from tests.bench.needs import needs
from tests.ethercat.host import DEVICE, Host, Short
from tests.ethercat.host_link import HostLink
from tests.ethercat.masters import report_of

TOOL, TABLE = 10e-6, 5e-4


def run(ticks: int | None, kind: type[Host] = Host) -> tuple[Drive, Curves, HostLink]:
    host = kind().to_op()
    robot = replace(Robot.load(None), T_s=kind.CYCLE_NS / 1e9)
    wanted = poses(path_of(robot, ticks))
    link = HostLink(host)
    machine = Machine(robot, DEVICE, wanted[0].tolist())
    drive = Drive(link, DEVICE, machine, MASTER_NS // kind.CYCLE_NS)
    return drive, drive.follow(wanted), link


def check(drive: Drive, curves: Curves) -> None:
    assert drive.faults == set() and drive.following == 0
    assert not drive.machine.stopped
    assert curves.tool_error < TOOL and curves.table_error < TABLE


@pytest.mark.parametrize("kind", [Host, Short])
def test_path__first_part_within_ten_micrometres(kind):
    drive, curves, _ = run(400_000_000 // kind.CYCLE_NS + 1, kind)
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
