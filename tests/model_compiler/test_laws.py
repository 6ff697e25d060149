# SPDX-License-Identifier: Apache-2.0
"""Laws of a URDF against their equations, written here with pinocchio's dynamics (no casadi)."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.model.law import Law, Port, before
from sim.laws.catalogue import robot
from sim.laws.laws import LAWS, Settings, count_scale, effort_limit
from sim.laws.prove_casadi import truth_of
from sim.laws.prove_program import draw
from sim.laws.reference import LawReference, PinocchioRobot
from sim.laws.tree import Tree

POINTS = 50
ARMS = ("scara", "xarm7", "iiwa14")


def drawn(law: Law, tree: Tree, settings: Settings) -> tuple[dict, dict]:
    """Inputs and states of `POINTS` ticks by name, and in SI units by kind (POINTS, n), near the
    measured state so that no effort is at its limit; speeds on both sides of `creep`."""
    rng, n = np.random.default_rng(3), len(tree.axes)
    scale = np.array([count_scale(joint, settings) for joint in tree.axes])
    last = np.rint(rng.uniform(-0.3, 0.3, (POINTS, n)) / scale)
    moved = np.rint(rng.uniform(-0.05, 0.05, (POINTS, n)) / settings.rate / scale)
    q, dq = (last + moved) * scale, moved * scale * settings.rate
    single = {
        "goal": q + rng.uniform(-1e-5, 1e-5, q.shape),
        "speed": dq + rng.uniform(-1e-3, 1e-3, q.shape),
        "accel": rng.uniform(-0.1, 0.1, q.shape),
        "extra": rng.uniform(-1, 1, q.shape),
        "s": rng.uniform(-1.1 * settings.windup, 1.1 * settings.windup, q.shape),
    }
    single = {name: values.astype(np.float32) for name, values in single.items()}
    words = {f"{name}{i}": values[:, i] for name, values in single.items() for i in range(n)}
    for i in range(n):
        words[f"q{i}"] = (last + moved)[:, i].astype(np.int32)
        words[before(f"q{i}")] = last[:, i].astype(np.int32)
    asked = {port.name for port in law.ports} | {before(f"q{i}") for i in range(n)}
    si = {name: values.astype(float) for name, values in single.items()} | {"q": q, "dq": dq}
    return {name: values for name, values in words.items() if name in asked}, si


def rubbing(tree: Tree, speed: np.ndarray, creep: float) -> np.ndarray:
    """Viscous and Coulomb friction of the URDF (POINTS, n)."""
    viscous = np.array([joint.damping for joint in tree.axes])
    dry = np.array([joint.friction for joint in tree.axes])
    return viscous * speed + dry * np.clip(speed / creep, -1, 1)


def forces(tree: Tree, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
    """Inverse dynamics by pinocchio (POINTS, n)."""
    arm = PinocchioRobot(tree.description.text, tree.stated)
    return np.array([arm.inverse(*row) for row in zip(q, dq, ddq, strict=True)])


def found(law: Law, words: dict, tree: Tree) -> np.ndarray:
    """Outputs in double precision; none at a limit."""
    results = truth_of(law)(words)
    tau = np.stack([results[f"tau{i}"] for i in range(len(tree.axes))], axis=1)
    assert (np.abs(tau) < [effort_limit(joint) for joint in tree.axes]).all()
    return tau


@pytest.mark.parametrize("integral", [False, True])
@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("name", ARMS)
def test_computed_torque_is_its_equation(name, integral, friction):
    tree = robot(name)
    settings = Settings(integral=integral, friction=friction, damping_ratio=0.8, windup=1e-5)
    law = LAWS["computed_torque"](tree, settings)
    words, x = drawn(law, tree, settings)
    w, e = 2 * np.pi * settings.bandwidth, x["goal"] - x["q"]
    ddq = x["accel"] + w**2 * e + 2 * 0.8 * w * (x["speed"] - x["dq"])
    if integral:
        s = np.clip(x["s"] + e / settings.rate, -settings.windup, settings.windup)
        ddq += w**3 / 10 * s
        results = truth_of(law)(words)
        for i in range(len(tree.axes)):
            np.testing.assert_allclose(results[f"s{i}_next"], s[:, i], rtol=1e-12)
        assert (np.abs(s) == settings.windup).any() and (np.abs(s) < settings.windup).any()
    want = forces(tree, x["q"], x["dq"], ddq)
    if friction:
        want += rubbing(tree, x["speed"], settings.creep)
    np.testing.assert_allclose(found(law, words, tree), want, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("name", ARMS)
def test_joint_impedance_is_its_equation(name, friction):
    tree, settings = robot(name), Settings(friction=friction, stiffness=60.0, damping=4.0)
    law = LAWS["joint_impedance"](tree, settings)
    words, x = drawn(law, tree, settings)
    stiff = np.minimum(60.0, [effort_limit(joint) for joint in tree.axes])
    zero = np.zeros_like(x["q"])
    want = forces(tree, x["q"], zero, zero)
    want += stiff * (x["goal"] - x["q"] - 4.0 / 60.0 * x["dq"])
    if friction:
        want += rubbing(tree, x["dq"], settings.creep)
    np.testing.assert_allclose(found(law, words, tree), want, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("name", ARMS)
def test_gravity_compensation_is_its_equation(name):
    tree, settings = robot(name), Settings()
    law = LAWS["gravity_compensation"](tree, settings)
    words, x = drawn(law, tree, settings)
    zero = np.zeros_like(x["q"])
    want = forces(tree, x["q"], zero, zero) + x["extra"]
    np.testing.assert_allclose(found(law, words, tree), want, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ARMS)
def test_reference__of_every_law__is_the_law_in_double_precision(name, law):
    tree, settings = robot(name), Settings()
    if law == "computed_torque":
        settings = Settings(integral=True, friction=True)
    made = LAWS[law](tree, settings)
    words = {p.name: v for p in made.of_kind("input") for v in [_over_its_range(p)]}
    words |= {p.name: _over_its_range(p) for p in made.of_kind("state")}
    for rate in made.of_kind("rate"):
        words[before(rate.rate_of)] = words[rate.rate_of] - np.int32(3)
    arm = PinocchioRobot(tree.description.text, tree.stated)
    want = LawReference(arm, law, settings)(words)
    got = truth_of(made)(words)
    assert got.keys() == want.keys()
    for result, (value, own) in want.items():
        assert (np.abs(got[result] - value) <= own).all(), result


def _over_its_range(port: Port) -> np.ndarray:
    return draw(port, POINTS, np.random.default_rng(len(port.name) + ord(port.name[-1])))
