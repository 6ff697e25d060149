# SPDX-License-Identifier: Apache-2.0
"""The planner's programs on the Verilated core against the plan in doubles of the same inputs."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from sim.core.iss import Iss
from sim.motion.planner.check import random_core_moves
from sim.motion.planner.core import ERRORS, PARAMETERS, planner_program
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.motion.planner.scurve import SCurve, SCurveError
from sim.robot.parameters import Robot
from tests.bench.seed import SEED

MICROMETRE = 1e-6
TICK = Robot.load().T_s
MOVES = 3000
DATA = ("vp", "am", "J", "t1", "t2", "t4", "s1", "s2", "s3")
# One division and its operands, a handful of roundings of 2^-24 each.
FEW_ROUNDINGS = 8 * 2.0**-24


def plan_of(moves: dict[str, np.ndarray], index: int) -> SCurve:
    return SCurve(*(float(moves[name][index]) for name in PARAMETERS))


def is_on_a_boundary(curve: SCurve) -> bool:
    """Whether the rounding of binary32 decides the class."""
    return any(
        abs(curve.length - critical) <= FEW_ROUNDINGS * critical
        for critical in (curve.cruise_critical_length, curve.acceleration_critical_length)
    )


@pytest.fixture(scope="module", params=["fast", "small"])
def planner(request):
    return planner_program("planner_scurve", request.param)


@pytest.fixture(scope="module")
def moves():
    return random_core_moves(MOVES, SEED)


@pytest.fixture(scope="module")
def planned(moves):
    return planner_program("planner_scurve").batch(moves)


def assert_plans_agree(moves: dict[str, np.ndarray], outputs: dict[str, np.ndarray]) -> set[int]:
    """Classes, phases and acceleration data of all moves; returns the classes that occurred."""
    kinds = set()
    for index in range(len(moves["L"])):
        curve = plan_of(moves, index)
        got = {name: float(values[index]) for name, values in outputs.items()}
        where = f"move {index}, SEED={SEED}: {[float(moves[n][index]) for n in PARAMETERS]}"
        assert got["error"] == 0.0, where
        boundary = is_on_a_boundary(curve)
        if not boundary:
            assert got["class"] == curve.kind.value, where
            kinds.add(curve.kind.value)
        t1, t2, _, t4, *_ = curve.durations
        for name, want, size in (
            ("vp", curve.peak_speed, curve.peak_speed),
            # The speed won is a difference of speeds.
            ("am", curve.peak_acceleration, curve.peak_speed / (curve.tr - curve.tm)),
            ("t1", t1, t1 if not boundary else math.inf),
            ("t2", t2, curve.tr if not boundary else math.inf),
            ("t4", t4, (curve.length / curve.peak_speed) if not boundary else math.inf),
        ):
            assert abs(got[name] - want) <= FEW_ROUNDINGS * size, f"{name} of {where}"
        if curve.tm > 0:
            size = curve.peak_speed / (curve.tr - curve.tm) / curve.tm
            assert abs(got["J"] - curve.jerk) <= FEW_ROUNDINGS * size, f"J of {where}"
        else:
            assert got["J"] == 0.0, where
        for k, want in enumerate(curve.displacements[:4]):
            name = f"s{k + 1}"
            if not boundary:
                assert abs(got[name] - want) <= MICROMETRE * curve.length, f"{name} of {where}"
        sides = 2 * (got["s1"] + got["s2"] + got["s3"])
        assert abs(sides + got["s4"] - curve.length) <= MICROMETRE * curve.length, where
    return kinds


def test_program__random_moves_of_all_classes__agree_with_the_model(moves, planned):
    assert assert_plans_agree(moves, planned.values) == {1, 2, 3, 4, 5, 6, 7}


def test_program__any_move__takes_the_same_cycles(planner):
    cycles = planner.batch(random_core_moves(200, SEED + 1)).cycles
    assert len(set(cycles.tolist())) == 1
    # Far below one tick of 10 kHz at 125 MHz.
    assert cycles[0] < 12_500


@pytest.mark.full
def test_program__hundred_thousand_moves__agree_with_the_model():
    many = random_core_moves(100_000, SEED + 2)
    kinds = assert_plans_agree(many, planner_program("planner_scurve").batch(many).values)
    assert kinds == {1, 2, 3, 4, 5, 6, 7}


def test_program__configurations_and_model__give_the_same_bits(planner, moves, planned):
    some = {name: values[:100] for name, values in moves.items()}
    outputs = planner.batch(some).values
    model = Iss(planner.image.to_json())
    for index in range(100):
        model.set_inputs({name: float(values[index]) for name, values in some.items()})
        bits = model.run().output_bits
        for name, values in outputs.items():
            assert int(values[index].view(np.uint32)) == bits[name]
            assert int(planned.values[name][index].view(np.uint32)) == bits[name]


def test_program__lengths_by_the_critical_ones__agree_with_the_model():
    """Every representable length around L_alpha and L_beta."""
    v0, vm, tr = np.float32(0.1), np.float32(0.6), np.float32(0.7)
    lengths = []
    for critical in ((v0 + vm) * tr, np.float32(2) * v0 * tr):
        word = int(np.float32(critical).view(np.uint32))
        lengths += [np.uint32(word + k).view(np.float32) for k in range(-40, 41)]
    count = len(lengths)
    columns = (v0, vm, tr, np.float32(0.1))
    inputs = dict(zip(PARAMETERS, [np.full(count, x) for x in columns], strict=False))
    inputs["L"] = np.array(lengths)
    outputs = planner_program("planner_scurve").batch(inputs).values
    assert set(outputs["class"].tolist()) == {1.0, 6.0, 7.0}
    assert_plans_agree(inputs, outputs)


@pytest.mark.parametrize(
    ("move", "code"),
    [
        ((0.1, 0.6, 0.6, 0.15, 0.8), 0),
        ((0.0, 0.0, 0.6, 0.15, 0.8), 1),
        ((0.1, -0.6, 0.6, 0.15, 0.8), 1),
        ((0.1, math.nan, 0.6, 0.15, 0.8), 1),
        ((0.1, math.inf, 0.6, 0.15, 0.8), 1),
        ((-0.1, 0.6, 0.6, 0.15, 0.8), 2),
        ((0.7, 0.6, 0.6, 0.15, 0.8), 2),
        ((math.nan, 0.6, 0.6, 0.15, 0.8), 2),
        ((0.1, 0.6, 0.0, 0.0, 0.8), 3),
        ((0.1, 0.6, math.nan, 0.15, 0.8), 3),
        ((0.1, 0.6, math.inf, 0.15, 0.8), 3),
        ((0.1, 0.6, 0.6, -0.15, 0.8), 4),
        ((0.1, 0.6, 0.6, 0.4, 0.8), 4),
        ((0.1, 0.6, 0.6, math.nan, 0.8), 4),
        ((0.1, 0.6, 0.6, 0.15, 0.0), 5),
        ((0.1, 0.6, 0.6, 0.15, -math.inf), 5),
        ((0.1, 0.6, 0.6, 0.15, math.inf), 5),
        ((0.1, 0.6, 0.6, 0.15, math.nan), 5),
        ((-1.0, -1.0, -1.0, -1.0, -1.0), 1),
        ((0.1, 1e20, 1e-20, 1e-21, 1e5), 6),
        ((1e-20, 1e-19, 1.0, 0.1, 1e20), 6),
    ],
)
def test_program__bad_parameters__give_their_error_and_zeros(planner, move, code):
    inputs = {name: np.array([x], np.float32) for name, x in zip(PARAMETERS, move, strict=True)}
    outputs = planner.batch(inputs).values
    assert outputs.pop("error")[0] == code, ERRORS[code]
    if code:
        assert all(values[0] == 0.0 for values in outputs.values())
    if 0 < code < 6 and all(math.isfinite(x) for x in move):
        with pytest.raises(
            SCurveError, match="S-curve parameter " + "x vm v0 tr tm length".split()[code]
        ):
            ramp_time_plan(*move)


def test_document__table_of_errors__is_the_one_of_the_command():
    page = Path(__file__).parents[2] / "docs/motion.md"
    table = re.findall(r"^\| (\d) \| (.*) \|$", page.read_text(), re.M)
    causes = {int(code): cause for code, cause in table if cause in ERRORS or code == "0"}
    assert causes == dict(enumerate(ERRORS))


# ------------------------------------------------------------------------------- sampler


def test_sampler__random_ticks_of_all_classes__are_within_a_micrometre(moves, planned):
    """One tick of every move, in and around the move."""
    curves = [plan_of(moves, index) for index in range(MOVES)]
    totals = np.array([curve.total_time for curve in curves])
    share = np.random.default_rng(SEED).uniform(-0.02, 1.05, MOVES)
    ticks = np.rint(totals / TICK * share).astype(np.int32)
    inputs = {"ticks": ticks, "L": moves["L"], "v0": moves["v0"]}
    inputs |= {name: planned.values[name] for name in DATA}
    outputs = planner_program("planner_sample").batch(inputs).values
    phases = set()
    for index, (curve, tick) in enumerate(zip(curves, ticks, strict=True)):
        time = int(tick) * TICK
        want = curve.profile(time)
        where = f"move {index}, tick {tick}, SEED={SEED}"
        assert abs(float(outputs["p"][index]) - want.position) <= MICROMETRE, where
        # The time is wrong by its rounding, and so are speed and acceleration.
        late = FEW_ROUNDINGS * curve.total_time
        speed = FEW_ROUNDINGS * curve.peak_speed + curve.peak_acceleration * late
        if curve.kind.value == 1 or is_on_a_boundary(curve):
            continue
        assert abs(float(outputs["v"][index]) - want.velocity) <= speed, where
        if curve.tm > 0:
            size = curve.peak_speed / (curve.tr - curve.tm)
            allowed = FEW_ROUNDINGS * (size + size / curve.tm * curve.total_time)
            assert abs(float(outputs["a"][index]) - want.acceleration) <= allowed, where
        assert outputs["over"][index] == (time >= curve.total_time), where
        phases.add(int(outputs["phase"][index]))
    assert phases == {1, 2, 3, 4, 5, 6, 7}


def test_sampler__end_and_start__are_exact(moves, planned):
    count = 300
    inputs = {"L": moves["L"][:count], "v0": moves["v0"][:count]}
    inputs |= {name: planned.values[name][:count] for name in DATA}
    program = planner_program("planner_sample")
    for tick, position, over in ((2**31 - 1, inputs["L"], 1), (0, 0.0, 0), (-(2**31), 0.0, 0)):
        outputs = program.batch({"ticks": np.full(count, tick)} | inputs).values
        assert np.array_equal(outputs["p"], np.broadcast_to(position, count).astype(np.float32))
        moving = planned.values["class"][:count] > 1
        assert np.array_equal(outputs["v"][moving], inputs["v0"][moving])
        assert np.all(outputs["a"] == 0.0) and np.all(outputs["over"] == over)


# ------------------------------------------------------------------------- trajectory generator


def test_trajectory__moves_one_after_the_other__follow_the_model_tick_by_tick():
    program = planner_program("planner_trajectory")
    cycles = set()
    for number, move in enumerate(
        (
            (0.0, 0.6, 0.05, 0.02, 0.04),
            (0.1, 0.6, 0.05, 0.025, 0.03),
            (0.1, 0.6, 0.06, 0.0, 0.02),
            (0.2, 0.6, 0.06, 0.01, 0.01),
        )
    ):
        curve = SCurve(*(float(np.float32(x)) for x in move))
        ticks = math.ceil(curve.total_time / TICK) + 20
        inputs = {name: np.full(ticks, np.nan, np.float32) for name in ("start", *PARAMETERS)}
        inputs["start"][:] = 0.0
        inputs["start"][0] = 1.0
        for name, value in zip(PARAMETERS, move, strict=True):
            inputs[name][0] = value  # not a number afterwards: the move is held
        run = program.batch(inputs)
        want = curve.profile(np.arange(ticks) * TICK)
        assert np.all(run.values["error"] == 0.0)
        assert np.abs(run.values["p"] - want.position).max() <= MICROMETRE, f"move {number}"
        assert np.abs(run.values["v"] - want.velocity).max() <= 1e-5 * curve.peak_speed
        assert np.count_nonzero(run.values["over"]) in (20, 21)
        assert run.values["p"][-1] == np.float32(move[-1])
        cycles |= set(run.cycles.tolist())
    assert len(cycles) == 1


def test_trajectory__no_move_or_a_refused_one__rests_with_its_error():
    program = planner_program("planner_trajectory")
    inputs = {name: np.zeros(5, np.float32) for name in ("start", *PARAMETERS)}
    assert program.batch(inputs).values["error"].tolist() == [1.0] * 5
    for name, value in zip(PARAMETERS, (0.1, 0.6, 0.05, 0.03, 0.04), strict=True):
        inputs[name][:] = value
    inputs["start"][1] = 1.0
    outputs = program.batch(inputs).values
    assert outputs["error"].tolist() == [1.0, 4.0, 4.0, 4.0, 4.0]
    assert np.all(outputs["over"] == 1.0) and np.all(outputs["p"] == 0.0)
    inputs["tm"][:] = 0.02
    assert program.batch(inputs).values["error"].tolist() == [4.0, 0.0, 0.0, 0.0, 0.0]
