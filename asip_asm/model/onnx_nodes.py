# SPDX-License-Identifier: Apache-2.0
"""Operators of ONNX on arrays of `casadi.SX`, by the standard's own definitions.

`OPERATORS` has each with the attributes that it takes and their defaults. An attribute that is not
in the table, and a value of one that is not computed, is refused by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import onnx
import onnx.helper

from asip_asm.diagnostics import closest
from asip_asm.model.onnx_values import VALUES, constant, floats
from asip_asm.model.read import ModelError

Array = np.ndarray
Outputs = Array | Sequence[Array | None]


@dataclass(frozen=True)
class Operator:
    """`compute` takes the inputs (None: left out) and the attributes as keywords."""

    compute: Callable[..., Outputs]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[int, int] = (1, 1)
    """Fewest and most."""


def apply(node: onnx.NodeProto, values: dict[str, Array], where: str) -> None:
    """Add the node's outputs to `values`. Raises ModelError."""
    operator = OPERATORS.get(node.op_type) if node.domain in ("", "ai.onnx") else None
    if operator is None:
        near = closest(node.op_type, list(OPERATORS))
        raise ModelError(
            f"{where}: this operator is not compiled; {near or 'express it by others'}"
        )
    given = {each.name: onnx.helper.get_attribute_value(each) for each in node.attribute}
    for name in given:
        if name not in operator.attributes:
            raise ModelError(f"{where}: the attribute '{name}' is not compiled; leave it out")
    fewest, most = operator.inputs
    if not fewest <= len(node.input) <= most:
        raise ModelError(f"{where}: has {len(node.input)} inputs, takes {fewest} to {most}")
    inputs = []
    for name in node.input:
        if name and name not in values:
            raise ModelError(f"{where}: reads {name!r}, which nothing before it writes")
        inputs.append(values[name] if name else None)
    if any(each is None for each in inputs[:fewest]):
        raise ModelError(f"{where}: an input that the operator needs is left out")
    attributes = {**operator.attributes, **given}
    if node.op_type == "Split":
        attributes["count"] = len(node.output)
    try:
        found = operator.compute(*inputs, **attributes)
    except Refused as error:
        raise ModelError(f"{where}: {error}") from None
    outputs: list[Array | None] = [found] if isinstance(found, np.ndarray) else list(found)
    if len(node.output) > len(outputs):
        raise ModelError(f"{where}: has {len(node.output)} outputs, {len(outputs)} are computed")
    for name, value in zip(node.output, outputs, strict=False):
        if not name:
            continue
        if value is None:
            raise ModelError(f"{where}: its output '{name}' is not computed; leave it out")
        if name in values:
            raise ModelError(f"{where}: '{name}' is written twice")
        if value.size > VALUES:
            raise ModelError(f"{where}: '{name}' has more than {VALUES} elements")
        values[name] = value


class Refused(ValueError):
    """A value of an attribute or input that is not computed; the text says which, and the cure."""


def _only(what: str, value: Any, *known: Any) -> None:
    if value not in known:
        raise Refused(f"{what} = {value!r} is not compiled; {known[0]!r} is")


def _integers(array: Array | None, what: str) -> list[int]:
    if array is None or array.dtype == object:
        raise Refused(f"{what} must be constant integers")
    return [int(x) for x in array.ravel()]


def _each(function: Callable[..., Any]) -> Callable[..., Array]:
    """Element by element, with broadcasting."""
    ufunc = np.frompyfunc(lambda *args: function(*args), _count(function), 1)

    def compute(*arrays: Array) -> Array:
        for array in arrays:
            if array is None or array.dtype != object:
                raise Refused("arithmetic on integers is not compiled; cast to float in the model")
        found = ufunc(*arrays)
        if isinstance(found, np.ndarray):
            return found
        alone = np.empty((), dtype=object)  # frompyfunc gives the object itself
        alone[()] = found
        return alone

    return compute


def _count(function: Callable[..., Any]) -> int:
    return function.__code__.co_argcount


