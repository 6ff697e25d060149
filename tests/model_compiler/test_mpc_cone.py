# SPDX-License-Identifier: Apache-2.0
"""Second-order cone of inputs in predictive control: projection, roundings, program, optimum."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from asip_asm.model.mpc_bound import input_bounds
from asip_asm.model.mpc_cone import Cone
from asip_asm.model.mpc_problem import Problem, drawn, load_problem
from sim.laws import mpc
from sim.laws.mpc_proof import TICKS, prove_mpc
from sim.laws.mpc_reference import Reference, distance, project
from sim.laws.rocket_landing import land_core, land_reference, rocket_problem

SEED = 38
TOW = """
title = "tow"
horizon = 7
iterations = 9
sample_time = 0.2
continuous = true
states = ["px", "pz", "vx", "vz"]
inputs = ["side", "ax", "az"]
A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0]]
B = [[0, 0, 0], [0, 0, 0], [0.3, 1, 0], [0, 0.1, 1]]
Q = [1, 1, 1, 2]
R = [2, 0.5, 0.5]
reference = "none"
state_box = { low = [-inf, -inf, -1, -inf], high = [inf, inf, 1, 1.5] }
input_box = { low = [-0.5, -inf, -2], high = [0.5, inf, 1.5] }
input_cone = { norm = ["ax"], axis = "az", slope = 0.5, limit = 1 }
start = { low = [-2, -2, -0.8, -1], high = [2, 2, 0.8, 1] }
"""
BALL = (
    'norm = ["ax"], axis = "az", slope = 0.5, limit = 1', 'norm = ["ax", "az"], limit = 1.2'
)  # fmt: skip
FREE = ("low = [-0.5, -inf, -2], high = [0.5, inf, 1.5]", "low = [-0.5, -inf, -inf]")
CONES = [
    Cone((0, 1), 2, 0.3, 2.0, -5.0, 4.0),
    Cone((1,), 0, 2.0, -1.0, 0.5, 3.0),
    Cone((2, 0), 1, 0.7, 0.0, 0.4, 3.0),
    Cone((0, 1, 2), None, 0.0, 1.5),
]
RHO = np.array([1.5, 1.5, 1.5])


def tow(folder: Path, *changes: tuple[str, str]) -> Path:
    text = TOW
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "tow.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def tow_problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    return load_problem(tow(tmp_path_factory.mktemp("tow")))


@pytest.mark.parametrize("cone", CONES)
@pytest.mark.parametrize("heavy", [1.0, 4.0])
def test_projection_is_that_of_another_construction_and_the_nearest_point(cone, heavy):
    rng, rho = np.random.default_rng(SEED), RHO.copy()
    if cone.axis is not None:
        rho[cone.axis] *= heavy
    u = rng.normal(size=(4000, 3)) * rng.choice([1e-9, 0.5, 3.0, 12.0], (4000, 1))
    u[0] = 0.0
    inputs = list(cone.inputs)
    got = cone.limited(u, rho)[:, inputs]
    assert np.abs(got - project(u, cone, rho)).max() < 1e-12
    # No allowed point lies beyond the plane through the projection: u - got is a normal there.
    size = len(cone.norm)
    axis = np.zeros(4000) if cone.axis is None else rng.uniform(cone.low, cone.high, 4000)
    way = rng.normal(size=(4000, size))
    radius = cone.limit + cone.slope * axis
    way *= (radius * rng.uniform(0, 1, 4000) / np.linalg.norm(way, axis=1))[:, None]
    allowed = way if cone.axis is None else np.column_stack((way, axis))
    normal = (u[:, inputs] - got) * rho[inputs]
    for k in range(0, 4000, 40):
        assert ((allowed - got[k]) @ normal[k]).max() < 1e-9


@pytest.mark.parametrize("cone", CONES)
def test_roundings_of_a_projection_are_within_their_bound(cone):
    rng = np.random.default_rng(SEED)
    u = rng.normal(size=(20_000, 3)) * rng.choice([1e-30, 1e-9, 1.0, 9.0], (20_000, 1))
    u = u.astype(np.float32).astype(float)
    error = np.abs(_single(cone, u) - cone.limited(u, RHO))
    bound = cone.roundings(np.abs(u), RHO)
    assert (error <= bound).all()
    assert error.max() > 1e-3 * bound.max()  # the bound is not idle


def _single(cone: Cone, u: np.ndarray) -> np.ndarray:
    """The operations of the program, each rounded; a multiply-add rounds once."""
    f = np.float32
    found = u.copy()

    def madd(a: float | np.ndarray, b: np.ndarray, c: float | np.ndarray) -> np.ndarray:
        return f(f(a).astype(float) * f(b).astype(float) + f(c).astype(float))

    first, *others = (f(u[:, j]) for j in cone.norm)
    square = first * first
    for other in others:
        square = madd(other, other, square)
    size, radius = np.sqrt(square), np.full(len(u), f(cone.limit))
    if cone.axis is not None:
        axis = f(u[:, cone.axis])
        excess = np.maximum(size - madd(cone.slope, axis, cone.limit), f(0))
        moved = madd(cone.share(RHO), excess, axis)
        found[:, cone.axis] = np.clip(moved, f(cone.low), f(cone.high))
        radius = madd(cone.slope, found[:, cone.axis], cone.limit)
    scale = radius / np.maximum(size, np.maximum(radius, f(2.0**-60)))
    for j in cone.norm:
        found[:, j] = scale * f(u[:, j])
    return found


@pytest.mark.quick("cone-trajectory-wide", "ball-point-stream")
@pytest.mark.parametrize("configuration", ["stream", "wide"])
@pytest.mark.parametrize("reference", ["none", "point", "trajectory"])
@pytest.mark.parametrize("changes", [(), (BALL, FREE)], ids=["cone", "ball"])
def test_program_has_the_interpreters_bits_and_the_doubles_values(
    configuration, reference, changes, tmp_path
):
    problem = load_problem(tow(tmp_path, ('"none"', f'"{reference}"'), *changes))
    built, _ = mpc.build_mpc(problem, tmp_path / "tow.s", configuration)
    proof = prove_mpc(problem, built.compiled, built.image, 2 * TICKS, SEED, "iss")
    assert proof.passed, proof.lines()
    assert proof.warm_error < 1e-5


@pytest.mark.full
def test_program_of_another_cone_is_found(tow_problem, tmp_path):
    built, _ = mpc.build_mpc(tow_problem, tmp_path / "tow.s")
    assert tow_problem.cone is not None
    other = replace(tow_problem, cone=replace(tow_problem.cone, limit=0.9))
    proof = prove_mpc(other, built.compiled, built.image, TICKS * 20, SEED, "iss")
    assert not proof.difference and proof.share > 1


def test_rtl_takes_the_cycles_that_were_announced(tow_problem, tmp_path):
    built, _ = mpc.build_mpc(tow_problem, tmp_path / "tow.s", "wide")
    proof = prove_mpc(tow_problem, built.compiled, built.image, 2 * TICKS, SEED)
    assert proof.passed and proof.ticks == 2 * TICKS, proof.lines()


def test_c_has_the_bits_of_the_interpreter(tow_problem, tmp_path):
    from sim.laws.native.bits import prove_c

    built, _ = mpc.build_mpc(tow_problem, tmp_path / "tow.s")
    assert not prove_c(built.compiled, 60, SEED)


@pytest.mark.parametrize("changes", [(), (BALL, FREE)], ids=["cone", "ball"])
def test_many_iterations_come_to_the_optimum_of_another_solver(changes, tmp_path):
    problem = load_problem(tow(tmp_path, *changes))
    few, many = distance(problem, 100), distance(replace(problem, iterations=900), 100)
    assert few.solver == "Clarabel" and not many.infeasible
    assert np.abs(many.first).max() < 1e-3 and np.abs(many.excess).max() < 1e-5
    assert np.abs(few.first).max() > 1e-3  # the fixed iterations are not the optimum
    plan = Reference(problem, 100).tick(drawn(problem, 100, SEED))["plan"]
    at_edge = problem.cone.beyond(1.001 * plan.reshape(100, 7, 3)) > 0
    assert at_edge.any(axis=1).mean() > 0.2  # the cone limits a share of the plans


def test_bound_of_roundings_covers_a_moved_limit_of_the_cone(tow_problem):
    cone = tow_problem.cone
    x = drawn(tow_problem, 200, SEED)
    reference = Reference(tow_problem, 200)
    u = reference.tick(x)["u"]
    bound = input_bounds(tow_problem, reference.pulls)
    near = replace(
        tow_problem, cone=replace(cone, limit=float(np.float32(cone.limit * 1.00000006)))
    )
    assert (np.abs(Reference(near, 200).tick(x)["u"] - u) <= bound).all()
    assert (input_bounds(replace(tow_problem, cone=None), reference.pulls) < bound).any()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("slope = 0.5", "slop = 0.5"), r"tow.toml:16: error: unknown key 'input_cone.slop'; .*sl"),
        (('norm = ["ax"]', 'norm = ["ay"]'), r":16: error: input_cone names 'ay'; .*ax"),
        (('norm = ["ax"]', "norm = []"), r":16: error: input_cone.norm = \[\]; give a list"),
        (('axis = "az"', 'axis = "ax"'), r":16: error: input_cone names 'ax' twice"),
        (('axis = "az", ', ""), r":16: error: input_cone has one of axis and slope"),
        (("slope = 0.5", "slope = -1"), r":16: error: input_cone.slope = -1; it is above 0"),
        (("limit = 1 }", "limit = inf }"), r":16: error: input_cone.limit = inf; give a number"),
        (("limit = 1 }", "limit = -0.8 }"), r":16: error: input_cone allows a norm of -0.05 at"),
        (("[-0.5, -inf, -2]", "[-0.5, -1, -2]"), r":15: error: input_box limits 'ax', which in"),
        (("[0.5, inf, 1.5]", "[0.5, inf, inf]"), r":15: error: .*no upper limit of 'az', the axis"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_cone_is_named(change, says, tmp_path, capsys):
    assert mpc.main([str(tow(tmp_path, change))]) == 1
    message = capsys.readouterr().err
    assert re.search(says, message), message


@pytest.mark.quick("stream")
@pytest.mark.parametrize("configuration", ["stream", "wide"])
def test_rocket_lands_within_its_limits_as_in_doubles(configuration, tmp_path):
    problem = rocket_problem()
    built, _ = mpc.build_mpc(problem, tmp_path / "rocket.s", configuration)
    assert built.cycles <= 13_500
    core, _ = land_core(problem, built.image, "iss")
    double = land_reference(problem)
    assert core.miss < 0.25 and core.sink < 0.6 and core.drift < 0.15 and core.cone < 1e-6
    assert core.held > 0.05  # the cone limits the flight
    assert np.abs(core.states - double.states).max() < 1e-4
