# SPDX-License-Identifier: Apache-2.0
"""What each option of the compiler does to a program: cycles, and error bounds of its results."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from asip_asm.machine import RUN_OVERHEAD, load_machine
from asip_asm.model.bound import bounds
from asip_asm.model.compiler import Compiled, Options, compile_law, trial_cycles
from asip_asm.model.exact import Array
from asip_asm.model.law import Law
from sim.prove_program import draw_ticks

POINTS = 200


def effects(compiled: Compiled, seed: int) -> str:
    """Table: the program beside those with one option changed, each by a short search.

    Bounds are means over drawn inputs, as multiples of this program's, over all results.
    """
    law, options = compiled.law, compiled.options
    forms = {"this program": options}
    for name in ("reassociate", "reciprocal"):
        on = getattr(options, name)
        forms[f"{'without' if on else 'with'} --{name}"] = replace(options, **{name: not on})
    other = "unit" if options.sine == "balanced" else "balanced"
    forms[f"--sine {other}"] = replace(options, sine=other)
    inputs = _inputs(law, np.random.default_rng(seed))
    own: dict[str, float] = {}
    lines = [f"{'options':<24}{'cycles':>8}  bounds of the results beside this program's"]
    for name, form in forms.items():
        cycles, means = _form(law, form, compiled if form == options else None, inputs)
        own = own or means
        ratios = [means[key] / own[key] for key in own if own[key] > 0] or [1.0]
        lines.append(f"{name:<24}{cycles:>8}  {min(ratios):.2f} to {max(ratios):.2f}")
    on_pipes = sum(mark.endswith("_turns") for mark, _ in compiled.graph.functions.values())
    unit = sum(node.op in ("fsin", "fcos") for _, node in compiled.graph.operations())
    lines.append(f"sines and cosines: {unit} on the sine unit, {on_pipes} on the pipes")
    return "\n".join(lines) + "\n"


def _inputs(law: Law, rng: np.random.Generator) -> dict[str, Array]:
    inputs, states = draw_ticks(law, POINTS, rng)
    for name, value in states.items():
        inputs[name] = np.full(POINTS, value[0])
    for port in law.of_kind("parameter"):
        inputs[port.name] = np.full(POINTS, port.initial, np.float32)
    return inputs


def _form(
    law: Law, options: Options, compiled: Compiled | None, inputs: dict[str, Array]
) -> tuple[int, dict[str, float]]:
    """Cycles, and mean bound of each result."""
    compiled = compiled or compile_law(law, options)
    machine = load_machine(options.configuration)
    _, limits = bounds(compiled.graph, inputs)
    means = {name: float(np.mean(limit)) for name, limit in limits.items()}
    return trial_cycles(compiled.graph, machine) + RUN_OVERHEAD, means
