# SPDX-License-Identifier: Apache-2.0
"""The Verilated ci_bench: custom instructions given as the CPU does; their results and cycles."""

from __future__ import annotations

import ctypes

import numpy as np

from sim.rtl.build import ROOT, build_library
from sim.rtl.custom_table import Instruction, load
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated
from tests.bench.seed import SEED
from tests.fpu.tb import generator

BENCH = ROOT / "sim/rtl/ci_bench.sv"
HARNESS = ROOT / "sim/rtl/ci_harness.cpp"
HIERARCHY = ROOT / "sim/rtl/ci_bench.vlt"
# select_i of ci_bench; the combinational components have outputs of their own.
SLAVES = {"fpga1": 1, "fpga2": 2}
ALONE = {
    name: place
    for place, name in enumerate(
        "fadd fsub fmul fdiv fsqrt fsin fcos fsat floatis fixsi fph1".split(), start=3
    )
}
FROM_CPU = 0b111 << 15  # writerc, readrb, readra
HALF = 128  # stalls: clk_en is low in this many of 256 cycles
PLATFORMS = load()  # records of nios_sw/custom.toml


def fields(item: Instruction) -> int:
    """Fields of the instruction word: where c, a, b come from."""
    return sum((item.registers[place] == "r") << bit for place, bit in ((0, 17), (1, 15), (2, 16)))


class CiBench(Verilated):
    """One model with every component."""

    prefix = "ci"

    def __init__(self) -> None:
        sources = [HIERARCHY, *sources_of("ci_bench", (ROOT / "rtl", BENCH.parent))]
        pointer, u32 = ctypes.c_void_p, ctypes.c_uint32
        signatures = {
            "run": (None, pointer, u32, u32, u32, u32, ctypes.c_uint64, pointer),
            "abandon": (None, pointer, u32),
            "done_when_idle": (u32, pointer, u32),
            "combinational": (None, pointer, u32, pointer),
        }
        super().__init__(build_library("ci_bench", sources, HARNESS), signatures)

    def run(
        self,
        select: int,
        n: int | np.ndarray,
        a: np.ndarray,
        b: np.ndarray | int = 0,
        registers: int | np.ndarray = FROM_CPU,
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
        self._lib.ci_run(
            self._handle,
            ops.ctypes.data,
            len(ops),
            cycles,
            stalls,
            gaps,
            int(generator("ci pins").integers(1 << 62)) + SEED,
            answer.ctypes.data,
        )
        return answer[:, 0].copy(), answer[:, 1].copy()

    def combinational(
        self, n: int | np.ndarray, a: np.ndarray, b: np.ndarray | int = 0
    ) -> dict[str, np.ndarray]:
        """Outputs of ci_fcmp, ci_fsign and the combinational group of both platforms."""
        ops = _rows(0, n, a, b, FROM_CPU)
        answer = np.zeros((len(ops), 4), dtype=np.uint32)
        self._lib.ci_combinational(self._handle, ops.ctypes.data, len(ops), answer.ctypes.data)
        return {
            name: answer[:, i].copy()
            for i, name in enumerate(("ci_fcmp", "ci_fsign", "fpga1", "fpga2"))
        }

    def abandon(self, select: int, n: int, a: int, b: int, cycles: int) -> None:
        """Start an instruction and reset after `cycles` cycles."""
        op = _rows(select, n, np.array([a]), b, FROM_CPU)
        self._lib.ci_abandon(self._handle, op.ctypes.data, cycles)

    def done_when_idle(self, select: int, n: int, cycles: int) -> int:
        """Cycles with done although nothing was started, out of `cycles`."""
        op = _rows(select, n, np.array([0]), 0, FROM_CPU)
        return self._lib.ci_done_when_idle(self._handle, op.ctypes.data, cycles)


def _rows(select, n, a, b, registers) -> np.ndarray:
    columns = np.broadcast_arrays(np.uint32(select), n, a, b, registers)
    return np.ascontiguousarray(np.stack(columns, axis=1).astype(np.uint32))
