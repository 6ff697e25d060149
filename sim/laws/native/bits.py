# SPDX-License-Identifier: Apache-2.0
"""Comparison of a platform's results with the exact interpreter, bit by bit."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from asip_asm.machine import load_machine
from asip_asm.model.c_code import unfused
from asip_asm.model.compiler import Compiled
from asip_asm.model.emit import emit
from asip_asm.model.exact import Array, Sine, evaluate
from asip_asm.model.places import choose_places
from sim.laws.native.law import NativeLaw, Ran
from sim.laws.prove_program import BATCH, draw_ticks


def separate(compiled: Compiled) -> Compiled:
    """The program whose multiply-adds are a product and a sum."""
    graph, law, options = unfused(compiled.graph), compiled.law, compiled.options
    if compiled.plan is not None:
        return dataclasses.replace(compiled, graph=graph)
    machine = load_machine(options.configuration)
    places = choose_places(graph, law, machine, options.constants, options.registers)
    return dataclasses.replace(compiled, graph=graph, text=emit(graph, law, machine, places))


def first_difference(
    compiled: Compiled,
    ran: Ran,
    inputs: Mapping[str, Array],
    states: Mapping[str, Array],
    sine: Sine,
) -> str:
    """Text of the first result that has other bits than the interpreter's, empty if none has.

    inputs (N,) and the states (1,) before the first tick are those that `ran` comes from.
    """
    size = len(ran.results)
    values = dict(inputs)
    for name, after in ran.states.items():
        values[name] = np.concatenate((states[name], after[:-1]))
    for port in compiled.law.of_kind("parameter"):
        values[port.name] = np.full(size, port.initial, np.float32)
    nodes = evaluate(compiled.graph, values, sine)
    for name, root in (compiled.graph.outputs | compiled.graph.next_states).items():
        got = ran.states[name] if name in ran.states else ran.outputs[name]
        unequal = (got.view(np.uint32) != nodes[root].view(np.uint32)) & (ran.results == 0)
        if unequal.any():
            k = int(np.argmax(unequal))
            return f"{name}, tick {k}: got {got[k]!r}, want {nodes[root][k]!r}"
    return ""


def prove_c(compiled: Compiled, count: int, seed: int) -> str:
    """Compare the C on this machine with the interpreter over drawn inputs, multiply-adds rounded
    once and twice; text of the first difference, empty if there is none. Raises CompilerError.
    """
    for fused in (True, False):
        law = NativeLaw(compiled, fused)
        form = compiled if fused else separate(compiled)
        rng = np.random.default_rng(seed)
        for begin in range(0, count, BATCH):
            size = min(BATCH, count - begin)
            inputs, states = draw_ticks(compiled.law, size, rng)
            blank = (name for name, _ in law.words["states"] if name not in states)
            states |= {name: np.zeros(1, np.float32) for name in blank}
            ran = law.run(inputs, states)
            difference = first_difference(form, ran, inputs, states, law.sine)
            if difference:
                return f"{difference} (from tick {begin}, fused {int(fused)})"
    return ""