def _unary(function: Callable[..., Any], **attributes: Any) -> Operator:
    """Element by element; attributes become keywords of `function`."""
    if not attributes:
        return Operator(_each(lambda x: function(x)))
    return Operator(lambda x, **given: _each(lambda value: function(value, **given))(x), attributes)


def _single(value: float) -> float:
    """The default of an attribute: the standard's are binary32."""
    return float(np.float32(value))


def _elu(x: ca.SX, alpha: float, gamma: float = 1.0) -> ca.SX:
    return gamma * ca.if_else(x > 0, x, alpha * ca.expm1(ca.fmin(x, 0)))


def _sigmoid(x: ca.SX) -> ca.SX:
    """1 / (1 + e^-x) = (1 + tanh(x / 2)) / 2, which overflows for no x."""
    return 0.5 + 0.5 * ca.tanh(0.5 * x)


def _softplus(x: ca.SX) -> ca.SX:
    return ca.fmax(x, 0) + ca.log1p(ca.exp(-ca.fabs(x)))


def _gelu(x: ca.SX, approximate: Any) -> ca.SX:
    if approximate == b"tanh":
        inner = math.sqrt(2 / math.pi) * (x + 0.044715 * (x * x * x))
        return 0.5 * x * (1 + ca.tanh(inner))
    _only("approximate", approximate, b"none", b"tanh")
    return 0.5 * x * (1 + ca.erf(x * math.sqrt(0.5)))


def _fold(function: Callable[[ca.SX, ca.SX], ca.SX]) -> Operator:
    """Of any number of inputs, from the first to the last."""

    def compute(first: Array, *others: Array) -> Array:
        for other in others:
            first = _each(lambda a, b: function(a, b))(first, other)
        return first

    return Operator(compute, inputs=(1, 64))


def _clip(x: Array, low: Array | None = None, high: Array | None = None) -> Array:
    if low is not None:
        x = _each(lambda a, b: ca.fmax(a, b))(x, low)
    return x if high is None else _each(lambda a, b: ca.fmin(a, b))(x, high)


def _matmul(a: Array, b: Array) -> Array:
    """Product, terms added from the first to the last; leading dimensions broadcast."""
    if a.dtype != object or b.dtype != object:
        raise Refused("a product of integers is not compiled; cast to float in the model")
    found = np.matmul(a, b)
    if isinstance(found, np.ndarray):
        return found
    alone = np.empty((), dtype=object)
    alone[()] = found
    return alone


def _gemm(
    a: Array,
    b: Array,
    c: Array | None = None,
    *,
    alpha: float,
    beta: float,
    transA: int,
    transB: int,
) -> Array:
    product = _matmul(a.T if transA else a, b.T if transB else b)
    if alpha != 1.0:
        product = _scaled(product, alpha)
    if c is None or beta == 0.0:
        return product
    return _add(product, c if beta == 1.0 else _scaled(c, beta))


def _add(a: Array, b: Array) -> Array:
    return _each(lambda x, y: x + y)(a, b)


def _scaled(a: Array, factor: float) -> Array:
    return _each(lambda x: factor * x)(a)


def _conv(
    x: Array,
    weights: Array,
    bias: Array | None = None,
    *,
    auto_pad: bytes,
    dilations: Sequence[int],
    group: int,
    kernel_shape: Sequence[int],
    pads: Sequence[int],
    strides: Sequence[int],
) -> Array:
    """Convolution over a dimension: x (batch, channels, length), weights (out, in/group, taps)."""
    if x.ndim != 3 or weights.ndim != 3:
        raise Refused("convolutions over one dimension alone are compiled")
    _only("auto_pad", auto_pad, b"NOTSET", b"VALID")
    if auto_pad == b"VALID" and any(pads):
        raise Refused("auto_pad = VALID and pads contradict each other; leave one out")
    if kernel_shape and list(kernel_shape) != [weights.shape[2]]:
        raise Refused("kernel_shape differs from the weights'")
    (step,), (gap,), (before, after) = strides or [1], dilations or [1], pads or [0, 0]
    batch, channels, length = x.shape
    outs, ins, taps = weights.shape
    if channels != ins * group or outs % group:
        raise Refused(f"{channels} channels in {group} groups do not fit weights {weights.shape}")
    padded = floats(np.zeros((batch, channels, before + length + after)))
    padded[:, :, before : before + length] = x
    positions = (padded.shape[2] - gap * (taps - 1) - 1) // step + 1
    found = np.empty((batch, outs, positions), dtype=object)
    for row in range(batch):
        for out in range(outs):
            first = out // (outs // group) * ins
            for at in range(positions):
                total = ca.SX(0) if bias is None else bias[out]
                for channel in range(ins):
                    for tap in range(taps):
                        value = padded[row, first + channel, at * step + tap * gap]
                        total = total + weights[out, channel, tap] * value
                found[row, out, at] = total
    return found


