# SPDX-License-Identifier: Apache-2.0
"""Certificates hold: errors against 200 bits at random and searched points, and planted faults."""

from __future__ import annotations

import math
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from asip_asm.model import (
    box_search,
    enclosure,
    enclosure_choices,
    enclosure_rules,
    ranges,
    structure,
)
from asip_asm.model.certificate import Certificate, certify
from asip_asm.model.compiler import Compiled, Options, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.law import Law, Port
from tests.model_compiler.graph_laws import alone, in_200_bits, random_law
from tests.model_compiler.laws import mixed
from tests.model_compiler.test_function_errors import sine_at_its_worst

EFFORT = 100_000
FAST = Options(reassociate=True, reciprocal=True)
Points = dict[str, np.ndarray]


def points_of(certificate: Certificate, count: int, rng: np.random.Generator) -> Points:
    """Random inputs of the box; many are ends, zeros, tiny, or equal to another input."""
    found: Points = {}
    for each in certificate.inputs:
        values = rng.uniform(each.low, each.high, count)
        special = rng.choice([each.low, each.high, 0.0, 1e-30, -1e-20, 0.5], count)
        values = np.where(rng.random(count) < 0.2, special, values)
        for other in list(found.values())[-1:]:
            values = np.where(rng.random(count) < 0.1, other, values)
        found[each.name] = np.clip(values, each.low, each.high).astype(np.float32)
    return found


def near(points: Points, certificate: Certificate, at: int, rng: np.random.Generator) -> Points:
    """Inputs near one of the points, over many scales."""
    found = {}
    for each in certificate.inputs:
        size = 10.0 ** rng.uniform(-8, -1, 20) * rng.choice([-1, 0, 1], 20)
        values = points[each.name][at] * (1 + size) + size * 1e-3
        found[each.name] = np.clip(values, each.low, each.high).astype(np.float32)
    return found


def shares(compiled: Compiled, certificate: Certificate, points: Points) -> np.ndarray:
    """Largest error by its bound at each point; sines are as wrong as the unit may be."""
    count = len(next(iter(points.values())))
    worst = np.zeros(count)
    exact = [
        in_200_bits(compiled.law, {n: float(v[k]) for n, v in points.items()}) for k in range(count)
    ]
    for sign in (1, -1):
        nodes = evaluate(compiled.graph, points, sine_at_its_worst(sign))
        for name, root in compiled.graph.outputs.items():
            bound = certificate.bounds[name].bound
            if math.isinf(bound):
                continue
            for k in range(count):
                error = float(abs(exact[k][name] - float(nodes[root][k])))
                share = error / bound if bound else math.inf * error if error else 0.0
                worst[k] = max(worst[k], math.inf if math.isnan(share) else share)
    return worst


def worst_share(law: Law, options: Options, seed: int, count: int = 40) -> float:
    """Largest share at random points and at some near the worst of them."""
    compiled = compile_law(law, options)
    certificate = certify(compiled.graph, law, EFFORT)
    rng = np.random.default_rng(seed)
    points = points_of(certificate, count, rng)
    found = shares(compiled, certificate, points)
    worst = float(found.max())
    for at in np.argsort(-found)[:2]:
        around = near(points, certificate, at, rng)
        worst = max(worst, float(shares(compiled, certificate, around).max()))
    return worst


def check(seed: int) -> bool:
    """Whether the certificate of a random law is finite; its bounds must hold."""
    law = random_law(seed)
    options = FAST if seed % 2 else Options()
    share = worst_share(law, options, seed)
    assert share <= 1, f"seed {seed}: error / bound {share}; replay: check({seed})"
    return bool(share)


@pytest.mark.quick("10")
@pytest.mark.parametrize("first", range(0, 30, 10))
def test_no_random_law_is_beyond_its_certificate(first):
    assert sum(check(seed) for seed in range(first, first + 10)) >= 3, "few bounds said anything"


@pytest.mark.full
@pytest.mark.parametrize("first", range(100, 1100, 50))
def test_no_law_of_many_is_beyond_its_certificate(first):
    for seed in range(first, first + 50):
        check(seed)


