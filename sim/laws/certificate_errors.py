# SPDX-License-Identifier: Apache-2.0
"""Largest errors of a compiled law at random inputs of its certificate's box, to compare the bounds
with: the exact interpreter against the law in double precision, without a core.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.certificate import Certificate
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array
from asip_asm.model.law import before
from sim.laws.prove_casadi import truth_of
from sim.laws.prove_program import Sample, draw, exact_results

PART = 10_000
"""Inputs at once."""
ENDS = 0.1
"""Share of the values that are at an end of their range."""
Errors = dict[str, float]


def largest_errors(
    compiled: Compiled,
    certificate: Certificate,
    count: int,
    seed: int,
    sample: Sample | None = None,
) -> Errors:
    """Largest error of every result. Half of the inputs are uniform in the box, the others are
    `sample`'s, which belong together, if there is one.
    """
    rng = np.random.default_rng(seed)
    worst: Errors = {}
    for values in _inputs(compiled, certificate, count, rng, sample):
        inside = certificate.covers(values)
        got = exact_results(compiled, values, sine_in_double)
        for name, want in truth_of(compiled.law)(values).items():
            error = np.abs(got[name].astype(np.float64) - want)[inside]
            worst[name] = max(worst.get(name, 0.0), float(error.max(initial=0.0)))
    return worst


def sine_in_double(angles: NDArray[np.float32], cosine: bool) -> NDArray[np.float32]:
    """Sine or cosine rounded from double precision."""
    wide = angles.astype(np.float64)
    return (np.cos(wide) if cosine else np.sin(wide)).astype(np.float32)


def _inputs(
    compiled: Compiled,
    certificate: Certificate,
    count: int,
    rng: np.random.Generator,
    sample: Sample | None,
) -> Iterator[dict[str, Array]]:
    done = 0
    while done < count:
        size = min(PART, count - done)
        values = uniform(certificate, size, rng)
        if sample is not None and (done // PART) % 2:
            values |= _together(compiled, values, size, rng, sample)
        yield values
        done += size


def uniform(certificate: Certificate, size: int, rng: np.random.Generator) -> dict[str, Array]:
    """Inputs, states, parameters (size,) from the box, a tenth of each at an end of its range."""
    values: dict[str, Array] = {}
    for each in certificate.inputs:
        drawn = rng.uniform(each.low, each.high, size)
        ends = np.where(rng.random(size) < 0.5, each.low, each.high)
        drawn = np.where(rng.random(size) < ENDS, ends, drawn)
        if each.of:
            now = values[each.of].astype(np.float64)
            last = now - np.rint(drawn) if each.whole else now - drawn
            kind = values[each.of].dtype
            values[each.state] = (last + each.offset).astype(kind)
        elif each.whole:
            values[each.name] = np.rint(drawn).astype(np.int32)
        elif each.name not in values:
            values[each.name] = np.clip(drawn.astype(np.float32), each.low, each.high).astype(
                np.float32
            )
    return values


def _together(
    compiled: Compiled,
    values: Mapping[str, Array],
    size: int,
    rng: np.random.Generator,
    sample: Sample,
) -> dict[str, Array]:
    """Inputs of consecutive ticks as `sample` draws them, and the counts before them."""
    found = sample(size, rng)
    for rate in compiled.law.of_kind("rate"):
        counts = found[rate.rate_of]
        found[before(rate.rate_of)] = np.concatenate((counts[:1], counts[:-1]))
    for port in compiled.law.of_kind("state"):
        if port.name in found and len(found[port.name]) != size:
            found[port.name] = draw(port, size, rng)
    return found
