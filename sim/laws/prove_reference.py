# SPDX-License-Identifier: Apache-2.0
"""What a proof compares a program with: the user's own model in double precision.

A `Reference` evaluates the user's file and nothing else: named arguments at their full dense shape
go in, named results come out. A `Truth` connects it to the words of the core by the names in the
user's interface file. It shares no code with the compiler's reading of signals
(`asip_asm.model.law`), so that a mistake there shows as a difference.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.read import ModelError

if TYPE_CHECKING:
    from asip_asm.model.law import Law

Shape = tuple[int, int]
Values = NDArray[np.float64]


class Reference(Protocol):
    """The user's model. `arguments` and `results`: rows and columns of each by name, in order."""

    @property
    def arguments(self) -> Mapping[str, Shape]: ...

    @property
    def results(self) -> Mapping[str, Shape]: ...

    def __call__(self, arguments: Mapping[str, Values]) -> dict[str, Values]:
        """Results (points, rows, columns) by name from arguments of the same form."""
        ...


@dataclass(frozen=True)
class Wire:
    """One signal of the core as the user's file has it.

    kind: 'input', 'state', 'parameter', 'rate', 'output' or 'export'. The physical value of a word
    is scale * word + offset. A 'rate' is scale * (count - count before) of the input `rate_of`;
    `last` names the state that holds the count before. limits: an output saturates to them.
    initial: of a state, or a parameter's value; safe: of an output after a fault.
    """

    kind: str
    name: str
    vector: str = ""
    scale: float = 1.0
    offset: float = 0.0
    limits: tuple[float, float] | None = None
    rate_of: str = ""
    last: str = ""
    initial: float = 0.0
    safe: float = 0.0

    def physical(self, words: Mapping[str, Any]) -> Values:
        """Values (points,) of the signal from the core's words."""
        if self.kind != "rate":
            return np.asarray(words[self.name]).astype(np.float64) * self.scale + self.offset
        now, last = (np.asarray(words[n]).astype(np.int64) for n in (self.rate_of, self.last))
        return np.asarray(self.scale * (now - last), np.float64)


class Truth:
    """Results of a reference for words of the core. Raises ModelError where names or sizes differ.

    Element (row, column) of an argument is the signal number row + rows * column of its vector: a
    matrix goes column by column, structural zeros included.
    """

    def __init__(self, reference: Reference, wires: Iterable[Wire]) -> None:
        self.reference = reference
        self.wires = wires = list(wires)
        sources = [w for w in wires if w.kind in ("input", "state", "parameter", "rate")]
        targets = [w for w in wires if w.kind in ("output", "state", "export")]
        self._sources = {
            name: _elements(name, name, shape, sources)
            for name, shape in reference.arguments.items()
        }
        self._targets: dict[str, list[Wire]] = {}
        for name, shape in reference.results.items():
            state = name.removesuffix("_next")
            own = [w for w in targets if w.kind != "state"]
            named = [w for w in own if name in (w.name, w.vector)]
            if named or state == name:
                self._targets[name] = _elements(name, name, shape, own)
            else:
                states = [w for w in targets if w.kind == "state"]
                self._targets[name] = _elements(name, state, shape, states)

    def difference(self, image: Image) -> str:
        """What of the image differs from the user's file: names, first states, safe outputs."""
        for kind, found in (("input", image.inputs), ("output", image.outputs)):
            want = [wire.name for wire in self.wires if wire.kind == kind]
            if [entry.name for entry in found] != want:
                return f"the image's {kind}s are not those of the interface file, in its order"
        bits = {s.name: s.bits for s in image.states} | {o.name: o.safe for o in image.outputs}
        for wire in self.wires:
            if wire.kind in ("state", "output"):
                value = wire.initial if wire.kind == "state" else wire.safe
                if int(bits.get(wire.name, "0"), 16) != np.float32(value).view(np.uint32):
                    what = "first value" if wire.kind == "state" else "safe value"
                    return f"the {what} of '{wire.name}' in the image is not {value:g}"
        return ""

    def __call__(self, words: Mapping[str, Any]) -> dict[str, Values]:
        """Each output, export and next state (`<state>_next`), an array (points,), from the words
        (points,) of inputs, states and parameters by name.
        """
        points = len(next(iter(words.values()))) if words else 1
        own = {w.name: w.initial for w in self.wires if w.kind == "parameter"}
        words = {**words, **{n: np.full(points, x, np.float32) for n, x in own.items()}}
        arguments = {}
        for name, wires in self._sources.items():
            rows, columns = self.reference.arguments[name]
            flat = np.array([wire.physical(words) for wire in wires], np.float64)
            arguments[name] = flat.reshape(columns, rows, points).transpose(2, 1, 0)
        found: dict[str, Values] = {}
        for name, values in self.reference(arguments).items():
            for k, wire in enumerate(self._targets[name]):
                rows = self.reference.results[name][0]
                value = values[:, k % rows, k // rows]
                if wire.kind == "output" and wire.limits is not None:
                    value = np.clip(value, *wire.limits)
                found[f"{wire.name}_next" if wire.kind == "state" else wire.name] = value
        return found


class RobotTruth(Protocol):
    """Results of a robot's own equations for words of the core: each a pair, the value and how far
    it may be from the truth itself.
    """

    def __call__(self, words: Mapping[str, Any]) -> Mapping[str, tuple[Values, Values]]: ...

    def difference(self, law: Law) -> str:
        """What of the law's ports differs from the user's file."""
        ...


def _elements(name: str, signal: str, shape: Shape, wires: Sequence[Wire]) -> list[Wire]:
    """Signals of an argument or result in the order of its elements."""
    wanted = shape[0] * shape[1]
    if not wanted:
        return []
    found = [wire for wire in wires if wire.vector == signal]
    if wanted == 1 and not found:
        found = [wire for wire in wires if wire.name == signal]
    if len(found) != wanted:
        raise ModelError(
            f"'{name}' is {shape[0]} by {shape[1]}, so it has {wanted} elements; the interface "
            f"file has {len(found)} signals for it"
        )
    return found
