# SPDX-License-Identifier: Apache-2.0
"""What a debugger needs of a core: the instruction-set model and the debug block both give it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from asip_asm.image import Image
from sim.core.fault import Fault


class TargetError(Exception):
    """The target refused something; the message says what and what to do."""


class TargetGone(TargetError):
    """The target does not answer any more; `reconnect` may find it again."""


class Kind(Enum):
    """What a core does: nothing (between two runs), halted inside a run, running, faulted."""

    IDLE = "idle"
    HALTED = "halted"
    RUNNING = "running"
    FAULT = "fault"


@dataclass(frozen=True)
class Status:
    """State of a core. position: bundle that issues next, or the last one before a fault; reason:
    why it is halted ('breakpoint', 'watch', 'step', 'start', 'request'); which: of the watches;
    fault: of a faulted core.
    """

    kind: Kind
    position: int = 0
    reason: str = ""
    which: int = 0
    fault: Fault | None = None


class Target(Protocol):
    """A core with a program. Words are raw, 32 bits; places are 'a3', 'k7', 'o0', 'd12',
    'a3.2' in a further lane.

    All methods raise TargetGone if the target does not answer.
    """

    label: str
    driven: bool
    """Another host writes the inputs and starts the runs; `begin` takes the next one."""

    @property
    def breakpoints(self) -> int: ...

    @property
    def watches(self) -> int: ...

    def load(self, image: Image) -> None:
        """Load a program, states at their initial values. Raises TargetError."""

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        """Start a run with these inputs; `hold`: it halts before its first bundle."""

    def resume(self) -> None:
        """Go on; the bundle that waits issues whatever breakpoint it has."""

    def step(self) -> None:
        """Issue one bundle."""

    def halt(self) -> None:
        """Issue no further bundle."""

    def poll(self, seconds: float) -> Status:
        """The state, as soon as the core does not run, at the latest after so long."""

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        """Halt before these bundles, and after every write of these registers and outputs; those
        of an earlier call are gone."""

    def read(self, place: str) -> int:
        """Word of a place. Raises TargetError for one that cannot be read."""

    def write(self, place: str, word: int) -> None: ...

    def counters(self) -> dict[str, int]:
        """Counters of the run, as far as the target has them."""

    def stream_places(self) -> dict[str, int]:
        """Place of the next word of each pipe's stream, as far as the target has it."""

    def clear(self) -> None:
        """End a fault."""

    def abort(self) -> None:
        """Give up the run that the core is in."""

    def reconnect(self) -> None:
        """Look for a target that is gone. Raises TargetGone if it is still."""

    def close(self) -> None: ...