DIRECTED: dict[str, Law] = {
    "sum": alone(lambda x: x[0] + x[1] + x[2], 3, (-1.0, 1.0)),
    "product": alone(lambda x: x[0] * x[1] - x[1] * x[2], 3, (-3.0, 3.0)),
    "quotient": alone(lambda x: x[0] / (x[1] * 0.1 + 0.11), 2, (-1.0, 1.0)),
    "constant": alone(lambda x: x * 0.1, 1, (-1.0, 1.0)),
    "root": alone(
        lambda x: ca.sqrt(ca.fmax((x[0] + x[1]) ** 2 - x[0] * (x[0] + 2 * x[1]) - x[1] ** 2, 0)),
        2,
        (-1.0, 1.0),
    ),
    "sine": alone(lambda x: ca.sin(x), 1, (-3.0, 3.0)),
    "sine of a sum": alone(lambda x: ca.sin(50 * x[0] + x[1]), 2, (-3.0, 3.0)),
    "exponential": alone(lambda x: ca.exp(x), 1, (-3.0, 3.0)),
    "switch": alone(lambda x: ca.if_else(x[0] * x[1] > 0.01, 1, -1), 2, (-1.0, 1.0)),
    "sign": alone(lambda x: ca.sign(x[0] * 0.1 + x[1]), 2, (-1.0, 1.0)),
    "floor": alone(lambda x: ca.floor(x[0] * 3.3 + x[1]), 2, (-10.0, 10.0)),
    "least": alone(lambda x: ca.fmin(x[0] + x[1], x[0] * x[1]), 2, (-2.0, 2.0)),
    "turned": alone(
        lambda x: (ca.cos(x[0]) * x[1] + ca.sin(x[0]) * (x[2] + x[1])) ** 4, 3, (-3.0, 3.0)
    ),
}


def switching_points(name: str) -> Points:
    """Points on the threshold of a directed law, which random ones do not meet."""
    near_ = np.linspace(0.02, 0.9, 400).astype(np.float32)
    if name == "switch":
        return {"x0": near_, "x1": (0.01 / near_.astype(float)).astype(np.float32)}
    if name == "sign":
        return {"x0": near_, "x1": (-0.1 * near_.astype(float)).astype(np.float32)}
    whole = np.arange(400) % 20
    x1 = (whole - 3.3 * near_.astype(float)).astype(np.float32)
    return {"x0": near_, "x1": np.clip(x1, -10, 10)}


def directed_share(name: str) -> float:
    law = DIRECTED[name]
    share = worst_share(law, Options(), 5, 200)
    if name in ("switch", "sign", "floor"):
        compiled = compile_law(law, Options())
        certificate = certify(compiled.graph, law, EFFORT)
        share = max(share, float(shares(compiled, certificate, switching_points(name)).max()))
    return share


@pytest.mark.parametrize("name", DIRECTED)
def test_directed_laws_are_within_their_certificates_and_near_them(name):
    assert 0.01 < directed_share(name) <= 1


def smaller(function: Callable, factor: float) -> Callable:
    return lambda *given: function(*given) * factor


def narrow(function: Callable) -> Callable:
    """Half of a range."""

    def half(*given):
        found = function(*given)
        middle = 0.5 * (found.low + found.high)
        return ranges.Form(0.5 * (found.low + middle), 0.5 * (found.high + middle))

    return half


def steady(*_):
    """A rule of whole numbers that forgets that roundings decide."""
    return 0.0


def no_doubt(rule: Callable) -> Callable:
    def changed(found, i, args):
        step = rule(found, i, args)
        step.own = step.own * 0
        step.jump = None
        step.in_doubt = None if step.in_doubt is None else step.in_doubt * 0
        return step

    return changed


def exact_constant(method: Callable) -> Callable:
    def changed(self, value):
        step = method(self, value)
        step.own = step.own * 0
        return step

    return changed


def flat(rule: Callable) -> Callable:
    """A rule whose derivatives are too small."""

    def changed(found, i, args):
        step = rule(found, i, args)
        step.partials = tuple(
            ranges.scaled(p, 0.25) if isinstance(p, ranges.Form) else p for p in step.partials
        )
        step.waves = ()
        return step

    return changed


