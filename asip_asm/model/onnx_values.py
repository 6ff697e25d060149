# SPDX-License-Identifier: Apache-2.0
"""Constant tensors of ONNX files: integers as they are, floats as arrays of `casadi.SX`."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from asip_asm.model.read import ModelError

VALUES = 1 << 22
"""Elements of one tensor at most."""


def package():
    """The package. Raises ModelError where it is not installed."""
    try:
        import onnx
        import onnx.numpy_helper
    except ImportError:
        raise ModelError(
            "ONNX files need the package onnx: pip install 'microtick[model]'"
        ) from None
    return onnx


def constant(tensor) -> np.ndarray:
    """A constant tensor: integers as they are, floats as objects that hold `casadi.SX`."""
    onnx = package()
    if tensor.data_location == onnx.TensorProto.EXTERNAL or len(tensor.external_data):
        raise ModelError(
            f"constant {tensor.name!r} lies in another file, which is not read; export the policy "
            "into one file"
        )
    if math.prod(tensor.dims) > VALUES:
        raise ModelError(f"constant {tensor.name!r} has more than {VALUES} elements")
    array = onnx.numpy_helper.to_array(tensor)
    if array.dtype.kind in "iu":
        return array.astype(np.int64)
    if array.dtype.kind not in "f" and "float" not in array.dtype.name:
        raise ModelError(f"constant {tensor.name!r} is of type {array.dtype.name}; floats are read")
    return floats(array)


def floats(array) -> np.ndarray:
    """Objects that hold `casadi.SX` of the same shape. Raises ModelError if one is not finite."""
    array = np.asarray(array)
    numbers = array.astype(np.float64).ravel()
    if not np.isfinite(numbers).all():
        raise ModelError("a constant is infinite or no number; replace infinity by a large bound")
    return objects([ca.SX(float(x)) for x in numbers]).reshape(array.shape)


def objects(elements: list) -> np.ndarray:
    found = np.empty(len(elements), dtype=object)
    for k, element in enumerate(elements):  # numpy would ask an SX for its elements
        found[k] = element
    return found
