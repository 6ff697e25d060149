# SPDX-License-Identifier: Apache-2.0
"""One run of the instruction-set model, bundle by bundle."""

from __future__ import annotations

from sim.core.iss import arithmetic
from sim.core.iss.core import Iss, RunFault
from sim.core.iss.isa import Fault, IllegalOperation


class SteppedRun:
    """A run of a loaded program that is before bundle `position`; None when it is over.

    fault, fault_bundle: why and where it ended otherwise; bundles executed so far; writes: words
    that the last bundle wrote, by register or output.
    """

    def __init__(self, iss: Iss) -> None:
        self.iss = iss
        self.position: int | None = iss.image.entry
        self.fault = Fault.NONE
        self.fault_bundle: int | None = None
        self.bundles = 0
        self.writes: dict[str, list[int]] = {}
        self._written: set[int] = set()
        iss.begin()

    def step(self) -> None:
        """Execute the bundle at `position`; does nothing when the run is over."""
        place = self.position
        if place is None:
            return
        try:
            with arithmetic.environment():
                self.position = self._execute(place)
            if self.position is None and self.iss.misses_outputs(self._written):
                raise RunFault(Fault.OUTPUT_MISSING)
        except IllegalOperation:
            self._end(Fault.ILLEGAL, place)
        except RunFault as stop:
            self._end(stop.fault, place)

    def _execute(self, place: int) -> int | None:
        step = self.iss.decoded(place)
        if self.bundles >= self.iss.image.watchdog:
            raise RunFault(Fault.WATCHDOG)
        self.bundles += 1
        self.writes = {}
        return self.iss.execute(step, place, self._written, self.writes)

    def _end(self, fault: Fault, place: int) -> None:
        self.position, self.fault, self.fault_bundle = None, fault, place
        self.iss.set_outputs_safe()
