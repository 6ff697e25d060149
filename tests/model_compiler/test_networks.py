# SPDX-License-Identifier: Apache-2.0
"""Networks of dense layers as programs of loops and streams, against ONNX Runtime in doubles."""

from __future__ import annotations

import sys

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import helper

from asip_asm.machine import load_machine
from asip_asm.model.bound import bounds
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.law import load_law
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import Words
from asip_asm.model.program import build
from asip_asm.model.read import ModelError
from asip_asm.project import ROOT
from sim.core.api import Core
from sim.laws.asip_model import __main__ as command
from sim.laws.prove_onnx import evaluator_of, in_double
from tests.bench.commands import output
from tests.model_compiler.onnx_models import interface, model, perceptron

SEED = 38
STREAM, WIDE = (Options(configuration=name) for name in ("stream", "wide"))


def written(folder, made: onnx.ModelProto, inputs: int, outputs: int, limit: float = 2.0):
    onnx.save(made, folder / "policy.onnx")
    (folder / "policy.interface.toml").write_text(interface(inputs, outputs, limit))
    return folder / "policy.onnx", folder / "policy.interface.toml"


def compared(
    folder, made: onnx.ModelProto, inputs: int, outputs: int, backend: str = "iss", options=STREAM
):
    """Compile, run, and compare bits with the interpreter and values with ONNX Runtime; cycles of
    the runs and those announced.
    """
    law = load_law(*written(folder, made, inputs, outputs), whole=False)
    built = build(compile_law(law, options), folder / "policy.s")
    x = np.random.default_rng(SEED).uniform(-2, 2, (25, inputs)).astype(np.float32)
    names = [port.name for port in law.of_kind("input")]
    values = {name: x[:, k] for k, name in enumerate(names)}
    with Core(built.image, backend=backend) as core:
        ticks = core.batch(values)
    graph = built.compiled.graph
    nodes = evaluate(graph, values, lambda angle, _: angle)
    _, limit = bounds(graph, values)
    want = in_doubles(made, x)
    for k, port in enumerate(law.of_kind("output")):
        got = ticks[port.name]
        assert (got.view(np.uint32) == nodes[graph.outputs[port.name]].view(np.uint32)).all()
        error = np.abs(got - np.clip(want[:, k], *port.limits))
        assert (error <= limit[port.name]).all() and limit[port.name].max() < 1e-3
    return ticks.cycles, built


def in_doubles(made: onnx.ModelProto, x: np.ndarray) -> np.ndarray:
    """Results (n, outputs) of ONNX Runtime in double precision; of activations that it has in
    binary32 alone by the evaluator of the package onnx, which must agree with it in binary32.
    """
    rows = [row[None] for row in x]
    try:
        session = onnxruntime.InferenceSession(in_double(made).SerializeToString())
        return np.stack([session.run(None, {"obs": row.astype(float)})[0][0] for row in rows])
    except onnxruntime.capi.onnxruntime_pybind11_state.NotImplemented:
        session = onnxruntime.InferenceSession(made.SerializeToString())
        single = np.stack([session.run(None, {"obs": row})[0][0] for row in rows])
        evaluator = evaluator_of(made)
        double = np.stack([evaluator.run(None, {"obs": row.astype(float)})[0][0] for row in rows])
        assert np.allclose(single, double, atol=1e-4)
        return double


@pytest.mark.parametrize("activation", ["Relu", "Elu", "Tanh", "Sigmoid", "Softsign", "Gelu"])
def test_network_has_the_interpreters_bits_and_onnx_runtimes_values(activation, tmp_path):
    compared(tmp_path, perceptron((5, 7, 3), activation, SEED), 5, 3)


@pytest.mark.parametrize("sizes", [(1, 1), (3, 40, 2), (12, 33, 35, 1), (2, 1, 70)])
def test_sizes_that_do_not_fill_blocks_and_rounds(sizes, tmp_path):
    if sizes[-1] > 32:
        with pytest.raises(ModelError, match="70 outputs, the core has 32"):
            compared(tmp_path, perceptron(sizes, "Relu", SEED), sizes[0], sizes[-1])
        return
    compared(tmp_path, perceptron(sizes, "Relu", SEED), sizes[0], sizes[-1])


@pytest.mark.quick("wide")
@pytest.mark.parametrize("options", [STREAM, WIDE], ids=lambda o: o.configuration)
def test_rtl_takes_the_cycles_that_were_announced(options, tmp_path):
    made = perceptron((6, 34, 4), "Elu", SEED)
    cycles, built = compared(tmp_path, made, 6, 4, "rtl", options)
    assert set(cycles.tolist()) == {built.image.cycles}


@pytest.mark.quick("Tanh")
@pytest.mark.parametrize("activation", ["Relu", "Elu", "Tanh", "Softsign"])
def test_network_in_lanes_has_the_interpreters_bits_and_onnx_runtimes_values(activation, tmp_path):
    made = perceptron((5, 26, 3), activation, SEED)
    _, built = compared(tmp_path, made, 5, 3, options=WIDE)
    in_lanes = any(name in built.compiled.text for name in ("vabove", "vbelow"))
    assert in_lanes == (activation in ("Relu", "Elu"))


@pytest.mark.parametrize("alpha", [0.5, 1.7])
def test_linear_part_and_scaled_exponential_in_lanes(alpha, tmp_path):
    random = np.random.default_rng(SEED)
    constants = {"v": random.normal(size=(20, 3)).astype(np.float32),
                 "w": random.normal(size=(2, 20)).astype(np.float32)}  # fmt: skip
    nodes = [
        helper.make_node("Gemm", ["obs", "v"], ["a"], transB=1),
        helper.make_node("Elu", ["a"], ["b"], alpha=alpha),
        helper.make_node("Gemm", ["b", "w"], ["act"], transB=1),
    ]
    _, built = compared(
        tmp_path, model(nodes, {"obs": [1, 3]}, {"act": [1, 2]}, constants), 3, 2, options=WIDE
    )
    assert "vabove" in built.compiled.text


