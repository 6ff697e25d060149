# SPDX-License-Identifier: Apache-2.0
"""Proof of a compiled law: bits against the exact interpreter, values against double precision.

The program runs on the core over drawn inputs. Every tick's outputs and next states must have the
bits that `asip_asm.model.exact` computes from the same inputs and the states that the core held
before; and must be as near to the CasADi function in double precision as
`asip_asm.model.bound` derives.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.bound import bounds
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array, evaluate
from asip_asm.model.law import Law, Port, before
from asip_asm.model.read import load_function, reference
from sim.core import Core

SEED = 1
COUNT = 10_000
BATCH = 20
"""Ticks from one random start of the states and encoders."""
CORNERS = 0.1
"""Share of values that are corners of their range."""


@dataclass(frozen=True)
class Proof:
    """What a proof found. worst: largest error as a share of its bound, over all inputs and
    results, and the result where; unbounded: results without a finite bound, which prove nothing.
    within: of each output, inputs where it is inside its limits; at a limit it is a constant, whose
    error says nothing. first_difference: text, empty if all bits agree.
    """

    inputs_tried: int
    bits_equal: bool
    first_difference: str
    worst_fraction_of_bound: float
    worst_result: str
    unbounded: int
    largest_error: dict[str, float]
    within: dict[str, int]
    seed: int

    @property
    def passed(self) -> bool:
        return self.bits_equal and self.worst_fraction_of_bound < 1 and not self.unbounded


@functools.cache
def _sine_unit():
    from sim.fpbench.native import Unit

    return Unit("fp_sincos")


def unit_sine(angles: NDArray[np.float32], cosine: bool) -> NDArray[np.float32]:
    """Sine or cosine by the core's unit alone (Verilated by itself, with its own evidence)."""
    rows = np.ascontiguousarray(angles).view(np.uint32).reshape(-1, 1)
    return _sine_unit().answers("cos" if cosine else "sin", rows)[1].view(np.float32)


def draw(port: Port, count: int, rng: np.random.Generator) -> Array:
    """Random values of an input or state inside its limits, a tenth of them corners."""
    low, high = port.limits or (-1.0, 1.0)
    values = rng.uniform(low, high, count)
    corner = rng.choice([low, high, 0.0, 1e-3 * high, (low + high) / 2, low / 3], count)
    values = np.where(rng.random(count) < CORNERS, np.clip(corner, low, high), values)
    if port.type == "int":
        return np.rint((values - port.offset) / port.scale).astype(np.int32)
    return inside(port, values)


def inside(port: Port, values: NDArray[np.float64]) -> NDArray[np.float32]:
    """As binary32, clipped to the limits of the port."""
    low, high = port.limits or (-1.0, 1.0)
    single = np.clip(values, low, high).astype(np.float32)
    over = (single > high) | (single < low)
    return np.where(over, np.nextafter(single, np.float32(0)), single)


Sample = Callable[[int, np.random.Generator], dict[str, Array]]
"""Inputs (n,) of n consecutive ticks, for laws whose inputs belong together; states (1,) before
them, where these belong to the inputs too."""


Reference = Callable[[Mapping[str, Array]], dict[str, tuple[Array, Array]]]
"""Results of words of the program by name, outputs saturated, and the reference's own error."""


def prove(
    compiled: Compiled,
    image: Image,
    *,
    count: int = COUNT,
    seed: int = SEED,
    backend: str = "rtl",
    sample: Sample | None = None,
    reference: Reference | None = None,
) -> Proof:
    """Run `count` drawn ticks of the program and compare. Raises CoreFault if the core stops."""
    law = compiled.law
    rng = np.random.default_rng(seed)
    outputs = [port.name for port in law.ports if port.kind in ("output", "export")]
    values: dict[str, list[Array]] = {}
    results: dict[str, list[Array]] = {}
    with Core(image, backend=backend) as core:
        for begin in range(0, count, BATCH):
            inputs, states = draw_ticks(law, min(BATCH, count - begin), rng, sample)
            core.preset({name: value[0].item() for name, value in states.items()})
            ticks = core.batch(
                inputs, read=[*states, *(n for n in outputs if n not in core.outputs)]
            )
            for name, first in states.items():
                after = ticks[name].view(first.dtype)
                inputs[name] = np.concatenate((first, after[:-1]))
                results.setdefault(f"{name}_next", []).append(after)
            for name in outputs:
                results.setdefault(name, []).append(ticks[name])
            for name, value in inputs.items():
                values.setdefault(name, []).append(value)
    inputs = {name: np.concatenate(parts) for name, parts in values.items()}
    for port in law.of_kind("parameter"):
        inputs[port.name] = np.full(count, port.initial, np.float32)
    got = {name: np.concatenate(parts) for name, parts in results.items()}
    sine = unit_sine if backend == "rtl" else rounded_sine
    return compare(compiled, inputs, got, seed, sine, reference)


