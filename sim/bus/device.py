# SPDX-License-Identifier: Apache-2.0
"""The device on the bus, Verilated: slave controller and Nios II system with its program, with an
ideal machine connected to it (device_harness.cpp)."""

from __future__ import annotations

import ctypes

import numpy as np

from sim.bus.verilated import HERE, BusModel, load
from sim.rtl import nios_image
from sim.rtl.nios_map import default_system_map

IMAGE = "ethercat"  # its program
CLOCK_NS = 10
CYCLE_CLOCKS = 10_000  # between two control ticks
INPUT_WORDS, OUTPUT_WORDS = 23, 29  # of a control tick: nios_sw/ethercat/ethercat_tick.h
BEFORE = 8  # clocks before a control tick at which `DeviceRtl.tick` begins
COUNTS = ("ticks", "last", "longest", "sum", "overrun", "sent", "returned")


class DeviceRtl(BusModel):
    """One device with its program running, a control tick each `CYCLE_CLOCKS`, or with SYNC0.

    inputs (23,), outputs (29,): words of the next tick and of the last one, uint32. The model is
    built on first use. Raises BuildError.
    """

    prefix = "device"

    def __init__(self) -> None:
        longs = ("device_now", "device_count", "device_time", "device_clocks")
        super().__init__(load("ethercat_nios", HERE / "device_harness.cpp", longs))
        self._lib.device_console.restype = ctypes.c_char_p
        self.inputs = self._words("inputs", INPUT_WORDS)
        self.outputs = self._words("outputs", OUTPUT_WORDS)
        program, system = nios_image.load(IMAGE), default_system_map()
        for memory in system.memories.values():
            words = np.zeros(memory.words, dtype=np.uint32)
            words[: len(program.memories[memory.name])] = program.memories[memory.name]
            self._call("load", ctypes.c_uint32(memory.base), words.ctypes, memory.words)
        bases = [system.base(block) for block in ("inputs", "outputs")]
        self._call("start", *map(ctypes.c_uint32, bases), CYCLE_CLOCKS)

    def _words(self, name: str, count: int) -> np.ndarray:
        getattr(self._lib, f"device_{name}").restype = ctypes.POINTER(ctypes.c_uint32 * count)
        return np.ctypeslib.as_array(self._call(name).contents)

    def counts(self) -> dict[str, int]:
        """COUNTS: ticks, clock cycles of the last, the longest and all of them, frames."""
        return {name: self._call("count", n) for n, name in enumerate(COUNTS)}

    def restart_counts(self) -> None:
        """Count ticks again."""
        self._call("restart_counts")

    def time(self) -> int:
        """System time of the controller, ns."""
        return self._call("time")

    def begun(self, most: int) -> tuple[np.ndarray, np.ndarray]:
        """Clocks in which SYNC0 began and in which a control tick was due, the last `most` each."""
        found = []
        for which in (0, 1):
            clocks = np.zeros(most, dtype=np.uint64)
            count = self._call("clocks", which, clocks.ctypes, ctypes.c_uint64(most))
            found.append(clocks[:count].astype(np.int64))
        return found[0], found[1]

    @property
    def console(self) -> str:
        """What the program has written."""
        return self._call("console").decode()

    def send(self, frame: bytes) -> None:
        """A frame without check sequence into port 0; what came back before is counted."""
        self._call("send", frame, len(frame))

    def take_machine(self) -> None:
        """From now on the inputs are the caller's; `tick` begins just before a control tick."""
        self._call("take_machine")
        self.align()

    def align(self) -> None:
        """Let time pass until a control tick is about to begin."""
        self._call("align", BEFORE)

    def tick(self) -> None:
        """One control tick, from `align` on. Raises OverflowError if its pass does not end."""
        before = self.counts()["ticks"]
        self.run(CYCLE_CLOCKS * CLOCK_NS)
        if self.counts()["ticks"] != before + 1:
            self.run(CYCLE_CLOCKS * CLOCK_NS)
            raise OverflowError(
                f"control pass {before} takes {self.counts()['last']} cycles of {CYCLE_CLOCKS}"
            )

    def take(self, descriptor: int) -> int:
        """Frames that a master has put into a TAP device onto the wire; waits for one, 1 s at most.

        Returns how many there were."""
        return self._call("take", descriptor, 1000)

    def give(self, descriptor: int) -> None:
        """What has come back to the master through the TAP device."""
        self._call("give", descriptor)