def _reduce(mean: bool) -> Operator:
    """Over axes, which are an attribute up to opset 17 and an input from 18 on."""

    def compute(
        x: Array, given: Array | None = None, /, *, keepdims: int, noop_with_empty_axes: int,
        axes: Sequence[int] | None,
    ) -> Array:  # fmt: skip
        chosen = _integers(given, "axes") if given is not None else axes
        if not chosen and noop_with_empty_axes:
            return x
        return _mean(x, chosen or range(x.ndim), bool(keepdims), mean)

    attributes = {"keepdims": 1, "noop_with_empty_axes": 0, "axes": None}
    return Operator(compute, attributes, (1, 2))


def _mean(x: Array, axes: Sequence[int], keep: bool, mean: bool = True) -> Array:
    """Mean, or sum, over axes."""
    chosen = sorted({axis % x.ndim for axis in axes})
    others = [axis for axis in range(x.ndim) if axis not in chosen]
    rows = x.transpose([*others, *chosen]).reshape(*(x.shape[a] for a in others), -1)
    found = np.empty(rows.shape[:-1], dtype=object)
    for at in np.ndindex(found.shape):
        total = rows[at][0]
        for value in rows[at][1:]:
            total = total + value
        found[at] = total / rows.shape[-1] if mean else total
    return (
        found.reshape([1 if a in chosen else n for a, n in enumerate(x.shape)]) if keep else found
    )


def _layer_norm(
    x: Array, scale: Array, bias: Array | None = None, *, axis: int, epsilon: float, stash_type: int
) -> list[Array | None]:
    _only("stash_type", stash_type, 1)
    axes = range(axis % x.ndim, x.ndim)
    centred = _each(lambda a, b: a - b)(x, _mean(x, axes, True))
    variance = _mean(_each(lambda a: a * a)(centred), axes, True)
    spread = _each(lambda a: ca.sqrt(a + epsilon))(variance)
    found = _each(lambda a, b, c: a / b * c)(centred, spread, scale)
    return [found if bias is None else _add(found, bias), None, None]


def _softmax(x: Array, *, axis: int) -> Array:
    axis %= x.ndim
    moved = np.moveaxis(x, axis, -1)
    found = np.empty(moved.shape, dtype=object)
    for at in np.ndindex(moved.shape[:-1]):
        largest = moved[at][0]
        for value in moved[at][1:]:
            largest = ca.fmax(largest, value)
        powers = [ca.exp(value - largest) for value in moved[at]]
        total = powers[0]
        for power in powers[1:]:
            total = total + power
        for k, power in enumerate(powers):
            found[(*at, k)] = power / total
    return np.moveaxis(found, -1, axis)


# ---- recurrent cells: X (steps, batch, inputs), W and R (1, gates * hidden, ...), B (1, 2 * ...)


