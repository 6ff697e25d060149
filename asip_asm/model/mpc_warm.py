# SPDX-License-Identifier: Apache-2.0
"""Data memory of a program of model-predictive control that begins from a plan of the host."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.isa import default_isa
from asip_asm.model.mpc_problem import Problem
from asip_asm.model.mpc_program import slot_of
from asip_asm.model.read import ModelError


def warm_words(
    problem: Problem,
    configuration: str,
    states: ArrayLike,
    inputs: ArrayLike,
    window: ArrayLike | None = None,
    multipliers: tuple[ArrayLike, ArrayLike] | None = None,
) -> NDArray[np.float32]:
    """Words of data memory from address 0 on, to be written before a tick.

    states (steps, n): those after each step of the plan; inputs (steps, m). window (steps, n), with
    a trajectory: references of these states, of which the last comes with the tick. multipliers:
    those of the states' and of the inputs' limits, of the same shapes, by the penalty; zero
    without. A multiplier counts where a value is at its limit, and moves it elsewhere.
    Raises ModelError for arrays of other shapes or with entries that are not finite.
    """
    n, m, steps = problem.sizes
    shapes = ((steps, n), (steps, m))
    plan = [_array(name, value, shape) for name, value, shape in
            zip(("states", "inputs"), (states, inputs), shapes, strict=True)]  # fmt: skip
    given = multipliers if multipliers is not None else (np.zeros(shapes[0]), np.zeros(shapes[1]))
    parts = [_array("multipliers", value, shape) for value, shape in
             zip(given, shapes, strict=True)]  # fmt: skip
    lanes = default_isa().configurations[configuration].lanes
    slot = slot_of(problem, pulls=not lanes)
    memory = np.zeros((steps + (2 if lanes else 1), slot.size))
    limits = (lambda t: np.clip(t, *problem.state_box), problem.limited_inputs)
    fields = ((slot.w_x, slot.h_x), (slot.w_u, slot.h_u))
    for (first, second), value, part, limited in zip(fields, plan, parts, limits, strict=True):
        t = limited(value) + part
        v = limited(t)
        for i, offset in first.items():
            held = i in second or not lanes
            w = t[:, i] - problem.relaxation * v[:, i] if held else t[:, i]
            memory[1 : steps + 1, offset] = w  # a slot is before the first one
        for i, offset in second.items():
            memory[1 : steps + 1, offset] = t[:, i] - 2 * v[:, i]
    words = memory.ravel()
    if problem.reference != "trajectory":
        if window is not None:
            raise ModelError(f"{problem.title}: reference = '{problem.reference}' has no window")
        return words.astype(np.float32)
    wanted = np.zeros((steps, n)) if window is None else _array("window", window, shapes[0])
    pull = -wanted @ problem.q
    if lanes:
        pull /= np.where(problem.penalty[0] > 0, problem.penalty[0], 1.0)
    # The tick moves them on by a step and appends the reference of the tick before.
    memory[2:steps, slot.pull] = pull[: steps - 2]
    return np.concatenate((memory.ravel(), wanted[steps - 2])).astype(np.float32)


def _array(name: str, value: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    found = np.asarray(value, float)
    if found.shape != shape or not np.isfinite(found).all():
        raise ModelError(
            f"{name} of shape {found.shape}: give {shape[0]} steps of {shape[1]} finite numbers"
        )
    return found
