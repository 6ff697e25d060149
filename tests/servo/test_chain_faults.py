# SPDX-License-Identifier: Apache-2.0
"""Faults while the chain follows a path, every clock: each ends in gates off, brakes closed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sim.bench.drive import start_up
from sim.bench.drive.averaged import at_joints, true_angles
from sim.bench.drive.path import Chain
from sim.bench.drive.plant import Plant
from sim.bench.dual.moves import moves_of
from sim.core.controller import ControllerFault
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import set_points
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.tracking import joint_path
from sim.rtl.asip_bus import CSR

ROBOT, DRIVES = Robot.load(), Drives.load()
PLANT = Plant(ROBOT, DRIVES)
MOST = [1e-5] * 3 + [1e-3] * 2  # following error [m, rad]: ten times what the path asks for
HELD = [1e-6] * 3 + [1e-4] * 2  # travel of a joint that its brake catches [m, rad]
SHORT = 20  # clocks, of a watchdog that no run keeps
SETTLED = 50 * 12_500  # clocks until the weight has bent the brakes


def begun(ticks: int, folder: Path) -> tuple[Chain, np.ndarray]:
    """Chain before a long move of all axes, brakes open; the joints' path."""
    settings = MotionSettings(ROBOT, lead_in=1e-3)
    file = folder / "move.ngc"
    file.write_text("%\nN10 G17 G21 G90 G61.1\nN20 G0 X60 Y40 Z650 A20 C-30\nN30 M2\n%\n")
    trajectory = generate(parse_file(file), settings)
    path = set_points(trajectory, ticks)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    angles = true_angles(PLANT, at_joints(PLANT, at))
    machine = Chain(PLANT, path, moves_of(trajectory, settings), angles)
    machine.begin()
    return machine, joint_path(ROBOT, path)[0]


def stands(machine: Chain) -> None:
    """Gates off, brakes closed, no current, no motion."""
    system = machine.system
    system.clock(SETTLED)
    before = system.look()
    system.clock(5 * 12_500)
    after = system.look()
    assert after.released == 0 and after.silent == before.silent, "a gate was on again"
    assert np.abs(after.i_q).max() < 0.01 and np.abs(after.i_d).max() < 0.01
    assert (np.abs(after.joints - before.joints) < HELD).all()
    assert after.shoot_through == 0


def watchdog(core: str) -> Callable[[Chain], None]:
    def act(machine: Chain) -> None:
        getattr(machine.system, core).write(CSR["WATCHDOG"], SHORT)

    return act


def no_number(machine: Chain) -> None:
    """A state of the tracking core is no number."""
    core = machine.system.tracking
    state = next(s.name for s in core.image.states)
    core.preset({state: 0x7FC00000})


@pytest.mark.quick("tracking watchdog")
@pytest.mark.parametrize(
    ("core", "fault"),
    [
        ("tracking", watchdog("tracking")),
        ("tracking", no_number),
        ("trajectory", watchdog("trajectory")),
    ],
    ids=["tracking watchdog", "tracking no number", "trajectory watchdog"],
)
def test_fault_of_a_core_that_orders__stops_all_axes_until_it_is_cleared(core, fault, tmp_path):
    machine, _ = begun(20, tmp_path)
    system = machine.system
    machine.advance(5)
    fault(machine)
    with pytest.raises(ControllerFault, match=f"{core}_fault"):
        for _ in range(3):
            machine.controller.advance(machine.counts)
    system.clock(5)
    status = system.status()
    assert status["trip"] == start_up.ALL and status["stop"] == 1
    assert not (status["late"] or status["fault"] or status["undervoltage"] or status["illegal"])
    stands(machine)
    joints = system.look().joints
    assert "stop" in start_up.supervise(system, joints, ROBOT.resolution, MOST)
    start_up.recover(system)  # the link is at rest: the axes listen to no core
    start_up.enable(system)
    with pytest.raises(start_up.StartUpError, match="tripped"):
        start_up.release(system)
    system.set("CONTROL", run=0)
    system.clock(12_500)
    system.set("CONTROL", clear=1)
    system.clock(100)
    start_up.recover(system)
    start_up.enable(system)
    start_up.release(system)
    system.clock(1250)
    assert system.look().released == start_up.ALL and not system.status()["trip"]


@pytest.mark.full
def test_encoder_that_stands_still__is_a_following_error_and_stops_all_axes(tmp_path):
    ticks, axis = 600, 2
    machine, desired = begun(ticks, tmp_path)
    system = machine.system
    first = 2
    machine.advance(first)
    while (start_up.positions(system) + machine.counts)[axis] & 3 == 2:
        machine.advance(1)  # two lines that fall at once would be an illegal transition
        first += 1
    system.fault(DRIVES.U_dc, lost=1 << axis)
    found = ""
    for tick in range(first, ticks):
        machine.controller.advance(machine.counts)
        found = start_up.supervise(system, desired[tick], ROBOT.resolution, MOST)
        if found:
            break
    assert found.startswith(f"following error of axis {axis + 1}: ")
    # What nothing could see is how far the axis has run ahead; the others are where they should be.
    off = np.abs(system.look().joints - desired[tick])
    assert off[axis] < 1e-3 and (np.delete(off, axis) < np.delete(MOST, axis)).all()
    stands(machine)
    assert system.read_front("MODE") == 0 and system.read_front("LINK") == 0
