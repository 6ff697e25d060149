# SPDX-License-Identifier: Apache-2.0
"""The device on the bus, Verilated: slave controller and Nios II system with its program, with an
ideal machine connected to it (device_harness.cpp)."""

from __future__ import annotations

import ctypes

import numpy as np

from sim.bus.verilated import HERE, BusModel, load
from sim.rtl import nios_image
from sim.rtl.nios_map import default_system_map

IMAGES = {100_000: "ethercat", 62_500: "ethercat_16khz"}  # programs by their control cycle, ns
CLOCK_NS = 10
CYCLE_NS = 100_000  # between two control ticks, if nothing else is said
CYCLE_CLOCKS = CYCLE_NS // CLOCK_NS
INPUT_WORDS, OUTPUT_WORDS = 23, 29  # of a control tick: nios_sw/ethercat/ethercat_tick.h
WORD_CLOCKS = 60  # of the machine, for both: a longer pass makes the next tick late (WORDS in C)
FRAME_BYTES = 1600  # at most
BEFORE = 8  # clocks before a control tick at which `DeviceRtl.tick` begins
COUNTS = ("ticks", "last", "longest", "sum", "overrun", "sent", "returned", "late")


class DeviceRtl(BusModel):
    """One device with its program running, a control tick each `cycle_ns`, or with SYNC0.

    cycle_ns: one of IMAGES. inputs (23,), outputs (29,): words of the next tick and of the last
    one, uint32. The model is built on first use. Raises BuildError.
    """

    prefix = "device"

    def __init__(self, cycle_ns: int = CYCLE_NS) -> None:
        longs = ("device_now", "device_count", "device_time", "device_clocks")
        self.cycle_clocks = cycle_ns // CLOCK_NS
        parameters = {"Period": self.cycle_clocks} if cycle_ns != CYCLE_NS else None
        harness = HERE / "device_harness.cpp"
        super().__init__(load("ethercat_nios", harness, longs, parameters=parameters))
        self._lib.device_console.restype = ctypes.c_char_p
        self.inputs = self._words("inputs", INPUT_WORDS)
        self.outputs = self._words("outputs", OUTPUT_WORDS)
        program, system = nios_image.load(IMAGES[cycle_ns]), default_system_map()
        for memory in system.memories.values():
            words = np.zeros(memory.words, dtype=np.uint32)
            words[: len(program.memories[memory.name])] = program.memories[memory.name]
            self._call("load", ctypes.c_uint32(memory.base), words.ctypes, memory.words)
        bases = [system.base(block) for block in ("inputs", "outputs")]
        self._call("start", *map(ctypes.c_uint32, bases), self.cycle_clocks)

    def _words(self, name: str, count: int) -> np.ndarray:
        getattr(self._lib, f"device_{name}").restype = ctypes.POINTER(ctypes.c_uint32 * count)
        return np.ctypeslib.as_array(self._call(name).contents)

    def counts(self) -> dict[str, int]:
        """COUNTS: ticks, clock cycles of the last, the longest and all of them, whether one was not
        served, frames, and ticks that were due before the pass of the one before had ended."""
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

    def received(self) -> list[bytes]:
        """Frames that have come back with a right check sequence, without it."""
        room, found = ctypes.create_string_buffer(FRAME_BYTES), []
        while count := self._call("receive", room, FRAME_BYTES):
            found.append(room.raw[:count])
        return found

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
        self.run(self.cycle_clocks * CLOCK_NS)
        if self.counts()["ticks"] != before + 1:
            self.run(self.cycle_clocks * CLOCK_NS)
            raise OverflowError(
                f"control pass {before} takes {self.counts()['last']} cycles of {self.cycle_clocks}"
            )

    def take(self, descriptor: int) -> int:
        """Frames that a master has put into a TAP device onto the wire; waits for one, 1 s at most.

        Returns how many there were."""
        return self._call("take", descriptor, 1000)

    def give(self, descriptor: int) -> None:
        """What has come back to the master through the TAP device."""
        self._call("give", descriptor)
