# SPDX-License-Identifier: Apache-2.0
"""Sines and cosines on the multiply-add pipes: error over their domains, choice, programs."""

from __future__ import annotations

import casadi as ca
import gmpy2
import numpy as np
import pytest

from asip_asm.model import sine
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.functions import TURN, TURNS
from asip_asm.model.graph import Graph
from asip_asm.model.law import Law, Port, build_graph
from asip_asm.model.program import build
from asip_asm.model.simplify import simplify
from scripts import sine_polynomial
from sim.bench.shown_robots.cycles import MOST, arm_law
from sim.laws.asip_model.effects import effects
from sim.laws.laws import Settings
from sim.laws.prove_program import prove, rounded_sine
from tests.model_compiler.proof import FAST, proved

COUNTS = 1 << 20
NAMES = ("sin", "cos")
CHUNK = 1 << 20


def polynomial(name: str, limit: float, t: np.ndarray, by_choices: bool) -> np.ndarray:
    """The polynomial's value of angles of at most `limit` turns, given in turns."""
    graph = Graph()
    call = graph.add(name, graph.add("input", value="t"))
    graph.outputs["r"] = call
    form = sine.replace_sines(graph, {call: sine.Angle(0, 1.0, 0.0, limit)}, by_choices)
    return evaluate(form, {"t": t.astype(np.float32)}, rounded_sine)[form.outputs["r"]]


