# SPDX-License-Identifier: Apache-2.0
"""Proof that several functions of one image do not disturb each other: they run on one core in a
drawn order, and each has the bits of the exact interpreter from its own states.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from asip_asm.image import Image
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array
from sim.core.api import Core
from sim.laws.native.bits import first_difference
from sim.laws.native.law import Ran
from sim.laws.prove_program import draw_ticks, rounded_sine, unit_sine

TICKS = 1000
LONGEST = 7
"""Most ticks of a function before another one's turn."""


def prove_functions(
    compiled: Mapping[str, Compiled], image: Image, *, ticks: int, seed: int, backend: str = "rtl"
) -> str:
    """Text of the first difference in so many ticks of each function, empty if there is none.

    Raises CoreFault if the core stops.
    """
    rng = np.random.default_rng(seed)
    drawn = {name: draw_ticks(one.law, ticks, rng) for name, one in compiled.items()}
    done = dict.fromkeys(compiled, 0)
    found: dict[str, list[dict[str, Array]]] = {name: [] for name in compiled}
    with Core(image, backend=backend) as core:
        for name, (_, states) in drawn.items():
            core.select(name)
            core.preset({state: value[0].item() for state, value in states.items()})
        while left := [name for name in compiled if done[name] < ticks]:
            name = left[rng.integers(len(left))]
            begin, inputs = done[name], drawn[name][0]
            done[name] = min(ticks, begin + int(rng.integers(1, LONGEST + 1)))
            core.select(name)
            part = {signal: values[begin : done[name]] for signal, values in inputs.items()}
            names = {port.name for port in compiled[name].law.of_kind("export")}
            read = [*core.states, *sorted(names - {*core.states, *core.inputs})]
            found[name].append(core.batch(part, read=read).values)
    sine = unit_sine if backend == "rtl" else rounded_sine
    for name, one in compiled.items():
        inputs, states = drawn[name]
        values = {
            key: np.concatenate([part[key] for part in found[name]]) for key in found[name][0]
        }
        after = {state: values[state].view(states[state].dtype) for state in states}
        outputs = {key: value for key, value in values.items() if key not in after}
        ran = Ran(outputs, after, np.zeros(ticks, np.int32))
        difference = first_difference(one, ran, inputs, states, sine)
        if difference:
            return f"{name}: {difference}"
    return ""
