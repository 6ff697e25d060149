# SPDX-License-Identifier: Apache-2.0
"""A program on a core as a Python object, for a control loop of one's own (docs/own_machine.md).

    core = Core("axis.s")
    out = core.tick(goal=0.1, count=1234)     # {"force": ...}
    core.read("speed"), core.cycles

Values go by the names of the program. Floats are rounded to binary32 (NaN and infinity pass: the
core shall show what it does with them), values declared `int` are int32. Inputs keep their value
from tick to tick and are 0 at first.
"""

from __future__ import annotations

import operator
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.assemble import assemble
from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.core.backends import BACKENDS, Backend, Runs, unknown
from sim.core.fault import Fault

CURES = {
    "ILLEGAL": "the image is damaged or for another core: assemble the program again",
    "ADDRESS": "keep indices inside their tables, with fmin and fmax before f2i",
    "WATCHDOG": "look for a loop without end, or raise .watchdog",
    "NOT_FINITE": "keep operands in their range with fsat, fmin, fmax, and inputs finite",
    "MEMORY": "load the program again: a bit of a memory of the core has changed",
    "CONTROL": "load the program again: a bit of a register of the core has changed",
    "DISAGREE": "load the program again; if it comes back, the core is damaged",
    "IMPLAUSIBLE": "find out which output jumped, or widen its record (asip_set_plausible)",
    "OUTPUT_MISSING": "write every output on every path through the program",
}
INT32 = (-(1 << 31), (1 << 31) - 1)


class CoreError(ValueError):
    """The core was used wrongly: an unknown name, a value of the wrong type, a closed core."""


class CoreFault(RuntimeError):
    """The core stopped a tick; the text names tick, cause, place in the source and the cure.

    tick: number of the tick since the core was made, from 0. cause: name in docs/regmap.md.
    outputs: the safe values, by name. before: the ticks of the batch before the fault.
    """

    def __init__(
        self, text: str, tick: int, cause: str, outputs: dict[str, float], before: Ticks
    ) -> None:
        super().__init__(text)
        self.tick, self.cause, self.outputs, self.before = tick, cause, outputs, before


@dataclass(frozen=True)
class Ticks:
    """N consecutive ticks: values (N,) by name, clock cycles (N,) (None on the instruction-set
    model, which has no clock), IEEE 754 exceptions (N,) as bits NV DZ OF UF NX, 4..0.

    Floats are binary32: their bits are `values[name].view(np.uint32)`.
    """

    values: dict[str, NDArray[Any]]
    cycles: NDArray[np.uint32] | None
    flags: NDArray[np.uint8]

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.values[name]


