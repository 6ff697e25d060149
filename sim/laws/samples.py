# SPDX-License-Identifier: Apache-2.0
"""Inputs that belong together, for the proof of a law: measured values and set-points near them.

Set-points and positions drawn apart are radians apart, and every output is at its limit: the bits
and errors of such ticks are those of a constant. Here set-points are near the measured state, by a
share of the range that is drawn over seven decades; a tenth stays as far off as the limits let it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.exact import Array
from asip_asm.model.law import Law
from sim.laws.prove_program import CORNERS, Sample, draw, inside, walk

DECADES = 7.0
INSIDE = 0.75
"""Share of the starts inside the stated range of positions; the others are also beyond it."""


def near(law: Law) -> Sample:
    """Of a law of `laws`: goals, speeds and accelerations near what the encoders say."""
    goals = {
        port.name.replace("goal", "q"): port.limits
        for port in law.of_kind("input")
        if port.type != "int"
    }
    inner = replace(
        law,
        ports=[
            replace(port, limits=goals[port.name]) if port.name in goals and port.type == "int"
            else port
            for port in law.ports
        ],
    )  # fmt: skip

    def sample(size: int, rng: np.random.Generator) -> dict[str, Array]:
        drawn_from = inner if rng.random() < INSIDE else law
        return draw_near(drawn_from, size, rng)

    def draw_near(law: Law, size: int, rng: np.random.Generator) -> dict[str, Array]:
        inputs = {port.name: draw(port, size, rng) for port in law.of_kind("input")}
        measured: dict[str, NDArray[np.floating]] = {}
        for rate in law.of_kind("rate"):
            counts = inputs[rate.rate_of] = walk(law, rate, size, rng)
            moved = np.diff(counts, prepend=counts[:1])
            measured[rate.rate_of.replace("q", "speed")] = rate.scale * moved
        for port in law.of_kind("input"):
            if port.type == "int":
                position = port.scale * inputs[port.name] + port.offset
                measured[port.name.replace("q", "goal")] = position
        share = 10.0 ** rng.uniform(-DECADES, 0.0, size)
        share[rng.random(size) < CORNERS] = 1.0
        for port in law.of_kind("input"):
            if port.type != "int":
                drawn, at = inputs[port.name].astype(float), measured.get(port.name, 0.0)
                inputs[port.name] = inside(port, at + share * (drawn - at))
        return inputs

    return sample
