# SPDX-License-Identifier: Apache-2.0
"""Policies of ONNX files against the standard's own evaluator in double precision."""

from __future__ import annotations

import numpy as np
import onnx
import pytest
from onnx import helper

from asip_asm.model.onnx_file import function_of, load_onnx
from asip_asm.model.onnx_nodes import OPERATORS
from asip_asm.model.read import ModelError
from sim.laws.asip_model import __main__ as command
from sim.laws.prove_onnx import OnnxReference, evaluator_of
from tests.model_compiler.onnx_models import interface, model, perceptron

SEED = 20261126
RANDOM = np.random.default_rng(SEED)


def some(*shape: int) -> np.ndarray:
    return RANDOM.normal(0, 0.5, shape).astype(np.float32)


def ints(*values: int) -> np.ndarray:
    return np.array(values, np.int64)


# Operator: (name of the case, shape of x, further inputs, attributes).
CASES: dict[str, tuple[str, tuple[int, ...], list, dict]] = {
    **{
        f"{name}": (name, (1, 7), [], {})
        for name in (
            "Abs Cos Elu Erf Exp Flatten Gelu HardSigmoid Identity LeakyRelu Neg Relu "
            "Selu Sigmoid Sin Softmax Softplus Softsign Tanh Transpose Dropout"
        ).split()
    },
    "elu alpha": ("Elu", (1, 7), [], {"alpha": 0.7}),
    "selu of its own": ("Selu", (1, 7), [], {"alpha": 1.5, "gamma": 0.9}),
    "leaky alpha": ("LeakyRelu", (1, 7), [], {"alpha": 0.2}),
    "hard": ("HardSigmoid", (1, 7), [], {"alpha": 1.1, "beta": 0.4}),
    "gelu tanh": ("Gelu", (1, 7), [], {"approximate": "tanh"}),
    "softmax rows": ("Softmax", (3, 4), [], {"axis": 0}),
    "log": ("Log", (1, 7), ["positive"], {}),
    "sqrt": ("Sqrt", (1, 7), ["positive"], {}),
    "reciprocal": ("Reciprocal", (1, 7), ["positive"], {}),
    "add": ("Add", (3, 4), [some(4)], {}),
    "sub": ("Sub", (3, 4), [some(3, 1)], {}),
    "mul": ("Mul", (3, 4), [some(1, 4)], {}),
    "div": ("Div", (3, 4), [some(4) + 3], {}),
    "pow": ("Pow", (1, 7), [np.float32([2.0])], {}),
    "max": ("Max", (3, 4), [some(4), some(3, 4)], {}),
    "min": ("Min", (3, 4), [some(4)], {}),
    "sum": ("Sum", (3, 4), [some(4), some(1)], {}),
    "clip": ("Clip", (1, 7), [np.float32(-0.3), np.float32(0.2)], {}),
    "clip above": ("Clip", (1, 7), [None, np.float32(0.2)], {}),
    "matmul": ("MatMul", (3, 4), [some(4, 2)], {}),
    "matmul vector": ("MatMul", (4,), [some(4)], {}),
    "gemm": ("Gemm", (1, 4), [some(4, 2), some(2)], {}),
    "gemm all": (
        "Gemm", (4, 3), [some(2, 4), some(1, 2)],
        {"alpha": 0.5, "beta": 2.0, "transA": 1, "transB": 1},
    ),
    "gemm alone": ("Gemm", (1, 4), [some(4, 2)], {}),
    "conv": ("Conv", (1, 2, 9), [some(3, 2, 3), some(3)], {}),
    "conv all": (
        "Conv", (1, 4, 9), [some(6, 2, 3)],
        {"strides": [2], "pads": [1, 2], "dilations": [2], "group": 2, "kernel_shape": [3]},
    ),
    "mean": ("ReduceMean", (3, 4), [ints(1)], {"keepdims": 0}),
    "mean of all": ("ReduceMean", (3, 4), [], {}),
    "total": ("ReduceSum", (3, 4), [ints(0)], {}),
    "norm": ("LayerNormalization", (2, 6), [some(6), some(6)], {"epsilon": 1e-3}),
    "norm without bias": ("LayerNormalization", (2, 6), [some(6)], {"axis": 1}),
    "reshape": ("Reshape", (3, 4), [ints(-1, 0)], {}),
    "flatten 0": ("Flatten", (3, 4), [], {"axis": 0}),
    "squeeze": ("Squeeze", (1, 3, 1), [ints(0)], {}),
    "squeeze all": ("Squeeze", (1, 3, 1), [], {}),
    "unsqueeze": ("Unsqueeze", (3, 4), [ints(0, 3)], {}),
    "transpose": ("Transpose", (1, 3, 4), [], {"perm": [2, 0, 1]}),
    "concat": ("Concat", (3, 4), [some(3, 2)], {"axis": 1}),
    "slice": ("Slice", (3, 8), [ints(1, 6), ints(3, 0), ints(0, 1), ints(1, -2)], {}),
    "slice to the start": ("Slice", (1, 8), [ints(6), ints(-100), ints(1), ints(-1)], {}),
    "gather": ("Gather", (3, 4), [ints(3, -1, 0)], {"axis": 1}),
    "gather one": ("Gather", (3, 4), [np.array(1, np.int64)], {}),
    "cast": ("Cast", (1, 7), [], {"to": onnx.TensorProto.FLOAT}),
    "gru": ("GRU", (2, 1, 3), [some(1, 12, 3), some(1, 12, 4), some(1, 24)], {"hidden_size": 4}),
    "gru reset after": (
        "GRU", (2, 1, 3), [some(1, 12, 3), some(1, 12, 4), some(1, 24), None, some(1, 1, 4)],
        {"hidden_size": 4, "linear_before_reset": 1},
    ),
    "lstm": (
        "LSTM", (2, 1, 3),
        [some(1, 16, 3), some(1, 16, 4), some(1, 32), None, some(1, 1, 4), some(1, 1, 4)],
        {"hidden_size": 4},
    ),
    "lstm without bias": (
        "LSTM", (1, 1, 3), [some(1, 16, 3), some(1, 16, 4)], {"hidden_size": 4}
    ),
}  # fmt: skip
ELSEWHERE = {"Constant", "Shape", "Split"}  # have tests of their own below


