# SPDX-License-Identifier: Apache-2.0
"""Frequency response of the position loops against the three poles that the gains ask for."""

from __future__ import annotations

import numpy as np
import pytest

from sim.bench.drive.position import LINES, SPEEDS, PositionLoops, position_loops, wobble
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.tracking import joint_path

ROBOT, DRIVES = Robot.load(), Drives.load()
# dB below a share of the corner: friction, bounded integrator and low-pass are not in the poles
MOST = {0.5: 0.5, 1.0: 3.0}
GRID = 2.0**-24  # of z as binary32 [m]


def test_motion__speeds_and_accelerations_are_those_of_its_place():
    path = wobble(ROBOT)
    place, speed, _ = joint_path(ROBOT, path)
    z = [rows[:, 2].astype(float) for rows in (path.position, path.velocity, path.acceleration)]
    for rows, rates, coarse in ((z[0], z[1], GRID / ROBOT.T_s), (z[1], z[2], 0.0)):
        found = (rows[2:] - rows[:-2]) / (2 * ROBOT.T_s)
        assert np.abs(found - rates[1:-1]).max() < 0.02 * np.abs(rates).max() + coarse
    found = np.diff(place, axis=0) / ROBOT.T_s
    middle = (speed[1:] + speed[:-1]) / 2
    coarse = GRID / ROBOT.T_s * np.array([1, 1, 1, 0, 0])
    assert (np.abs(found - middle).max(axis=0) < 0.02 * np.abs(speed).max(axis=0) + coarse).all()
    spectrum = np.abs(np.fft.fft(path.table_velocity[len(path) // 2 :, 0])) * 4 / len(path)
    np.testing.assert_allclose(spectrum[LINES], SPEEDS[1], rtol=1e-3)


def test_loops__have_the_poles_of_their_gains():
    loops = position_loops(ROBOT, DRIVES)
    s = 2j * np.pi * loops.frequency
    for k, corner in enumerate((ROBOT.f_legs, ROBOT.f_table, ROBOT.f_table)):
        w = 2 * np.pi * corner
        want = (3 * w * w * s + w**3) / (s + w) ** 3
        for share, most in MOST.items():
            below = loops.frequency <= share * corner
            off = 20 * np.log10(np.abs(loops.alone[below, k] / want[below]))
            assert np.abs(off).max() < most
        assert corner < loops.bandwidth[k] < 2 * corner
        # With speeds and accelerations the joint goes where it should.
        slow = loops.frequency <= corner / 2
        assert np.abs(1 - loops.fed[slow, k]).max() < 0.05


def test_bandwidth__is_where_the_last_line_falls():
    frequency = np.array([1.0, 2.0, 3.0, 4.0])
    closed = np.array([[1.0, 1.0, 0.1], [0.5, 1.0, 0.1], [0.9, 1.0, 0.1], [0.5, 1.0, 0.1]]) + 0j
    assert PositionLoops(frequency, closed, closed).bandwidth == pytest.approx([4.0, 4.0, 2.0])
