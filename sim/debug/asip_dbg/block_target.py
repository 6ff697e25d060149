# SPDX-License-Identifier: Apache-2.0
"""A core with a debug block as a target, over any link of `sim.debug`."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

from asip_asm.image import Image
from sim.core.fault import Fault
from sim.debug.asip_dbg.target import Kind, Status, TargetError, TargetGone
from sim.debug.client import Client, DebugError
from sim.debug.link import LinkError
from sim.debug.state import State


@contextmanager
def client_errors() -> Iterator[None]:
    """Errors of the client as those of a target."""
    try:
        yield
    except LinkError as error:
        raise TargetGone(str(error)) from None
    except (DebugError, ValueError) as error:
        raise TargetError(str(error)) from None


def _first_lane(place: str) -> None:
    """Refuse a place in a further lane, which the debug block cannot reach. Raises TargetError."""
    if "." in place:
        raise TargetError(f"{place}: the core shows the first lane alone, --iss all")


class BlockTarget:
    """A `Target` over a client; `connect` makes one, again after the target was gone.

    Raises TargetGone if there is nothing at the other end.
    """

    driven = False

    def __init__(self, connect: Callable[[], Client], label: str) -> None:
        self.label = label
        self._connect = connect
        self._runs = 0
        self._armed: tuple[Sequence[int], Sequence[str]] | None = [], []
        with client_errors():
            self.client = connect()

    @property
    def breakpoints(self) -> int:
        """Of the block that was built."""
        return self.client.sizes.breakpoints

    @property
    def watches(self) -> int:
        """Of the block that was built."""
        return self.client.sizes.watches

    def load(self, image: Image) -> None:
        self.abort()
        with client_errors():
            self.client.load(image)
        self.free_points()
        self._image = image

    def free_points(self) -> None:
        """Clear all breakpoints and watches, those of an earlier session too."""
        with client_errors():
            self.client.free_points()
        self._armed = [], []

    def begin(self, inputs: Mapping[str, int], hold: bool) -> None:
        with client_errors():
            for entry in self._image.inputs:
                self.client.write_register(f"k{entry.index}", inputs[entry.name])
            self.client.set_mode(stop_at_start=hold)
            if self.client.state().held:
                self.client.resume()
            self._runs = self.client.runs()
            self.client.start()

    def resume(self) -> None:
        with client_errors():
            self.client.resume()

    def step(self) -> None:
        with client_errors():
            self.client.step()

    def halt(self) -> None:
        with client_errors():
            self.client.halt()

    def poll(self, seconds: float) -> Status:
        end = time.monotonic() + seconds
        with client_errors():
            while True:
                state = self.client.state()
                status = self._status(state)
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
        return Status(Kind.IDLE)

    def arm(self, bundles: Sequence[int], places: Sequence[str]) -> None:
        if (bundles, places) == self._armed:
            return
        self.free_points()
        self._armed = None  # until the last one is set
        with client_errors():
            for bundle in bundles:
                self.client.set_breakpoint(bundle)
            for place in places:
                self.client.set_watch(place)
        self._armed = bundles, places

    def read(self, place: str) -> int:
        _first_lane(place)
        with client_errors():
            if place[:1] == "d":
                return self.client.read_data(int(place[1:]))[0]
            return self.client.read_register(place)

    def write(self, place: str, word: int) -> None:
        _first_lane(place)
        with client_errors():
            if place[:1] == "d":
                self.client.write_data(int(place[1:]), [word])
            else:
                self.client.write_register(place, word)

    def counters(self) -> dict[str, int]:
        with client_errors():
            return {"CYCLES": self.client.cycles()}

    def stream_places(self) -> dict[str, int]:
        return {}

    def clear(self) -> None:
        with client_errors():
            self.client.clear()

    def abort(self) -> None:
        with client_errors():
            state = self.client.state()
            if state.running:
                self.client.abort()
                state = self.client.wait(lambda now: not now.running)
            if state.fault:
                self.client.clear()
            self._runs = self.client.runs() - 1  # no run is on

    def reconnect(self) -> None:
        self.client.close()
        with client_errors():
            self.client = self._connect()

    def close(self) -> None:
        """Leave the core without breakpoints, and let it go on."""
        with suppress(TargetError):  # it may be gone
            self.free_points()
            with client_errors():
                self.client.set_mode()
                self.client.resume()
        self.client.close()