def test_cases__are_of_every_operator():
    assert {case[0] for case in CASES.values()} | ELSEWHERE == set(OPERATORS)


def differs(made: onnx.ModelProto, shape: tuple[int, ...], positive: bool = False) -> float:
    """Largest difference of the reading and of onnx's evaluator at random inputs."""
    function = function_of(made)
    evaluator = evaluator_of(made)
    worst = 0.0
    for _ in range(5):
        x = RANDOM.normal(0, 1, shape)
        x = np.abs(x) + 0.1 if positive else x
        ours = function(x.reshape(function.size_in(0)))
        ours = ours if isinstance(ours, tuple) else (ours,)
        for one, other in zip(ours, evaluator.run(None, {"x": x}), strict=True):
            other = np.reshape(other, one.shape)
            worst = max(worst, float(np.max(np.abs(one.full() - other))))
    return worst


@pytest.mark.parametrize("name", CASES)
def test_operator__is_that_of_the_standard(name):
    kind, shape, more, attributes = CASES[name]
    positive = bool(more) and isinstance(more[0], str)
    more = [] if positive else more
    constants = {f"c{k}": array for k, array in enumerate(more) if array is not None}
    inputs = [f"c{k}" if array is not None else "" for k, array in enumerate(more)]
    node = helper.make_node(kind, ["x", *inputs], ["y"], **attributes)
    made = model([node], {"x": shape}, {"y": []}, constants)
    assert differs(made, shape, positive) < 1e-12, f"replay: SEED={SEED}"


