# SPDX-License-Identifier: Apache-2.0
"""The C of a compiled tracking law, with the bits of its program, as a controller of the main job's
closed loop.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.compiler import Compiled
from asip_asm.model.law import before
from sim.core.controller import ControllerFault, LawTicks, one_tick
from sim.laws.native.law import NativeLaw
from sim.robot.records import OUTPUTS, Counts, Floats


class NativeController:
    """Inputs of the law: 15 set-points, five counts, in this order; outputs F1 .. tau5.

    states: arrays (1,) by name, as the next tick takes them.
    """

    def __init__(self, compiled: Compiled) -> None:
        self._law, self._source = NativeLaw(compiled), compiled.law
        self._inputs = self._source.of_kind("input")
        self.states: dict[str, NDArray] = {}

    def prime(self, words: Floats, counts: Counts) -> None:
        """States before the first tick, with its counts as the last ones."""
        self.states = {
            port.name: np.array([port.initial], np.float32)
            for port in self._source.of_kind("state")
        }
        named = self._row(words, counts)
        for port in self._source.of_kind("rate"):
            self.states[before(port.rate_of)] = named[port.rate_of]

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick; set-points are rounded to binary32. Raises ControllerFault."""
        ran = self._law.run(self._row(words, counts), self.states)
        if ran.results[0]:
            raise ControllerFault(f"{self._source.title}: an output is no number")
        self.states = {name: values[-1:] for name, values in ran.states.items()}
        return one_tick(float(ran.outputs[name][0]) for name in OUTPUTS)

    def _row(self, words: Floats, counts: Counts) -> dict[str, NDArray]:
        values = (*np.asarray(words, np.float32), *np.asarray(counts, np.int32))
        return {
            port.name: np.atleast_1d(value)
            for port, value in zip(self._inputs, values, strict=True)
        }
