# SPDX-License-Identifier: Apache-2.0
"""Plant against Lagrange's equation, energy, and the refinement of its own step."""

import dataclasses

import mpmath as mp
import numpy as np
import pytest
from model_paths import workspace_points

from sim.robot import dynamics, kinematics
from sim.robot.plant import Plant, table_acceleration, tool_acceleration

SEED = 23


def frictionless(robot, **changes):
    return dataclasses.replace(robot, friction_legs=0.0, friction_table=0.0, **changes)


def kinetic_energy(robot, place, speed):
    """Platform, sliders along and legs across their directions; numbers of mpmath or Python."""
    total = robot.m_p * sum(v * v for v in speed)
    for xp, yp in robot.legs:
        leg = (place[0] - xp, place[1] - yp, place[2])
        length2 = sum(r * r for r in leg)
        length = mp.sqrt(length2)
        along2 = sum(r * v for r, v in zip(leg, speed, strict=True)) ** 2 / length2
        turning2 = (sum(v * v for v in speed) - along2) / length2
        inertia = robot.J_a + robot.m_s * (length - robot.l_c) ** 2
        total += robot.m_s * along2 + inertia * turning2
    return total / 2


def lagrange_force(robot, place, speed, change):
    """d/dt dT/dv - dT/dx at 30 digits, by numerical differentiation of the kinetic energy."""
    x, v, a = ([mp.mpf(float(u)) for u in w] for w in (place, speed, change))

    def momentum(axis, t):
        at = [p + t * (u + t * w / 2) for p, u, w in zip(x, v, a, strict=True)]
        rate = [u + t * w for u, w in zip(v, a, strict=True)]

        def energy(delta):
            return kinetic_energy(robot, at, [u + delta * (k == axis) for k, u in enumerate(rate)])

        return mp.diff(energy, 0)

    def slope(axis):
        def energy(delta):
            return kinetic_energy(robot, [p + delta * (k == axis) for k, p in enumerate(x)], v)

        return mp.diff(energy, 0)

    return [mp.diff(lambda t, k=axis: momentum(k, t), 0) - slope(axis) for axis in range(3)]


def test_tool_acceleration__fast_motion__satisfies_lagranges_equation(robot):
    robot = frictionless(robot)
    rng = np.random.default_rng(SEED)
    with mp.workdps(60):
        for place in workspace_points(robot, 4, SEED):
            speed, forces = rng.normal(0, 3.0, 3), rng.normal(0, 500.0, 3)
            got = tool_acceleration(robot, tuple(place), tuple(speed), tuple(forces))
            lengths = kinematics.inverse(robot, place)
            applied = dynamics.leg_directions(robot, place, lengths).T @ forces
            applied[2] -= dynamics.carried_mass(robot, lengths) * robot.g
            needed = [float(f) for f in lagrange_force(robot, place, speed, got)]
            np.testing.assert_allclose(needed, applied, rtol=0, atol=1e-10)


def test_tool_acceleration__friction__opposes_each_leg(robot):
    place, speed, forces = (0.03, -0.05, 0.6), (0.02, 0.004, -0.0005), (300.0, 200.0, 250.0)
    leg_speed = kinematics.inverse_velocity(robot, place, speed)
    reduced = tuple(np.array(forces) - 8.0 * np.tanh(leg_speed / 1e-3))
    assert tool_acceleration(robot, place, speed, forces) == pytest.approx(
        tool_acceleration(frictionless(robot), place, speed, reduced), rel=1e-12
    )


def test_tool_acceleration__gravity_forces_at_rest__keep_the_tool_still(robot):
    for place in workspace_points(robot, 20, SEED):
        lengths = kinematics.inverse(robot, place)
        hold = tuple(dynamics.gravity(robot, place, lengths))
        still = tool_acceleration(robot, tuple(place), (0.0, 0.0, 0.0), hold)
        assert still == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_table_acceleration__both_axes__follow_their_equations(robot):
    got = table_acceleration(robot, (np.pi / 6, 1.0), (0.5, -1e-3), (10.0, 2.0))
    tilt = (10.0 - 0.02 * 45.0 * 9.81 * 0.5 - 0.5) / 1.6
    assert got == pytest.approx((tilt, (2.0 + 0.5 * np.tanh(1.0)) / 0.9), rel=1e-12)


