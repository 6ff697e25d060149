# SPDX-License-Identifier: Apache-2.0
"""Signals of a law by name and dense shape, and faults of that mapping that a proof must find."""

from __future__ import annotations

import inspect
import textwrap
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from asip_asm import interface as interface_module
from asip_asm.model import law as law_module
from asip_asm.model import read as read_module
from asip_asm.model.compiler import compile_law
from asip_asm.model.law import Law, Port, load_law
from asip_asm.model.program import build
from asip_asm.model.read import ModelError
from sim.laws.prove_casadi import CasadiReference, truth_of, truth_of_files
from sim.laws.prove_program import Proof, prove
from tests.model_compiler.proof import proved

RECORD = """
title = "all shapes"
[constants]
T_s = 1e-3
[[parameter]]
names = ["gain"]
unit = "1"
value = 0.75
meaning = "of the loop"
[[input]]
names = ["m00", "m10", "m01", "m11"]
vector = "m"
unit = "1"
limits = [-2, 2]
meaning = "matrix, column by column"
[[input]]
names = ["r0", "r1", "r2"]
vector = "r"
unit = "1"
limits = [-1, 1]
meaning = "row"
[[input]]
names = ["q0"]
vector = "q"
type = "int"
scale = "pi/512"
offset = 0.25
unit = "rad"
limits = [-3, 3]
meaning = "encoder"
[[input]]
names = ["q1"]
vector = "q"
type = "int"
scale = "pi/2048"
unit = "rad"
limits = [-3, 3]
meaning = "encoder"
[[state]]
names = ["last0", "last1"]
type = "int"
unit = "count"
starts_from = ["q0", "q1"]
meaning = "counts of the last tick"
[[state]]
names = ["v0", "v1", "v2"]
vector = "v"
unit = "1"
initial = 0.5
limits = [-4, 4]
meaning = "states"
[[output]]
names = ["u0", "u1"]
vector = "u"
unit = "1"
safe = 0.125
limits = [-3, 3]
meaning = "outputs"
[[output]]
names = ["w00", "w10", "w01", "w11"]
vector = "w"
unit = "1"
safe = 0
meaning = "of a lower triangle"
"""


def all_shapes() -> ca.Function:
    """Matrices, a row, sparse arguments and results, rates, in MX."""
    m = ca.MX.sym("m", ca.Sparsity.lower(2))
    r, v = ca.MX.sym("r", 1, 3), ca.MX.sym("v", 3)
    q, rate, gain = ca.MX.sym("q", 2), ca.MX.sym("q_rate", 2), ca.MX.sym("gain")
    none = ca.MX.sym("none", 0, 0)
    mix = ca.sparsify(ca.DM([[0.5, 0, 0.25], [0, 0, 0], [0, 0.125, 0]]))
    lower = ca.MX.sym("lower", ca.Sparsity.lower(2))
    w = ca.Function("w", [lower], [2 * lower])(m)
    u = ca.vertcat(gain * q[0] + 0.01 * rate[1], q[1] - 0.02 * rate[0] + m[1, 0])
    following = ca.mtimes(mix, v) + ca.MX(ca.Sparsity(3, 1)) + ca.vertcat(r[0, 2], 0, m[0, 0])
    sparse = ca.project(following, ca.Sparsity.triplet(3, 1, [0, 2], [0, 0]))
    return ca.Function(
        "shapes",
        [v, m, none, r, q, rate, gain],
        [w, u, sparse, none],
        ["v", "m", "none", "r", "q", "q_rate", "gain"],
        ["w", "u", "v_next", "nothing"],
    )


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    function, record = tmp_path / "law.casadi", tmp_path / "law.interface.toml"
    all_shapes().save(str(function))
    record.write_text(RECORD)
    return function, record


def proof_of(function: Path, record: Path, count: int = 60) -> Proof:
    built = build(compile_law(load_law(function, record)), record.with_suffix(".s"))
    truth = truth_of_files(function, record)
    return prove(built.compiled, built.image, count=count, backend="iss", truth=truth)


def test_every_shape_is_proved_against_the_file(files):
    proof = proof_of(*files)
    assert proof.passed, (proof.first_difference, proof.worst_result)
    names = {"w00", "w10", "w01", "w11", "u0", "u1", "v0_next", "v1_next", "v2_next"}
    assert set(proof.largest_error) == names
    assert proof.largest_error["w01"] == proof.largest_error["v1_next"] == 0


def test_a_call_with_many_points_is_a_call_with_each():
    reference = CasadiReference(all_shapes())
    rng = np.random.default_rng(5)
    points = {n: rng.uniform(-1, 1, (7, *shape)) for n, shape in reference.arguments.items()}
    together = reference(points)
    for k in range(7):
        alone = reference.function(*(ca.DM(values[k]) for values in points.values()))
        for (name, values), want in zip(together.items(), alone, strict=True):
            np.testing.assert_array_equal(values[k], want.full(), name)


