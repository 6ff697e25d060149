# SPDX-License-Identifier: Apache-2.0
"""Drive cases and the computed-torque law on the robot, on the bar of the letter A."""

from __future__ import annotations

import numpy as np
import pytest

from sim.bench.cnc.figures import STROKES
from sim.bench.cnc.position_loop import CASES, Case, Drive, DriveError
from sim.bench.cnc.robot import LEAD_IN as LEAD_IN_S
from sim.bench.cnc.robot import DriveController, RobotRun, leg_drive, simulate, stroke
from sim.motion.gcode.interpreter import parse_file
from sim.motion.geometry.moves import Motion
from sim.motion.trajectory.exact_stop import Trajectory, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints
from sim.robot.tracking import joint_path

LEG_DRIVE = leg_drive(Robot.load())
LEAD_IN = round(LEAD_IN_S / Robot.load().T_s)  # ticks
BAR = 7  # block of AGH: bar of the A, 15 mm with both table axes


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return generate(parse_file(AGH))


@pytest.fixture(scope="module")
def path(robot, trajectory) -> SetPoints:
    points = set_points(trajectory, None)
    return stroke(robot, points, *trajectory.first_ticks[BAR : BAR + 2])


@pytest.fixture(scope="module")
def runs(robot, path) -> dict[str, RobotRun]:
    """The three drive cases."""
    return {case.name: simulate(robot, path, case) for case in CASES}


def test_stroke__begins_at_rest_on_the_first_set_point(path):
    words = path.words()
    assert not words[:LEAD_IN, 3:9].any() and not words[:LEAD_IN, 11:].any()
    assert (words[:LEAD_IN, :3] == words[LEAD_IN, :3]).all()
    assert np.abs(path.velocity).max() > 0.01
    assert np.abs(path.velocity[-1]).max() < 1e-4


def test_strokes_of_the_quick_run__are_feed_moves_of_three_letters(trajectory):
    for block in STROKES.values():
        assert trajectory.blocks[block].move.motion is not Motion.RAPID
        assert trajectory.blocks[block].speed == pytest.approx(2 / 60)


def test_computed_torque__friction_and_payload_error__below_10_um(robot, path):
    assert simulate(robot, path, None).tracking.tool < 10e-6


def test_computed_torque__payload_far_too_heavy__breaks_the_bound(robot, path):
    """Negative control: the bounded integrator cannot carry it."""
    assert simulate(robot, path, None, payload=300.0).tracking.tool > 10e-6


@pytest.mark.full
def test_drives_without_feed_forward__error_is_speed_over_kp(robot, path, runs):
    run = runs[CASES[0].name]
    _, speed, _ = joint_path(robot, path)
    expected = np.abs(speed[:, :3]).max() / LEG_DRIVE.kp
    assert np.abs(run.leg_error).max() == pytest.approx(expected, rel=0.02)


def test_drives_with_velocity_feed_forward__error_follows_acceleration(robot, path, runs):
    run = runs[CASES[1].name]
    _, _, acceleration = joint_path(robot, path)
    # The encoder's count, friction and the payload are within 1 um.
    lag = 2.0 * LEG_DRIVE.damping / LEG_DRIVE.natural + 0.5 * robot.T_s
    expected = np.abs(acceleration[:, :3]).max() * lag / LEG_DRIVE.kp
    error = np.abs(run.leg_error[LEAD_IN:]).max()
    assert error == pytest.approx(expected, abs=1e-6)
    assert error < 10e-6


def test_drives_with_both__better_than_with_velocity_alone(runs):
    worst = [runs[case.name].tracking.leg for case in CASES]
    assert worst[2] < worst[1] < worst[0] / 20


def test_drives__k1_of_0_9__breaks_the_bound(robot, path):
    assert simulate(robot, path, Case("wrong", 0.9, 0.0)).tracking.tool > 10e-6


def test_legs__of_a_first_order_drive__refused(robot):
    with pytest.raises(DriveError, match="damping = None: the drives of the legs"):
        DriveController(robot, CASES[0], Drive())
