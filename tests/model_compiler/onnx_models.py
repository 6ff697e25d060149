# SPDX-License-Identifier: Apache-2.0
"""Small ONNX models for tests, made with the package onnx."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import onnx
from onnx import helper, numpy_helper

FLOAT = onnx.TensorProto.FLOAT
Shape = Sequence[int | str]


def model(
    nodes: Sequence[onnx.NodeProto],
    inputs: Mapping[str, Shape],
    outputs: Mapping[str, Shape],
    constants: Mapping[str, np.ndarray] | None = None,
    opset: int = 20,
) -> onnx.ModelProto:
    """A checked model of these nodes."""
    ends = [
        [helper.make_tensor_value_info(name, FLOAT, shape) for name, shape in side.items()]
        for side in (inputs, outputs)
    ]
    tensors = [numpy_helper.from_array(array, name) for name, array in (constants or {}).items()]
    graph = helper.make_graph(list(nodes), "g", *ends, tensors)
    found = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)])
    onnx.checker.check_model(found)
    return found


def perceptron(sizes: Sequence[int], activation: str, seed: int, last: str = "") -> onnx.ModelProto:
    """Gemm layers of these sizes, an activation after each but the last, which has `last`."""
    random = np.random.default_rng(seed)
    nodes, constants, value = [], {}, "obs"
    for k, (columns, rows) in enumerate(zip(sizes[:-1], sizes[1:], strict=True)):
        weights = random.normal(0, 1 / np.sqrt(columns), (rows, columns))
        constants[f"w{k}"] = weights.astype(np.float32)
        constants[f"b{k}"] = random.normal(0, 0.1, rows).astype(np.float32)
        ends = k == len(sizes) - 2
        kind = last if ends else activation
        made = "act" if ends and not kind else f"h{k}"
        nodes.append(helper.make_node("Gemm", [value, f"w{k}", f"b{k}"], [made], transB=1))
        value = made
        if kind:
            value = "act" if ends else f"a{k}"
            nodes.append(helper.make_node(kind, [made], [value]))
    return model(nodes, {"obs": ["batch", sizes[0]]}, {"act": ["batch", sizes[-1]]}, constants)


def interface(inputs: int, outputs: int, limit: float = 1.0) -> str:
    """Interface record of a policy with those numbers of observations and actions."""
    names = [
        "[" + ", ".join(f'"{name}{k}"' for k in range(size)) + "]"
        for name, size in (("obs_", inputs), ("act_", outputs))
    ]
    return (
        'title = "policy"\n'
        f'[[input]]\nnames = {names[0]}\nvector = "obs"\nunit = "1"\nmeaning = "observation"\n'
        f"limits = [-{limit}, {limit}]\n"
        f'[[output]]\nnames = {names[1]}\nvector = "act"\nunit = "1"\nmeaning = "action"\n'
        "limits = [-5.0, 5.0]\nsafe = 0.0\n"
    )
