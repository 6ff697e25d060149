# SPDX-License-Identifier: Apache-2.0
"""Proof of a program of model-predictive control: bits, cycles, and distance from double precision.

The program runs on the core for some ticks from memories as loaded, then again with other inputs.
The exact interpreter computes the same ticks from the graph, all runs at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import evaluate
from asip_asm.model.mpc_bound import input_bounds
from asip_asm.model.mpc_problem import Problem
from asip_asm.pace import Pace
from sim.core.api import Core
from sim.laws.mpc_reference import Reference
from sim.laws.prove_program import draw, rounded_sine

TICKS = 20
"""Ticks from memories as loaded, each but the first one warm from the one before."""
SEED = 1
Single = NDArray[Any]


@dataclass(frozen=True)
class MpcProof:
    """Ticks tried; runs whose cycles are not those announced; first word unlike the interpreter's,
    empty if none; worst distance of an input of the plant from double precision after the first
    tick, and as a share of its bound for the inputs tried; and after all ticks.
    """

    ticks: int
    other_cycles: int
    difference: str
    error: float
    share: float
    warm_error: float

    @property
    def passed(self) -> bool:
        return not self.other_cycles and not self.difference and self.share <= 1

    def lines(self) -> list[str]:
        """Text for people."""
        bits = self.difference or "bits equal the exact interpreter's"
        cycles = f"; {self.other_cycles} runs took other cycles" if self.other_cycles else ""
        return [
            f"{self.ticks} ticks: {bits}{cycles}",
            f"distance from double precision: {self.error:.2g} in a first tick, {self.share:.2g} "
            f"of its bound; {self.warm_error:.2g} in {TICKS} warm ticks",
        ]


def prove_mpc(
    problem: Problem, compiled: Compiled, image: Image, count: int, seed: int = SEED,
    backend: str = "rtl",
) -> MpcProof:  # fmt: skip
    """Run `count` drawn ticks and compare. Raises CoreFault if the core stops."""
    law, runs = compiled.law, max(1, count // TICKS)
    rng = np.random.default_rng(seed)
    ports = law.of_kind("input")
    given = {
        port.name: np.asarray(draw(port, runs * TICKS, rng)).reshape(runs, TICKS) for port in ports
    }
    names = [port.name for port in law.of_kind("output")]
    got, cycles = on_core(image, given, names, backend)
    want, difference = interpreted(compiled, given, names), ""
    for name in names:
        unequal = got[name].view(np.uint32) != want[name].view(np.uint32)
        if unequal.any() and not difference:
            run, tick = np.argwhere(unequal)[0]
            difference = (
                f"{name}, run {run} tick {tick} of seed {seed}: got {got[name][run, tick]!r}, want "
                f"{want[name][run, tick]!r}"
            )
    other = int((cycles != image.cycles).sum()) if cycles is not None else 0
    reference = Reference(problem, runs)
    n = len(problem.states)
    errors = np.zeros((TICKS, runs, len(problem.inputs)))
    bound = np.zeros(len(problem.inputs))
    for tick in range(TICKS):
        values = np.stack([given[port.name][:, tick] for port in ports], axis=1).astype(float)
        u = reference.tick(values[:, :n], values[:, n:] if len(ports) > n else None)["u"]
        if tick == 0:
            bound = input_bounds(problem, reference.pulls)
        errors[tick] = np.abs(u - np.stack([got[i][:, tick] for i in problem.inputs], axis=1))
    first = errors[0].max(axis=0)
    return MpcProof(
        runs * TICKS, other, difference, float(first.max()),
        float((first / bound).max()), float(errors.max()),
    )  # fmt: skip


def on_core(
    image: Image, given: dict[str, Single], names: list[str], backend: str
) -> tuple[dict[str, Single], NDArray | None]:
    """Outputs (runs, ticks) of inputs (runs, ticks), each run from memories as loaded; cycles.

    Between runs only states and data memory are restored: a program writes nothing else.
    """
    found: dict[str, list[Single]] = {name: [] for name in names}
    cycles = []
    runs, ticks_of_run = next(iter(given.values())).shape
    data = [int(word, 16) for word in image.data]
    pace = Pace("proof: ticks", runs * ticks_of_run)
    with Core(image, backend=backend) as core:
        for run in range(runs):
            pace.at(run * ticks_of_run)
            core.clear()
            core.backend.write_data(0, data)
            ticks = core.batch({name: value[run] for name, value in given.items()})
            for name in names:
                found[name].append(ticks[name])
            if ticks.cycles is not None:
                cycles.append(ticks.cycles)
    return {n: np.stack(v) for n, v in found.items()}, np.stack(cycles) if cycles else None


def interpreted(
    compiled: Compiled, given: dict[str, Single], names: list[str]
) -> dict[str, Single]:
    """The same by the exact interpreter, all runs at once."""
    graph = compiled.graph
    runs, ticks = next(iter(given.values())).shape
    states: dict[str, Single] = {name: np.zeros(runs, np.float32) for name in graph.next_states}
    found: dict[str, list[Single]] = {name: [] for name in names}
    for tick in range(ticks):
        values = {name: value[:, tick] for name, value in given.items()}
        nodes = evaluate(graph, values | states, rounded_sine)
        states = {name: nodes[root] for name, root in graph.next_states.items()}
        for name in names:
            found[name].append(nodes[graph.outputs[name]])
    return {name: np.stack(values, axis=1) for name, values in found.items()}