RULES = enclosure_rules.RULES
PLANTS = {
    "roundings of a quarter": ("sum", enclosure, "half_ulp", smaller(enclosure.half_ulp, 0.25)),
    "no rounding of constants": (
        "constant", enclosure.Enclosure, "constant_step",
        exact_constant(enclosure.Enclosure.constant_step),
    ),
    "products of half their size": ("product", enclosure_rules, "times", narrow(ranges.times)),
    "reciprocals of a tenth": (
        "quotient", enclosure_rules, "inverse", lambda x: ranges.scaled(ranges.inverse(x), 0.1)
    ),
    "sines without their own error": ("sine", enclosure_rules, "SINE_ULP", 0.1),
    "angles that hardly move a sine": ("sine of a sum", RULES, "fsin", flat(RULES["fsin"])),
    "exponentials in a tenth of an ulp": (
        "exponential", enclosure_rules.MARKED, "exp",
        enclosure_rules.MARKED["exp"].__class__(
            np.exp, lambda x: (np.exp(x),), 0.02, 3e-38, (-86.5, 88.3)
        ),
    ),
    "comparisons without doubt": ("switch", RULES, "flt", no_doubt(RULES["flt"])),
    "signs without doubt": ("sign", RULES, "fsgn", no_doubt(RULES["fsgn"])),
    "whole numbers without doubt": ("floor", enclosure_choices, "_steps_of", steady),
    "roots as smooth at 0 as elsewhere": ("root", RULES, "fsqrt", no_doubt(RULES["fsqrt"])),
    "all floors taken as turns of an angle": (
        "floor", structure.Structure, "_only_turns", lambda self, i: True
    ),
    "sines and cosines that never add up": (
        "turned", enclosure_rules, "_polar",
        lambda found, i, value: ranges.within(value, -0.3, 0.3)
        if i in found.structure.joint_sums else value,
    ),
    "boxes that lose their upper half": (
        "product", box_search.Problem, "whole",
        lambda self: (
            np.array([[each.low] for each in self.inputs]),
            np.array([[0.6 * each.low + 0.4 * each.high] for each in self.inputs]),
        ),
    ),
}  # fmt: skip


@pytest.mark.parametrize("plant", PLANTS)
def test_planted_faults_are_found(plant, monkeypatch):
    law, place, name, changed = PLANTS[plant]
    if isinstance(place, dict):
        monkeypatch.setitem(place, name, changed)
    else:
        monkeypatch.setattr(place, name, changed)
    assert directed_share(law) > 1


# ---------------------------------------------------------------------- guards and faults
def certificate_of(law: Law, effort: int = 500_000) -> Certificate:
    return certify(compile_law(law, Options()).graph, law, effort)


def test_a_direction_is_not_certified_at_zero():
    found = certificate_of(alone(lambda x: x / ca.norm_2(x), 2, (-1.0, 1.0)))
    assert not found.finite
    assert found.fault.reason == "division by zero"
    assert found.fault.point == {"x0": 0.0, "x1": 0.0}
    for low, high in found.fault.box.values():
        assert -1e-6 < low <= 0 <= high < 1e-6
    assert found.fault.text().startswith("at x0 = 0, x1 = 0: division by zero")


def within_50(x: ca.SX) -> ca.SX:
    """Saturated, as an output is; a bound of 100 would then pass for one."""
    return ca.fmax(ca.fmin(x, 50), -50)


@pytest.mark.parametrize(
    ("expression", "limits", "most"),
    [
        (lambda x: ca.if_else(x == 0, 1, ca.sin(x) / x), (-3.0, 3.0), 3e-7),
        (lambda x: within_50(ca.if_else(x == 0, 1, ca.sin(x) / x)), (-3.0, 3.0), 3e-7),
        (lambda x: within_50(ca.if_else(x == 0, 1, ca.atan(x) / x)), (-3.0, 3.0), 4e-7),
        (lambda x: within_50(ca.if_else(x == 0, 1, ca.log1p(x) / x)), (-0.5, 3.0), 2e-6),
        (lambda x: ca.if_else(x > 0, ca.sqrt(x), 0), (-4.0, 4.0), 1.3e-7),
        (lambda x: ca.if_else(ca.fabs(x) < 0.5, 0, 1 / x), (-4.0, 4.0), 1.3e-7),
    ],
)
def test_the_branch_not_taken_adds_nothing(expression, limits, most):
    found = certificate_of(alone(expression, 1, limits))
    assert found.finite
    assert found.bounds["r0"].bound < most


