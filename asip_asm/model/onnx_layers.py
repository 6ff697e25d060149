# SPDX-License-Identifier: Apache-2.0
"""Dense layers of an ONNX file: a network as matrices, for programs of streams and loops.

Nodes on constants alone are computed, those that only rename or reshape are passed, a product with
a constant matrix begins a layer, sums and products with constants join its weights, and a function
of each element ends it. What is none of these is named.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import casadi as ca
import msgspec
import numpy as np
import onnx.helper

from asip_asm.model.onnx_file import OnnxPolicy, _check_model, matrix_shape, shape_of
from asip_asm.model.onnx_nodes import apply
from asip_asm.model.onnx_values import constant, objects
from asip_asm.model.read import Entry, ModelError, Scalars, scalars

SHAPES = frozenset({"Identity", "Flatten", "Reshape", "Squeeze", "Unsqueeze"})
SUMS = frozenset({"Add", "Sub", "Mul", "Div"})
FUNCTIONS = frozenset(
    {"Relu", "Elu", "Selu", "LeakyRelu", "Tanh", "Sigmoid", "Softplus", "Softsign", "Gelu", "Erf"}
)


@dataclass(frozen=True)
class Layer:
    """activation(weights x + bias), element by element; without one None."""

    weights: list[list[float]]
    bias: list[float]
    activation: Scalars | None

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.weights), len(self.weights[0])


@dataclass(frozen=True)
class Network:
    """Layers from the one argument to the one result."""

    argument: Entry
    result: Entry
    layers: tuple[Layer, ...]

    @property
    def products(self) -> int:
        return sum(math.prod(layer.shape) for layer in self.layers)


class _Reader:
    def __init__(self, model) -> None:
        _check_model(model)
        self.graph = model.graph
        self.values = {tensor.name: constant(tensor) for tensor in model.graph.initializer}
        entries = [entry for entry in model.graph.input if entry.name not in self.values]
        if len(entries) != 1 or len(model.graph.output) != 1:
            raise ModelError(
                f"{len(entries)} inputs and {len(model.graph.output)} outputs; a network of dense "
                "layers has one of each"
            )
        self.entry = entries[0]
        self.shape = shape_of(self.entry, "input")
        self.size = math.prod(self.shape)
        self.now = self.entry.name
        self.layers: list[Layer] = []
        self.weights: np.ndarray | None = None
        self.scale, self.bias = np.ones(self.size), np.zeros(self.size)

    def network(self) -> Network:
        argument = _entry(self.entry.name, self.shape)
        for number, node in enumerate(self.graph.node):
            self._node(node, f"node {number} {node.name!r} ({node.op_type})")
        if self.graph.output[0].name != self.now:
            raise ModelError(
                f"output {self.graph.output[0].name!r} is not what the last node gives"
            )
        if self.weights is not None:
            self._layer(None)
        elif not self.layers or np.any(self.scale != 1) or np.any(self.bias != 0):
            raise ModelError("what follows the last activation is no product with a matrix")
        return Network(argument, _entry(self.now, (len(self.bias),)), tuple(self.layers))

    def _node(self, node, where: str) -> None:
        reads = [k for k, name in enumerate(node.input) if name == self.now]
        others = [name for name in node.input if name and name != self.now]
        if not reads and all(name in self.values for name in others):
            apply(node, self.values, where)
            return
        if len(reads) != 1 or any(name not in self.values for name in others):
            raise ModelError(f"{where}: joins two branches")
        given = {each.name: onnx.helper.get_attribute_value(each) for each in node.attribute}
        if node.op_type in ("MatMul", "Gemm"):
            self._product(node, given, reads[0], where)
        elif node.op_type in SUMS:
            self._sum(node, reads[0], where)
        elif node.op_type in FUNCTIONS:
            if self.weights is None:
                raise ModelError(f"{where}: has no product with a matrix before it")
            self._layer(self._activation(node, where))
        elif node.op_type not in SHAPES:
            raise ModelError(f"{where}: is no part of a dense layer")
        self.now = node.output[0]

    def _constant(self, name: str) -> np.ndarray:
        value = self.values[name]
        flat = [float(each) for each in value.ravel()]
        return np.array(flat).reshape(value.shape)

    def _product(self, node, given: dict, place: int, where: str) -> None:
        other = self._constant(node.input[1 - place]) if place < 2 else np.zeros(0)
        bias = np.zeros(1)
        if node.op_type == "Gemm":
            unknown = sorted(set(given) - {"alpha", "beta", "transA", "transB"})
            if place != 0 or given.get("transA") or unknown:
                raise ModelError(f"{where}: is no product of a matrix and the network's vector")
            other = given.get("alpha", 1.0) * (other if given.get("transB") else other.T)
            if len(node.input) > 2 and node.input[2]:
                bias = given.get("beta", 1.0) * self._constant(node.input[2]).ravel()
        elif place == 0:
            other = other.T
        if other.ndim != 2 or other.shape[1] != len(self.bias):
            raise ModelError(
                f"{where}: a matrix of {other.shape} does not fit {len(self.bias)} numbers"
            )
        if self.weights is not None:
            self._layer(None)
        self.weights = other * self.scale
        self.bias = np.broadcast_to(other @ self.bias + bias, (len(other),))
        self.scale = np.ones(len(other))

    def _sum(self, node, place: int, where: str) -> None:
        value = self._constant(node.input[1 - place]).ravel()
        if value.size not in (1, len(self.bias)) or (place == 1 and node.op_type in ("Sub", "Div")):
            raise ModelError(f"{where}: is no sum or product with a constant of the vector's size")
        if node.op_type in ("Add", "Sub"):
            self.bias = self.bias + (value if node.op_type == "Add" else -value)
            return
        factor = value if node.op_type == "Mul" else 1 / value
        self.bias = self.bias * factor
        if self.weights is None:
            self.scale = self.scale * factor
        else:
            self.weights = self.weights * np.broadcast_to(factor, (len(self.bias),))[:, None]

    def _activation(self, node, where: str) -> Scalars:
        x = ca.SX.sym("x")
        values = dict(self.values) | {self.now: objects([x]).reshape(1, 1)}
        values.pop(node.output[0], None)
        apply(node, values, where)
        return scalars(ca.Function("f", [x], [values[node.output[0]].ravel()[0]], ["x"], ["y"]))

    def _layer(self, activation: Scalars | None) -> None:
        assert self.weights is not None
        self.layers.append(Layer(self.weights.tolist(), self.bias.tolist(), activation))
        self.weights = None
        self.scale, self.bias = np.ones(len(self.bias)), np.zeros(len(self.bias))


def _entry(name: str, shape: tuple[int, ...]) -> Entry:
    rows, columns = matrix_shape(name, shape)
    if columns != 1 and rows != 1:
        raise ModelError(f"'{name}' is a matrix; dense layers take a vector")
    return Entry(name, rows, columns, tuple(range(rows * columns)))


def network_of(model) -> Network | str:
    """The network of an `onnx.ModelProto`; the reason why it is not one of dense layers. Raises
    ModelError for a file that is none.
    """
    _check_model(model)
    try:
        return _Reader(model).network()
    except ModelError as error:
        return str(error)


@functools.cache
def dense_layers(policy: OnnxPolicy) -> Network | str:
    """Layers of a policy, or the reason why not. Raises ModelError for a bad file."""

    def work(model) -> bytes:
        found = network_of(model)
        whole = isinstance(found, Network)
        return msgspec.msgpack.encode((found, "") if whole else (None, found))

    found, reason = msgspec.msgpack.decode(policy.use(work), type=tuple[Network | None, str])
    return found or reason
