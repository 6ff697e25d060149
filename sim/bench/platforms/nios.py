# SPDX-License-Identifier: Apache-2.0
"""The C of a compiled law on the Nios II systems, in RTL: its bits and its cycles."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.c_image import identifier
from asip_asm.model.c_code import struct_members
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array
from asip_asm.project import ROOT
from sim.laws.native.law import CompilerError, Ran, pack, unpack, write_c
from sim.rtl.nios_image import Program
from sim.rtl.nios_rtl import NiosRtl

MAIN = ROOT / "nios_sw/src/law_main.c"
COMPILER = ROOT / "nios_sw/nios-gcc"
# As nios_sw/Makefile compiles the tracking law.
FLAGS = ("-std=c11", "-O3", "-Wall", "-Wextra", "-Werror", "-fno-schedule-insns",
         "-frename-registers", "-fno-tree-coalesce-vars")  # fmt: skip
SYSTEM = "fpga2"
CYCLES_PER_TICK = 1_000_000  # a tick that takes longer never ends


@dataclass(frozen=True)
class NiosRan(Ran):
    """N ticks as on this machine, and the cycles of each."""

    cycles: NDArray[np.uint32]


def build_elf(compiled: Compiled, folder: Path, rows: int) -> Path:
    """The program that runs the law over at most so many rows; its path. Raises CompilerError, also
    without cross compiler, and where the rows do not fit.

    Its C is written to `folder` too.
    """
    prefix = identifier(compiled.law.title) or "law"
    header, source = write_c(compiled, folder / prefix)
    elf = folder / f"{prefix}_{SYSTEM}.elf"
    command = [COMPILER, "--system", SYSTEM, *FLAGS, f"-I{folder}", f"-DLAW={prefix}",
               f'-DLAW_HEADER="{header.name}"', f"-DROWS={rows}",
               "-Wl,--strip-debug", MAIN, source, "-o", elf]  # fmt: skip
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if done.returncode:
        raise CompilerError(done.stderr.strip() or done.stdout.strip())
    return elf


def run_elf(
    program: Program,
    compiled: Compiled,
    inputs: Mapping[str, Array],
    states: Mapping[str, Array],
) -> NiosRan:
    """A tick per row of the inputs (N,), from the states (1,). Raises NiosError, ImageError."""
    words = struct_members(compiled.law)
    rows, state = pack(words["inputs"], inputs), pack(words["states"], states)
    used = 4 * (1 + state.shape[1])
    width = rows.shape[1] + max(1, len(words["outputs"])) + state.shape[1] + 2
    room = (program.symbols["law_run"].size - used) // (4 * width)
    if len(rows) > room:
        raise ValueError(f"{len(rows)} rows, data memory holds {room}")
    rtl = NiosRtl(SYSTEM)
    try:
        rtl.load(program)
        base = program.address("law_run")
        rtl.write(base, np.concatenate(([len(rows)], state[0], rows.ravel())).astype(np.uint32))
        rtl.start()
        status = rtl.execute(CYCLES_PER_TICK * len(rows))
        if status:
            raise CompilerError(f"{program.name} ended with status {status}: {rtl.console}")
        place = base + used + 4 * room * rows.shape[1]

        def block(width: int) -> NDArray[np.uint32]:
            nonlocal place
            found = rtl.read(place, room * width).reshape(room, width)[: len(rows)]
            place += 4 * room * width
            return found

        outputs = unpack(words["outputs"], block(max(1, len(words["outputs"]))))
        after = unpack(words["states"], block(state.shape[1]))
        return NiosRan(outputs, after, block(1)[:, 0].view(np.int32), block(1)[:, 0])
    finally:
        rtl.close()
