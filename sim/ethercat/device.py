# SPDX-License-Identifier: Apache-2.0
"""The device on the bus, Verilated: slave controller and Nios II system with its program, with an
ideal machine behind it (device_harness.cpp)."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from asip_asm.project import ROOT
from sim.harness.build import build_library
from sim.harness.nios_image import Program
from sim.harness.nios_map import default_system_map
from sim.harness.sources import sources_of
from sim.harness.waves import load_model

HERE = Path(__file__).parent
TOP = "ethercat_nios"
CLOCK_NS = 10
INPUT_WORDS, OUTPUT_WORDS = 16, 29  # of a control tick: nios_sw/ethercat/ethercat_tick.h
BEFORE = 8  # clocks before a control tick at which `DeviceRtl.tick` begins
COUNTS = ("ticks", "last", "longest", "sum", "overrun", "sent", "returned")


class DeviceRtl:
    """One device with its program running; `tick_clocks` between control ticks, 0: none.

    inputs (16,), outputs (29,): words of the next tick and of the last one, uint32. The model is
    built on first use. Raises BuildError.
    """

    def __init__(self, program: Program, tick_clocks: int = 10_000) -> None:
        self._lib = load_model(
            build_library(
                TOP,
                sources_of(TOP),
                HERE / "device_harness.cpp",
                headers=[HERE / "ring.h", HERE / "capture.h"],
                harness_flags=["-I", str(ROOT / "sim/harness"), "-I", str(HERE)],
            )
        )
        self._lib.device_new.restype = ctypes.c_void_p
        self._lib.device_console.restype = ctypes.c_char_p
        for name in ("device_now", "device_count"):
            getattr(self._lib, name).restype = ctypes.c_uint64
        words = {"device_inputs": INPUT_WORDS, "device_outputs": OUTPUT_WORDS}
        for name, count in words.items():
            getattr(self._lib, name).restype = ctypes.POINTER(ctypes.c_uint32 * count)
        self._device = ctypes.c_void_p(self._lib.device_new())
        self.inputs = np.ctypeslib.as_array(self._lib.device_inputs(self._device).contents)
        self.outputs = np.ctypeslib.as_array(self._lib.device_outputs(self._device).contents)
        self._tick_clocks = tick_clocks
        system = default_system_map()
        for memory in system.memories.values():
            words = np.zeros(memory.words, dtype=np.uint32)
            words[: len(program.memories[memory.name])] = program.memories[memory.name]
            self._lib.device_load(
                self._device, ctypes.c_uint32(memory.base), words.ctypes, memory.words
            )
        bases = [system.base(block) for block in ("inputs", "outputs")]
        self._lib.device_start(self._device, *map(ctypes.c_uint32, bases), tick_clocks)

    def close(self) -> None:
        """End the model."""
        if self._device:
            self._lib.device_delete(self._device)
            self._device = None

    def run(self, ns: int) -> None:
        """Let time pass."""
        self._lib.device_run(self._device, ctypes.c_uint64(ns))

    @property
    def now(self) -> int:
        """Simulated time, ps."""
        return self._lib.device_now(self._device)

    def counts(self) -> dict[str, int]:
        """COUNTS: ticks, clock cycles of the last, the longest and all of them, frames."""
        return {name: self._lib.device_count(self._device, n) for n, name in enumerate(COUNTS)}

    def restart_counts(self) -> None:
        """Count ticks anew."""
        self._lib.device_restart_counts(self._device)

    @property
    def console(self) -> str:
        """What the program has written."""
        return self._lib.device_console(self._device).decode()

    def send(self, frame: bytes) -> None:
        """A frame without check sequence into port 0; what comes back is dropped."""
        self._lib.device_send(self._device, frame, len(frame))

    def take_machine(self) -> None:
        """From now on the inputs are the caller's; `tick` begins just before a control tick."""
        self._lib.device_take_machine(self._device)
        self.align()

    def align(self) -> None:
        """Let time pass until a control tick is about to begin."""
        self._lib.device_align(self._device, BEFORE)

    def tick(self) -> None:
        """One control tick, from `align` on. Raises OverflowError if its pass does not end."""
        before = self.counts()["ticks"]
        self.run(self._tick_clocks * CLOCK_NS)
        if self.counts()["ticks"] != before + 1:
            self.run(self._tick_clocks * CLOCK_NS)
            raise OverflowError(
                f"control pass {before} takes {self.counts()['last']} cycles of {self._tick_clocks}"
            )

    def capture(self, path: Path) -> None:
        """Write what passes port 0 to a pcap file. Raises OSError."""
        if not self._lib.device_capture(self._device, str(path).encode()):
            raise OSError(f"{path} cannot be written")

    def take(self, descriptor: int) -> int:
        """Frames that a master has put into a TAP device onto the wire; waits for one, 1 s at most.

        Returns how many there were."""
        return self._lib.device_take(self._device, descriptor, 1000)

    def give(self, descriptor: int) -> None:
        """What has come back to the master behind the TAP device."""
        self._lib.device_give(self._device, descriptor)

    def serve(self, descriptor: int) -> None:
        """Join port 0 to a TAP device until `stop`, from another thread."""
        self._lib.device_serve(self._device, descriptor)

    def stop(self) -> None:
        """End `serve`."""
        self._lib.device_stop(self._device)
