# SPDX-License-Identifier: Apache-2.0
"""The derived error bounds for robots of every kind: formulas, programs, systems as RTL."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from asip_asm.assemble import assemble
from sim.bench.run import random_robots
from sim.bench.run.bounds import bounds
from sim.bench.run.random_robots import COUNT, PROGRAMS, draw, examine, motion, replay
from sim.core.iss import run_path
from sim.robot import float32, tracking
from sim.robot.parameters import Robot
from sim.robot.records import ACCELERATIONS, OUTPUTS, POSITIONS, VELOCITIES, SetPoints

SEED = 7
ERRORS = ("e1", "e2", "e3", "e4", "e5")
MASSES = ("M1", "M2", "M3")
GRAVITIES = ("G1", "G2", "G3", "G4")


def near(robot: Robot, path: SetPoints) -> np.ndarray:
    """Counts a few resolutions next to a path, (N, 5): e passes the threshold e_c both ways."""
    t = np.arange(len(path))[:, None] * robot.T_s
    axes = np.arange(5)
    error = 12.0 * np.sin(2.0 * np.pi * (22.0 + 7.0 * axes) * t + axes)
    return np.rint(tracking.joint_path(robot, path)[0] / robot.resolution - error).astype(np.int64)


def worst(got: np.ndarray, want: np.ndarray, bound: np.ndarray) -> float:
    """Largest error as a fraction of its bound; where the bound is 0 the error must be."""
    return float(np.max(np.abs(got - want) / np.maximum(bound, 1e-300)))


def assert_kept(number: int, fractions: dict[str, float]) -> None:
    beyond = {name: value for name, value in fractions.items() if not value <= 1.0}
    assert not beyond, (
        f"robot {number} of seed {SEED}: {beyond} of the bounds; "
        f"replay: draw({SEED}, {number}), motion(robot, {SEED}, {number})"
    )


@pytest.mark.parametrize("first", [0, pytest.param(100, marks=pytest.mark.full)])
def test_printed_formulas_in_float32_keep_every_bound(first):
    for number in range(first, first + (100 if first == 0 else 5000)):
        robot = draw(SEED, number)
        path = motion(robot, SEED, number)
        counts = near(robot, path)
        want, got = tracking.run(robot, path, counts), float32.run(robot, path, counts)
        limit = bounds(robot, path, want, optimised=False)
        names = {field.name: f"{field.name}_d" for field in dataclasses.fields(limit)[:3]}
        fractions = {}
        for field in dataclasses.fields(limit):
            row = names.get(field.name, field.name)
            fractions[row] = worst(
                getattr(got, row), getattr(want, row), getattr(limit, field.name)
            )
        assert_kept(number, fractions)


@pytest.mark.parametrize("program", ["as_printed", "optimised", "observer"])
@pytest.mark.parametrize("first", [0, pytest.param(20, marks=pytest.mark.full)])
def test_programs_keep_every_bound(program, first):
    for number in range(first, first + (6 if first == 0 else 200)):
        robot = draw(SEED, number)
        path = motion(robot, SEED, number, 60)
        counts = near(robot, path)
        source = PROGRAMS / f"tracking_{program}.s"
        image = assemble(source, optimise=False, defines=robot.values()).to_json()
        rows = run_path(image, robot, path, counts, (*ERRORS, *MASSES, *GRAVITIES)).rows
        observer = program == "observer"
        want = tracking.run(robot, path, counts, "observer" if observer else "difference")
        limit = bounds(robot, path, want, program != "as_printed", counts if observer else None)
        fractions = {}
        for names, theirs, bound in (
            (POSITIONS, want.position_d, limit.position),
            (VELOCITIES, want.velocity_d, limit.velocity),
            (ACCELERATIONS, want.acceleration_d, limit.acceleration),
            (ERRORS, want.e, limit.e),
            (MASSES, want.mass, limit.mass),
            (GRAVITIES, want.gravity, limit.gravity),
            (OUTPUTS, want.output, limit.output),
        ):
            for axis, name in enumerate(names):
                fractions[name] = worst(rows[name], theirs[:, axis], bound[:, axis])
        assert_kept(number, fractions)


def test_boost_of_an_odd_number_of_ticks_ends_its_first_half_on_time():
    """e below e_c all the time: from the first tick after half the time on there is no boost."""
    robot = dataclasses.replace(Robot.load(), T_c=0.0021, e_c_legs=0.25, e_c_table=0.25)
    path = motion(robot, SEED, 0, 40)
    counts = near(robot, path)
    image = assemble(
        PROGRAMS / "tracking_optimised.s", optimise=False, defines=robot.values()
    ).to_json()
    rows = run_path(image, robot, path, counts, ERRORS).rows
    want = tracking.run(robot, path, counts)
    assert (want.phi_c == robot.xi_c).any(axis=0).all() and (want.phi_c == 1.0).any(axis=0).all()
    limit = bounds(robot, path, want, optimised=True).output
    for axis, name in enumerate(OUTPUTS):
        assert worst(rows[name], want.output[:, axis], limit[:, axis]) <= 1.0, name


@pytest.mark.quick("0")
@pytest.mark.parametrize(
    "number", [k if k < 3 else pytest.param(k, marks=pytest.mark.full) for k in range(COUNT)]
)
def test_random_robot_keeps_its_bounds_in_closed_loop_as_rtl(number):
    outcome = examine(random_robots.SEED, number)
    assert outcome.kept, f"{outcome.fractions}; replay: {replay(random_robots.SEED, number)}"


def test_random_robots__draws_are_repeatable_and_of_three_periods():
    robots = [draw(random_robots.SEED, number) for number in range(COUNT)]
    assert robots == [draw(random_robots.SEED, number) for number in range(COUNT)]
    assert {robot.T_s for robot in robots} == {5e-5, 1e-4, 2e-4}
    assert any(robot.boost_ticks % 2 for robot in robots)
