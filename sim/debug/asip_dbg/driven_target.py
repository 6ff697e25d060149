# SPDX-License-Identifier: Apache-2.0
"""A core whose ticks another host starts, in a machine or a simulation that runs."""

from __future__ import annotations

import time
from collections.abc import Mapping

from asip_asm.image import Image
from sim.debug.asip_dbg.block_target import BlockTarget, client_errors
from sim.debug.asip_dbg.target import Kind, Status, TargetError
from sim.debug.state import State

NEXT_RUN = 10.0
"""Seconds to wait for the machine's next tick."""


class DrivenTarget(BlockTarget):
    """The program is there and runs; the debugger neither loads it nor writes inputs.

    From the first command on every run waits before its first bundle (MODE.stop_at_start), so that
    the end of a tick is a place to stop: there the next one waits.
    """

    driven = True
    _inside = False  # a run that the session knows of is on

    def load(self, image: Image) -> None:
        with client_errors():
            self.client.check_program(image)
        self._image = image
        self._inside = False
        self.free_points()
        with client_errors():
            self.client.set_mode(stop_at_start=True)

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        end = time.monotonic() + NEXT_RUN
        with client_errors():
            while not (state := self.client.state()).halted:
                if state.fault and not state.running:
                    self._inside = True  # the session shall see it
                    return
                if time.monotonic() > end:
                    raise TargetError(f"no tick began within {NEXT_RUN:g} s; does its host run?")
                self.client.link.pause()
            self._inside = hold
            if not hold:
                self.resume()

    def resume(self) -> None:
        self._inside = False
        super().resume()

    def step(self) -> None:
        self._inside = False
        super().step()

    def _status(self, state: State) -> Status:
        if state.halted and state.reason == "start" and not self._inside:
            return Status(Kind.IDLE)  # the run is over, the next one waits
        if state.halted or (state.fault and not state.running):
            return super()._status(state)
        return Status(Kind.RUNNING, state.next)

    def abort(self) -> None:
        self._inside = False
        super().abort()