@pytest.mark.quick("sizes0", "sizes3")
@pytest.mark.parametrize("sizes", [(1, 1), (3, 17), (2, 40, 2), (12, 33, 35, 1), (4, 130, 70, 3)])
def test_sizes_that_do_not_fill_vectors_blocks_and_rounds(sizes, tmp_path):
    made = perceptron(sizes, "Relu", SEED)
    compared(tmp_path, made, sizes[0], sizes[-1], options=WIDE)


def test_scaled_observations_and_products_in_a_row_join_the_weights(tmp_path):
    random = np.random.default_rng(SEED)
    mean, deviation = random.normal(size=4), random.uniform(0.5, 2, 4)
    constants = {
        "mean": mean.astype(np.float32), "deviation": deviation.astype(np.float32),
        "w": random.normal(size=(4, 6)).astype(np.float32), "half": np.float32([0.5]),
        "v": random.normal(size=(3, 6)).astype(np.float32),
        "u": random.normal(size=(2, 3)).astype(np.float32),
    }  # fmt: skip
    nodes = [
        helper.make_node("Sub", ["obs", "mean"], ["a"]),
        helper.make_node("Div", ["a", "deviation"], ["b"]),
        helper.make_node("MatMul", ["b", "w"], ["c"]),
        helper.make_node("Mul", ["c", "half"], ["d"]),
        helper.make_node("Elu", ["d"], ["e"]),
        helper.make_node("Gemm", ["e", "v"], ["f"], transB=1, alpha=0.5),
        helper.make_node("Gemm", ["f", "u"], ["act"], transB=1),
    ]
    made = model(nodes, {"obs": [1, 4]}, {"act": [1, 2]}, constants)
    compared(tmp_path, made, 4, 2)


def test_what_is_no_dense_layer_is_named_and_compiled_without_streams(tmp_path, capsys):
    made = model([helper.make_node("Softmax", ["obs"], ["act"])], {"obs": [1, 3]}, {"act": [1, 3]})
    files = [str(file) for file in written(tmp_path, made, 3, 3)]
    assert command.main([*files, "--config", "stream", "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().err
    assert "compiled without streams: " in said and "node 0 '' (Softmax)" in said
    assert "is no part of a dense layer" in said


def test_options_of_scalar_programs_are_refused(tmp_path):
    law = load_law(*written(tmp_path, perceptron((3, 4, 2), "Relu", SEED), 3, 2), whole=False)
    with pytest.raises(ModelError, match="leave out --reassociate"):
        compile_law(law, Options(configuration="stream", reassociate=True))


def test_more_weights_than_a_stream_holds_are_refused_by_name(tmp_path):
    made = perceptron((48, 256, 128, 12), "Elu", SEED)
    law = load_law(*written(tmp_path, made, 48, 12), whole=False)
    with pytest.raises(ModelError, match=r"constants in the stream of pipe A, .* has 8192; take"):
        compile_law(law, STREAM)


def test_product_leaves_out_zeros_and_keeps_rows_that_have_none():
    plan = Plan("p", ["x0", "x1"], {"y0": 0.0, "y1": 0.0}, load_machine("stream"))
    values = np.array([[[1.0, 0.0], [0.0, 0.0]], [[2.0, 1e-30], [0.0, 0.0]]])
    results = plan.product(Words(values[0]), ["x0", "x1"])
    assert sum(op.words is not None for op in plan.items) == 1
    for name, to in zip(results, plan.outputs, strict=True):
        plan.op("mov", name, to=to)
    plan.finish()
    assert plan.streams["A"] + plan.streams["B"] == [1.0]
    nodes = evaluate(plan.graph, {"x0": np.float32([3]), "x1": np.float32([5])}, lambda a, _: a)
    assert [nodes[i][0] for i in plan.graph.outputs.values()] == [3.0, 0.0]


def test_exponential_linear_unit_is_within_its_stated_error(tmp_path):
    compared(tmp_path, perceptron((2, 3), "Elu", SEED, last="Elu"), 2, 3)
    from asip_asm.model.expand import expand_functions
    from asip_asm.model.functions import BELOW
    from asip_asm.model.graph import Graph
    from asip_asm.model.sums import SumBuilder

    real = Graph()
    x = real.add("input", value="x")
    real.outputs["y"] = real.add("expm1", real.add("min", x, real.const(0.0)))
    graph = SumBuilder(expand_functions(real), load_machine("stream"), False).run()
    some = -np.concatenate((np.geomspace(1e-40, 100, 200_001), np.linspace(-9, 9, 100_001)))
    values = some.astype(np.float32)
    got = evaluate(graph, {"x": values}, lambda a, _: a)[graph.outputs["y"]].astype(float)
    want = BELOW["expm1_below"].exact(values.astype(float))
    allowed = BELOW["expm1_below"].ulp * 2.0**-23 * np.abs(want) + BELOW["expm1_below"].absolute
    assert (np.abs(got - want) <= allowed).all()
    assert graph.functions[graph.outputs["y"]][0] == "expm1_below"


@pytest.mark.full
def test_table_of_matrix_laws__made_again__equal():
    output(sys.executable, "scripts/matrix_table.py", "--check", cwd=ROOT)
