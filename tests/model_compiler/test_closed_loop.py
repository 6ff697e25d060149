# SPDX-License-Identifier: Apache-2.0
"""Closed loops of compiled laws, and the job that shows the robots."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sim.robots.__main__ import main
from sim.robots.catalogue import robot
from sim.robots.closed_loop import Arm, DoubleLaw, _run
from sim.robots.laws import Settings, computed_torque
from sim.robots.quadrotor import Quadrotor, law


def test_pendulum_on_the_core_tracks_as_in_double_precision(tmp_path, capsys):
    arguments = ["--only", "pendulum", "--seconds", "0.2", "--inputs", "200"]
    assert main([*arguments, "--output", str(tmp_path)]) == 1  # shorter than the goals
    data = json.loads((tmp_path / "robots.json").read_text())
    found = data["robots"]["pendulum"]
    assert found["bits_equal"] and found["inputs_tried"] == 200
    assert found["closed_loop"]["ticks"] == 200
    assert 0.9 < found["closed_loop"]["ratio_to_double"] <= 1.05
    assert found["cycles"] <= 1.05 * found["bound_cycles"]
    missed = [goal["name"] for goal in data["goals"] if not goal["met"]]
    missed = [name for name in missed if name.startswith("pendulum")]
    assert missed == ["pendulum, inputs tried", "pendulum, closed loop"]
    assert len(data["goals"]) == 9  # and that of the hand-written program
    assert "Microtick: any robot" in (tmp_path / "robots.html").read_text()


def test_unknown_robot_is_a_wrong_command_line(capsys):
    assert main(["--only", "marvin"]) == 2
    assert "no robot marvin; there are own_printed" in capsys.readouterr().out


def test_computed_torque_holds_an_arm_on_its_path():
    settings = Settings(rate=1000.0)
    tree = robot("ur5")
    machine = Arm(tree, settings, seconds=1.0)
    double = DoubleLaw(computed_torque(tree, settings))
    loop = _run(machine, lambda inputs, _: double.tick(inputs))
    assert np.ptp(machine.goal, axis=0).min() > 0.01
    assert np.abs(loop.errors).max() < 2e-3


def test_quadrotor_flies_its_circle():
    machine = Quadrotor(4.0)
    double = DoubleLaw(law())
    loop = _run(machine, lambda inputs, _: double.tick(inputs))
    assert np.abs(loop.errors).max() < 0.3
    assert np.abs(loop.errors[-500:]).max() < 0.15


@pytest.mark.full
def test_every_robot_is_proved_and_tracks(tmp_path):
    """Cycles are the command's goal; they depend on the units of the core."""
    main(["--output", str(tmp_path)])
    goals = json.loads((tmp_path / "robots.json").read_text())["goals"]
    assert [g["name"] for g in goals if not g["met"] and g["unit"] != "cycles"] == []
