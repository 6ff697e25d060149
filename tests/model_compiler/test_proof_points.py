# SPDX-License-Identifier: Apache-2.0
"""Points that every proof tries, pointwise bounds next to 0, and what `asip-model --prove` says."""

from __future__ import annotations

import json
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from asip_asm.model.bound import bounds
from asip_asm.model.certificate import certify
from asip_asm.model.compiler import compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.graph import Graph
from asip_asm.model.law import before
from asip_asm.model.program import build
from asip_asm.model.read import ModelError
from sim.laws.asip_model.__main__ import main
from sim.laws.certificate_errors import largest_errors, sine_in_double
from sim.laws.prove_points import directed, load_points
from sim.laws.prove_program import Check, prove, unit_sine
from tests.model_compiler.graph_laws import alone, in_200_bits
from tests.model_compiler.laws import mixed

RECORD = """title = "{name}"
[[input]]
names = [{inputs}]
vector = "x"
unit = "1"
meaning = "input"
limits = [{low}, {high}]
[[output]]
names = [{outputs}]
vector = "r"
unit = "N"
meaning = "result"
safe = 0.0
"""


def command(tmp_path, expression, size, limits, *more: str) -> tuple[int, dict]:
    """Exit status of `asip-model --prove` for a law of x, and its certificate's file."""
    x = ca.SX.sym("x", size)
    function = ca.Function("law", [x], [expression(x)], ["x"], ["r"])
    function.save(str(tmp_path / "law.casadi"))
    names = {
        "inputs": ", ".join(f'"x{i}"' for i in range(size)),
        "outputs": ", ".join(f'"r{i}"' for i in range(function.nnz_out())),
    }
    record = tmp_path / "law.interface.toml"
    record.write_text(RECORD.format(name="law", low=limits[0], high=limits[1], **names))
    stem = tmp_path / "out"
    words = [str(tmp_path / "law.casadi"), str(record), "--prove", "--inputs", "200"]
    status = main([*words, "--boxes-effort", "1", "-o", str(stem), *more])
    file = tmp_path / "out.certificate.json"
    return status, json.loads(file.read_text()) if file.exists() else {}


def test_a_law_that_stops_at_zero_is_not_proved(tmp_path, capsys):
    status, content = command(tmp_path, lambda x: x / ca.norm_2(x), 2, (-1.0, 1.0))
    text = capsys.readouterr().out
    assert status == 1
    assert "not proved: at x0 = 0, x1 = 0: division by zero" in text
    assert text.splitlines()[-1] == "NOT proved"
    assert not content["proved"] and not content["holds"]
    assert content["fault"]["point"] == {"x0": 0.0, "x1": 0.0}
    assert content["results"]["r0"]["bound"] is None


def test_a_bound_as_large_as_the_range_proves_nothing(tmp_path, capsys):
    status, content = command(tmp_path, lambda x: ca.fmod(x, 0.001), 1, (-1e6, 1e6))
    text = capsys.readouterr().out
    assert status == 1
    assert "not proved: the bound is at least half of the range of the result" in text
    assert content["holds"] and not content["proved"]
    assert not content["results"]["r0"]["means_something"]


def test_a_guarded_law_is_proved_with_bound_unit_and_share(tmp_path, capsys):
    points = tmp_path / "points.csv"
    points.write_text("x0\n0.5\n-1e-30\n")
    status, content = command(
        tmp_path,
        lambda x: ca.if_else(x == 0, 1, ca.sin(x) / x),
        1,
        (-3.0, 3.0),
        "--points",
        str(points),
    )
    text = capsys.readouterr().out
    assert status == 0 and text.splitlines()[-1] == "proved"
    assert "205 inputs" in text  # zero, low, high and two points are among them
    row = next(line for line in text.splitlines() if line.startswith("  r0")).split()
    found = content["results"]["r0"]
    assert row[3] == "N" == found["unit"]
    assert float(row[2]) == pytest.approx(found["bound"], rel=1e-5)
    assert (
        0 < float(row[4]) == pytest.approx(found["largest_error_seen"] / found["bound"], abs=1e-6)
    )


def test_points_are_zero_low_high_and_the_users():
    law = mixed()
    ticks = list(directed(law, [{"y": 0.5, "q": -7}]))
    assert [inputs["y"][0] for inputs, _ in ticks] == [0.0, -2.0, 2.0, 0.5]
    assert [states["s"][0] for _, states in ticks] == [0.0, -1.0, 1.0, 0.0]
    assert ticks[3][0]["q"][0] == -7
    assert all(states[before("q")] == inputs["q"] for inputs, states in ticks)