def draw_ticks(
    law: Law, size: int, rng: np.random.Generator, sample: Sample | None = None
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Inputs of consecutive ticks, arrays (size,), and the states before them, arrays (1,)."""
    if sample:
        inputs = sample(size, rng)
    else:
        inputs = {port.name: draw(port, size, rng) for port in law.of_kind("input")}
        for rate in law.of_kind("rate"):
            inputs[rate.rate_of] = walk(law, rate, size, rng)
    states = {p.name: draw(p, 1, rng) for p in law.of_kind("state")}
    states |= {name: inputs.pop(name) for name in states if name in inputs}
    for rate in law.of_kind("rate"):
        states[before(rate.rate_of)] = inputs[rate.rate_of][:1]
    return inputs, states


def walk(law: Law, rate: Port, size: int, rng: np.random.Generator) -> NDArray[np.int32]:
    """Counts of an encoder from a drawn one on, differences within the limits of the rate."""
    port = law.port(rate.rate_of)
    low, high = sorted(int((b - port.offset) / port.scale) for b in port.limits or (-1.0, 1.0))
    most = max(1, int(abs((rate.limits or (-1.0, 1.0))[1] / rate.scale)))
    steps = rng.integers(-most, most + 1, size)
    walk = int(draw(port, 1, rng)[0]) + np.cumsum(steps)
    period = 2 * max(1, high - low)  # reflected at the limits
    folded = np.abs((walk - low + period // 2) % period - period // 2) + low
    return folded.astype(np.int32)


def rounded_sine(angles: NDArray[np.float32], cosine: bool) -> NDArray[np.float32]:
    """Correctly rounded sine or cosine, as the instruction-set model has it."""
    from sim.iss.arithmetic import sincos_rounded

    words = np.ascontiguousarray(angles).view(np.uint32)
    bits = [sincos_rounded(int(word), cosine)[0] for word in words]
    return np.array(bits, np.uint32).view(np.float32)


def exact_results(compiled: Compiled, inputs: Mapping[str, Array], sine) -> dict[str, Array]:
    """Outputs and next states (`<state>_next`) by the exact interpreter."""
    nodes = evaluate(compiled.graph, inputs, sine)
    found = {name: nodes[root] for name, root in compiled.graph.outputs.items()}
    return found | {f"{n}_next": nodes[root] for n, root in compiled.graph.next_states.items()}


def true_results(law: Law, inputs: Mapping[str, Array]) -> dict[str, NDArray[np.float64]]:
    """Results of the CasADi function in double precision, outputs saturated, by name."""
    function = load_function(law.function)
    physical = {}
    for port in law.ports:
        if port.kind == "rate":
            last = inputs[before(port.rate_of)].astype(np.int64)
            physical[port.name] = port.scale * (inputs[port.rate_of].astype(np.int64) - last)
        elif port.kind in ("input", "state", "parameter"):
            value = inputs[port.name].astype(np.float64)
            physical[port.name] = port.scale * value + port.offset if port.type == "int" else value
    points = len(next(iter(physical.values())))
    names = iter(law.arguments())
    arguments = [
        np.array([physical[next(names)[1].name] for _ in range(function.nnz_in(i))]).reshape(
            -1, points
        )
        for i in range(function.n_in())
    ]
    mapped = reference(function)(_dense(function, arguments, points), points)
    rows = [row for i, m in enumerate(mapped) for row in _rows(function, i, m, points)]
    found: dict[str, NDArray[np.float64]] = {}
    for (_, port), row in zip(law.results(), rows, strict=True):
        if port.kind == "output" and port.limits is not None:
            row = np.clip(row, *port.limits)
        found[f"{port.name}_next" if port.kind == "state" else port.name] = row
    return found


def _dense(function, arguments: list[NDArray[np.float64]], points: int) -> list:
    """Arguments side by side, as `Function.map` takes them."""
    import casadi as ca

    result = []
    for i, rows in enumerate(arguments):
        pattern = function.sparsity_in(i)
        result.append(ca.horzcat(*(ca.DM(pattern, rows[:, k]) for k in range(points))))
    return result


def _rows(function, i: int, mapped: NDArray[np.float64], points: int) -> list[NDArray[np.float64]]:
    """Nonzeros of a result by point."""
    width = function.size2_out(i)
    blocks = mapped.reshape(mapped.shape[0], points, width)
    rows, columns = function.sparsity_out(i).get_triplet()
    return [blocks[r, :, c] for r, c in zip(rows, columns, strict=True)]


def compare(
    compiled: Compiled,
    inputs: Mapping[str, Array],
    got: Mapping[str, Array],
    seed: int,
    sine,
    reference: Reference | None = None,
) -> Proof:
    """Compare results with the interpreter, and with double precision."""
    difference = ""
    for name, want in exact_results(compiled, inputs, sine).items():
        unequal = got[name].view(np.uint32) != want.view(np.uint32)
        if unequal.any() and not difference:
            k = int(np.argmax(unequal))
            difference = f"{name}, tick {k} of seed {seed}: got {got[name][k]!r}, want {want[k]!r}"
    real, limit = bounds(compiled.graph, inputs)
    if reference is None:
        found = true_results(compiled.law, inputs)
        truth = {name: (value, np.zeros_like(value)) for name, value in found.items()}
    else:
        truth = reference(inputs)
    worst, where, unbounded, largest, within = 0.0, "", 0, {}, {}
    limits = {p.name: p.limits for p in compiled.law.of_kind("output") if p.limits}
    for name, (want, own) in truth.items():
        root = name.removesuffix("_next") if name not in limit else name
        error = np.abs(got[name].astype(np.float64) - want)
        share = error / np.maximum(limit[root] + own, 1e-300)
        share = np.where(error == 0, 0.0, share)
        unbounded += int(np.sum(~np.isfinite(limit[root])))
        largest[name] = float(error.max())
        if name in limits:
            within[name] = int(np.sum((want > limits[name][0]) & (want < limits[name][1])))
        if not share.max() <= worst:
            worst, where = float(share.max()), f"{name}, tick {int(np.argmax(share))}"
    count = len(next(iter(got.values())))
    return Proof(count, not difference, difference, worst, where, unbounded, largest, within, seed)
