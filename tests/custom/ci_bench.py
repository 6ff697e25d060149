# SPDX-License-Identifier: Apache-2.0
"""The Verilated ci_bench: custom instructions given as the CPU does; their results and cycles."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping

import numpy as np

from scripts.custom_table import Instruction, Platform, load
from sim.harness.build import ROOT, build_library
from sim.harness.sources import sources_of
from sim.harness.waves import load_model
from tests.fpu.tb import generator, seed

BENCH = ROOT / "sim/harness/ci_bench.sv"
HARNESS = ROOT / "sim/harness/ci_harness.cpp"
HIERARCHY = ROOT / "sim/harness/ci_bench.vlt"
# select_i of ci_bench; the combinational components have outputs of their own.
SLAVES = {"fpga1": 1, "fpga2": 2}
ALONE = {
    name: place
    for place, name in enumerate(
        "fadd fsub fmul fdiv fsqrt fsin fcos fsat floatis fixsi fph1".split(), start=3
    )
}
FROM_CPU = 0b111  # writerc, readrb, readra
FIELDS = {"a": 0, "b": 5, "c": 10}
HALF = 128  # stalls: clk_en is low in this many of 256 cycles


@functools.cache
def platforms() -> Mapping[str, Platform]:
    """Records of nios_sw/custom.toml."""
    return load()


def fields(item: Instruction, **registers: int) -> int:
    """Fields of the instruction word: where c, a, b come from, and internal registers."""
    flags = sum((item.registers[place] == "r") << bit for place, bit in ((0, 2), (1, 0), (2, 1)))
    return flags << 15 | sum(value << FIELDS[name] for name, value in registers.items())


class CiBench:
    """One model with every component; closed by the garbage collector."""

    def __init__(self) -> None:
        folders = (ROOT / "rtl", BENCH.parent)
        sources = [HIERARCHY, *sources_of("ci_bench", folders)]
        library = load_model(build_library("ci_bench", sources, HARNESS))
        pointer, u32 = ctypes.c_void_p, ctypes.c_uint32
        library.ci_new.restype = pointer
        library.ci_free.argtypes = [pointer]
        library.ci_run.argtypes = [pointer, pointer, u32, u32, u32, u32, ctypes.c_uint64, pointer]
        library.ci_abandon.argtypes = [pointer, pointer, u32]
        library.ci_done_when_idle.argtypes = [pointer, pointer, u32]
        library.ci_combinational.argtypes = [pointer, pointer, u32, pointer]
        self._library, self._handle = library, library.ci_new()

    def __del__(self) -> None:
        self._library.ci_free(self._handle)

    def run(
        self,
        select: int,
        n: int | np.ndarray,
        a: np.ndarray,
        b: np.ndarray | int = 0,
        registers: int | np.ndarray = FROM_CPU << 15,
        cycles: int = 0,
        stalls: int = 0,
        gaps: int = 0,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(result bits, enabled cycles) of each instruction; `cycles` 0 waits for done.

        `stalls` of 256 cycles have clk_en low, up to `gaps` idle cycles with random pins follow an
        instruction. Cycles 0 in the answer: done never came.
        """
        ops = _rows(select, n, a, b, registers)
        answer = np.zeros((len(ops), 2), dtype=np.uint32)
        self._library.ci_run(
            self._handle,
            ops.ctypes.data,
            len(ops),
            cycles,
            stalls,
            gaps,
            int(generator("ci pins").integers(1 << 62)) + seed(),
            answer.ctypes.data,
        )
        return answer[:, 0].copy(), answer[:, 1].copy()

    def combinational(
        self, n: int | np.ndarray, a: np.ndarray, b: np.ndarray | int = 0
    ) -> dict[str, np.ndarray]:
        """Outputs of ci_fcmp, ci_fsign and the combinational group of both platforms."""
        ops = _rows(0, n, a, b, FROM_CPU << 15)
        answer = np.zeros((len(ops), 4), dtype=np.uint32)
        self._library.ci_combinational(self._handle, ops.ctypes.data, len(ops), answer.ctypes.data)
        return {
            name: answer[:, i].copy()
            for i, name in enumerate(("ci_fcmp", "ci_fsign", "fpga1", "fpga2"))
        }

    def abandon(self, select: int, n: int, a: int, b: int, cycles: int) -> None:
        """Start an instruction and reset after `cycles` cycles."""
        op = _rows(select, n, np.array([a]), b, FROM_CPU << 15)
        self._library.ci_abandon(self._handle, op.ctypes.data, cycles)

    def done_when_idle(self, select: int, n: int, cycles: int) -> int:
        """Cycles with done although nothing was started, out of `cycles`."""
        op = _rows(select, n, np.array([0]), 0, FROM_CPU << 15)
        return self._library.ci_done_when_idle(self._handle, op.ctypes.data, cycles)


def _rows(select, n, a, b, registers) -> np.ndarray:
    columns = np.broadcast_arrays(np.uint32(select), n, a, b, registers)
    return np.ascontiguousarray(np.stack(columns, axis=1).astype(np.uint32))