class Core:
    """One core with one program, loaded and with its states at their initial values.

    program: source text, image file (*.json) or image. configuration: 'fast', 'small', 'stream' or
    'wide'; None leaves it to the program. defines: values of its parameters (`.param`); params:
    file to read in place of the one that `.params` names. backend: 'rtl', the Verilated core, built
    at first use (a minute or two), 'iss', the instruction-set model, or a `Backend` that exists,
    for example `sim.debug.backend.open_backend("serial:/dev/ttyUSB0")`, a board.
    inputs, outputs, states, exports: names, in the order of the program.
    Raises AssemblyError, ImageError, OSError for the program, CoreError for the rest.
    """

    def __init__(
        self,
        program: Image | Path | str,
        *,
        configuration: str | None = None,
        defines: Mapping[str, float] | None = None,
        params: Path | None = None,
        backend: str | Backend = "rtl",
    ) -> None:
        if isinstance(backend, str) and backend not in BACKENDS:
            raise CoreError(f"no backend '{backend}'; there are {', '.join(BACKENDS)}")
        self._whole = _image(program, configuration, defines, params)
        self.ticks = 0
        self.cycles: int | None = None
        self.flags = 0
        self._fault = ""
        self._name(self._whole)
        where = BACKENDS[backend]() if isinstance(backend, str) else backend
        where.load(self.image)
        self._backend: Backend | None = where
        if self._whole.functions:
            self.select(self._whole.functions[0].name)

    def select(self, function: str) -> None:
        """Go on with a function of an image with several: the next ticks are its, by its names.

        The states of all functions persist. Inputs are 0 until they are set again. The first one
        is selected at the start. Raises ImageError for an unknown function.
        """
        view = self._whole.function(function)
        self.backend.select(view)
        self._name(view)

    def _name(self, image: Image) -> None:
        self.image = image
        self.inputs = tuple(entry.name for entry in image.inputs)
        self.outputs = tuple(entry.name for entry in image.outputs)
        self.states = tuple(entry.name for entry in image.states)
        self.exports = tuple(entry.name for entry in image.exports)
        self._kinds = dict(image.types)
        self._inputs = {entry.name: 0 for entry in self.image.inputs}
        self._constants = {entry.name: int(entry.bits, 16) for entry in self.image.constants}
        self._kinds |= {entry.name: entry.type for entry in self.image.constants}
        bank_k = {f"k{e.index}": e.name for e in self.image.inputs}
        bank_k |= {f"k{e.index}": e.name for e in self.image.constants}
        exports = ((e.name, e.register) for e in self.image.exports)
        self._same = {name: bank_k[place] for name, place in exports if place in bank_k}

    # ------------------------------------------------------------------ life
    def close(self) -> None:
        """Free the model; the object is of no use afterwards."""
        backend = getattr(self, "_backend", None)
        if backend is not None:
            backend.close()
            self._backend = None

    def __enter__(self) -> Core:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def backend(self) -> Backend:
        """The model itself: with 'rtl' its member `rtl` gives the bus, clock and traces."""
        if self._backend is None:
            raise CoreError("the core is closed; make another Core")
        return self._backend

    # ------------------------------------------------------------------ values in
    def set(self, values: Mapping[str, float] | None = None, /, **named: float) -> None:
        """Inputs by name, from the next tick on."""
        given = {**(values or {}), **named}
        words = {name: self._word("input", name, self._inputs, v) for name, v in given.items()}
        self._inputs.update(words)

    def set_words(self, values: Mapping[str, int] | None = None, /, **named: int) -> None:
        """Inputs as raw 32-bit words."""
        given = {**(values or {}), **named}
        for name in given:
            _known("input", name, self._inputs)
        self._inputs.update({name: _raw(name, word) for name, word in given.items()})

    def preset(self, values: Mapping[str, float] | None = None, /, **named: float) -> None:
        """States by name, for the next tick."""
        given = {**(values or {}), **named}
        words = {name: self._word("state", name, self.states, v) for name, v in given.items()}
        self.backend.preset(words)

    def preset_data(self, address: int, values: ArrayLike) -> None:
        """Words of data memory from an address on as floats, for the next tick."""
        words = np.asarray(values, np.float32).ravel().view(np.uint32)
        room = default_isa().data_words
        if address < 0 or address + len(words) > room:
            raise CoreError(
                f"{len(words)} words from address {address} on: data memory has {room} words"
            )
        self.backend.write_data(address, words.tolist())

    # ------------------------------------------------------------------ ticks
    def tick(
        self, values: Mapping[str, float] | None = None, /, **named: float
    ) -> dict[str, float]:
        """Set the inputs given and run one tick; the outputs by name. Raises CoreFault.

        `cycles` and `flags` are those of this tick then.
        """
        self.set(values, **named)
        data = np.array([list(self._inputs.values())], dtype=np.uint32)
        ticks = self._run(data, ())
        return {name: float(values[0]) for name, values in ticks.values.items()}

    def batch(self, inputs: Mapping[str, ArrayLike], read: Sequence[str] = ()) -> Ticks:
        """Consecutive ticks in one call, inputs (N,) by name; those not given keep their value.

        The outputs of every tick, and what `read` names (exports, states). Raises CoreFault at the
        first fault, with the ticks before it.
        """
        columns = {n: self._column(n, values) for n, values in inputs.items()}
        lengths = {len(column) for column in columns.values()}
        if len(lengths) != 1:
            given = ", ".join(f"{name} {len(column)}" for name, column in columns.items())
            raise CoreError(f"a batch needs inputs of one length; given are {given or 'none'}")
        ticks = lengths.pop()
        data = np.empty((ticks, len(self._inputs)), dtype=np.uint32)
        for i, (name, word) in enumerate(self._inputs.items()):
            data[:, i] = columns.get(name, word)
        for name in read:
            self._check_readable(name)
        return self._run(data, read)

    def clear(self) -> None:
        """End a fault: ticks run again, the states have their initial values (after a fault they
        may hold anything), inputs and data memory what they had."""
        self.backend.preset({state.name: int(state.bits, 16) for state in self.image.states})
        self._fault = ""

    # ------------------------------------------------------------------ values out
    def read(self, name: str) -> float | int:
        """An output, export, state, input or constant by its type; a register ('c12') as a float.

        An export that is neither input nor state is taken for a float: the image does not say more
        (`read_word` gives the bits).
        """
        word = np.uint32(self.read_word(name))
        return int(word.view(np.int32)) if self._is_int(name) else float(word.view(np.float32))

    def read_word(self, name: str) -> int:
        """The 32 bits of what `read` names."""
        backend = self.backend
        self._check_readable(name)
        held = self._held(name)
        return backend.read_name(name) if held is None else held

    # ------------------------------------------------------------------ inside
    def _is_int(self, name: str) -> bool:
        return self._kinds.get(self._same.get(name, name)) == "int"

    def _held(self, name: str) -> int | None:
        """Word of a name of bank K, which the host cannot read back."""
        name = self._same.get(name, name)
        return self._inputs.get(name, self._constants.get(name))

    def _check_readable(self, name: str) -> None:
        if self._held(name) is None and self.backend.place(name) is None:
            known = [*self.outputs, *self.exports, *self.states, *self._inputs, *self._constants]
            _known("output, export, state, input, constant or register", name, known)

    def _word(self, what: str, name: str, known: Collection[str], value: Any) -> int:
        _known(what, name, known)
        where = f"{what} {name}"
        if not isinstance(value, Real):
            raise CoreError(f"{where}: {value!r} is not a number; a batch takes arrays")
        if not self._is_int(name):
            try:
                return int.from_bytes(struct.pack("<f", float(value)), "little")
            except OverflowError:
                raise CoreError(f"{where}: {value} is too large for binary32") from None
        if not isinstance(value, Integral):
            raise CoreError(f"{where} is an int32, got {value!r}; round it: round(x)")
        word = int(value)
        if not INT32[0] <= word <= INT32[1]:
            raise CoreError(f"{where}: {value} is outside of int32, {INT32[0]} to {INT32[1]}")
        return word & 0xFFFFFFFF

    def _column(self, name: str, values: ArrayLike) -> NDArray[np.uint32]:
        _known("input", name, self._inputs)
        column = np.asarray(values)
        where = f"input {name}"
        if column.ndim != 1 or column.dtype.kind not in "biuf":
            raise CoreError(
                f"{where}: a batch takes an array of numbers, one per tick; got shape "
                f"{column.shape} of {column.dtype}"
            )
        if self._is_int(name):
            if column.dtype.kind == "f":
                raise CoreError(f"{where} is an int32, got {column.dtype}; np.rint(x).astype(int)")
            if len(column) and not INT32[0] <= column.min() <= column.max() <= INT32[1]:
                raise CoreError(
                    f"{where}: {column.min()} to {column.max()} is outside of int32, "
                    f"{INT32[0]} to {INT32[1]}"
                )
            return column.astype(np.int32).view(np.uint32)
        with np.errstate(over="ignore"):
            single = column.astype(np.float32)
        lost = np.isinf(single) & np.isfinite(column)
        if lost.any():
            raise CoreError(f"{where}: {column[lost][0]} is too large for binary32")
        return single.view(np.uint32)

    # ------------------------------------------------------------------ inside
    def _run(self, data: NDArray[np.uint32], read: Sequence[str]) -> Ticks:
        """Run a tick per row of data, columns in the order of the inputs."""
        backend = self.backend
        if self._fault:
            raise CoreError(
                f"the core is in a fault ({self._fault}); clear() ends it and gives the states "
                "their initial values"
            )
        names = [*self.outputs, *(name for name in read if self._held(name) is None)]
        runs = backend.run(list(self._inputs), data, names)
        if len(data):
            self._inputs.update(zip(self._inputs, data[len(runs.flags) - 1].tolist(), strict=True))
        ticks = self._ticks(runs, data, names, read)
        if len(data):
            self.flags = int(ticks.flags[-1])
            self.cycles = None if ticks.cycles is None else int(ticks.cycles[-1])
        self.ticks += len(ticks.flags)
        if runs.fault is not None:
            self._fail(runs.fault, runs, ticks)
        return ticks

    def _ticks(
        self, runs: Runs, data: NDArray[np.uint32], names: Sequence[str], read: Sequence[str]
    ) -> Ticks:
        n = len(runs.flags)
        columns = dict(zip(names, np.ascontiguousarray(runs.words.T), strict=True))
        inputs = list(self._inputs)
        for name in read:
            held = self._same.get(name, name)
            if held in self._inputs:
                columns[name] = np.ascontiguousarray(data[:n, inputs.index(held)])
            elif held in self._constants:
                columns[name] = np.full(n, self._constants[held], dtype=np.uint32)
        values = {
            name: column.view(np.int32 if self._is_int(name) else np.float32)
            for name, column in columns.items()
        }
        return Ticks(values, runs.cycles, runs.flags)

    def _fail(self, fault: Fault, runs: Runs, ticks: Ticks) -> None:
        """Raise the CoreFault of the last tick."""
        cause, tick = fault.cause, self.ticks - 1
        self._fault = f"{cause} in tick {tick}"
        odd = [
            f"{name} is {self.read(name)}"
            for name in self._inputs
            if not self._is_int(name) and not np.isfinite(self.read(name))
        ]
        text = f"tick {tick} stopped with {runs.text}\n"
        text += f"  inputs: {', '.join(odd)}\n" if odd else ""
        text += (
            f"  cure: {CURES[cause]}\n"
            "  The outputs have their safe values. clear() ends the fault and presets the states."
        )
        outputs = {name: float(ticks[name][-1]) for name in self.outputs}
        before = Ticks(
            {name: column[:-1] for name, column in ticks.values.items()},
            None if ticks.cycles is None else ticks.cycles[:-1],
            ticks.flags[:-1],
        )
        raise CoreFault(text, tick, cause, outputs, before)


def _image(
    program: Image | Path | str,
    configuration: str | None,
    defines: Mapping[str, float] | None,
    params: Path | None,
) -> Image:
    if not isinstance(program, Image):
        path = Path(program)
        if path.suffix != ".json":
            return assemble(path, configuration=configuration, defines=defines, params=params)
        program = Image.load(path)
    if defines or params:
        raise CoreError("an image has no parameters any more: give the source with them")
    if configuration not in (None, program.configuration):
        raise CoreError(
            f"the image is for configuration '{program.configuration}', not '{configuration}'; "
            "assemble it again"
        )
    return program


def _known(what: str, name: str, known: Collection[str]) -> None:
    if name not in known:
        raise CoreError(unknown(what, name, known))


def _raw(name: str, word: Any) -> int:
    try:
        value = operator.index(word)
    except TypeError:
        raise CoreError(f"input {name}: a raw word is an integer, got {word!r}") from None
    if not -(1 << 31) <= value < 1 << 32:
        raise CoreError(f"input {name}: {value} does not fit in 32 bits")
    return value & 0xFFFFFFFF
