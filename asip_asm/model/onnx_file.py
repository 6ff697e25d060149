# SPDX-License-Identifier: Apache-2.0
"""Policies in ONNX files: read as data, in a confined child, into scalar instructions.

One tick is one inference. A dimension without a number (the batch of an exporter) is 1. A tensor is
a vector or a matrix once its dimensions of size 1 are dropped; the interface record gives a matrix
column by column, as for CasADi. Every node, input and attribute acts or is refused by name. A file
may name no other file. Operators: `asip_asm.model.onnx_nodes`; standard: ONNX, opset 13 and up.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import msgspec
import numpy as np

from asip_asm.files import read_bytes
from asip_asm.model.confined import BYTES, SECONDS, Confined, confined
from asip_asm.model.onnx_values import VALUES, constant, objects, package
from asip_asm.model.read import ModelError, Scalars, scalars

SUFFIX = ".onnx"
FILE_BYTES = 1 << 26
OPSETS = range(13, 27)
"""Versions of the operators that are read. Their meaning is the same in all of these."""
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True)
class OnnxPolicy:
    """A policy that was read: its bytes, and its scalar instructions as data."""

    path: Path
    content: bytes

    @functools.cached_property
    def scalars(self) -> Scalars:
        """Raises ModelError."""
        data = self.use(lambda model: msgspec.msgpack.encode(scalars(function_of(model))))
        return msgspec.msgpack.decode(data, type=Scalars)

    def use(
        self, work: Callable[[Any], bytes], seconds: int = SECONDS, memory: int = BYTES
    ) -> bytes:
        """Answer of `work` on the `onnx.ModelProto`, in a confined child. Raises ModelError."""
        return _use(self.path, self.content, work, seconds, memory)


def load_onnx(path: Path, whole: bool = True) -> OnnxPolicy:
    """The policy of a file; `whole`: its scalar instructions are read now. Raises ModelError,
    OSError.
    """
    if not path.exists():
        raise ModelError(f"{path}: no such file; export a policy to it")
    content = read_bytes(path, FILE_BYTES, "a policy")
    from asip_asm.model import onnx_nodes  # noqa: F401  imported here: the child can open no file

    policy = OnnxPolicy(path, content)
    if whole:
        _ = policy.scalars
    return policy


def _use(
    path: Path,
    content: bytes,
    work: Callable[[object], bytes],
    seconds: int = SECONDS,
    memory: int = BYTES,
) -> bytes:
    onnx = package()
    try:
        return confined(lambda: work(_parsed(onnx, content)), seconds, memory)
    except Confined as error:
        raise ModelError(f"{path}: {error}") from None


def _parsed(onnx, content: bytes):
    try:
        model = onnx.ModelProto.FromString(content)
    except Exception:
        raise ModelError("not an ONNX file, or damaged; export the policy again") from None
    if not model.graph.node or not model.graph.output:
        raise ModelError("not an ONNX file, or one without nodes or outputs; export it again")
    return model


def function_of(model) -> ca.Function:
    """A CasADi function (SX) of an `onnx.ModelProto`, argument and result names of its graph.

    Raises ModelError.
    """
    from asip_asm.model.onnx_nodes import apply

    _check_model(model)
    graph = model.graph
    values: dict[str, np.ndarray] = {}
    for tensor in graph.initializer:
        values[tensor.name] = constant(tensor)
    symbols: dict[str, ca.SX] = {}
    for entry in graph.input:
        if entry.name in values:
            continue  # the default of an initializer, which stays a constant
        shape = shape_of(entry, "input")
        rows, columns = matrix_shape(entry.name, shape)
        symbol = symbols[entry.name] = ca.SX.sym(entry.name, rows, columns)
        elements = [symbol[r, c] for r in range(rows) for c in range(columns)]
        values[entry.name] = objects(elements).reshape(shape)
    for number, node in enumerate(graph.node):
        where = f"node {number} {node.name!r} ({node.op_type})"
        try:
            apply(node, values, where)
        except (ValueError, LookupError, TypeError, RuntimeError) as error:
            if isinstance(error, ModelError):
                raise
            raise ModelError(f"{where}: {error}; its tensors do not fit together") from None
    results = {}
    for entry in graph.output:
        _check_name(entry.name, "output")
        if entry.name not in values:
            raise ModelError(f"output {entry.name!r}: no node writes it")
        value = values[entry.name]
        if value.dtype != object:
            raise ModelError(f"output {entry.name!r} is of integers; a policy gives floats")
        rows, columns = matrix_shape(entry.name, value.shape)
        lines = [ca.horzcat(*line) for line in value.reshape(rows, columns)]
        results[entry.name] = ca.vertcat(*lines)
    return ca.Function(
        "policy", list(symbols.values()), list(results.values()), list(symbols), list(results)
    )


def _check_model(model) -> None:
    for field, what in (
        (model.functions, "functions of its own; inline them"),
        (model.training_info, "training information; export it for inference"),
        (model.graph.sparse_initializer, "sparse constants; export them dense"),
        (model.graph.quantization_annotation, "quantised tensors; export it in float"),
    ):
        if len(field):
            raise ModelError(f"the file has {what}")
    versions = {entry.domain: entry.version for entry in model.opset_import}
    if others := sorted(d for d in versions if d not in ("", "ai.onnx")):
        used = {node.domain for node in model.graph.node}
        if found := [d for d in others if d in used]:
            raise ModelError(f"operators of the domain {found[0]!r}; only those of ONNX are read")
    version = versions.get("", versions.get("ai.onnx", 0))
    if version not in OPSETS:
        raise ModelError(
            f"opset {version}; {OPSETS[0]} to {OPSETS[-1]} are read: export with one of these, or "
            "use onnx.version_converter"
        )


def shape_of(entry, what: str) -> tuple[int, ...]:
    """Shape of an input; a dimension without a number is a batch of 1. Raises ModelError."""
    onnx = package()
    _check_name(entry.name, what)
    tensor = entry.type.tensor_type
    if tensor.elem_type not in (onnx.TensorProto.FLOAT, onnx.TensorProto.DOUBLE):
        kind = entry.type.WhichOneof("value") or "nothing"
        if kind == "tensor_type":
            kind = onnx.TensorProto.DataType.Name(tensor.elem_type).lower()
        raise ModelError(f"{what} {entry.name!r} is of {kind}; take floats and doubles")
    if not tensor.HasField("shape"):
        raise ModelError(f"{what} {entry.name!r} has no shape; export it with one")
    shape = tuple(d.dim_value if d.HasField("dim_value") else 1 for d in tensor.shape.dim)
    if any(size < 1 for size in shape) or math.prod(shape) > VALUES:
        raise ModelError(f"{what} {entry.name!r} has the shape {shape}; sizes are 1 to {VALUES}")
    return shape


def matrix_shape(name: str, shape: tuple[int, ...]) -> tuple[int, int]:
    """Rows and columns of a tensor without its dimensions of size 1. Raises ModelError."""
    sizes = [size for size in shape if size != 1]
    if len(sizes) > 2:
        raise ModelError(f"{name!r} has the shape {shape}; signals are vectors and matrices")
    rows, columns = [*sizes, 1, 1][:2]
    return rows, columns


def _check_name(name: str, what: str) -> None:
    if not _NAME.fullmatch(name):
        raise ModelError(
            f"{what} {name!r} cannot name signals: letters, digits and '_' of ASCII can; export "
            "the policy with input_names and output_names"
        )