def test_a_root_of_what_cancels_is_off_by_the_root_of_its_error():
    found = certificate_of(DIRECTED["root"])
    assert 1e-4 < found.bounds["r0"].bound < 3e-3


@pytest.mark.parametrize(
    ("expression", "limits", "reason", "inside"),
    [
        (lambda x: 1 / x, (0.5, 2.0), "", None),
        (lambda x: 1 / (x - 1), (0.5, 2.0), "division by zero", 1.0),
        (lambda x: ca.sqrt(x - 1), (0.5, 2.0), "root of a negative number", 0.7),
        (lambda x: ca.sin(100 * x), (-3.0, 3.0), "sine beyond 256 rad", 2.9),
        (lambda x: ca.exp(x), (-5.0, 95.0), "exp outside of -86.5 to 88.3", 90.0),
        (lambda x: (x * 1e30) * (x * 1e30), (-1.0, 1.0), "overflow", 0.5),
        (lambda x: ca.log(x), (-1.0, 1.0), "log outside of 1.17549e-38 to 1.2e+38", 0.0),
        (lambda x: ca.floor(x * 1e10), (-1.0, 1.0), "integer beyond 32 bits", 0.5),
    ],
)
def test_operations_that_leave_their_domain_are_shown_with_an_input(
    expression, limits, reason, inside
):
    found = certificate_of(alone(expression, 1, limits))
    assert found.finite == (not reason)
    if reason:
        assert found.fault.reason == reason
        low, high = found.fault.box["x0"]
        assert low <= inside <= high
        assert low <= found.fault.point["x0"] <= high


def test_a_turn_more_or_less_moves_no_cosine():
    def expression(x: ca.SX) -> ca.SX:
        turns = x * 0.37
        return ca.cos((turns - ca.floor(turns + 0.5)) * (2 * math.pi) + 0.25)

    found = certificate_of(alone(expression, 1, (-40.0, 40.0)))
    assert found.bounds["r0"].bound < 3e-5


def test_rates_and_states_have_ranges_of_their_own():
    found = certificate_of(mixed())
    inputs = {each.name: each for each in found.inputs}
    assert inputs["q_rate"].high < 10
    assert (inputs["s"].low, inputs["s"].high) == (-1.0, 1.0)
    assert found.finite and not found.open_states
    assert set(found.assumed) == {"x0", "x1", "x2"}


def test_a_state_without_an_end_counts_for_one_tick():
    x, s = ca.SX.sym("x"), ca.SX.sym("s")
    function = ca.Function("f", [x, s], [s + x, 2 * s + x], ["x", "s"], ["y", "s_next"])
    ports = [
        Port("input", "x", limits=(-1.0, 1.0)),
        Port("state", "s", limits=(-2.0, 2.0)),
        Port("output", "y"),
    ]
    found = certificate_of(Law("grows", function, ports))
    assert list(found.open_states) == ["s"]
    assert found.as_json()["states_for_one_tick"] == ["s"]


def test_the_change_of_an_input_is_that_of_what_a_state_holds_of_it():
    x, last = ca.SX.sym("x"), ca.SX.sym("last")
    function = ca.Function(
        "f", [x, last], [1e3 * (x - last), x], ["x", "last"], ["speed", "last_next"]
    )
    ports = [
        Port("input", "x", limits=(-8.0, 8.0), change=2.0**-10),
        Port("state", "last", limits=(-8.0, 8.0)),
        Port("output", "speed"),
    ]
    found = certificate_of(Law("differs", function, ports))
    assert found.bounds["speed"].high < 1
    values = {"x": np.float32([1.0, 1.0]), "last": np.float32([1.0, 0.5])}
    assert found.covers(values).tolist() == [True, False]


def test_the_same_law_has_the_same_certificate():
    law = random_law(7)
    assert certificate_of(law, EFFORT).as_json() == certificate_of(law, EFFORT).as_json()
