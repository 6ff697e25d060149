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
COUNTS = ("ticks", "last", "longest", "sum", "overrun", "sent", "returned")


class DeviceRtl:
    """One device with its program running; `tick_clocks` between control ticks, 0: none.

    The model is built on first use. Raises BuildError.
    """

    def __init__(self, program: Program, tick_clocks: int = 10_000) -> None:
        self._lib = load_model(
            build_library(
                TOP,
                sources_of(TOP),
                HERE / "device_harness.cpp",
                headers=[HERE / "ring.h"],
                harness_flags=["-I", str(ROOT / "sim/harness"), "-I", str(HERE)],
            )
        )
        self._lib.device_new.restype = ctypes.c_void_p
        self._lib.device_console.restype = ctypes.c_char_p
        for name in ("device_now", "device_count"):
            getattr(self._lib, name).restype = ctypes.c_uint64
        self._lib.device_output.restype = ctypes.c_uint32
        self._device = ctypes.c_void_p(self._lib.device_new())
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

    def output(self, word: int) -> int:
        """A word that the last tick gave (nios_sw/ethercat/ethercat_tick.h)."""
        return self._lib.device_output(self._device, word)

    def input(self, word: int, value: int) -> None:
        """A word that the next tick takes; positions and digital inputs are the machine's."""
        self._lib.device_input(self._device, word, ctypes.c_uint32(value))

    @property
    def console(self) -> str:
        """What the program has written."""
        return self._lib.device_console(self._device).decode()

    def send(self, frame: bytes) -> None:
        """A frame without check sequence into port 0; what comes back is dropped."""
        self._lib.device_send(self._device, frame, len(frame))

    def serve(self, descriptor: int) -> None:
        """Join port 0 to a TAP device until `stop`, from another thread."""
        self._lib.device_serve(self._device, descriptor)

    def stop(self) -> None:
        """End `serve`."""
        self._lib.device_stop(self._device)