@pytest.mark.parametrize("opset", [13, 17, 20])
def test_split_shape_and_constants__as_exporters_write_them(opset):
    """Split by sizes; a reshape to a computed shape; a mean over axes given either way."""
    attribute = {"axes": [1]} if opset < 18 else {}
    axes = [] if opset < 18 else ["axis"]
    nodes = [
        helper.make_node("Constant", [], ["k"], value_float=0.25),
        helper.make_node("Constant", [], ["axis"], value_ints=[1]),
        helper.make_node("Mul", ["x", "k"], ["scaled"]),
        helper.make_node("Split", ["scaled", "sizes"], ["low", "high"], axis=1),
        helper.make_node("Shape", ["high"], ["shape"]),
        helper.make_node("Reshape", ["high", "shape"], ["same"]),
        helper.make_node("ReduceMean", ["same", *axes], ["mean"], keepdims=1, **attribute),
        helper.make_node("Concat", ["low", "mean"], ["y"], axis=1),
    ]
    made = model(nodes, {"x": [2, 6]}, {"y": [2, 5]}, {"sizes": ints(4, 2)}, opset)
    assert differs(made, (2, 6)) < 1e-12


def test_split_in_equal_parts():
    node = helper.make_node("Split", ["x"], ["y", "z"], axis=1, num_outputs=2)
    made = model([node], {"x": [1, 6]}, {"y": [1, 3], "z": [1, 3]})
    assert differs(made, (1, 6)) < 1e-12


def test_matrix_goes_column_by_column():
    """The reference takes element (row, column) of the tensor where the reading has it."""
    node = helper.make_node("MatMul", ["x", "w"], ["y"])
    made = model([node], {"x": [2, 3]}, {"y": [2, 2]}, {"w": some(3, 2)})
    x = np.arange(6.0).reshape(2, 3)
    want = evaluator_of(made).run(None, {"x": x})[0]
    assert np.allclose(function_of(made)(x).full(), want, atol=1e-12)


# ---- refused


def save(tmp_path, made: onnx.ModelProto):
    path = tmp_path / "policy.onnx"
    path.write_bytes(made.SerializeToString())
    return path


def relu(**changes) -> onnx.ModelProto:
    return model([helper.make_node("Relu", ["x"], ["y"])], {"x": [1, 3]}, {"y": [1, 3]}, **changes)


def outside(made: onnx.ModelProto) -> None:
    tensor = made.graph.initializer.add(name="w", data_type=1, dims=[2])
    tensor.data_location = onnx.TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="/etc/passwd")


def renamed(made: onnx.ModelProto) -> None:
    made.graph.input[0].name = made.graph.node[0].input[0] = "obs.1"


def infinite(made: onnx.ModelProto) -> None:
    made.graph.initializer.append(onnx.numpy_helper.from_array(np.float32([np.inf]), "w"))


def node_of(*more, **attributes):
    def change(made: onnx.ModelProto) -> None:
        made.graph.node[0].CopyFrom(helper.make_node(*more, **attributes))

    return change


