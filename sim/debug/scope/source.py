# SPDX-License-Identifier: Apache-2.0
"""What a scope looks at: a description, events in the order of time, and the commands it takes.

`Pace` and `Step` are messages of the page: they come to the source as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from sim.debug.scope.messages import Pace, Step

VERSION = "gain_version"
"""Channel: the version of the gains that a tick used."""
CYCLES = "cycles"
"""Channel: clock cycles of the tick."""


class Channel(msgspec.Struct, frozen=True):
    """One number per tick. group: what kind of signal it is, such as 'outputs'."""

    name: str
    unit: str
    group: str
    meaning: str = ""


class Gain(msgspec.Struct, frozen=True):
    """A value that may be changed between two ticks. form: 'parameter', from which words of the
    program are computed, or 'constant', a word of the program itself."""

    name: str
    unit: str
    value: float
    form: str
    meaning: str = ""


class StepInput(msgspec.Struct, frozen=True):
    """An input to which a step can be added. response: channel that is 0 while the machine is where
    its path wants it, and the step's size once it has followed."""

    name: str
    unit: str
    response: str
    amplitude: float


class Scene(msgspec.Struct, frozen=True):
    """A parallel machine in space [m]: start points of its legs (3, 3), channels of the tool's
    place (3), the path as it is wanted (3, N); of the table: point on its tilt axis (3), distance
    of its surface from there, channels of tilt and rotation [rad]."""

    legs: list[list[float]]
    tool: list[str]
    path: list[list[float]]
    pivot: list[float]
    height: float
    table: list[str]


class Description(msgspec.Struct, frozen=True):
    """A source. period: of a tick [s]; ticks: how many there will be, None if nobody knows; shown:
    channels to begin with; inputs: that a fault may be put on (simulated machines only)."""

    title: str
    period: float
    channels: list[Channel]
    shown: list[str]
    gains: list[Gain] = []
    steps: list[StepInput] = []
    inputs: list[str] = []
    scene: Scene | None = None
    ticks: int | None = None
    paces: bool = True  # it can be paused and slowed down

    @property
    def names(self) -> list[str]:
        """Names of the channels, in the order of a block's columns."""
        return [channel.name for channel in self.channels]


# ---------------------------------------------------------------------- events


@dataclass(frozen=True)
class Block:
    """Consecutive ticks from `first` on: values (n, channels) in float64, which holds every
    binary32 and int32 exactly."""

    first: int
    values: NDArray[np.float64]


@dataclass(frozen=True)
class Applied:
    """Gains are in force from `tick` on; values: of all that are not as before."""

    tick: int
    version: int
    values: Mapping[str, float]


@dataclass(frozen=True)
class Stepped:
    """A step is added to an input from `tick` on, now or soon, for `ticks` ticks."""

    tick: int
    name: str
    amplitude: float
    ticks: int


@dataclass(frozen=True)
class Fault:
    """The core stopped in `tick`; text: cause, place in the source."""

    tick: int
    text: str


@dataclass(frozen=True)
class Lost:
    """Ticks before `tick` that never came, as the link was too slow."""

    tick: int
    ticks: int


@dataclass(frozen=True)
class Note:
    """A message for people, '' when it is over."""

    text: str


@dataclass(frozen=True)
class End:
    """The source gives no more ticks."""

    text: str = "the run is over"


Event = Block | Applied | Stepped | Fault | Lost | Note | End

# ---------------------------------------------------------------------- commands


@dataclass(frozen=True)
class Commit:
    """Change gains together, between two ticks."""

    version: int
    values: Mapping[str, float]


@dataclass(frozen=True)
class Put:
    """Put a value on an input for one tick, as a broken sensor would. Simulated machines only."""

    name: str
    value: float


Command = Pace | Commit | Step | Put


class SourceError(ValueError):
    """The source refuses a command; the text says why and what would do."""


def checked(name: str, value: float, kind: str = "float") -> float:
    """The value as a word of type 'float' (rounded to binary32) or 'int' holds it.

    Raises SourceError if none can.
    """
    with np.errstate(over="ignore"):
        single = float(np.float32(value))
    if kind == "int":
        if value != value // 1 or not -(1 << 31) <= value < 1 << 31:
            raise SourceError(f"{name} = {value:g} is no int32")
        return value
    if not abs(single) < np.inf:
        raise SourceError(f"{name} = {value:g} is too large for binary32")
    return single


class Source(Protocol):
    """Where ticks come from. `wait` and `send` may be called by different threads."""

    description: Description

    def wait(self) -> Event:
        """The next event; nothing comes after an End."""

    def check(self, values: Mapping[str, float]) -> None:
        """Raise SourceError unless the gains could be committed together."""

    def send(self, command: Command) -> None:
        """Raises SourceError."""

    def close(self) -> None: ...
