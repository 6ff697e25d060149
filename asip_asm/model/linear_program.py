# SPDX-License-Identifier: Apache-2.0
"""Program of a linear system, for instance an observer: x+ = A x + B w once a tick.

The state lies in data memory. The outputs of a tick are the new state. The rows of (A B) come from
the streams: four rows in each vector with lanes, else one word for each product.

The bound of roundings holds in every tick after the state was zero. A tick rounds each sum by

    r = gamma (|A| |x| + |B| |w|)   (Higham, Accuracy and Stability, section 3.1),

and roundings reach later ticks through A, so together they are at most S r with S = sum of |A^k|
over all k. With K such that |A^K| has a norm below 1, S <= (I - |A^K|)^-1 (sum of |A^k|, k < K).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asip_asm.machine import Machine
from asip_asm.model.law import Law, Port
from asip_asm.model.plan import Plan
from asip_asm.model.plan_items import PIPES, Vectors, Words
from asip_asm.model.read import ModelError

Matrix = NDArray[np.float64]
PARTS = 2
"""Sums of a vector, to be ready earlier."""
UNIT, SMALLEST = 2.0**-24, 2.0**-149
LONGEST, GROWN = 1 << 20, 1e100
"""Ticks within which a disturbance must halve; how much it may grow before."""


@dataclass(frozen=True)
class LinearSystem:
    """a: (n, n); b: (n, m); names and units of states and inputs; limits: (m,), largest size of
    each input; rate [Hz].
    """

    title: str
    a: Matrix
    b: Matrix
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    limits: Matrix
    rate: float
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]


def linear_law(system: LinearSystem) -> Law:
    """The system as a law, for interpreter and proofs; it has no function of its own."""
    ports = [
        Port("input", name, unit, "input", vector="w", limits=(-most, most))
        for name, unit, most in zip(system.inputs, system.input_units, system.limits, strict=True)
    ]
    ports += [
        Port("output", name, unit, "new state", vector="x")
        for name, unit in zip(system.states, system.state_units, strict=True)
    ]
    return Law(system.title, None, ports, rate=system.rate)  # type: ignore[arg-type]  # not evaluated: the plan is made from the matrices


def linear_plan(system: LinearSystem, machine: Machine) -> Plan:
    """The finished plan. Raises ModelError for what the core has no room for."""
    n = len(system.states)
    plan = Plan(system.title, system.inputs, dict.fromkeys(system.states, 0.0), machine)
    plan.spaces["state"] = n
    plan.reorder = True
    plan.rewind()
    operands = [*system.inputs, *(plan.load("state", i) for i in range(n))]
    matrix = np.hstack((system.b, system.a))
    lanes = 1 + machine.build.lanes
    found = (
        _in_lanes(plan, matrix, operands, lanes)
        if machine.build.lanes
        else plan.product(Words(matrix), operands)
    )
    for i, (name, value) in enumerate(zip(system.states, found, strict=True)):
        plan.store(value, "state", i)
        plan.op("mov", value, to=name)
    plan.finish()
    return plan


def _in_lanes(plan: Plan, matrix: Matrix, operands: list[str], lanes: int) -> list[str]:
    """The rows of matrix * operands, as numbers."""
    results = []
    for number, first in enumerate(range(0, len(matrix), lanes)):
        pipe = PIPES[number % len(PIPES)]
        rows = matrix[first : first + lanes]
        block = np.zeros((lanes, len(operands)))
        block[: len(rows)] = rows
        columns = np.flatnonzero(block.any(axis=0)).tolist() or [0]
        sums = []
        for part in range(min(PARTS, len(columns))):
            total = ""
            for j in columns[part::PARTS]:
                words = Vectors(block[:, j])
                total = (
                    plan.vector("vfmadd", words, operands[j], total, pipe=pipe)
                    if total
                    else plan.vector("vfmul", words, operands[j], pipe=pipe)
                )
            sums.append(total)
        total = plan.vector("vmadd", sums[0], 1.0, sums[1], pipe=pipe) if sums[1:] else sums[0]
        results += [
            plan.vector("vout", 0.0, total, pipe=pipe, lane=lane) for lane in range(len(rows))
        ]
    return results


def state_bounds(system: LinearSystem) -> tuple[Matrix, Matrix]:
    """Largest size of each state (n,), and largest distance (n,) of the program's state from that
    of exact arithmetic, in every tick, for inputs within their limits. Raises ModelError for a
    system that is not stable.
    """
    a, b = np.abs(system.a), np.abs(system.b)
    n, count = len(a), sum(system.b.shape)
    reach, response = np.zeros((n, n)), np.zeros(n)
    power, ticks = np.eye(n), 0
    while np.abs(power).sum(axis=1).max() >= 0.5 or not ticks:
        reach += np.abs(power)
        response += np.abs(power @ system.b) @ system.limits
        power, ticks = power @ system.a, ticks + 1
        if ticks > LONGEST or np.abs(power).max() > GROWN:
            raise ModelError(
                f"{system.title}: the state does not decay within {LONGEST} ticks; make A stable"
            )
    tail = np.linalg.inv(np.eye(n) - np.abs(power))
    reach, largest = tail @ reach, tail @ response
    gamma = 1.001 * (count + PARTS + 2) * UNIT  # a product, its sum and its rounded constant
    right = reach @ (gamma * (a @ largest + b @ system.limits) + count * SMALLEST)
    spread = gamma * reach @ a
    if np.abs(np.linalg.eigvals(spread)).max() >= 1:
        raise ModelError(f"{system.title}: roundings grow without a bound; let the state decay "
                         "in fewer ticks")  # fmt: skip
    return largest, np.linalg.inv(np.eye(n) - spread) @ right
