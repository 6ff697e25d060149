# SPDX-License-Identifier: Apache-2.0
"""The C of a compiled law on this machine: its bits tick by tick, and its time."""

from __future__ import annotations

import ctypes
import hashlib
import os
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.c_image import identifier
from asip_asm.files import replaced, write_text
from asip_asm.model.c_code import to_c_code, words_of
from asip_asm.model.compiler import Compiled
from asip_asm.model.exact import Array
from asip_asm.project import BUILD
from sim.rtl.runtime import seal, sealed, toolchain

HARNESS = Path(__file__).with_name("law.c")
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno", "-std=c11", "-Wall",
         "-Wextra", "-Werror")  # fmt: skip


class CompilerError(RuntimeError):
    """The C compiler is missing or refused a text; the message says what it printed."""


def write_c(compiled: Compiled, stem: Path) -> tuple[Path, Path]:
    """Write STEM.tick.h and STEM.tick.c; returns both. Raises ModelError, OSError."""
    header, source = Path(f"{stem}.tick.h"), Path(f"{stem}.tick.c")
    for path, text in zip((header, source), to_c_code(compiled, header.name), strict=True):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, text)
    return header, source


def pack(words: list[tuple[str, str]], values: Mapping[str, Array]) -> NDArray[np.uint32]:
    """Rows (N, words) of a structure from arrays (N,) by signal."""
    size = len(next(iter(values.values()))) if values else 1
    rows = np.zeros((size, max(1, len(words))), np.uint32)
    for k, (name, _) in enumerate(words):
        rows[:, k] = np.ascontiguousarray(values[name]).view(np.uint32)
    return rows


def unpack(words: list[tuple[str, str]], rows: NDArray[np.uint32]) -> dict[str, Array]:
    """Arrays (N,) by signal from rows of a structure."""
    kinds: dict[str, type[np.float32 | np.int32]] = {"float": np.float32, "int32_t": np.int32}
    return {
        name: np.ascontiguousarray(rows[:, k]).view(kinds[kind])
        for k, (name, kind) in enumerate(words)
    }


@dataclass(frozen=True)
class Ran:
    """N consecutive ticks: outputs, states after each (by signal), results (0: no fault)."""

    outputs: dict[str, Array]
    states: dict[str, Array]
    results: NDArray[np.int32]


@dataclass(frozen=True)
class Times:
    """Nanoseconds of each tick, and the median of what reading the clock takes of it."""

    ticks: NDArray[np.int32]
    clock: float


class NativeLaw:
    """A law's C, compiled for this machine. fused: multiply-adds round once, as on the core.

    Raises CompilerError.
    """

    def __init__(self, compiled: Compiled, fused: bool = True, flags: tuple[str, ...] = FLAGS):
        self.words = words_of(compiled)
        prefix = identifier(compiled.law.title) or "law"
        defines = (f"-DLAW={prefix}", '-DLAW_HEADER="law.tick.h"',
                   f"-D{prefix.upper()}_FUSED={int(fused)}")  # fmt: skip
        texts = to_c_code(compiled, "law.tick.h")
        content = "".join((*texts, HARNESS.read_text(), repr((flags, defines)), toolchain()))
        folder = BUILD / "native" / hashlib.sha256(content.encode()).hexdigest()[:16]
        library = folder / "law.so"
        if not sealed(library):
            _, source = write_c(compiled, folder / "law")
            with replaced(library) as part:
                _compile([*flags, *defines, "-shared", "-fPIC", f"-I{folder}", HARNESS, source,
                          "-o", part, "-lm"])  # fmt: skip
            seal(library)
        self._lib = ctypes.CDLL(str(library))

    def run(self, inputs: Mapping[str, Array], states: Mapping[str, Array]) -> Ran:
        """A tick per row of the inputs (N,), from the states (1,)."""
        rows, state = pack(self.words["inputs"], inputs), pack(self.words["states"], states)
        n = len(rows)
        outputs = np.zeros((n, max(1, len(self.words["outputs"]))), np.uint32)
        after = np.zeros((n, state.shape[1]), np.uint32)
        results = np.zeros(n, np.int32)
        pointers = (
            a.ctypes.data_as(ctypes.c_void_p) for a in (rows, state, outputs, after, results)
        )
        self._lib.run(ctypes.c_long(n), *pointers)
        return Ran(
            unpack(self.words["outputs"], outputs), unpack(self.words["states"], after), results
        )

    def sine(self, angles: NDArray[np.float32], cosine: bool) -> NDArray[np.float32]:
        """Sine or cosine by the C library, which the law calls: for the exact interpreter."""
        angles = np.ascontiguousarray(angles)
        found = np.empty_like(angles)
        self._lib.sines(ctypes.c_long(len(angles)), _pointer(angles), int(cosine), _pointer(found))
        return found

    def time(self, inputs: Mapping[str, Array], runs: int, cpu: int | None = None) -> Times:
        """Time of so many ticks, one by one, on one processor or on any.

        Raises CompilerError if the processor cannot be had.
        """
        rows = pack(self.words["inputs"], inputs)
        ticks, clock = np.zeros(runs, np.int32), np.zeros(runs, np.int32)
        pointers = [_pointer(array) for array in (rows, ticks, clock)]
        failed = self._lib.time_ticks(
            ctypes.c_long(runs), ctypes.c_long(len(rows)), pointers[0],
            -1 if cpu is None else cpu, *pointers[1:],
        )  # fmt: skip
        if failed:
            raise CompilerError(f"processor {cpu} cannot be had; `taskset -p $$` shows which can")
        return Times(ticks, float(np.median(clock)))


def _pointer(array: NDArray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def _compile(arguments: list[str | Path]) -> None:
    command = [os.environ.get("CC", "cc"), *map(str, arguments)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise CompilerError(f"no C compiler '{command[0]}'; apt install gcc, or set CC") from None
    if done.returncode:
        raise CompilerError(f"{' '.join(command)}\n{done.stderr}")
