# SPDX-License-Identifier: Apache-2.0
"""The instruction-set model as a target: same bits as the core except for sine and cosine, no
cycles, nothing to build.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from asip_asm.image import Image
from sim.core.fault import Fault
from sim.core.iss.core import Iss
from sim.core.iss.stepped import SteppedRun
from sim.debug.asip_dbg.target import Kind, Status, TargetError


class IssTarget:
    """A `Target` without limits of a debug block but those that keep its tables readable."""

    label = "instruction-set model"
    breakpoints = 64
    watches = 64
    driven = False
    iss: Iss
    """With the program that was loaded."""

    def __init__(self) -> None:
        self._run: SteppedRun | None = None
        self._going = False
        self._reason = ""
        self._which = 0
        self._bundles: Sequence[int] = ()
        self._watched: Sequence[str] = ()

    def load(self, image: Image) -> None:
        self.iss = Iss(image, trace=True)
        self._run = None

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        self.iss.set_words(inputs)
        self._run = SteppedRun(self.iss)
        self._going = not hold
        self._reason = "start" if hold else ""
        if self._run.position in self._bundles and not hold:
            self._stop("breakpoint")

    def resume(self) -> None:
        if self._run and self._run.position is not None:
            self._going = True
            self._one()

    def step(self) -> None:
        self.resume()
        if self._going:
            self._stop("step")

    def halt(self) -> None:
        if self._going:
            self._stop("request")

    def poll(self, seconds: float) -> Status:
        end = time.monotonic() + seconds
        while self._going and time.monotonic() < end:
            self._one()
        run = self._run
        if run is None or (run.position is None and not run.fault):
            return Status(Kind.IDLE)
        if run.position is None:
            fault = Fault(run.fault.name, bundle=run.fault_bundle)
            return Status(Kind.FAULT, run.fault_bundle or 0, fault=fault)
        if self._going:
            return Status(Kind.RUNNING, run.position)
        return Status(Kind.HALTED, run.position, self._reason, self._which)

    def _stop(self, reason: str, which: int = 0) -> None:
        self._going, self._reason, self._which = False, reason, which

    def _one(self) -> None:
        """Execute the bundle that waits, and see whether the next one waits."""
        run = self._run
        assert run is not None
        run.step()
        if run.position is None:
            self._going = False
            return
        for which, place in enumerate(self._watched):
            if place in run.writes:
                self._stop("watch", which)
        if self._going and run.position in self._bundles:
            self._stop("breakpoint")

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        self._bundles, self._watched = bundles, places

    def read(self, place: str) -> int:
        try:
            return self.iss.read_place(place)
        except KeyError:
            raise TargetError(f"there is no place '{place}'") from None

    def write(self, place: str, word: int) -> None:
        try:
            self.iss.write_place(place, word)
        except KeyError:
            raise TargetError(f"there is no place '{place}'") from None

    def counters(self) -> dict[str, int]:
        return {"BUNDLES": self._run.bundles} if self._run else {}

    def stream_places(self) -> dict[str, int]:
        return dict(zip("AB", self.iss.stream_places, strict=False))

    def clear(self) -> None:
        self._run = None

    def abort(self) -> None:
        self._run, self._going = None, False

    def reconnect(self) -> None:
        """The model is always there."""

    def close(self) -> None:
        """The model goes with its session."""