def test_a_proof_runs_its_points_on_the_core(tmp_path):
    law = alone(lambda x: 1 / (x - 0.25), 1, (-1.0, 1.0))
    built = build(compile_law(law), tmp_path / "law.s")
    proof = prove(built.compiled, built.image, count=20, backend="iss", points=directed(law, []))
    assert proof.inputs_tried == 23


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no points"),
        ("z\n1\n", "points.csv:1: no input or state 'z'"),
        ("y,y\n1,1\n", "points.csv:1: no input or state 'y', or named twice"),
        ("y\n1\n3\n", "points.csv:3: y = '3' is not a number of its range, -2 to 2"),
        ("y\nnan\n", "points.csv:2: y = 'nan' is not a number"),
        ("y\none\n", "points.csv:2: y = 'one' is not a number"),
        ("y,s\n1\n", "points.csv:2: 1 numbers for 2 names"),
        ("q\n0.5\n", "points.csv:2: q = 0.5 is no whole number"),
        ("gain\n1\n", "points.csv:1: no input or state 'gain'"),
        ("q_rate\n1\n", "points.csv:1: no input or state 'q_rate'"),
    ],
)
def test_points_with_a_mistake_are_refused(text, what, tmp_path):
    file = tmp_path / "points.csv"
    file.write_text(text)
    with pytest.raises(ModelError) as raised:
        load_points(file, mixed())
    assert what in str(raised.value)


def test_an_error_above_the_bound_or_a_bound_without_meaning_is_no_proof():
    assert Check("N", 1e-6, 1e-5, -1.0, 1.0).meaningful
    assert not Check("N", 2e-5, 1e-5, -1.0, 1.0).holds
    assert not Check("N", float("nan"), 1e-5, -1.0, 1.0).holds
    assert not Check("N", 0.0, 1.0, -1.0, 1.0).meaningful
    assert Check("N", 0.0, 1e-7, 1.0, 1.0).meaningful
    assert Check("N", 0.5, 1.0, -9.0, 9.0).share == 0.5


# ---------------------------------------------------------------------- bounds at single inputs
@pytest.mark.parametrize(
    ("expression", "points"),
    [
        (lambda x: ca.if_else(x == 0, 1, ca.sin(x) / x), [0.0, 1e-20, 0.5, -3.0]),
        (lambda x: ca.if_else(x > 0, ca.sqrt(x), 0), [0.0, -1.0, 2.0, 1e-40]),
    ],
)
def test_a_branch_not_taken_leaves_a_finite_bound(expression, points):
    graph = compile_law(alone(expression, 1, (-4.0, 4.0))).graph
    _, found = bounds(graph, {"x0": np.float32(points)})
    assert np.all(found["r0"] < 1e-6)


def test_the_root_of_what_cancels_keeps_its_bound():
    law = alone(
        lambda x: ca.sqrt(ca.fmax((x[0] + x[1]) ** 2 - x[0] * (x[0] + 2 * x[1]) - x[1] ** 2, 0)),
        2,
        (-1.0, 1.0),
    )
    graph = compile_law(law).graph
    rng = np.random.default_rng(3)
    points = {f"x{i}": rng.uniform(-1, 1, 400).astype(np.float32) for i in range(2)}
    _, limit = bounds(graph, points)
    got = evaluate(graph, points, sine_in_double)[graph.outputs["r0"]].astype(float)
    assert (got > 0).sum() > 50
    for k in range(400):
        exact = in_200_bits(law, {name: float(x[k]) for name, x in points.items()})["r0"]
        assert abs(float(exact) - got[k]) <= limit["r0"][k]


# ---------------------------------------------------------------------- what the rules rely on
def test_the_sine_of_a_small_angle_is_the_angle():
    rng = np.random.default_rng(9)
    top = int(np.float32(2.0**-12).view(np.uint32))
    words = np.concatenate(
        (rng.integers(0, top + 1, 4000), np.arange(500), top - np.arange(500))
    ).astype(np.uint32)
    angles = np.concatenate((words.view(np.float32), -words.view(np.float32)))
    assert np.array_equal(unit_sine(angles, False).view(np.uint32), angles.view(np.uint32))


def test_random_inputs_of_the_box_are_within_the_bounds():
    law = mixed()
    compiled = compile_law(law)
    certificate = certify(compiled.graph, law, 300_000)
    errors = largest_errors(compiled, certificate, 4000, 1)
    for name, bound in certificate.bounds.items():
        assert 0 < errors[name] <= bound.bound


def test_interpreter__the_graph_has_changed__computes_the_new_one():
    """The order of a graph is noted: each change must be seen."""
    graph = Graph()
    x, two = graph.add("input", value="x"), graph.const(2.0)
    graph.outputs["y"], other = graph.add("fmul", x, two), graph.add("fneg", x)
    given = {"x": np.array([3.0, -1.5], np.float32)}

    def found() -> list[float]:
        return evaluate(graph, given, no_sine)[graph.outputs["y"]].tolist()

    def no_sine(angles, cosine):
        raise AssertionError("no sine in this graph")

    assert found() == found() == [6.0, -3.0]
    graph.nodes[graph.outputs["y"]] = replace(graph.nodes[graph.outputs["y"]], op="fadd")
    assert found() == [5.0, 0.5]
    graph.nodes[two] = replace(graph.nodes[two], value=4.0)
    assert found() == [7.0, 2.5]
    graph.outputs["y"] = graph.add("fsub", graph.outputs["y"], x)
    assert found() == [4.0, 4.0]
    graph.outputs["y"] = other
    assert found() == [-3.0, 1.5]
