# SPDX-License-Identifier: Apache-2.0
"""Proof of a compiled law: bits against the exact interpreter, values against double precision.

The program runs on the core over drawn inputs. All inputs at zero, at their lower and at their
upper limits, and a user's points, are always among them (`sim.laws.prove_points` yields them).
Every tick's outputs and next states must have the bits that `asip_asm.model.exact` computes from
the same inputs and the states that the core held before; and must be as near to the user's own
model in double precision (`sim.laws.prove_reference`) as `asip_asm.model.bound` derives.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.bound import bounds
from asip_asm.model.certificate import Certificate
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array, evaluate
from asip_asm.model.law import Law, Port, before
from asip_asm.pace import Pace
from sim.core.api import Core
from sim.laws.prove_casadi import truth_of
from sim.laws.prove_reference import RobotTruth, Truth

SEED = 1
COUNT = 10_000
BATCH = 20
"""Ticks from one random start of the states and encoders."""
CORNERS = 0.1
"""Share of values that are corners of their range."""


CONSTANT = 2.0**-20
"""A bound below this share of a result's size means something even if the result never moves."""


@dataclass(frozen=True)
class Check:
    """Largest error of a result [unit] inside the certificate's box, and the certificate's bound;
    low, high: values of the law that the inputs reached.

    A bound of half their range or more means nothing: a constant would be as near to the law.
    """

    unit: str
    error: float
    bound: float
    low: float
    high: float

    @property
    def share(self) -> float:
        return 0.0 if self.error == 0 else self.error / max(self.bound, 1e-300)

    @property
    def holds(self) -> bool:
        return self.error <= self.bound

    @property
    def meaningful(self) -> bool:
        size = max(abs(self.low), abs(self.high))
        return self.bound < 0.5 * (self.high - self.low) or self.bound <= CONSTANT * size


@dataclass(frozen=True)
class Proof:
    """What a proof found. worst: largest error as a share of its bound, over all inputs and
    results, and the result where; unbounded: results without a finite bound, which prove nothing.
    within: of each output, inputs where it is inside its limits; at a limit it is a constant, whose
    error says nothing. first_difference: text, empty if all bits agree. checks: of each result,
    against the certificate, if there is one.
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
    certificate: Certificate | None = None
    checks: Mapping[str, Check] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        sampled = self.bits_equal and self.worst_fraction_of_bound < 1 and not self.unbounded
        whole = self.certificate is None or self.certificate.finite
        return sampled and whole and all(c.holds and c.meaningful for c in self.checks.values())


@functools.cache
def _sine_unit():
    from sim.core.fpbench.native import Unit

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


def inside(port: Port, values: NDArray[np.floating]) -> NDArray[np.float32]:
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
    truth: Truth | RobotTruth | None = None,
    certificate: Certificate | None = None,
    points: Iterable[tuple[dict[str, Array], dict[str, Array]]] = (),
) -> Proof:
    """Run `points` and `count` drawn ticks of the program and compare.

    truth: the user's own model (None: the function and ports of a law that was made in Python).
    points: inputs of ticks and the states before them. Raises CoreFault if the core stops,
    ModelError if the user's model cannot be evaluated.
    """
    law = compiled.law
    rng = np.random.default_rng(seed)
    outputs = [port.name for port in law.ports if port.kind in ("output", "export")]
    values: dict[str, list[Array]] = {}
    results: dict[str, list[Array]] = {}
    with Core(image, backend=backend) as core:
        sizes = (min(BATCH, count - begin) for begin in range(0, count, BATCH))
        drawn = (draw_ticks(law, size, rng, sample) for size in sizes)
        pace, done = Pace("proof: inputs", count), 0
        for inputs, states in itertools.chain(points, drawn):
            pace.at(done)
            done += len(next(iter(inputs.values()), ()))
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
        size = len(next(iter(inputs.values())))
        inputs[port.name] = np.full(size, port.initial, np.float32)
    got = {name: np.concatenate(parts) for name, parts in results.items()}
    sine = unit_sine if backend == "rtl" else rounded_sine
    truth = truth or truth_of(law)
    proof = compare(compiled, inputs, got, seed, sine, truth, certificate)
    differs = truth.difference(image) if isinstance(truth, Truth) else truth.difference(law)
    if differs and not proof.first_difference:
        proof = replace(proof, bits_equal=False, first_difference=differs)
    return proof


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
    from sim.core.iss.arithmetic import sincos_rounded

    words = np.ascontiguousarray(angles).view(np.uint32)
    bits = [sincos_rounded(int(word), cosine)[0] for word in words]
    return np.array(bits, np.uint32).view(np.float32)


def exact_results(compiled: Compiled, inputs: Mapping[str, Array], sine) -> dict[str, Array]:
    """Outputs and next states (`<state>_next`) by the exact interpreter."""
    nodes = evaluate(compiled.graph, inputs, sine)
    found = {name: nodes[root] for name, root in compiled.graph.outputs.items()}
    return found | {f"{n}_next": nodes[root] for n, root in compiled.graph.next_states.items()}


def _rates(law: Law) -> set[str]:
    """Results that no user's model has: the counts of the next tick's rates."""
    return {f"{before(port.rate_of)}_next" for port in law.of_kind("rate")}


def compare(
    compiled: Compiled,
    inputs: Mapping[str, Array],
    got: Mapping[str, Array],
    seed: int,
    sine: Callable,
    truth: Truth | RobotTruth | None = None,
    certificate: Certificate | None = None,
) -> Proof:
    """Compare results with the interpreter, with double precision, and with the certificate."""
    difference = ""
    for name, bits in exact_results(compiled, inputs, sine).items():
        unequal = got[name].view(np.uint32) != bits.view(np.uint32)
        if unequal.any() and not difference:
            k = int(np.argmax(unequal))
            difference = f"{name}, tick {k} of seed {seed}: got {got[name][k]!r}, want {bits[k]!r}"
    real, limit = bounds(compiled.graph, inputs)
    found = (truth or truth_of(compiled.law))(inputs)
    want_of = {n: v if isinstance(v, tuple) else (v, np.zeros_like(v)) for n, v in found.items()}
    if missing := sorted(set(got) - _rates(compiled.law) - set(want_of)):
        difference = difference or f"the user's model gives no {', '.join(missing)}"
    worst, where, unbounded, largest, within = 0.0, "", 0, {}, {}
    limits = {p.name: p.limits for p in compiled.law.of_kind("output") if p.limits}
    for name, (want, own) in want_of.items():
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
    checks = _checks(certificate, inputs, got, want_of) if certificate else {}
    return Proof(
        count, not difference, difference, worst, where, unbounded, largest, within, seed,
        certificate, checks,
    )  # fmt: skip


def _checks(
    certificate: Certificate,
    inputs: Mapping[str, Array],
    got: Mapping[str, Array],
    wanted: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> dict[str, Check]:
    """Errors in the certificate's box, less those that `wanted` may have of its own; ticks that
    began with a state outside of it do not count.
    """
    inside = certificate.covers(inputs)
    found = {}
    for name, bound in certificate.bounds.items():
        want, own = (part[inside] for part in wanted[name])
        error = np.maximum(np.abs(got[name].astype(np.float64)[inside] - want) - own, 0.0)
        low, high = float(want.min(initial=np.inf)), float(want.max(initial=-np.inf))
        largest = float(error.max(initial=0.0))
        found[name] = Check(bound.unit, largest, bound.bound, low, high)
    return found
