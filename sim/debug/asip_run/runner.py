# SPDX-License-Identifier: Apache-2.0
"""One run of a program after another, with what `asip-run` shows of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from asip_asm.image import Image
from sim.core.backends import Observed
from sim.core.fault import NO_FAULT
from sim.debug.asip_run.inputs import UserError
from sim.debug.backend import open_backend
from sim.rtl.asip_bus import AsipError


@dataclass(frozen=True)
class Run:
    """Result of one run: flags {nv, dz, of, uf, nx}, words by name, text of a fault."""

    cause: str
    text: str
    flags: int
    words: dict[str, int]
    observed: Observed


def limit_note(result: Run, own: int, cycles: int) -> str:
    """What to add to the text of a fault where --max-cycles bounds the program's own watchdog."""
    if result.cause != "WATCHDOG" or own <= cycles:
        return ""
    return f"\n  stopped by --max-cycles {cycles}; the program's own watchdog is {own}"


@contextmanager
def user_errors(place: str) -> Iterator[None]:
    """What a core at a place of `open_backend` raises as an error of the user's."""
    errors: tuple[type[Exception], ...] = (AsipError,)
    if place == "rtl":  # the model and links need no Verilator
        from sim.rtl.runtime import BuildError

        errors += (BuildError,)
    try:
        yield
    except errors as error:
        raise UserError(str(error)) from None


class Runner:
    """A loaded program at a place of `open_backend`. Raises UserError where none is."""

    def __init__(self, image: Image, states: Mapping[str, int], place: str, trace: bool) -> None:
        self._place = place
        with user_errors(place):
            self._backend = open_backend(place, trace)
            self._backend.load(image)
            self._backend.preset(states)
        self._places = image.registers
        self._constants = {f"k{entry.index}": int(entry.bits, 16) for entry in image.constants}
        self._inputs = {f"k{entry.index}": entry.name for entry in image.inputs}

    def run(self, inputs: Mapping[str, int], names: Sequence[str]) -> Run:
        """Write inputs (words by name), run once and read `names`."""
        # The host cannot read bank K: what is there is known.
        known = self._constants | {place: inputs[name] for place, name in self._inputs.items()}
        held = {name: known.get(self._places.get(name, name)) for name in names}
        read = [name for name, word in held.items() if word is None]
        data = np.array([list(inputs.values())], dtype=np.uint32)
        with user_errors(self._place):
            self._backend.clear()
            runs = self._backend.run(list(inputs), data, read)
            observed = self._backend.observed()
        words = held | dict(zip(read, runs.words[-1].tolist(), strict=True))
        return Run(
            cause=runs.fault.cause if runs.fault else NO_FAULT,
            text=runs.text,
            flags=int(runs.flags[-1]),
            words={name: words[name] for name in names},
            observed=observed,
        )
