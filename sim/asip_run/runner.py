# SPDX-License-Identifier: Apache-2.0
"""One run of a program after another, with what `asip-run` shows of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from asip_asm.image import Image
from sim.asip_run.inputs import UserError
from sim.core_backends import BACKENDS, Observed
from sim.core_fault import NO_FAULT


@dataclass(frozen=True)
class Run:
    """Result of one run: flags {nv, dz, of, uf, nx}, words by name, text of a fault."""

    cause: str
    text: str
    flags: int
    words: dict[str, int]
    observed: Observed


class RunLimit:
    """Bounds the watchdog of an image by --max-cycles, and says so where that stops a run."""

    def __init__(self, image: Image, cycles: int) -> None:
        self.own = image.watchdog
        self.cycles = cycles
        image.watchdog = min(image.watchdog, cycles)

    def note(self, result: Run) -> str:
        """What to add to the text of a fault."""
        if result.cause != "WATCHDOG" or self.own <= self.cycles:
            return ""
        return (
            f"\n  stopped by --max-cycles {self.cycles}; the program's own watchdog is {self.own}"
        )


class Runner:
    """A loaded program on a backend of sim/core_backends.py. Raises UserError where none is."""

    def __init__(self, image: Image, states: Mapping[str, int], backend: str, trace: bool) -> None:
        self._errors: tuple[type[Exception], ...] = ()
        if backend == "rtl":  # Verilator is needed here only, not by the instruction-set model
            from sim.harness.asip_rtl import AsipError
            from sim.harness.build import BuildError

            self._errors = AsipError, BuildError
        try:
            self._backend = BACKENDS[backend](image, trace)
        except self._errors as error:
            raise UserError(str(error)) from None
        self._backend.preset(states)
        self._places = {entry.name: entry.register for entry in (*image.exports, *image.states)}
        self._constants = {f"k{entry.index}": int(entry.bits, 16) for entry in image.constants}
        self._inputs = {f"k{entry.index}": entry.name for entry in image.inputs}

    def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
        """Write inputs (words by name), run once and read `names`."""
        # The host cannot read bank K: what stands there is known.
        known = self._constants | {place: inputs[name] for place, name in self._inputs.items()}
        held = {name: known.get(self._places.get(name, name)) for name in names}
        read = [name for name, word in held.items() if word is None]
        self._backend.clear()
        data = np.array([list(inputs.values())], dtype=np.uint32)
        try:
            runs = self._backend.run(list(inputs), data, read)
        except self._errors as error:
            raise UserError(str(error)) from None
        words = held | dict(zip(read, runs.words[-1].tolist(), strict=True))
        return Run(
            cause=runs.fault.cause if runs.fault else NO_FAULT,
            text=runs.text,
            flags=int(runs.flags[-1]),
            words={name: words[name] for name in names},
            observed=self._backend.observed(),
        )