REFUSED = {
    "file elsewhere": (outside, "lies in another file"),
    "name": (renamed, "'obs.1' cannot name signals"),
    "infinity": (infinite, "infinite or no number"),
    "operator": (node_of("QuantizeLinear", ["x", "x"], ["y"]), "QuantizeLinear.*not compiled"),
    "near": (node_of("Sigmoyd", ["x"], ["y"]), "Sigmoid"),
    "domain": (node_of("Relu", ["x"], ["y"], domain="com.microsoft"), "not compiled"),
    "attribute": (node_of("Relu", ["x"], ["y"], consumed_inputs=[1]), "'consumed_inputs'"),
    "value": (node_of("Gelu", ["x"], ["y"], approximate="sine"), "approximate"),
    "integers": (node_of("Cast", ["x"], ["y"], to=onnx.TensorProto.INT64), "int64"),
    "missing": (node_of("Add", ["x", "w"], ["y"]), "reads 'w'"),
    "left out": (node_of("Add", ["x", ""], ["y"]), "left out"),
    "inputs": (node_of("Add", ["x"], ["y"]), "takes 2 to 2"),
    "outputs": (node_of("Relu", ["x"], ["y", "z"]), "2 outputs"),
    "opset": (lambda made: setattr(made.opset_import[0], "version", 9), "opset 9; 13 to"),
    "type": (
        lambda made: setattr(made.graph.input[0].type.tensor_type, "elem_type", 7),
        "int64; take floats",
    ),
    "shape": (lambda made: made.graph.input[0].type.tensor_type.ClearField("shape"), "no shape"),
    "size": (
        lambda made: setattr(
            made.graph.input[0].type.tensor_type.shape.dim[1], "dim_value", 1 << 40
        ),
        "sizes are",
    ),
    "three dimensions": (
        lambda made: made.graph.input[0].type.tensor_type.shape.CopyFrom(
            helper.make_tensor_value_info("t", 1, [2, 3, 4]).type.tensor_type.shape
        ),
        "vectors and matrices",
    ),
    "nothing": (lambda made: made.Clear(), "not an ONNX file"),
    "twice": (lambda made: made.graph.node.append(made.graph.node[0]), "written twice"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_compiled__refused_by_name(name, tmp_path):
    change, text = REFUSED[name]
    made = relu()
    change(made)
    with pytest.raises(ModelError, match=text):
        load_onnx(save(tmp_path, made))


def test_convolution__pads_next_to_auto_pad__refused():
    node = helper.make_node("Conv", ["x", "w"], ["y"], auto_pad="VALID", pads=[1, 1])
    made = model([node], {"x": [1, 1, 5]}, {"y": [1, 1, 5]}, {"w": some(1, 1, 3)})
    with pytest.raises(ModelError, match="auto_pad = VALID and pads contradict"):
        function_of(made)


def test_damaged_bytes__refused_or_read(tmp_path):
    """Every damaged file ends in a ModelError or is read; nothing else is raised."""
    content = bytearray(perceptron([3, 4, 2], "Tanh", SEED).SerializeToString())
    random = np.random.default_rng(SEED)
    path = tmp_path / "policy.onnx"
    refused = 0
    for _ in range(60):
        changed = bytearray(content)
        for at in random.integers(0, len(content), 3):
            changed[at] = random.integers(256)
        path.write_bytes(changed[: random.integers(1, len(content) + 1)])
        try:
            load_onnx(path)
        except ModelError as error:
            refused += 1
            assert str(error).startswith(str(path))
    assert refused > 30


# ---- the whole way


@pytest.mark.full
def test_policy__compiled_and_proved_against_the_file(tmp_path, capsys, monkeypatch):
    path = save(tmp_path, perceptron([3, 4, 2], "Elu", SEED, "Tanh"))
    record = tmp_path / "policy.interface.toml"
    record.write_text(interface(3, 2))
    arguments = [str(path), str(record), "--prove", "--inputs", "300", "--boxes-effort", "1", "-o"]
    assert command.main([*arguments, str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.rstrip().endswith("proved")
    # A reading with another weight is found.
    read = load_onnx(path)
    other = save(tmp_path, perceptron([3, 4, 2], "Elu", SEED + 1, "Tanh"))
    monkeypatch.setattr("asip_asm.model.law.load_onnx", lambda _, whole: read)
    monkeypatch.setattr("sim.laws.prove_casadi.load_function", load_onnx)
    assert (
        command.main(
            [
                *map(str, (other, record)),
                "--prove",
                "--boxes-effort",
                "1",
                "-o",
                str(tmp_path / "two"),
            ]
        )
        == 1
    )
    assert capsys.readouterr().out.rstrip().endswith("NOT proved")


def test_reference__shapes_of_the_file(tmp_path):
    reference = OnnxReference(load_onnx(save(tmp_path, perceptron([5, 4, 2], "Relu", SEED))))
    assert (reference.arguments, reference.results) == ({"obs": (5, 1)}, {"act": (2, 1)})
