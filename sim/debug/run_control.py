# SPDX-License-Identifier: Apache-2.0
"""Run control over a link: halt, step, breakpoints, watches."""

from __future__ import annotations

import time
from collections.abc import Callable

from sim.debug.requests import DebugError, Requests
from sim.debug.state import BANKS, REGMAP, State
from sim.rtl.asip_bus import place_address


class RunControl(Requests):
    """A core that is held, stepped and let go."""

    def halt(self) -> None:
        """Hold the core after the bundle that issues now; without a run, at the first bundle of
        the next one. `wait` reports when it is halted."""
        self._control("halt")

    def resume(self) -> None:
        """Let bundles issue until the next breakpoint or watch."""
        self._control("resume")

    def step(self, bundles: int = 1, timeout: float | None = None) -> State:
        """Issue so many bundles one by one; each is written back before the next one.

        Returns the state after: halted before the next bundle, or not running if the run has
        ended. Raises DebugError if the core is not halted.
        """
        state = self.state()
        for _ in range(bundles):
            if not state.halted:
                raise DebugError("a step needs a core that is halted inside a run; halt it first")
            self._control("step")
            state = self.wait(lambda now: now.halted or not now.running, timeout)
            if not state.running:
                break
        return state

    def abort(self) -> None:
        """End a run with the fault WATCHDOG: outputs take their safe values."""
        self._control("abort")

    def wait(self, until: Callable[[State], bool], timeout: float | None = None) -> State:
        """The first state seen for which `until` holds. Raises DebugError after `timeout` seconds
        (None: that of the client)."""
        seconds = self.timeout if timeout is None else timeout
        end = time.monotonic() + seconds
        while True:
            state = self.state()
            if until(state):
                return state
            if time.monotonic() > end:
                raise DebugError(f"not reached within {seconds:g} s; the state is {state}")
            self.link.pause()

    def set_mode(self, *, watchdog_runs: bool = False, stop_at_start: bool = False) -> None:
        """watchdog_runs: the watchdog counts while the core is halted, and ends the run with a
        fault; else it is halted. stop_at_start: every run waits before its first bundle."""
        word = REGMAP.registers["MODE"].word(
            watchdog_runs=int(watchdog_runs), stop_at_start=int(stop_at_start)
        )
        self._write("MODE", word)

    # ------------------------------------------------------------------ breakpoints
    def set_breakpoint(self, bundle: int) -> int:
        """Hold the core before it issues this bundle; returns the breakpoint's number.

        Raises DebugError if all are taken, ValueError for an address that is none.
        """
        word = REGMAP.registers["BREAK"].word(value=bundle)
        number = self._free("breakpoints", self.sizes.breakpoints)
        self._write("BREAK", word, number)
        self._enable("breakpoints", number, True)
        return number

    def clear_breakpoint(self, number: int) -> None:
        """Free a breakpoint."""
        self._enable("breakpoints", number, False)

    def set_watch(self, place: str, value: int | None = None, mask: int = 0xFFFFFFFF) -> int:
        """Hold the core when a register ('a3', 'b0', 'c12') or output ('o2') is written, with
        `value` in the bits of `mask` (None: whatever is written); returns the watch's number.

        A watch sees the write-back: some bundles after the one that made the value have issued
        by then. Raises DebugError if all are taken, ValueError for a place that is none.
        """
        letter, digits = place[:1].lower(), place[1:]
        if letter == "k":
            raise ValueError(f"'{place}': programs do not write bank K")
        place_address(place)
        bank = 3 if letter == "o" else BANKS.index(letter)
        number = self._free("watches", self.sizes.watches)
        word = REGMAP.registers["WATCH_PLACE"].word(bank=bank, index=int(digits))
        self._write("WATCH_PLACE", word, number)
        self._write("WATCH_MASK", 0 if value is None else mask, number)
        self._write("WATCH_VALUE", (value or 0) & mask, number)
        self._enable("watches", number, True)
        return number

    def clear_watch(self, number: int) -> None:
        """Free a watch."""
        self._enable("watches", number, False)

    def free_points(self) -> None:
        """Clear all breakpoints and watches, those of an earlier session too."""
        self._write("ENABLE", 0)

    def _free(self, what: str, count: int) -> int:
        used = self._fields("ENABLE")[what]
        for number in range(count):
            if not used >> number & 1:
                return number
        raise DebugError(f"all {count} {what} of the core are taken; clear one")

    def _enable(self, what: str, number: int, on: bool) -> None:
        bits = self._fields("ENABLE")
        bits[what] = (bits[what] & ~(1 << number)) | (int(on) << number)
        self._write("ENABLE", REGMAP.registers["ENABLE"].word(**bits))
