# SPDX-License-Identifier: Apache-2.0
"""Predictive control: problem files, programs against interpreter, doubles and the optimum."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from asip_asm.model.mpc_bound import input_bounds
from asip_asm.model.mpc_problem import Problem, drawn, load_problem
from asip_asm.model.mpc_warm import warm_words
from asip_asm.model.read import ModelError
from sim.core.api import Core
from sim.laws import mpc
from sim.laws.mpc_flight import fly_core, fly_reference, quadrotor_problem
from sim.laws.mpc_proof import TICKS, prove_mpc
from sim.laws.mpc_reference import Reference, distance

SEED = 38
CART = """
title = "cart"
horizon = 6
iterations = 8
sample_time = 0.1
continuous = true
states = ["p", "v"]
inputs = ["force", "brake"]
A = [[0, 1], [0, -0.2]]
B = [[0, 0], [1, 0.5]]
Q = [4, 1]
R = [[0.5, 0.1], [0.1, 1]]
terminal = [[20, 4], [4, 6]]
reference = "trajectory"
state_box = { low = [-inf, -1.5], high = [inf, 1.5] }
input_box = { low = [-2, -inf], high = [2, 0.5] }
start = { low = [-1, -1], high = [1, 1] }
"""


def cart(folder: Path, *changes: tuple[str, str]) -> Path:
    text = CART
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "cart.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def cart_problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    return load_problem(cart(tmp_path_factory.mktemp("cart")))


@pytest.mark.quick('"lqr"-point', '"Q"-trajectory')
@pytest.mark.parametrize("reference", ["none", "point", "trajectory"])
@pytest.mark.parametrize("terminal", ['"lqr"', '"Q"', "[[20, 4], [4, 6]]"])
def test_program_has_the_interpreters_bits_and_the_doubles_values(reference, terminal, tmp_path):
    file = cart(
        tmp_path,
        ('"trajectory"', f'"{reference}"'),
        ("[[20, 4], [4, 6]]", terminal),
        ("start =", "penalty = { state = 3, input = 1 }\nrelaxation = 1.5\nstart ="),
    )
    problem = load_problem(file)
    built, _ = mpc.build_mpc(problem, tmp_path / "cart.s")
    proof = prove_mpc(problem, built.compiled, built.image, 2 * TICKS, SEED, "iss")
    assert proof.passed, proof.lines()
    assert proof.warm_error < 1e-5


@pytest.mark.parametrize("reference", ["none", "point", "trajectory"])
def test_program_in_lanes_has_the_interpreters_bits_and_the_doubles_values(reference, tmp_path):
    problem = load_problem(cart(tmp_path, ('"trajectory"', f'"{reference}"')))
    built, _ = mpc.build_mpc(problem, tmp_path / "cart.s", "wide")
    proof = prove_mpc(problem, built.compiled, built.image, 2 * TICKS, SEED, "iss")
    assert proof.passed, proof.lines()
    assert proof.warm_error < 1e-5


@pytest.mark.parametrize("reference", ["none", "point", "trajectory"])
@pytest.mark.parametrize("configuration", ["stream", "wide"])
def test_tick_begins_from_the_plan_of_the_host(configuration, reference, tmp_path):
    problem = load_problem(cart(tmp_path, ('"trajectory"', f'"{reference}"')))
    built, _ = mpc.build_mpc(problem, tmp_path / "cart.s", configuration)
    (n, m, steps), rng = problem.sizes, np.random.default_rng(SEED)
    states, inputs, window = (rng.uniform(-1.8, 1.8, (steps, size)) for size in (n, m, n))
    held = [rng.uniform(-0.2, 0.2, (steps, size)) for size in (n, m)]
    solver = Reference(problem, 1)
    plan = np.hstack((inputs.ravel(), states.ravel()))
    total = np.clip(plan, solver.low, solver.high) + np.hstack(
        [each.ravel() for each in held[::-1]]
    )
    solver.v[0] = np.clip(total, solver.low, solver.high) * solver.boxed
    solver.multiplier[0] = (total - solver.v[0]) * solver.boxed
    x, wanted = rng.uniform(-1, 1, (2, 1, n))
    names, values = problem.states, dict(zip(problem.states, x[0], strict=True))
    if reference != "none":
        values |= dict(zip([f"{name}_ref" for name in names], wanted[0], strict=True))
    if reference == "trajectory":
        solver.window[0, 1:] = window[:-1]
    given = (window if reference == "trajectory" else None, (held[0], held[1]))
    words = warm_words(problem, configuration, states, inputs, *given)
    assert len(words) == sum(int(size) for size in _spaces(built))
    with Core(built.image, backend="iss") as core:
        cold = core.tick(values)
        core.preset_data(0, words)
        got = core.tick(values)
    u = solver.tick(x, wanted if reference != "none" else None)
    assert np.abs([got[name] for name in problem.inputs] - u["u"][0]).max() < 1e-5
    assert abs(got["dual_residual"] - u["dual"][0]) < 1e-5
    assert max(abs(got[name] - cold[name]) for name in problem.inputs) > 1e-4


def _spaces(built) -> list[str]:
    return re.findall(r"^\.space \w+, (\d+)$", built.compiled.text, re.M)


@pytest.mark.parametrize("change", [{"states": 5}, {"inputs": 0}, {"window": 1}, {"bad": 0}])
def test_plan_of_another_shape_is_refused(change, cart_problem):
    n, m, steps = cart_problem.sizes
    count = {"states": steps, "inputs": steps, "window": steps} | change
    arrays = [np.zeros((count[name], size)) for name, size in
              zip(("states", "inputs", "window"), (n, m, n), strict=True)]  # fmt: skip
    name = next(iter(change))
    if name == "bad":
        arrays[0][1, 1], name = np.nan, "states"
    with pytest.raises(ModelError, match=f"{name} of shape .*: give 6 steps of 2 finite numbers"):
        warm_words(cart_problem, "wide", *arrays)
    point = replace(cart_problem, reference="point")
    with pytest.raises(ModelError, match="reference = 'point' has no window"):
        warm_words(point, "wide", *(np.zeros((steps, size)) for size in (n, m, n)))


@pytest.mark.parametrize("configuration", ["stream", "wide"])
def test_rtl_takes_the_cycles_that_were_announced(configuration, cart_problem, tmp_path):
    built, _ = mpc.build_mpc(cart_problem, tmp_path / "cart.s", configuration)
    proof = prove_mpc(cart_problem, built.compiled, built.image, 2 * TICKS, SEED)
    assert proof.passed and proof.ticks == 2 * TICKS, proof.lines()


def test_a_wrong_word_of_a_stream_is_found(cart_problem, tmp_path):
    built, _ = mpc.build_mpc(cart_problem, tmp_path / "cart.s")
    first, *others = built.image.streams
    words = list(first.words)
    place = next(k for k, word in enumerate(words) if int(word, 16) << 1 & 0xFFFFFFFF)
    words[place] = f"{int(words[place], 16) ^ 1 << 22:08x}"
    streams = [msgspec.structs.replace(first, words=words), *others]
    image = msgspec.structs.replace(built.image, streams=streams)
    assert not prove_mpc(cart_problem, built.compiled, image, TICKS, SEED, "iss").passed


def test_many_iterations_come_to_the_optimum_and_few_near_it(cart_problem):
    few = distance(cart_problem, 300)
    many = distance(replace(cart_problem, iterations=600), 300)
    assert not many.infeasible and np.abs(many.first).max() < 1e-4
    assert np.abs(many.excess).max() < 1e-6 and many.violation.max() < 1e-5
    assert np.abs(few.first).max() > 1e-3  # the fixed iterations are not the optimum
    assert np.median(few.excess) < 0.01 and np.quantile(few.violation, 0.99) < 0.01


def test_states_without_a_plan_are_counted(cart_problem):
    start = np.array([[-1.0, 0.5], [1.0, 3.0]])
    weak = np.array([[-2.0, -2.0], [2.0, 0.5]])
    found = distance(replace(cart_problem, start=start, input_box=weak), 20)
    assert 0 < found.infeasible < 20
    assert f"{found.infeasible} more have no plan within the limits" in found.lines()[0]


def test_penalties_that_are_found_beat_those_at_hand(tmp_path):
    fixed = ("start =", "penalty = { state = 100, input = 100 }\nrelaxation = 1\nstart =")
    poor = distance(load_problem(cart(tmp_path, fixed)), 200)
    found = distance(load_problem(cart(tmp_path)), 200)
    assert np.quantile(found.excess, 0.9) < 0.1 * np.quantile(poor.excess, 0.9)


def test_bound_of_roundings_covers_binary32_gains(cart_problem):
    """With its data rounded to binary32 the solver is as near as the bound says."""
    x = drawn(cart_problem, 200, SEED).astype(np.float32).astype(float)
    reference = Reference(cart_problem, 200)
    u = reference.tick(x, np.zeros_like(x))["u"]
    tried, whole = input_bounds(cart_problem, reference.pulls), input_bounds(cart_problem)
    assert (tried <= whole).all() and (tried < 0.01).all()
    worse = replace(
        cart_problem,
        a=cart_problem.a.astype(np.float32).astype(float),
        b=cart_problem.b.astype(np.float32).astype(float),
    )
    moved = np.abs(Reference(worse, 200).tick(x, np.zeros_like(x))["u"] - u)
    assert 0 < moved.max() <= tried.min()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("horizon = 6", "horizn = 6"), r"cart.toml:3: error: unknown key 'horizn'; .*horizon"),
        (("horizon = 6", "horizon = 1"), r"cart.toml:3: error: horizon = 1; it is 2 to 256"),
        (
            ("horizon = 6", "horizon = 250\nrelaxation = 1\npenalty = {state = 1, input = 1}"),
            "data memory, the core has 1024; shorten the horizon",
        ),
        (("iterations = 8\n", ""), "no 'iterations'; every problem states it"),
        (("A = [[0, 1], [0, -0.2]]", "A = [[0, 1]]"), r":9: error: 'A' is 1 by 2; with 2 states"),
        (("B = [[0, 0], [1, 0.5]]", "B = [[0], [1]]"), r":10: error: 'B' is 2 by 1; .* 2 by 2"),
        (("Q = [4, 1]", "Q = [4, -1]"), r":11: error: 'Q' has the eigenvalue -1"),
        (("R = [[0.5, 0.1], [0.1, 1]]", "R = [0.5, 0]"), r":12: error: 'R' has .* definite"),
        (("R = [[0.5, 0.1], [0.1, 1]]", "R = [[1, 2], [0, 1]]"), r":12: error: 'R' is not symm"),
        (("[[20, 4], [4, 6]]", '"best"'), r":13: error: terminal = 'best'; it is 'lqr', 'Q'"),
        (('"trajectory"', '"path"'), r":14: error: reference = 'path'; it is none, point, traj"),
        (("high = [2, 0.5]", "high = [-3, 0.5]"), r":16: error: the box of 'force' is -2 to -3"),
        (("high = [2, 0.5]", "top = [2, 0.5]"), r":16: error: unknown key 'input_box.top'"),
        (("high = [1, 1] }", "high = [1] }"), r":17: error: 'start.high' needs 2 numbers, one"),
        (('"p", "v"', '"p", "p"'), r":7: error: 'p' appears twice"),
        (('"p", "v"', '"p", "force"'), "'force' is a state and an input"),
        (('"p", "v"', '"p", "c12"'), "'c12' cannot name a signal"),
        (("sample_time = 0.1", "sample_time = 0"), r":5: error: sample_time = 0.0; it is above 0"),
        (("start =", "relaxation = 2\nstart ="), r":17: error: relaxation = 2; it is 1 to below 2"),
        (("start =", "penalty = { u = 2 }\nstart ="), r"unknown key 'penalty.u'"),
        (("[0, -0.2]]", "[0, nan]]"), r":9: error: 'A' has an entry that is not finite"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(change, says, tmp_path, capsys):
    assert mpc.main([str(cart(tmp_path, change))]) == 1
    message = capsys.readouterr().err
    assert re.search(says, message), message
    assert not list(tmp_path.glob("*.json"))


def test_a_plant_without_lqr_and_one_without_limits_are_refused(tmp_path):
    still = (("A = [[0, 1], [0, -0.2]]", "A = [[1, 0], [0, -0.2]]"), ("[[20, 4], [4, 6]]", '"lqr"'))
    with pytest.raises(ModelError, match="have no LQR.*terminal = 'Q'"):
        load_problem(cart(tmp_path, *still))
    free = [(line, "") for line in CART.splitlines() if "_box" in line]
    with pytest.raises(ModelError, match="an LQR needs no MPC"):
        load_problem(cart(tmp_path, *free))


def test_quadrotor_in_lanes_takes_less_than_100_us_with_the_interpreters_bits(tmp_path):
    problem = quadrotor_problem()
    built, _ = mpc.build_mpc(problem, tmp_path / "quadrotor.s", "wide")
    assert built.cycles <= 12_500
    proof = prove_mpc(problem, built.compiled, built.image, TICKS, SEED, "iss")
    assert proof.passed, proof.lines()
    assert proof.warm_error < 1e-5


@pytest.mark.full
def test_quadrotor_flies_its_figure_within_the_box_as_in_doubles(tmp_path):
    problem = quadrotor_problem()
    built, _ = mpc.build_mpc(problem, tmp_path / "quadrotor.s")
    assert built.cycles <= 27_500
    core, _ = fly_core(problem, built.image, "iss")
    double = fly_reference(problem)
    assert core.beyond < 0.01 and core.error < 1.05 * double.error
    assert np.abs(core.places[:, 1]).max() > 0.7  # the box is reached
    assert np.abs(core.places - double.places).max() < 1e-3
