# SPDX-License-Identifier: Apache-2.0
"""Friction in the tracking law: bits of the programs, the bristle, reversals of the machine."""

from __future__ import annotations

import functools
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from asip_asm.model.program import build
from sim.bench.drive import lugre
from sim.bench.drive.friction_law import (
    BOUNDS,
    STAGES,
    TABLE,
    bristle,
    compiled,
    corner,
    friction_law,
    pulse_of,
)
from sim.bench.drive.recording import PATH
from sim.bench.drive.whole import FrictionController, Whole, path_of, whole
from sim.laws import own
from sim.laws.prove_program import COUNT, prove
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

ROBOT, DRIVES = Robot.load(), Drives.load()
FULL = pytest.mark.full
REST = "G17 G21 G90 G61.1\nG0 C0.5\nG0 X5\nG0 X0\nG0 X1 C3\nM2\n"


@pytest.mark.parametrize("count", [200, pytest.param(COUNT, marks=FULL)])
@pytest.mark.parametrize("kind", ["feed-forward", "adaptive"])
def test_program__bits_on_the_core_and_distance_from_double_precision(kind, count, tmp_path):
    """Ticks of random motions that start from any states, corners in a tenth of these."""
    program = compiled(ROBOT, DRIVES, kind)
    image = build(program, tmp_path / "law.s").image
    proof = prove(program, image, count=count, sample=lambda n, rng: own.sample(ROBOT, n, rng))
    assert proof.passed and proof.inputs_tried == count, proof


def test_bristle__goes_where_that_of_the_plant_goes():
    friction = DRIVES.friction[0]
    z, v = ca.SX.sym("z"), ca.SX.sym("v")
    step = ca.Function("step", [z, v], bristle(friction, z, v, 1e-4))
    law = plant = 0.0
    for speed in [*np.linspace(0, 0.2, 50), *np.linspace(0.2, -0.2, 200), 0.0]:
        law, force, rest = (float(value) for value in step(law, speed))
        before = plant
        plant, _ = lugre.step(friction, plant, speed, 1e-4)
        assert law == pytest.approx(plant, abs=1e-12)
        want = friction.stiffness * plant + friction.damping * (plant - before) / 1e-4
        assert force + rest == pytest.approx(want + friction.viscous * speed, abs=1e-6)


def law_at(counts: float, speed: float, integral: float, moving: float, n: int) -> dict:
    """A tick of the feed-forward, all axes at home, axis n so many counts after."""
    law = friction_law(ROBOT, DRIVES, "feed-forward").function
    values = {law.name_in(k): np.zeros(law.size1_in(k)) for k in range(law.n_in())}
    values |= {"z": 0.6, f"moving{n}": moving}
    values["count"][:3] = np.hypot(ROBOT.R, 0.6) / ROBOT.resolution[0]
    values["count"][n] = -counts
    values["integral"][n] = integral
    values["w_alpha" if n == 3 else "w_gamma"] = speed
    found = law(**values)
    return {name: np.array(value).ravel() for name, value in found.items()}


@pytest.mark.parametrize("n", TABLE)
def test_rest__integral_takes_an_error_of_half_a_count_or_more(n):
    for counts, held in ((0.49, True), (-0.49, True), (0.51, False), (-0.51, False)):
        found = law_at(counts, 0.0, 0.3, -0.2, n)
        assert bool(found["integral_next"][n] == 0.3) is held
        assert found[f"moving{n}_next"] == -0.2


@pytest.mark.parametrize("n", TABLE)
def test_move__begins_with_the_last_ones_integral_as_far_as_friction_explains_the_change(n):
    hidden = (DRIVES.friction[n].static + DRIVES.friction[n].coulomb) / getattr(ROBOT, TABLE[n])
    for integral, begun in ((0.3, -0.2), (2.0, 2.0 - hidden), (-3.0, -3.0 + hidden)):
        found = law_at(0.0, 1e-3, integral, -0.2, n)
        assert found["integral_next"][n] == pytest.approx(begun, abs=1e-12)
        assert found[f"moving{n}_next"] == found["integral_next"][n]


@pytest.mark.full
def test_slow_move__after_a_rest_errs_at_most_half_of_what_it_does_without(tmp_path):
    """The table rests for 1.4 s next to a count while the tool moves; then it begins slowly."""
    file = tmp_path / "rest.ngc"
    file.write_text(REST)
    path = path_of(ROBOT, file=file)
    plain, better = (whole(ROBOT, DRIVES, path, kind) for kind in ("none", "feed-forward"))
    assert better.tracking.table <= 0.5 * plain.tracking.table


def test_kind__unknown_is_refused():
    with pytest.raises(ValueError, match="must be one of none, feed-forward, adaptive"):
        friction_law(ROBOT, DRIVES, "coulomb")


@functools.cache
def run(kind: str, share: float) -> Whole:
    """To after the first reversal of all axes."""
    return whole(ROBOT, DRIVES, path_of(ROBOT, 8900, Path(PATH)), kind, share)


@pytest.mark.full
@pytest.mark.parametrize(
    ("kind", "share"),
    [
        ("feed-forward", 1.0),
        *(pytest.param(k, 0.8, marks=FULL) for k in ("feed-forward", "adaptive")),
    ],
)
def test_reversal__errs_at_most_half_of_what_it_does_without_friction_in_the_law(kind, share):
    plain, better = run("none", 1.0), run(kind, share)
    assert plain.reversal_leg > 1e-6, "there is no reversal to compare"
    assert better.reversal_leg <= 0.5 * plain.reversal_leg
    if kind == "feed-forward":
        assert better.reversal_table <= 0.5 * plain.reversal_table
    assert better.tracking.leg <= 1.5e-6


@pytest.mark.parametrize("n", [0, 4])
def test_pulse__is_that_of_the_closed_loop_behind_a_reversal_and_fades(n):
    """w^2 s / (s + w)^3 of a step from -1 to 1: (w t)^2 exp(-w t)."""
    states = [ca.SX.sym(name) for name in STAGES]
    signal = ca.SX.sym("signal")
    after, pulse = pulse_of(ROBOT, n, states, signal)
    tick = ca.Function("tick", [*states, signal], [*after, pulse])
    now, found = [-1.0, 0.0, 0.0], []
    for _ in range(5000):
        *now, value = tick(*now, 1.0)
        found.append(float(value))
    t = corner(ROBOT, n) * ROBOT.T_s * np.arange(5000)
    np.testing.assert_allclose(found, t**2 * np.exp(-t), rtol=0, atol=0.02)
    assert abs(found[-1]) < 1e-9


@FULL
def test_adaptive_law__errs_less_than_a_feed_forward_that_believes_in_too_little_friction():
    plain, fed, adapted = (run(k, 0.8) for k in ("none", "feed-forward", "adaptive"))
    assert adapted.reversal_leg <= 0.5 * plain.reversal_leg
    assert adapted.reversal_leg <= fed.reversal_leg


def test_adaptive_law__estimates_stay_between_their_bounds():
    controller = FrictionController(ROBOT, DRIVES, "adaptive")
    path = path_of(ROBOT, 5000, Path(PATH)).words()[1000:]
    counts = [3128100] * 3 + [0, 0]  # the machine does not move at all, a millimetre aside
    controller.prime(path[0], counts)
    found = []
    for words in path:
        controller.step(words, counts)
        found += controller.estimates()
    assert (min(found), max(found)) == BOUNDS
