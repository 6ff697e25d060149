# SPDX-License-Identifier: Apache-2.0
"""Values that a program reads and sets: numbered parameters, and names."""

from __future__ import annotations

from sim.gcode.expressions import Key
from sim.gcode.state import State


class Variables:
    """Numbers, and names that begin with an underscore, are known everywhere; other names belong to
    the subroutine that runs, or to the main program."""

    def __init__(self, state: State) -> None:
        self._state = state
        self.names: dict[Key, float] = {}

    @property
    def numbers(self) -> dict[Key, float]:
        """What is known everywhere, as it is stored."""
        return self._state.parameters

    def read(self, key: Key) -> float | None:
        """The value; None for a name that has none. Raises NoValueError as State.parameter."""
        if isinstance(key, str):
            return self._of(key).get(key)
        return self._state.parameter(key)

    def write(self, key: Key, value: float) -> None:
        """Set a number or name."""
        self._of(key)[key] = value

    def _of(self, key: Key) -> dict[Key, float]:
        own = isinstance(key, str) and not key.startswith("_")
        return self.names if own else self.numbers