def _cell(
    gates: int, x: Array, w: Array, r: Array, b: Array | None, lengths: Array | None, given: dict
) -> tuple[int, list[Array], list[Array], list[Array], list[Array]]:
    """Checked: the hidden size, and W, R and their two biases of each gate."""
    _only("direction", given["direction"], b"forward")
    _only("layout", given["layout"], 0)
    _only("clip", given["clip"], None)
    _only("activation_alpha", given["activation_alpha"], None)
    _only("activation_beta", given["activation_beta"], None)
    usual = [b"Sigmoid", b"Tanh", b"Tanh"][: 2 if gates == 3 else 3]
    if given["activations"] is not None:
        _only("activations", list(given["activations"]), usual)
    if lengths is not None:
        raise Refused("sequence_lens is not compiled; leave it out")
    if x.ndim != 3 or w.ndim != 3 or r.ndim != 3 or w.shape[0] != 1:
        raise Refused("X, W and R have three dimensions, W and R one direction")
    size = r.shape[2]
    if given["hidden_size"] not in (None, size) or w.shape[1:] != (gates * size, x.shape[2]):
        raise Refused(f"hidden_size, X {x.shape}, W {w.shape} and R {r.shape} do not fit together")
    b = floats(np.zeros((1, 2 * gates * size))) if b is None else b

    def parts(array: Array) -> list[Array]:
        return [array[k * size : (k + 1) * size] for k in range(gates)]

    return size, parts(w[0]), parts(r[0]), parts(b[0]), parts(b[0, gates * size :])


_sigma = _each(lambda x: _sigmoid(x))
_tanh = _each(lambda x: ca.tanh(x))


def _start(first: Array | None, x: Array, size: int) -> Array:
    return floats(np.zeros((x.shape[1], size))) if first is None else first[0]


def _gru(
    x: Array, w: Array, r: Array, b: Array | None = None, lengths: Array | None = None,
    first: Array | None = None, *, linear_before_reset: int, **given: Any,
) -> list[Array]:  # fmt: skip
    size, w_, r_, wb, rb = _cell(3, x, w, r, b, lengths, given)
    h, found = _start(first, x, size), []
    for row in x:
        z, reset = (
            _sigma(_add(_add(_matmul(row, w_[k].T), _matmul(h, r_[k].T)), _add(wb[k], rb[k])))
            for k in (0, 1)
        )
        if linear_before_reset:
            hidden = reset * _add(_matmul(h, r_[2].T), rb[2])
            new = _tanh(_add(_add(_matmul(row, w_[2].T), hidden), wb[2]))
        else:
            hidden = _matmul(reset * h, r_[2].T)
            new = _tanh(_add(_add(_matmul(row, w_[2].T), hidden), _add(rb[2], wb[2])))
        h = _each(lambda g, n, old: (1 - g) * n + g * old)(z, new, h)
        found.append(h[None])
    return [np.stack(found), h[None]]


def _lstm(
    x: Array, w: Array, r: Array, b: Array | None = None, lengths: Array | None = None,
    first: Array | None = None, cell: Array | None = None, peepholes: Array | None = None,
    *, input_forget: int, **given: Any,
) -> list[Array]:  # fmt: skip
    _only("input_forget", input_forget, 0)
    if peepholes is not None:
        raise Refused("peepholes (P) are not compiled; leave them out")
    size, w_, r_, wb, rb = _cell(4, x, w, r, b, lengths, given)
    h, c, found = _start(first, x, size), _start(cell, x, size), []
    for row in x:
        into, out, forget, new = (
            _add(_add(_matmul(row, w_[k].T), _matmul(h, r_[k].T)), _add(wb[k], rb[k]))
            for k in range(4)
        )
        c = _add(_sigma(forget) * c, _sigma(into) * _tanh(new))
        h = _sigma(out) * _tanh(c)
        found.append(h[None])
    return [np.stack(found), h[None], c[None]]


# ---- shapes: constants decide, so nothing of them is left in the program


def _reshape(x: Array, shape: Array, *, allowzero: int) -> Array:
    _only("allowzero", allowzero, 0)
    sizes = _integers(shape, "the new shape")
    return x.reshape([x.shape[k] if size == 0 else size for k, size in enumerate(sizes)])


def _flatten(x: Array, *, axis: int) -> Array:
    if not -x.ndim <= axis <= x.ndim:
        raise Refused(f"axis = {axis} of a tensor with {x.ndim} dimensions")
    axis += x.ndim if axis < 0 else 0
    return x.reshape(math.prod(x.shape[:axis]), -1)