def test_energy__no_gravity_friction_or_force__is_kept_while_coasting(robot):
    robot = frictionless(robot, g=0.0)
    plant = Plant(robot, (0.05, -0.04, 0.55))
    for _ in range(400):
        plant.step((300.0, -500.0, 400.0, 0.0, 5.0))
    start = kinetic_energy(robot, plant.tool, plant.tool_velocity)
    place, rate = plant.tool, plant.table_velocity
    assert start > 1.0
    for _ in range(1000):
        plant.step((0.0,) * 5)
    assert np.linalg.norm(np.subtract(plant.tool, place)) > 0.02
    assert kinetic_energy(robot, plant.tool, plant.tool_velocity) == pytest.approx(start, rel=1e-12)
    assert plant.table_velocity == rate


def test_energy__forces_and_gravity__equals_their_work(robot):
    robot = frictionless(robot)
    plant = Plant(robot, (0.05, -0.04, 0.55))
    rng = np.random.default_rng(SEED)
    work = 0.0
    for _ in range(500):
        forces = rng.normal(200.0, 200.0, 3)
        before, place = np.array(plant.joints[:3]), plant.tool
        plant.step((*forces, 0.0, 0.0))
        after = np.array(plant.joints[:3])
        weight = robot.g * 0.5 * sum(dynamics.carried_mass(robot, (before, after)))
        work += forces @ (after - before) - weight * (plant.tool[2] - place[2])
    # the trapezoid of m_z errs by m_z'' dz^3 / 12 per tick, far below 1e-9 J in sum
    energy = float(kinetic_energy(robot, plant.tool, plant.tool_velocity))
    assert energy > 1.0
    assert energy == pytest.approx(work, abs=1e-9)


def end_of_run(robot, steps, ticks):
    """Joints after random forces about the static ones that make every leg reverse."""
    place = (0.05, -0.04, 0.6)
    hold = dynamics.gravity(robot, place, kinematics.inverse(robot, place))
    rng = np.random.default_rng(SEED)
    plant = Plant(robot, place, steps=steps)
    for _ in range(ticks):
        push = rng.normal(0.0, 40.0, 3)
        plant.step((*(hold + push), *rng.normal(0.0, 3.0, 2)))
    return np.array(plant.joints)


def test_integration__one_step_per_period__is_far_finer_than_the_encoders(robot):
    fine = end_of_run(robot, 8, 1000)
    coarse = np.abs(end_of_run(robot, 1, 1000) - fine)
    assert coarse[:3].max() < 1e-3 * robot.encoder_legs
    assert coarse[3:].max() < 1e-3 * robot.encoder_table


def test_integration__half_the_step__divides_the_error_by_sixteen(robot):
    smooth = frictionless(robot, friction_speed_legs=1.0)
    object.__setattr__(smooth, "T_s", 0.01)  # beyond its limit: an error to be measured
    ends = {steps: end_of_run(smooth, steps, 20) for steps in (1, 2, 32)}
    errors = [np.abs(ends[steps] - ends[32])[:3].max() for steps in (1, 2)]
    assert 12.0 < errors[0] / errors[1] < 20.0


def test_counts__at_rest__are_the_nearest_encoder_lines(robot):
    plant = Plant(robot, (0.01, 0.02, 0.6), (0.3, -0.7))
    error = np.array(plant.counts()) * robot.resolution - plant.joints
    assert np.all(np.abs(error) <= 0.5 * np.array(robot.resolution) * (1 + 1e-9))
    assert all(type(count) is int for count in plant.counts())
    assert plant.counts()[4] < 0


def test_counts__half_a_line__round_up(robot):
    coarse = dataclasses.replace(robot, turn_table=128.0)
    q = coarse.encoder_table
    assert Plant(coarse, (0.0, 0.0, 0.6), (1.5 * q, -1.5 * q)).counts()[3:] == (2, -1)
