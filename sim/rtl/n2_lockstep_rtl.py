# SPDX-License-Identifier: Apache-2.0
"""n2_core's RTL as a Python object: Verilated model, memories, traces, interrupts."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from sim.rtl.build import build_library, file_list
from sim.rtl.n2_lockstep_isa import default_isa
from sim.rtl.verilated import Verilated

HARNESS = Path(__file__).with_name("n2_lockstep.cpp")
ITCM, DTCM = 0x1000_0000, 0x1004_0000
BYTES = 1 << 16  # of each memory
EXCEPTION = ITCM + 0x20
# Combinational custom instructions of the test bench: numbers 224 to 239.
COMBINATIONAL = range(224, 240)
NEVER = 0xFFFF_FFFF
DEPTH = 8  # more instructions than the pipeline holds

RECORD = np.dtype(
    [(n, "u4") for n in ("cycle", "pc", "word", "write", "dst", "value", "exception", "cause")]
)
TRANSFER = np.dtype([(n, "u4") for n in ("cycle", "write", "address", "byteenable", "data")])
START = np.dtype([(n, "u4") for n in ("cycle", "n", "a", "b", "c", "reads", "dataa", "datab")])


class N2Rtl(Verilated):
    """One Verilated core; all data are 32-bit words, addresses byte addresses.

    `parameters` override those of rtl/nios/n2_core.sv (integers). The model is built on first use.
    """

    prefix = "n2"

    def __init__(self, parameters: Mapping[str, int] | None = None) -> None:
        combinational = sum(1 << n for n in COMBINATIONAL)
        values: dict[str, int | str] = {"Trace": 1, "CiCombinational": f"256'h{combinational:x}"}
        library = build_library(
            "n2_core", file_list("nios/n2_core.f"), HARNESS, values | dict(parameters or {}), 1
        )
        u32, pointer = ctypes.c_uint32, ctypes.c_void_p
        signatures = {
            "memory": (ctypes.POINTER(u32), u32, ctypes.POINTER(u32)),
            "reset": (None,),
            "waits": (None, u32, u32),
            "irq": (None, u32, u32),
            "run": (u32, u32, u32, u32),
            **dict.fromkeys(("protocol_errors", "cycles", "retired"), (u32,)),
            **dict.fromkeys(("records", "transfers", "starts"), (u32, pointer, u32)),
        }
        super().__init__(library, signatures)
        self.itcm, self.dtcm, self.avalon = (self._memory(which) for which in range(3))

    def _memory(self, which: int) -> np.ndarray:
        words = ctypes.c_uint32()
        first = self._call("memory", which, ctypes.byref(words))
        return np.ctypeslib.as_array(first, (words.value,))

    def load(self, address: int, data: bytes) -> None:
        """Put bytes into the memory at a byte address; Avalon memory repeats every BYTES.

        Raises ValueError for data that do not fit into one memory.
        """
        memory, start = self.avalon, address % BYTES
        if 0 <= address - ITCM < BYTES:
            memory, start = self.itcm, address - ITCM
        elif 0 <= address - DTCM < BYTES:
            memory, start = self.dtcm, address - DTCM
        if start + len(data) > BYTES:
            raise ValueError(f"error: {len(data)} bytes at {address:#010x} leave their memory")
        memory.view(np.uint8)[start : start + len(data)] = np.frombuffer(data, np.uint8)

    def start(self, image: Sequence[tuple[int, bytes]]) -> None:
        """Clear registers and memories, load (byte address, contents), reset: ready to run.

        Reset does not clear registers; a program of the core's own does. No wait states.
        """
        add = default_isa().instructions["add"]
        words = [add.encode(register, 0, 0) for register in range(1, 32)]
        words += [add.encode(0, 0, 0)] * DEPTH  # after it memory may hold a `call`, which is 0
        self.waits(0)
        self.load(ITCM, np.array(words, "<u4").tobytes())
        self.reset()
        self.run(31 + 1)
        for memory in (self.itcm, self.dtcm, self.avalon):
            memory[:] = 0
        for address, data in image:
            self.load(address, data)
        self.reset()

    def reset(self) -> None:
        """Reset the core and the traces; memories keep their contents."""
        self._call("reset")

    def waits(self, most: int, seed: int = 1) -> None:
        """Avalon transfers wait a random number of cycles, 0 to `most`."""
        self._call("waits", most, seed)

    def irq(self, cycle: int, level: int) -> None:
        """Interrupt lines from a cycle (since reset) on; calls in order of cycles, after reset."""
        self._call("irq", cycle, level)

    def run(self, records: int = NEVER, cycles: int = 100_000, stop_pc: int = NEVER) -> np.ndarray:
        """Run until so many instructions, so many cycles or stop_pc; RECORDs since reset."""
        self._call("run", records, cycles, stop_pc)
        return self._events("records", RECORD)

    @property
    def transfers(self) -> np.ndarray:
        """Avalon transfers since reset."""
        return self._events("transfers", TRANSFER)

    @property
    def starts(self) -> np.ndarray:
        """Multicycle custom instructions since reset."""
        return self._events("starts", START)

    @property
    def protocol_errors(self) -> int:
        """Violations of the Avalon-MM or custom instruction protocol since the model was made."""
        return self._call("protocol_errors")

    @property
    def counters(self) -> tuple[int, int]:
        """Cycles and retired instructions as the core counts them."""
        return self._call("cycles"), self._call("retired")
