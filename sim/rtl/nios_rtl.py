# SPDX-License-Identifier: Apache-2.0
"""The Nios II systems FPGA1 and FPGA2 as Python objects: Verilated model, programs, ticks."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.rtl.build import build_library, file_list
from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.nios_image import Program
from sim.rtl.nios_map import default_system_map
from sim.rtl.verilated import Verilated

HARNESS = Path(__file__).with_name("nios_harness.cpp")
STAGES = HARNESS.with_name("nios_stages.vlt")
FILES = "nios/n2_system.f"
PLATFORMS = {"fpga1": 1, "fpga2": 2}
# An instruction of a trace: its first cycle in each stage, and the first cycle after the last one.
STEP = np.dtype(
    [(name, np.uint64) for name in ("decode", "execute", "memory", "align", "end")]
    + [(name, np.uint32) for name in ("pc", "word", "value", "flags")]
)
TICK_LIMIT = 1_000_000  # cycles; a tick that takes longer never ends


class NiosError(RuntimeError):
    """The program did not do what was asked; the message says what happened and when."""


@dataclass(frozen=True)
class NiosTicks:
    """N ticks: outputs (N, 5) and extra words (N, extras) as raw words, cycles (N,)."""

    outputs: NDArray[np.uint32]
    extra: NDArray[np.uint32]
    cycles: NDArray[np.uint32]


class NiosRtl(Verilated):
    """One system, 'fpga1' or 'fpga2', in reset until `start`. Data are raw 32-bit words.

    `debug` builds it with the debug module (rtl/nios/n2_debug.sv), which a debugger drives.

    The model is built on first use. Raises NiosError, and BuildError from the first use.
    """

    prefix = "nios"

    def __init__(self, platform: str, debug: bool = False) -> None:
        library = build_library(
            "n2_system",
            [STAGES, *file_list(FILES)],
            HARNESS,
            {"Platform": PLATFORMS[platform], "Trace": 1, **({"Debug": 1} if debug else {})},
        )
        self.platform = platform
        self.map = default_system_map()
        integer, u32, u64, pointer = ctypes.c_int, ctypes.c_uint32, ctypes.c_uint64, ctypes.c_void_p
        words = (u32, u32, pointer)  # address, number, where
        signatures = {
            "cycles": (u64,),
            "retired": (u32,),
            "pc": (u32,),
            "overrun": (u32,),
            "write": (None, u32, pointer, u32),
            "read": (None, u32, pointer, u32),
            "run": (None, u32, u32),
            "clock": (None, u32),
            "tick": (None,),
            "execute": (integer, u64, pointer),
            "debug": (None, pointer, u32),
            "halted": (u32,),
            "until_halt": (integer, u64),
            "ended": (integer, pointer),
            "console": (u32, pointer, u32),
            "console_clear": (None,),
            "guard": (None, u64, pointer, u32),
            "stray": (integer, pointer),
            "profile": (None, u32, u32, u32),
            "profile_read": (None, pointer, pointer),
            "trace": (None, u64, u64),
            "traced": (u64, pointer),
            "ticks": (u32, u32, *words, *words, pointer, u32, pointer, pointer, u64),
        }
        super().__init__(library, signatures)

    # ------------------------------------------------------------------ memories
    def write(self, address: int, words: Sequence[int] | NDArray[np.uint32]) -> None:
        """Write words from a byte address on: memories (itcm in reset only) or the block input."""
        data = np.ascontiguousarray(words, dtype=np.uint32)
        self._call("write", address, data.ctypes.data, len(data))

    def read(self, address: int, words: int = 1) -> NDArray[np.uint32]:
        """Read words from a byte address on: memories (itcm in reset only) or the block output."""
        data = np.zeros(words, dtype=np.uint32)
        self._call("read", address, data.ctypes.data, words)
        return data

    def load(self, program: Program) -> None:
        """Hold the core in reset and fill both memories, with 0 beyond the program."""
        self.hold()
        for memory in self.map.memories.values():
            words = np.zeros(memory.words, dtype=np.uint32)
            words[: len(program.memories[memory.name])] = program.memories[memory.name]
            self.write(memory.base, words)
        self.program = program

    def hold(self) -> None:
        """Hold the core in reset."""
        self._call("run", 0, 0)
        self.clock(2)

    def start(self, enable: bool = False) -> None:
        """Let the core run from its reset vector. enable: the host wants control."""
        self._call("run", 1, int(enable))

    def clock(self, cycles: int = 1) -> None:
        """Let time pass."""
        self._call("clock", cycles)

    def tick(self) -> None:
        """Start a control tick and do not wait for its end; `ticks` does both."""
        self._call("tick")

    @property
    def cycles(self) -> int:
        """Clock cycles simulated since the model was made."""
        return int(self._call("cycles"))

    @property
    def retired(self) -> int:
        """Instructions completed since the start, modulo 2^32."""
        return int(self._call("retired"))

    @property
    def pc(self) -> int:
        """Byte address of the last instruction completed."""
        return int(self._call("pc"))

    @property
    def overrun(self) -> bool:
        """A tick came while one was pending."""
        return bool(self._call("overrun"))

    # ------------------------------------------------------------------ programs
    def execute(self, limit: int) -> int:
        """Run until the program ends by the register EXIT or by `break 1`; returns its status.

        Raises NiosError after `limit` cycles.
        """
        status = self.advance(limit)
        if status is None:
            raise NiosError(f"{self.program.name} did not end within {limit} cycles")
        return status

    def advance(self, cycles: int) -> int | None:
        """Let the program run on for at most so many cycles; its status once it has ended.

        Stops early at an access that `guard` finds.
        """
        return self._word("execute", cycles)

    def guard(self) -> None:
        """Let `advance` and `until_halt` stop at a load or store where there is neither memory nor
        I/O. The hardware ignores such stores and loads 0.
        """
        regions = [(m.base, m.base + 4 * m.words) for m in self.map.memories.values()]
        regions.append((self.map.io.base, self.map.io.base + self.map.io.bytes))
        ranges = np.array(regions, dtype=np.uint32).ravel()
        accessing = sum(
            1 << record.op
            for record in default_isa().instructions.values()
            if record.unit in ("load", "store")
        )
        self._call("guard", accessing, ranges.ctypes.data, len(ranges))

    @property
    def stray(self) -> int | None:
        """Address of the access that `guard` stopped; None: there was none."""
        return self._word("stray")

    @property
    def console(self) -> str:
        """What the program wrote to the console, without what `take_console` took."""
        return self._console().decode("latin-1")

    def take_console(self) -> bytes:
        """What the program wrote to the console since the last call."""
        text = self._console()
        self._call("console_clear")
        return text

    def _console(self) -> bytes:
        length = self._call("console", None, 0)
        text = ctypes.create_string_buffer(length + 1)
        self._call("console", text, length)
        return text.raw[:length]

    def ticks(self, words: NDArray[np.uint32], extra: Sequence[int] = ()) -> NiosTicks:
        """Run a control tick per row of `words` (N, inputs); read outputs and `extra` addresses."""
        system = self.map
        words = np.ascontiguousarray(words, dtype=np.uint32)
        if words.shape[1] != len(system.inputs):
            raise ValueError(f"{words.shape[1]} input words, must be {len(system.inputs)}")
        n = len(words)
        addresses = np.asarray(extra, dtype=np.uint32)
        outputs = np.zeros((n, len(system.outputs)), dtype=np.uint32)
        extras = np.zeros((n, len(addresses)), dtype=np.uint32)
        cycles = np.zeros(n, dtype=np.uint32)
        done = self._call(
            "ticks",
            n,
            system.base("inputs"),
            words.shape[1],
            words.ctypes.data,
            system.base("outputs"),
            outputs.shape[1],
            outputs.ctypes.data,
            addresses.ctypes.data,
            len(addresses),
            extras.ctypes.data,
            cycles.ctypes.data,
            TICK_LIMIT,
        )
        if done < n:
            raise NiosError(
                f"{self.platform}: tick {done} of {n} did not end within {TICK_LIMIT} cycles"
            )
        return NiosTicks(outputs, extras, cycles)

    # ------------------------------------------------------------------ debug module
    def debug(self, accesses: Sequence[tuple[int, int | None]]) -> list[int]:
        """Accesses to the debug module: (register, word to write, or None to read).

        Returns what was read, in order.
        """
        words = np.zeros((len(accesses), 3), dtype=np.uint32)
        for row, (register, data) in zip(words, accesses, strict=True):
            row[:] = register, data is not None, data or 0
        self._call("debug", words.ctypes.data, len(words))
        return [int(data) for _, write, data in words if not write]

    @property
    def halted(self) -> bool:
        """The debug module has halted the core."""
        return bool(self._call("halted"))

    def until_halt(self, cycles: int) -> bool:
        """Let the program run until it halts, ends or strays; whether it has halted."""
        return bool(self._call("until_halt", cycles))

    @property
    def ended(self) -> int | None:
        """Status of a program that has ended; None: it has not."""
        return self._word("ended")

    # ------------------------------------------------------------------ profile
    def profile(self, whole: bool = False) -> None:
        """Start (and empty) the profile: cycles per instruction during control ticks, or always."""
        code = self.map.memories["itcm"]
        self._call("profile", code.base, code.words, int(whole))

    def profiled(self) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
        """Per word of the instruction memory: cycles spent, instructions completed."""
        words = self.map.memories["itcm"].words
        spent, completed = np.zeros(words, np.uint64), np.zeros(words, np.uint64)
        self._call("profile_read", spent.ctypes.data, completed.ctypes.data)
        return spent, completed

    # ------------------------------------------------------------------ trace
    def trace(self, count: int, skip: int = 0) -> None:
        """Start a trace of `count` instructions, after the next `skip`; 0 ends one."""
        self._call("trace", skip, count)

    def traced(self) -> NDArray[np.void]:
        """The instructions of the trace in the order in which they left the pipeline, as STEP."""
        steps = np.zeros(self._call("traced", None), STEP)
        self._call("traced", steps.ctypes.data)
        return steps
