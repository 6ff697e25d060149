# SPDX-License-Identifier: Apache-2.0
"""Delays of the chain from its RTL and settings, and the torque that a count of the table makes."""

from __future__ import annotations

from sim.bench.drive.averaged import MIDDLE, at_joints, true_angles
from sim.bench.drive.path import Chain
from sim.bench.drive.plant import Plant
from sim.bench.drive.recording import path_and_moves, tracking_image
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

TILT = 3
PERIODS = 3


def delays(robot: Robot, drives: Drives) -> dict[str, float]:
    """`commands`: from the first clock of a control period to the commands, on the RTL with the
    feed-forward's program; `orders`: from there to the run that takes them, at most; `values`: from
    the middle of the currents' window to its compare values in force; `voltage`: from there to the
    middle of what they make [us]. `count`: of the tilt axis [urad]; `pulse`: torque that it makes
    for a control period [N m]. Raises ControllerFault, StartUpError."""
    (path, moves), plant = path_and_moves(robot, 10), Plant(robot, drives)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    chain = Chain(
        plant,
        path,
        moves,
        true_angles(plant, at_joints(plant, at)),
        tracking_image(robot, drives, "feed-forward"),
    )
    chain.begin()
    clocks = max(
        int(chain.controller.advance(chain.counts)["command_clock"]) for _ in range(PERIODS)
    )
    gain = robot.J_44 * (robot.K_V[TILT] / robot.T_s + robot.K_P[TILT])
    us = 1e6 * CLOCK
    return {
        "commands": us * clocks,
        "orders": us * HALF_PERIOD,
        "values": us * (HALF_PERIOD - MIDDLE),
        "voltage": us * HALF_PERIOD / 2,
        "count": 1e6 * robot.resolution[TILT],
        "pulse": gain * robot.resolution[TILT],
    }