FAULTS = [
    (read_module._entries, "tuple(pattern(i).find())", "tuple(range(pattern(i).nnz()))"),
    (
        read_module._entries,
        "tuple(pattern(i).find())",
        "tuple(p % pattern(i).size1() * pattern(i).size2() + p // pattern(i).size1()"
        " for p in pattern(i).find())",
    ),
    (
        read_module.read_function,
        "work[outputs[0]] = arguments[argument][place]",
        "work[outputs[0]] = arguments[argument][-1 - place]",
    ),
    (
        read_module.read_function,
        "places[nonzero]] = work[inputs[0]]",
        "places[-1 - nonzero]] = work[inputs[0]]",
    ),
    (law_module._match, ".append(port)", ".insert(0, port)"),
    (law_module._port, "scale=number(signal.scale, 1.0)", "scale=2 * number(signal.scale, 1.0)"),
    (law_module._port, "offset=number(signal.offset)", "offset=-number(signal.offset)"),
    (law_module._port, "initial=number(signal.initial)", "initial=2 * number(signal.initial)"),
    (law_module._port, "safe=number(signal.safe)", "safe=0.0"),
    (law_module._port, "number(signal.limits[1]))", "2 * number(signal.limits[1]))"),
    (law_module._rate, "scale = count.scale / period", "scale = count.scale / 2 / period"),
    (law_module.load_law, 'names.get("T_s", 1e-4)', "1e-4"),
    (law_module._source, "graph.const(port.offset)", "graph.const(0.0)"),
    (law_module._source, '"isub", count, last', '"isub", last, count'),
    (
        law_module.build_graph,
        "graph.next_states[port.name] = node",
        "graph.next_states[port.name] = values[port.name]",
    ),
    (
        law_module.build_graph,
        "if port.limits is not None and port.kind",
        "if port.safe > 1 and port.kind",
    ),
    (
        interface_module._Loader._entry,
        "enumerate(names)",
        "enumerate(reversed(names))",
    ),
]


@pytest.mark.quick("0-*", "2-*")
@pytest.mark.parametrize("k", range(len(FAULTS)), ids=lambda k: f"{k}-{FAULTS[k][0].__name__}")
def test_a_fault_of_the_mapping_is_found(k, files, monkeypatch):
    """The reader of signals with a fault in it compiles another law, which is not proved."""
    function, right, wrong = FAULTS[k]
    text = textwrap.dedent(inspect.getsource(function))
    assert text.count(right) == 1
    names = dict(function.__globals__)
    exec(
        compile(
            "from __future__ import annotations\n" + text.replace(right, wrong), "fault", "exec"
        ),
        names,
    )
    assert proof_of(*files, count=20).passed
    with monkeypatch.context() as planted:
        planted.setattr(function, "__code__", names[function.__name__].__code__)
        assert not proof_of(*files, count=60).passed


def law(arguments, results, ports) -> Law:
    a, r = list(arguments), list(results)
    function = ca.Function("f", [arguments[n] for n in a], [results[n] for n in r], a, r)
    return Law("f", function, ports)


def vector(kind: str, name: str, count: int) -> list[Port]:
    return [Port(kind, f"{name}{i}", vector=name) for i in range(count)]


X = ca.SX.sym("x", 3)
S = ca.SX.sym("s")
REFUSED = {
    "more signals than elements": (
        law({"x": X[:2]}, {"y": X[0]}, [*vector("input", "x", 3), Port("output", "y")]),
        "argument 'x' of the function is 2 by 1, the interface gives it 3 signals",
    ),
    "nonzeros are not elements": (
        law({"x": X}, {"y": ca.SX(3, 1)}, [*vector("input", "x", 3), *vector("output", "y", 2)]),
        "result 'y' of the function is 3 by 1, the interface gives it 2 signals",
    ),
    "no next value": (
        law({"s": S}, {"y": S}, [Port("state", "s"), Port("output", "y")]),
        "gives the next value of s; name a result 's_next'",
    ),
    "part of the next values": (
        law({"x": X}, {"x_next": X[:2]}, vector("state", "x", 3)),
        "result 'x_next' of the function is 2 by 1, the interface gives it 3 signals",
    ),
    "driven twice": (
        law(
            {"x": X}, {"y": X[:2], "y0": X[2]},
            [*vector("input", "x", 3), *vector("output", "y", 2)],
        ),
        "the results 'y' and 'y0' both give 'y0'",
    ),
    "a signal and a vector": (
        law(
            {"x": X[:2]}, {"y": X[0]},
            [Port("input", "x"), *vector("input", "x", 2), Port("output", "y")],
        ),
        "argument 'x' of the function is both a signal and the vector of x0, x1",
    ),
    "without a vector": (
        law(
            {"x": X}, {"y": X[0]},
            [*(Port("input", f"x{i}") for i in range(3)), Port("output", "y")],
        ),
        r"argument 'x' \(3 by 1\) of the function has no signal",
    ),
    "too many states": (
        law(
            {"z": (z := ca.SX.sym("z", 121))}, {"z_next": z, "y": z[0]},
            [*vector("state", "z", 121), Port("output", "y")],
        ),
        "121 states .* the core has 120 registers",
    ),
    "name of a last count": (
        law(
            {"q_rate": S, "q_before": X[0]}, {"y": S},
            [Port("input", "q", type="int"), Port("rate", "q_rate", rate_of="q"),
             Port("input", "q_before"), Port("output", "y")],
        ),
        "'q_before' is the name of the last count of 'q'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_law_that_says_two_things_is_refused(case):
    wrong, message = REFUSED[case]
    with pytest.raises(ModelError, match=message):
        compile_law(wrong)


def test_a_law_in_python_with_zeros_in_its_result(tmp_path):
    mix = ca.sparsify(ca.DM([[0.5, 0, 0.25], [0, 0, 0], [0, 0.125, 0]]))
    ports = [*vector("state", "x", 3), Port("input", "s"), Port("output", "y")]
    found = law({"x": X, "s": S}, {"x_next": mix @ X, "y": S + X[0]}, ports)
    proved(found, tmp_path)
    ones = {name: np.array([value], np.float32) for name, value in
            {"x0": 1, "x1": 2, "x2": 4, "s": 0}.items()}  # fmt: skip
    result = truth_of(found)(ones)
    assert [result[f"x{i}_next"][0] for i in range(3)] == [1.5, 0, 0.25]
