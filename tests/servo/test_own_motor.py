# SPDX-License-Identifier: Apache-2.0
"""docs/drive.md, "Your own motor", with motors and encoders that are not the project's."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from sim.bench.drive import start_up
from sim.bench.drive.averaged import at_joints, true_angles
from sim.bench.drive.chain import ChainRtl
from sim.bench.drive.hardware import load
from sim.bench.drive.plant import Plant
from sim.bench.drive.response import TURN, averaged_responses, locked, turn
from sim.laws.drive.clocks import HALF_PERIOD
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import ROBOT_TOML, Robot

OWN = {
    **{"pole_legs": 0.048, "poles_tilt": 14, "poles_rotation": 10},
    **{"R_legs": 1.4, "R_tilt": 0.9, "R_rotation": 1.7},
    **{"L_d_legs": 8e-3, "L_d_tilt": 6e-3, "L_d_rotation": 9e-3},
    **{"L_q_legs": 9e-3, "L_q_tilt": 6e-3, "L_q_rotation": 11e-3},
    **{"psi_legs": 0.62, "psi_tilt": 0.75, "psi_rotation": 0.6},
    **{"i_max_legs": 18.0, "i_max_tilt": 20.0, "i_max_rotation": 12.0},
    **{"cogging_legs": 0.0, "cogging_tilt": 0.0, "cogging_rotation": 0.0},
    **{"encoder_legs": 0.5e-6, "turn_table": 1048576},
    **{"rotation_min": -100.0, "rotation_max": 100.0},
}


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> tuple[Robot, Drives]:
    """Step 1, by hand: a copy of the file with the values of every row of the page's table."""
    text = ROBOT_TOML.read_text(encoding="utf-8")
    for name, value in OWN.items():
        text, count = re.subn(rf"(?m)(^\[{name}\]\nvalue = )\S+", rf"\g<1>{value!r}", text)
        assert count == 1, name
    path = Path(tmp_path_factory.mktemp("own")) / "my_robot.toml"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_table__every_entry_of_a_motor_is_another(own):
    (robot, drives), file = own, Drives.load()
    for name in (field.name for field in fields(Drives)):
        if re.match(r"(pole|poles|R|L_d|L_q|psi|i_max|cogging)_", name):
            assert getattr(drives, name) == OWN[name] != getattr(file, name)
    assert (robot.resolution != np.array(Robot.load().resolution)).all()


def test_loops__bandwidth_and_margin_follow_from_the_file(own):
    robot, drives = own
    for loop in averaged_responses(robot, drives, Setting(robot.resolution)):
        assert loop.bandwidth >= 5000 and loop.margin >= 45


def test_loops__a_test_bench_brings_the_motors_to_speed_without_a_trip(own):
    """Where they are expected then, with no count lost."""
    robot, drives = own
    setting, plant = Setting(robot.resolution), Plant(robot, drives, friction=False)
    system, _ = locked(robot, drives, setting, plant)
    turn(system, drives)
    system.clock(20 * HALF_PERIOD)
    assert system.status()["trip"] == 0
    travel = system.look().joints - at_joints(plant, robot.start)
    assert (travel / [m.pole for m in drives.motors] > 0.4 * 70 * 1e-5 * TURN).all()
    # A jump of three counts would be read as one back. The plant's last step may be 1 us old, 2.6
    # counts of the fastest.
    off = start_up.positions(system) - travel / robot.resolution
    assert (np.abs(off) < 3.8).all(), off


@pytest.mark.full
def test_bring_up__alignment_finds_the_angles_of_the_own_motors(own):
    """Step 5, its order: brakes stay closed."""
    robot, drives = own
    setting, plant, system = Setting(robot.resolution), Plant(robot, drives), ChainRtl()
    counts = system.place(plant, robot.start)
    start_up.configure(system, drives, setting, counts)
    start_up.measure_offsets(system)
    found = start_up.align(system, drives, setting, dwell=0.008)
    off = found - true_angles(plant, at_joints(plant, robot.start))
    assert np.degrees(np.abs((off + np.pi) % (2 * np.pi) - np.pi)).max() < 3.0
    start_up.enable(system)
    system.clock(20 * HALF_PERIOD)
    assert system.status()["trip"] == 0 and system.look().released == 0
