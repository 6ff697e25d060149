# SPDX-License-Identifier: Apache-2.0
"""The project's own law written in Python: against the golden model, and as programs."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from asip_asm.model.compiler import compile_law
from asip_asm.model.program import build
from sim.bench.shown_robots.own_errors import compare_with_assembly
from sim.core.api import Core
from sim.laws import own
from sim.laws.closed_loop import DoubleLaw, _run
from sim.laws.native.controller import NativeController
from sim.robot import tracking
from sim.robot.records import OUTPUTS, SetPoints
from tests.model_compiler.proof import FAST, proved

LAWS = {"printed": own.printed, "optimised": own.optimised}
CYCLES = {"printed": 214, "optimised": 124}


@pytest.mark.parametrize("name", LAWS)
def test_law_is_the_golden_model_at_every_tick(robot, name):
    values = own.sample(robot, 500, np.random.default_rng(4))
    words = np.stack([values[n] for n in own.SET_POINTS], axis=1).astype(float)
    counts = np.stack([values[f"count{i}"] for i in own.AXES], axis=1)
    want = tracking.run(robot, SetPoints.from_words(words), counts).output
    double = DoubleLaw(LAWS[name](robot))
    rows = [{key: column[k].item() for key, column in values.items()} for k in range(500)]
    got = np.array([list(double.tick(row).values()) for row in rows])
    assert np.abs(got - want).max() < 1e-7


@pytest.mark.parametrize("name", (pytest.param("printed", marks=pytest.mark.full), "optimised"))
def test_program_is_short_and_keeps_its_bound(robot, tmp_path, name):
    sample = functools.partial(own.sample, robot)
    built, proof = proved(LAWS[name](robot), tmp_path, FAST, 200, sample=sample)
    assert built.cycles <= CYCLES[name] and built.cycles <= 1.05 * built.bound_cycles
    assert proof.largest_error["F1"] < 2.0  # N, of 3000


@pytest.mark.quick("optimised")
@pytest.mark.parametrize("name", LAWS)
def test_errors_of_outputs_are_those_of_the_assembly_program_on_the_path(robot, name):
    compiled = compile_law(LAWS[name](robot), FAST)
    errors = compare_with_assembly(f"own_{name}", compiled, ticks=20_000)
    assert set(errors) == set(OUTPUTS)
    for output, (error, target) in errors.items():
        assert 0 < error <= target, (output, error, target)


def test_native_controller_has_the_bits_of_the_core_over_ticks(robot, tmp_path):
    """States and last counts go from tick to tick."""
    built = build(compile_law(own.optimised(robot)), tmp_path / "law.s")
    values = own.sample(robot, 20, np.random.default_rng(6))
    words = np.stack([values[n] for n in own.SET_POINTS], axis=1)
    counts = np.stack([values[f"count{i}"] for i in own.AXES], axis=1)
    native = NativeController(built.compiled)
    native.prime(words[0], counts[0])
    with Core(built.image, backend="iss") as core:
        core.preset({f"count{i}_before": int(counts[0, i]) for i in own.AXES})
        for k in range(20):
            want = core.tick({name: column[k].item() for name, column in values.items()})
            got = native.step(words[k], counts[k]).outputs[0]
            assert got[:3].tolist() == [want[name] for name in OUTPUTS[:3]], k


def test_plant_follows_its_path(robot):
    machine = own.FiveAxes(robot, 0.1)
    double = DoubleLaw(own.optimised(robot))
    loop = _run(machine, lambda inputs, _: double.tick(inputs))
    # The motion shakes at 30 Hz, the bandwidth of the loop.
    assert np.abs(loop.errors[-500:, :3]).max() < 1e-4