def _squeeze(x: Array, axes: Array | None = None) -> Array:
    return x.squeeze() if axes is None else x.squeeze(tuple(_integers(axes, "axes")))


def _unsqueeze(x: Array, axes: Array) -> Array:
    return np.expand_dims(x, tuple(_integers(axes, "axes")))


def _transpose(x: Array, *, perm: Sequence[int] | None) -> Array:
    return x.transpose(perm) if perm else x.T


def _concat(*arrays: Array, axis: int | None) -> Array:
    if axis is None:
        raise Refused("the attribute 'axis' is missing")
    return np.concatenate(arrays, axis)


def _slice(
    x: Array, starts: Array, ends: Array, axes: Array | None = None, steps: Array | None = None
) -> Array:
    first, last = _integers(starts, "starts"), _integers(ends, "ends")
    along = range(len(first)) if axes is None else _integers(axes, "axes")
    by = [1] * len(first) if steps is None else _integers(steps, "steps")
    chosen = [slice(None)] * x.ndim
    for axis, start, end, step in zip(along, first, last, by, strict=True):
        size = x.shape[axis]
        if step < 0 and end < -size:
            chosen[axis] = slice(start, None, step)
        else:
            chosen[axis] = slice(start, end, step)
    return x[tuple(chosen)]


def _split(
    x: Array, sizes: Array | None = None, *, axis: int, num_outputs: int | None, count: int
) -> list[Array]:
    if sizes is None:
        size = -(-x.shape[axis] // (num_outputs or count))
        ends = [size * k for k in range(1, num_outputs or count)]
    else:
        ends = list(np.cumsum(_integers(sizes, "split"))[:-1])
        if sum(_integers(sizes, "split")) != x.shape[axis]:
            raise Refused("split does not add up to the size of the axis")
    return np.split(x, ends, axis)


def _gather(x: Array, indices: Array, *, axis: int) -> Array:
    if indices.dtype == object:
        raise Refused("indices must be constant integers")
    if indices.size and (indices.min() < -x.shape[axis] or indices.max() >= x.shape[axis]):
        raise Refused(f"an index is outside of the {x.shape[axis]} elements of axis {axis}")
    found = np.take(x, indices, axis)
    return found if isinstance(found, np.ndarray) else np.array(found, dtype=x.dtype)


def _constant(**given: Any) -> Array:
    chosen = {name: value for name, value in given.items() if value is not None}
    if len(chosen) != 1:
        raise Refused("a constant has one value")
    ((name, value),) = chosen.items()
    if name == "value":
        return constant(value)
    if name in ("value_int", "value_ints"):
        return np.array(value, dtype=np.int64)
    return floats(np.array(value))


def _cast(x: Array, *, to: int | None, saturate: int, round_mode: bytes) -> Array:
    kind = onnx.TensorProto.DataType.Name(to or 0)
    wanted = ("FLOAT", "DOUBLE") if x.dtype == object else ("INT64", "INT32")
    if kind in wanted:
        return x
    if x.dtype != object and kind in ("FLOAT", "DOUBLE"):
        return floats(x)
    raise Refused(f"a cast to {kind.lower()} is not compiled; leave it out")


def _shape(x: Array, *, start: int, end: int | None) -> Array:
    return np.array(x.shape[start:end], dtype=np.int64)


def _dropout(x: Array, ratio: Array | None = None, training: Array | None = None, *, seed: Any):
    if training is not None:
        raise Refused("training_mode is not compiled; export for inference")
    return [x, None]


_CELL = {
    "activation_alpha": None, "activation_beta": None, "activations": None, "clip": None,
    "direction": b"forward", "hidden_size": None, "layout": 0,
}  # fmt: skip
OPERATORS: dict[str, Operator] = {
    "Abs": _unary(lambda x: ca.fabs(x)),
    "Add": Operator(_add, inputs=(2, 2)),
    "Cast": Operator(_cast, {"to": None, "saturate": 1, "round_mode": b"up"}),
    "Clip": Operator(_clip, inputs=(1, 3)),
    "Concat": Operator(_concat, {"axis": None}, (1, 64)),
    "Constant": Operator(
        _constant,
        dict.fromkeys(("value", "value_float", "value_floats", "value_int", "value_ints")),
        (0, 0),
    ),
    "Conv": Operator(
        _conv,
        {
            "auto_pad": b"NOTSET",
            "dilations": (),
            "group": 1,
            "kernel_shape": (),
            "pads": (),
            "strides": (),
        },
        (2, 3),
    ),
    "Cos": _unary(lambda x: ca.cos(x)),
    "Div": Operator(_each(lambda a, b: a / b), inputs=(2, 2)),
    "Dropout": Operator(_dropout, {"seed": None}, (1, 3)),
    "Elu": _unary(_elu, alpha=1.0),
    "Erf": _unary(lambda x: ca.erf(x)),
    "Exp": _unary(lambda x: ca.exp(x)),
    "Flatten": Operator(_flatten, {"axis": 1}),
    "GRU": Operator(_gru, _CELL | {"linear_before_reset": 0}, (3, 6)),
    "Gather": Operator(_gather, {"axis": 0}, (2, 2)),
    "Gelu": _unary(_gelu, approximate=b"none"),
    "Gemm": Operator(_gemm, {"alpha": 1.0, "beta": 1.0, "transA": 0, "transB": 0}, (2, 3)),
    "HardSigmoid": _unary(
        lambda x, alpha, beta: ca.fmin(ca.fmax(alpha * x + beta, 0), 1),
        alpha=_single(0.2),
        beta=0.5,
    ),
    "Identity": Operator(lambda x: x),
    "LSTM": Operator(_lstm, _CELL | {"input_forget": 0}, (3, 8)),
    "LayerNormalization": Operator(
        _layer_norm, {"axis": -1, "epsilon": _single(1e-5), "stash_type": 1}, (2, 3)
    ),
    "LeakyRelu": _unary(lambda x, alpha: ca.if_else(x > 0, x, alpha * x), alpha=_single(0.01)),
    "Log": _unary(lambda x: ca.log(x)),
    "MatMul": Operator(_matmul, inputs=(2, 2)),
    "Max": _fold(lambda a, b: ca.fmax(a, b)),
    "Min": _fold(lambda a, b: ca.fmin(a, b)),
    "Mul": Operator(_each(lambda a, b: a * b), inputs=(2, 2)),
    "Neg": _unary(lambda x: -x),
    "Pow": Operator(_each(lambda a, b: a**b), inputs=(2, 2)),
    "Reciprocal": _unary(lambda x: 1 / x),
    "ReduceMean": _reduce(True),
    "ReduceSum": _reduce(False),
    "Relu": _unary(lambda x: ca.fmax(x, 0)),
    "Reshape": Operator(_reshape, {"allowzero": 0}, (2, 2)),
    "Selu": _unary(_elu, alpha=1.67326319217681884765625, gamma=1.05070102214813232421875),
    "Shape": Operator(_shape, {"start": 0, "end": None}),
    "Sigmoid": _unary(_sigmoid),
    "Sin": _unary(lambda x: ca.sin(x)),
    "Slice": Operator(_slice, inputs=(3, 5)),
    "Softmax": Operator(_softmax, {"axis": -1}),
    "Softplus": _unary(_softplus),
    "Softsign": _unary(lambda x: x / (1 + ca.fabs(x))),
    "Split": Operator(_split, {"axis": 0, "num_outputs": None}, (1, 2)),
    "Sqrt": _unary(lambda x: ca.sqrt(x)),
    "Squeeze": Operator(_squeeze, inputs=(1, 2)),
    "Sub": Operator(_each(lambda a, b: a - b), inputs=(2, 2)),
    "Sum": _fold(lambda a, b: a + b),
    "Tanh": _unary(lambda x: ca.tanh(x)),
    "Transpose": Operator(_transpose, {"perm": None}),
    "Unsqueeze": Operator(_unsqueeze, inputs=(2, 2)),
}
"""By name in ONNX."""