def worst(name: str, limit: float, t: np.ndarray) -> tuple[float, float]:
    """Largest error in units of 2^-23 of the result, less the absolute part, and the angle, of both
    ways to fold the angle.
    """
    found = []
    for part in np.array_split(t, 1 + len(t) // CHUNK):
        want = TURNS[f"{name}_turns"].exact(part.astype(np.float64), 1.0)
        for by_choices in (False, True):
            got = polynomial(name, limit, part, by_choices).astype(np.float64)
            gap = np.abs(got - want) - TURNS[f"{name}_turns"].absolute
            error = gap / (2.0**-23 * np.maximum(np.abs(want), 1e-300))
            found.append((float(error.max()), float(part[int(error.argmax())])))
    return max(found)


def every_float(low: float, high: float, step: int = 1) -> np.ndarray:
    """Binary32 numbers of both signs, sizes from low to high."""
    first, last = (int(np.float32(end).view(np.uint32)) for end in (low, high))
    positive = np.arange(first, last + 1, step, dtype=np.uint32).view(np.float32)
    return np.concatenate((positive, -positive))


@pytest.mark.quick("sin")
@pytest.mark.parametrize("name", NAMES)
def test_every_count_of_an_encoder_of_20_bits_keeps_the_stated_error(name):
    turns = np.arange(-COUNTS, COUNTS + 1) / COUNTS
    for limit in (0.25, 0.5, 0.75, 1.0, 4.0):
        error, where = worst(name, limit, turns[np.abs(turns) <= limit])
        assert 0.8 < error < TURNS[f"{name}_turns"].ulp, (limit, where)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("limit", [0.5, 0.75, 1.0])
def test_floats_from_the_smallest_to_the_largest_keep_the_stated_error(name, limit):
    error, where = worst(name, limit, every_float(0.0, limit, 4001))
    assert error < TURNS[f"{name}_turns"].ulp, where


@pytest.mark.full
@pytest.mark.parametrize("name", NAMES)
def test_every_float_from_a_256th_to_a_turn_keeps_the_stated_error(name):
    for power in range(-8, 0):
        limit = 2.0 ** (power + 1)
        error, where = worst(name, max(limit, 0.5), every_float(2.0**power, limit))
        assert error < TURNS[f"{name}_turns"].ulp, where


@pytest.mark.full
@pytest.mark.parametrize("name", NAMES)
def test_every_multiple_of_a_2_to_the_21st_up_to_four_turns_keeps_the_stated_error(name):
    error, where = worst(name, 4.0, np.arange(-(1 << 23), (1 << 23) + 1) / (1 << 21))
    assert error < TURNS[f"{name}_turns"].ulp, where


@pytest.mark.parametrize("name", NAMES)
def test_reference_is_that_of_mpfr(name):
    gmpy2.get_context().precision = 200
    function = getattr(gmpy2, name)
    for t in np.random.default_rng(1).uniform(-1, 1, 100):
        want = float(function(2 * gmpy2.const_pi() * gmpy2.mpfr(float(t))))
        assert TURNS[f"{name}_turns"].exact(t, 1.0) == pytest.approx(want, abs=1e-14)


def test_coefficients_are_those_of_the_script():
    assert sine_polynomial.coefficients() == list(sine.SINE)


def law_of(x: Port, scale: float = 1.0, offset: float = 0.0) -> Law:
    """Sines and cosines of multiples of a scaled input, as many as make the sine unit late."""
    q = ca.SX.sym("q")
    angle = scale * q + offset
    total = sum(ca.sin(k * angle) * ca.cos(angle / k) for k in (1, 2, 3))
    return Law("f", ca.Function("f", [q], [total], ["q"], ["r"]), [x, Port("output", "r")])


PORTS = {
    "float": Port("input", "q", limits=(-3.0, 3.0)),
    "positive": Port("input", "q", limits=(0.0, 6.0)),
    "encoder": Port("input", "q", type="int", scale=TURN / COUNTS, limits=(-6.0, 6.0)),
    "encoder with a zero": Port("input", "q", type="int", scale=TURN / COUNTS, offset=0.4,
                                limits=(-2.0, 2.0)),
    "encoder behind a gear": Port("input", "q", type="int", scale=TURN / 3e5, limits=(-9.0, 9.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", PORTS)
def test_program_with_polynomials_is_faster_and_keeps_its_bound(tmp_path, name):
    law = law_of(PORTS[name], offset=0.1 if name == "float" else 0.0)
    built, proof = proved(law, tmp_path, FAST, 2000)
    assert 0 < len(built.compiled.graph.functions) < 6
    plain = build(compile_law(law, Options("fast", True, True, "unit")), tmp_path / "unit.s")
    assert built.cycles < plain.cycles and not plain.compiled.graph.functions
    assert proof.worst_fraction_of_bound > 0.1


def test_pipes__every_angle_with_limits_is_a_polynomial(tmp_path):
    options = Options("fast", True, True, "pipes")
    built, _ = proved(law_of(PORTS["encoder"]), tmp_path, options, 500)
    assert "fsin" not in built.compiled.text and "fcos" not in built.compiled.text


def test_a_wrong_coefficient_is_beyond_the_bound(tmp_path, monkeypatch):
    monkeypatch.setattr(sine, "SINE", (sine.SINE[0] * (1 + 2e-6), *sine.SINE[1:]))
    built = build(compile_law(law_of(PORTS["encoder"]), FAST), tmp_path / "law.s")
    proof = prove(built.compiled, built.image, count=500, backend="iss")
    assert proof.bits_equal and proof.worst_fraction_of_bound > 1


@pytest.mark.parametrize(
    "port",
    [Port("input", "q"), Port("input", "q", limits=(-300.0, 300.0)), Port("state", "q")],
    ids=["no limits", "beyond 256 rad", "state"],
)
def test_an_angle_without_a_known_range_stays_on_the_unit(port):
    q = ca.SX.sym("q")
    results = {"r": ca.sin(q) + ca.cos(q)} | ({"q_next": q} if port.kind == "state" else {})
    function = ca.Function("f", [q], list(results.values()), ["q"], list(results))
    compiled = compile_law(Law("f", function, [port, Port("output", "r")]))
    assert not compiled.graph.functions and "fsin" in compiled.text


def test_ranges_follow_the_arithmetic_of_the_angle():
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    angle = ca.fmax(ca.fmin(3 * a - b, 4), -2) + 0.5 * a * b
    function = ca.Function("f", [a, b], [ca.sin(angle)], ["a", "b"], ["r"])
    ports = [Port("input", "a", limits=(-1, 2)), Port("input", "b", limits=(0, 1))]
    law = Law("f", function, [*ports, Port("output", "r")])
    (found,) = sine.angles(simplify(build_graph(law)), law).values()
    assert found.limit == pytest.approx(5 / TURN)  # 4 + 0.5 * 2 * 1


@pytest.mark.quick("ur5")
@pytest.mark.parametrize("name", ["ur5", "iiwa14", pytest.param("panda", marks=pytest.mark.full)])
def test_arm_takes_no_more_cycles_than_aimed_at(tmp_path, name):
    built, _ = proved(arm_law(name, Settings().overshoot), tmp_path, FAST)
    assert built.cycles <= MOST[name] and built.cycles <= 1.05 * built.bound_cycles


def test_report_shows_what_each_option_changes(tmp_path):
    built = build(compile_law(law_of(PORTS["encoder"]), FAST), tmp_path / "law.s")
    text = effects(built, seed=1)
    rows = {line[:24].strip(): line[24:].split() for line in text.splitlines()[1:5]}
    assert int(rows["--sine unit"][0]) > int(rows["this program"][0])
    assert rows["this program"][1:] == ["1.00", "to", "1.00"]
    assert rows["--sine unit"][1:] != ["1.00", "to", "1.00"]
    assert rows["without --reassociate"] and rows["without --reciprocal"]
    assert "on the pipes" in text
