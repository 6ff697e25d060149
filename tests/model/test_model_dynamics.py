# SPDX-License-Identifier: Apache-2.0
"""Dynamics of the law against the rigid-body mass matrix and the statics system."""

import numpy as np
from model_paths import workspace_points

from sim.robot import dynamics, kinematics

SEED = 11


def mass_matrix(robot, point):
    """M_x of the specification, built from its text."""
    starts = robot.R * np.array(((0, 1), (np.sqrt(0.75), -0.5), (-np.sqrt(0.75), -0.5)))
    total = robot.m_p * np.eye(3)
    for xp, yp in starts:
        leg = point - (xp, yp, 0.0)
        length = np.linalg.norm(leg)
        along = np.outer(leg, leg) / length**2
        inertia = robot.J_a + robot.m_s * (length - robot.l_c) ** 2
        total += robot.m_s * along + inertia / length**2 * (np.eye(3) - along)
    return total


def test_reduced_masses__whole_workspace__equal_the_mass_matrix_along_each_leg(robot):
    points = workspace_points(robot, 100, SEED)
    lengths = kinematics.inverse(robot, points)
    w = dynamics.leg_directions(robot, points, lengths)
    want = [np.diag(d @ mass_matrix(robot, p) @ d.T) for d, p in zip(w, points, strict=True)]
    np.testing.assert_allclose(dynamics.reduced_masses(robot, lengths), want, rtol=1e-12)


def test_leg_directions__whole_workspace__are_unit_vectors_that_lead_to_the_tool(robot):
    points = workspace_points(robot, 100, SEED)
    lengths = kinematics.inverse(robot, points)
    w = dynamics.leg_directions(robot, points, lengths)
    np.testing.assert_allclose(np.linalg.norm(w, axis=-1), 1.0, rtol=1e-15)
    for leg, (xp, yp) in enumerate(robot.legs):
        end = np.array((xp, yp, 0.0)) + lengths[:, leg, None] * w[:, leg]
        np.testing.assert_allclose(end, points, atol=1e-15)


def test_gravity__closed_form__equals_the_linear_system(robot):
    points = workspace_points(robot, 1000, SEED)
    lengths = kinematics.inverse(robot, points)
    solved = dynamics.gravity_solve(robot, points, lengths)
    # 1e-13 of the force that the legs carry together
    scale = np.abs(solved).max()
    np.testing.assert_allclose(
        dynamics.gravity(robot, points, lengths), solved, rtol=0, atol=1e-13 * scale
    )


def test_carried_mass__one_pose__follows_the_formula_term_by_term(robot):
    lengths = np.array((0.7, 0.8, 0.9))
    want = 10.0 + sum((12.0 * (length - 0.35) - 3.0) / length for length in (0.7, 0.8, 0.9))
    np.testing.assert_allclose(dynamics.carried_mass(robot, lengths), want, rtol=1e-15)


def test_table__gravity__acts_on_the_tilt_only(robot):
    theta = np.array(((np.pi / 2, 1.0), (-np.pi / 6, 2.0)))
    want = 0.02 * 45.0 * 9.81 * np.array(((1.0, 0.0), (-0.5, 0.0)))
    np.testing.assert_allclose(dynamics.table_gravity(robot, theta), want, atol=1e-15)
