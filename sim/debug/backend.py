# SPDX-License-Identifier: Apache-2.0
"""A core with a debug block, a board for example, as a `Backend`, over any link of `sim.debug`."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from sim.core.backends import (
    BACKENDS,
    IDLE,
    Backend,
    BusBackend,
    Kind,
    OneRun,
    Runs,
    Status,
    run_each,
)
from sim.core.fault import NO_FAULT, Fault
from sim.debug.client import Client, DebugError, connect
from sim.debug.link import Bus
from sim.debug.state import State
from sim.rtl.asip_bus import CSR, FAULT_NAMES, STATUS, AsipError

NEXT_RUN = 10.0
"""Seconds to wait for the machine's next tick."""


def open_backend(place: str, trace: bool = False) -> Backend:
    """A core at a place: 'rtl', 'iss', or the address of a link (`sim.debug.link.open_link`).

    Raises LinkError if nothing answers there.
    """
    return BACKENDS[place](trace) if place in BACKENDS else open_block(place)


def open_block(target: Bus | str, driven: bool = False) -> BlockBackend:
    """A core with a debug block: a model in this process, or at the address of a link. driven: its
    ticks are another host's. Raises LinkError if nothing answers."""
    label = f"core at {target}" if isinstance(target, str) else "Verilated core"
    kind = DrivenBackend if driven else BlockBackend
    return kind(lambda: connect(target), label)


class BlockBackend(BusBackend):
    """A core over a client; `connect` makes one, again after the core was gone. No trace.

    Raises LinkError if there is nothing at the other end.
    """

    def __init__(self, connect: Callable[[], Client], label: str) -> None:
        self.label = label
        self._connect = connect
        self._runs = 0
        self._armed: tuple[Sequence[int], Sequence[str]] | None = None
        self._taken = False  # it is to be left without breakpoints
        self._open()

    def _open(self) -> None:
        self.client = self._connect()
        sizes = self.client.sizes  # of the block that was built
        self.breakpoints, self.watches = sizes.breakpoints, sizes.watches

    def load(self, image: Image) -> None:
        self._taken = True
        self.abort()
        self.client.set_mode()
        self._free_points()
        if self.client.state().held:
            self.client.resume()
        self.client.load(image)
        self._name(image)

    def attach(self, image: Image) -> None:
        """Go on with the program that the core has. Raises DebugError if it is another one."""
        self.client.check_program(image)
        self._name(image)

    def _free_points(self) -> None:
        """Clear all breakpoints and watches, those of an earlier session too."""
        self.client.free_points()
        self._armed = [], []

    def read_word(self, address: int) -> int:
        return self.client.read_word(address)

    def write_word(self, address: int, word: int) -> None:
        self.client.write_word(address, word)

    def write_data(self, address: int, words: Sequence[int]) -> None:
        self.client.write_data(address, words)

    # ------------------------------------------------------------------ whole runs
    def run(self, inputs: Sequence[str], data: NDArray[np.uint32], read: Sequence[str]) -> Runs:
        return run_each(self, self._one_run, inputs, data, read)

    def _one_run(self, inputs: Mapping[str, int]) -> OneRun:
        """Raises DebugError if the run does not end."""
        self._write_inputs(inputs)
        self.client.clear()
        self.client.start()
        end = time.monotonic() + self.client.timeout
        while STATUS["busy"].of(status := self.read_word(CSR["STATUS"])):
            if time.monotonic() > end:
                raise DebugError(
                    f"the run has not ended within {self.client.timeout:g} s; is a debugger "
                    f"holding the core? Its watchdog is {self.image.watchdog} cycles"
                )
            self.client.link.pause()
        cause = FAULT_NAMES[STATUS["cause"].of(status)]
        fault = None if cause == NO_FAULT else self.fault(cause)
        return OneRun(STATUS["flags"].of(status), self.client.cycles(), fault)

    def _write_inputs(self, inputs: Mapping[str, int]) -> None:
        places = {entry.name: f"k{entry.index}" for entry in self.image.inputs}
        for name, word in inputs.items():
            self.write(places[name], word)

    def clear(self) -> None:
        self.client.clear()

    # ------------------------------------------------------------------ runs that stop inside
    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        self._write_inputs(inputs)
        self.client.set_mode(stop_at_start=hold)
        if self.client.state().held:
            self.client.resume()
        self._runs = self.client.runs()
        self.client.start()

    def resume(self) -> None:
        self.client.resume()

    def step(self) -> None:
        self.client.step()

    def halt(self) -> None:
        self.client.halt()

    def abort(self) -> None:
        state = self.client.state()
        if state.running:
            self.client.abort()
            state = self.client.wait(lambda now: not now.running)
        if state.fault:
            self.client.clear()
        self._runs = self.client.runs() - 1  # no run is on

    def poll(self, seconds: float) -> Status:
        end = time.monotonic() + seconds
        while True:
            status = self._status(self.client.state())
            if status.kind is not Kind.RUNNING or time.monotonic() >= end:
                return status
            self.client.link.pause()

    def _status(self, state: State) -> Status:
        if state.halted:
            return Status(Kind.HALTED, state.next, state.reason, state.which)
        if state.fault and not state.running:
            return Status(Kind.FAULT, state.last + 1, fault=Fault.of(*self.client.fault()))
        if state.running or self.client.runs() == self._runs:
            return Status(Kind.RUNNING, state.next)
        return IDLE

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        if (bundles, places) == self._armed:
            return
        self._free_points()
        self._armed = None  # until the last one is set
        try:
            for bundle in bundles:
                self.client.set_breakpoint(bundle)
            for place in places:
                self.client.set_watch(place)
        except ValueError as error:
            raise AsipError(str(error)) from None
        self._armed = bundles, places

    # ------------------------------------------------------------------ life
    def reconnect(self) -> None:
        self.client.close()
        self._open()

    def close(self) -> None:
        """A core that `load` has taken is left without breakpoints, and goes on."""
        if self._taken:
            with suppress(AsipError):  # it may be gone
                self._free_points()
                self.client.set_mode()
                self.client.resume()
        self.client.close()


class DrivenBackend(BlockBackend):
    """A core whose ticks another host starts, in a machine or a simulation that runs: the program
    is there; nothing is loaded from here, and no inputs are written.

    From `load` on every run waits before its first bundle (MODE.stop_at_start), so that the end of
    a tick is a place to stop: there the next one waits.
    """

    driven = True
    _inside = False  # a run that the session knows of is on

    def load(self, image: Image) -> None:
        """Raises DebugError if the core has another program."""
        self._taken = True
        self.attach(image)
        self._inside = False
        self._free_points()
        self.client.set_mode(stop_at_start=True)

    def _one_run(self, inputs: Mapping[str, int]) -> OneRun:
        raise AsipError("another host starts the runs of this core; it cannot be given one")

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        end = time.monotonic() + NEXT_RUN
        while not (state := self.client.state()).halted:
            if state.fault and not state.running:
                self._inside = True  # the session shall see it
                return
            if time.monotonic() > end:
                raise DebugError(f"no tick began within {NEXT_RUN:g} s; does its host run?")
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
            return IDLE  # the run is over, the next one waits
        if state.halted or (state.fault and not state.running):
            return super()._status(state)
        return Status(Kind.RUNNING, state.next)

    def abort(self) -> None:
        self._inside = False
        super().abort()
