# SPDX-License-Identifier: Apache-2.0
"""What a plan of loops and streams is made of: operations, constants of streams, loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

PIPES = "AB"


@dataclass(frozen=True, eq=False)
class Words:
    """A constant of a stream: `values` is indexed by the counters of the loops named in `axes`."""

    values: NDArray[np.float64]
    axes: tuple[str, ...] = ()

    def at(self, counters: Mapping[str, int]) -> float:
        return float(self.values[tuple(counters[axis] for axis in self.axes)])


@dataclass(frozen=True, eq=False)
class Vectors(Words):
    """Vectors of a stream: the last axis of `values` is that of the lanes."""

    def lanes(self, counters: Mapping[str, int]) -> list[float]:
        return [float(v) for v in self.values[tuple(counters[axis] for axis in self.axes)]]


Operand = str | float | int | Words
"""Name of a value, constant of bank K (an int: int32), or word or vector of a stream."""


@dataclass(eq=False)
class Op:
    """One operation. block, offset: of `ld` and `st`, whose index register is args[-1], if any.
    pipe: of an operation that takes a word of a stream. lane: that `vout` takes.
    """

    name: str
    dst: str
    args: tuple[Operand, ...]
    block: str = ""
    offset: int = 0
    pipe: str = ""
    lane: int = 0

    @property
    def words(self) -> Words | None:
        return next((arg for arg in self.args if isinstance(arg, Words)), None)

    def reads(self) -> list[str]:
        return [arg for arg in self.args if isinstance(arg, str)]


@dataclass(eq=False)
class Loop:
    """`body`, `count` times; its counter is `name`, from 0."""

    name: str
    count: int
    body: list[Op | Loop | Rewind]


@dataclass(eq=False)
class Rewind:
    """Both streams go on with the words after this place, also when it is reached again."""

    places: dict[str, int] = field(default_factory=dict)


Item = Op | Loop | Rewind
