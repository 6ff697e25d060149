# SPDX-License-Identifier: Apache-2.0
"""The reference of a proof for an ONNX file: the evaluator of the package onnx, in doubles.

The file is parsed again, its floats are made doubles, and each node is computed by the standard's
reference implementation in a confined process. Nothing of the compiler's reading is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
import onnx
import onnx.reference
import scipy.special
from onnx import numpy_helper
from onnx.reference.op_run import OpRun

from asip_asm.model.onnx_file import OnnxPolicy
from sim.laws.prove_reference import Shape, Values

SECONDS = 120
MEMORY = 1 << 31
DOUBLE = onnx.TensorProto.DOUBLE
FLOATS = (
    onnx.TensorProto.FLOAT,
    onnx.TensorProto.FLOAT16,
    onnx.TensorProto.BFLOAT16,
)


class Erf(OpRun):
    """The error function in double precision; the evaluator's own rounds to binary32."""

    def _run(self, x: Values) -> tuple[Values]:
        return (scipy.special.erf(x),)


class Gelu(OpRun):
    """The standard's formulas in double precision; the evaluator's own uses its Erf."""

    def _run(self, x: Values, approximate: str = "none") -> tuple[Values]:
        if approximate == "tanh":
            return (0.5 * x * (1 + np.tanh(np.sqrt(2 / np.pi) * (x + 0.044715 * x**3))),)
        return (0.5 * x * (1 + scipy.special.erf(x / np.sqrt(2))),)


def evaluator_of(model: onnx.ModelProto) -> onnx.reference.ReferenceEvaluator:
    """The evaluator of a model whose floats are made doubles."""
    return onnx.reference.ReferenceEvaluator(in_double(model), new_ops=[Erf, Gelu])


class OnnxReference:
    """A `Reference` by onnx's own evaluator. Raises ModelError where it refuses the file."""

    def __init__(self, policy: OnnxPolicy) -> None:
        _warm_up()
        self.policy = policy
        data = policy.use(lambda model: msgspec.msgpack.encode(_shapes(model)))
        self.arguments: dict[str, Shape]
        self.results: dict[str, Shape]
        self.arguments, self.results = msgspec.msgpack.decode(
            data, type=tuple[dict[str, Shape], dict[str, Shape]]
        )

    def __call__(self, arguments: Mapping[str, Values]) -> dict[str, Values]:
        points = len(next(iter(arguments.values()))) if arguments else 1
        data = self.policy.use(lambda model: _evaluate(model, arguments, points), SECONDS, MEMORY)
        values = np.frombuffer(data, np.float64).reshape(points, -1)
        found: dict[str, Values] = {}
        at = 0
        for name, (rows, columns) in self.results.items():
            part = values[:, at : at + rows * columns]
            found[name] = part.reshape(points, rows, columns)
            at += rows * columns
        return found


def _warm_up() -> None:
    """Import what the evaluator imports late: the confined child can open no file."""
    node = onnx.helper.make_node("Identity", ["x"], ["y"])
    ends = [onnx.helper.make_tensor_value_info(name, DOUBLE, [1]) for name in "xy"]
    graph = onnx.helper.make_graph([node], "g", ends[:1], ends[1:])
    evaluator_of(onnx.helper.make_model(graph)).run(None, {"x": np.zeros(1)})


def in_double(model: onnx.ModelProto) -> onnx.ModelProto:
    """The model with every float tensor a double of the same value."""
    model = onnx.ModelProto.FromString(model.SerializeToString())
    graph = model.graph
    for tensor in graph.initializer:
        _widen(tensor)
    for entry in (*graph.input, *graph.output, *graph.value_info):
        if entry.type.tensor_type.elem_type in FLOATS:
            entry.type.tensor_type.elem_type = DOUBLE
    for node in graph.node:
        for attribute in node.attribute:
            if node.op_type == "Cast" and attribute.name == "to" and attribute.i in FLOATS:
                attribute.i = DOUBLE
            elif node.op_type == "Constant" and attribute.name == "value":
                _widen(attribute.t)
            elif node.op_type == "Constant" and attribute.name in ("value_float", "value_floats"):
                single = attribute.name == "value_float"
                numbers = np.array(attribute.f if single else attribute.floats, np.float64)
                value = numpy_helper.from_array(numbers)
                attribute.CopyFrom(onnx.helper.make_attribute("value", value))
    return model


def _widen(tensor: onnx.TensorProto) -> None:
    if tensor.data_type in FLOATS:
        array = numpy_helper.to_array(tensor).astype(np.float64)
        tensor.CopyFrom(numpy_helper.from_array(array, tensor.name))


def _inputs(model: onnx.ModelProto) -> dict[str, tuple[int, ...]]:
    constants = {tensor.name for tensor in model.graph.initializer}
    return {
        entry.name: tuple(d.dim_value or 1 for d in entry.type.tensor_type.shape.dim)
        for entry in model.graph.input
        if entry.name not in constants
    }


def _run(
    model: onnx.ModelProto, points: Sequence[Mapping[str, Values]]
) -> list[list[np.ndarray[Any, Any]]]:
    evaluator = evaluator_of(model)
    ran = (evaluator.run(None, dict(point)) for point in points)
    return [found if isinstance(found, list) else list(found.values()) for found in ran]


def _matrix(shape: tuple[int, ...]) -> Shape:
    """Rows and columns without the dimensions of size 1."""
    rows, columns = [*(n for n in shape if n != 1), 1, 1][:2]
    return rows, columns


def _shapes(model: onnx.ModelProto) -> tuple[dict[str, Shape], dict[str, Shape]]:
    inputs = _inputs(model)
    (found,) = _run(model, [{name: np.zeros(shape) for name, shape in inputs.items()}])
    names = [entry.name for entry in model.graph.output]
    results = {n: _matrix(value.shape) for n, value in zip(names, found, strict=True)}
    return {name: _matrix(shape) for name, shape in inputs.items()}, results


def _evaluate(model: onnx.ModelProto, arguments: Mapping[str, Values], points: int) -> bytes:
    inputs = _inputs(model)
    given = [
        {name: arguments[name][k].reshape(shape) for name, shape in inputs.items()}
        for k in range(points)
    ]
    rows = [np.concatenate([np.ravel(x) for x in found]) for found in _run(model, given)]
    return np.asarray(rows, np.float64).tobytes()
