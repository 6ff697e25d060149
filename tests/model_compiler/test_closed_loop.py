# SPDX-License-Identifier: Apache-2.0
"""Closed loops of compiled laws, and the job that shows the robots."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sim.bench.drive.load_step import BEFORE, LOAD, Loaded
from sim.bench.shown_robots.__main__ import main
from sim.laws.catalogue import robot
from sim.laws.closed_loop import Arm, ClosedLoop, DoubleLaw, Loop, _run
from sim.laws.drive.current_law import MAGIC, observed
from sim.laws.laws import Settings, computed_torque
from sim.laws.quadrotor import Quadrotor, law
from sim.robot.drives import Drives
from sim.robot.parameters import Robot


def test_pendulum_on_the_core_tracks_as_in_double_precision(tmp_path, capsys):
    arguments = ["--only", "pendulum", "--seconds", "0.2", "--inputs", "200"]
    assert main([*arguments, "--output", str(tmp_path)]) == 1  # shorter than the goals
    data = json.loads((tmp_path / "shown_robots.json").read_text())
    found = data["robots"]["pendulum"]
    assert found["bits_equal"] and found["inputs_tried"] == 200
    assert found["closed_loop"]["ticks"] == 200
    assert 0.9 < found["closed_loop"]["ratio_to_double"] <= 1.05
    assert found["closed_loop"]["axes"]["pole"]["unit"] == "rad"
    assert found["cycles"] <= 1.05 * found["bound_cycles"]
    missed = [goal["name"] for goal in data["goals"] if not goal["met"]]
    missed = [name for name in missed if name.startswith("pendulum")]
    within = "pendulum, inputs with an output inside its limits, least"
    assert missed == ["pendulum, inputs tried", within, "pendulum, closed loop"]
    assert len(data["goals"]) == 10  # and that of the hand-written program
    assert "Microtick: any robot" in (tmp_path / "robots.html").read_text()


@pytest.mark.full
def test_observer_is_shown_with_its_figures_and_goals(tmp_path, capsys):
    arguments = ["--only", "observer", "--seconds", "0.5", "--inputs", "250"]
    assert main([*arguments, "--output", str(tmp_path)]) == 1  # shorter than the goals
    data = json.loads((tmp_path / "shown_robots.json").read_text())
    found = data["robots"]["observer"]
    assert found["configuration"] == "wide" and found["cycles_as_written"] is None
    assert found["bits_equal"] and found["inputs_tried"] == 250
    assert found["closed_loop"]["ticks"] == 500
    assert 0.9 < found["closed_loop"]["ratio_to_double"] <= 1.05
    missed = [goal["name"] for goal in data["goals"] if not goal["met"]]
    assert missed == ["observer, inputs tried", "observer, closed loop"]
    assert "Observer of 24 states" in (tmp_path / "robots.html").read_text()


def test_loads_displace_the_motors_of_the_machine_in_its_order():
    """Without currents a load accelerates each mass: s = a T^2 n (n + 1) / 2."""
    drives, setting = Drives.load(), observed(Robot.load())
    machine = Loaded(drives, setting, {n: setting.moved[n] for n in (3, 0)}, ticks=BEFORE + 40)
    assert machine.axes == {"axis 3": "rad", "axis 0": "m"}
    half = MAGIC + setting.half / 2
    duties = {f"pwm{n}{k}": half for n in (0, 3) for k in "abc"}
    for tick in range(machine.ticks):
        assert tick > BEFORE or not machine.error(tick).any()
        assert set(machine.inputs(tick)) >= {"bus", "q0", "ia3", "force3"}
        machine.step(duties)
    found = machine.error(machine.ticks)
    for place, n in zip(found, (3, 0), strict=True):
        motor = drives.motors[n]
        accel = -LOAD * motor.force_per_ampere * motor.i_max / setting.moved[n]
        assert place == pytest.approx(accel * setting.period**2 * 40 * 41 / 2, rel=1e-2)
    machine.start()
    assert not machine.error(0).any() and machine.at == 0


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
    assert np.abs(loop.errors[:, :3]).max() < 0.3
    assert np.abs(loop.errors[-500:, :3]).max() < 0.15
    assert 1e-4 < np.abs(loop.errors[-500:, 3:]).max() < 0.1


def closed(core: np.ndarray, double: np.ndarray) -> ClosedLoop:
    """Two axes, errors (ticks, 2)."""
    runs = (Loop(errors, np.zeros((len(errors), 1))) for errors in (core, double))
    return ClosedLoop(len(core), *runs, {"lift": "m", "turn": "rad"}, 0)


def test_an_axis_with_small_errors_is_judged_by_its_own():
    double = np.tile([1e-6, 0.1], (100, 1))
    loop = closed(double * [20, 1], double)
    assert loop.ratios == pytest.approx({"lift": 20, "turn": 1})
    assert loop.worst == "lift" and loop.ratio == loop.ratios["lift"]


def test_errors_of_the_start_hide_none_behind_it():
    double = np.full((100, 2), 1e-3)
    double[:25] = 1.0
    core = double.copy()
    core[25:, 1] *= 2
    assert closed(core, double).ratios == pytest.approx({"lift": 1, "turn": 2})


def test_one_tick_of_a_limit_cycle_does_not_decide_and_a_lasting_one_does():
    double = np.random.default_rng(1).choice([-1e-6, 1e-6], (10_000, 2))
    core = double.copy()
    core[5000, 0] *= 3
    core[5000:, 1] *= 3
    ratios = closed(core, double).ratios
    assert ratios["lift"] < 1.001 and ratios["turn"] > 2


def test_an_axis_without_an_error_in_double_precision_may_have_none():
    zero = np.zeros((8, 2))
    assert closed(zero, zero).ratio == 1
    loop = closed(zero + [0, 1e-9], zero)
    assert loop.worst == "turn" and loop.ratio == np.inf
    lost = closed(zero + [np.nan, 1e-9], zero + 1)
    assert lost.worst == "lift" and not lost.ratio <= 1.05


@pytest.mark.full
def test_every_robot_is_proved_and_tracks(tmp_path):
    """Cycles are the command's goal; they depend on the units of the core."""
    main(["--output", str(tmp_path)])
    goals = json.loads((tmp_path / "shown_robots.json").read_text())["goals"]
    assert [g["name"] for g in goals if not g["met"] and g["unit"] != "cycles"] == []
