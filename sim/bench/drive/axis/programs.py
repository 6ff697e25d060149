# SPDX-License-Identifier: Apache-2.0
"""Programs of one axis as the bench runs them: C with the operations of the core's program."""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.c_image import identifier
from asip_asm.files import write_text
from asip_asm.model.c_code import parameter_macros, struct_members, to_c_code
from asip_asm.model.compiler import Compiled
from asip_asm.project import BUILD
from sim.laws.drive.clocks import MACROS
from sim.rtl import runtime
from sim.rtl.build import machine_flag


@dataclass(frozen=True)
class Program:
    """A compiled law as a function of the bench; first: its states, named, before the first run."""

    tick: ctypes.c_void_p
    first: NDArray[np.float32]
    orders: int
    names: tuple[str, ...]
    library: ctypes.CDLL

    def states(self, values: Mapping[str, float]) -> NDArray[np.float32]:
        """`first`, with these instead, as a host presets them."""
        found = self.first.copy()
        for name, value in values.items():
            found[self.names.index(name)] = value
        return found


def program(
    compiled: Compiled, words: int, parameters: Mapping[str, float] | None = None
) -> Program:
    """Built once per content. words: inputs in front of the orders; parameters: as written."""
    law = compiled.law
    prefix = identifier(law.title) or "law"
    header, source = to_c_code(compiled, "law.tick.h")
    macros = parameter_macros(law, prefix)
    given = sorted((parameters or {}).items())
    defines = [f"-D{macros[name]}={float(np.float32(value))!r}f" for name, value in given]
    texts = [header, source, *defines, runtime.toolchain()]
    folder = BUILD / "servo" / hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]
    path = folder / "law.so"
    with runtime.only_one(folder):
        if not runtime.sealed(path):
            folder.mkdir(exist_ok=True)
            write_text(folder / "law.tick.h", header)
            write_text(folder / "law.c", source)
            options = ["-O2", "-fPIC", "-ffp-contract=off", "-shared", *machine_flag(), "-I."]
            source_file = ["-x", "c", "law.c", "-o", str(path), "-lm"]
            runtime.run([runtime.compiler(), *options, *defines, *source_file], folder)
            runtime.seal(path)
    loaded = ctypes.CDLL(str(path))
    tick = ctypes.cast(getattr(loaded, f"{prefix}_tick"), ctypes.c_void_p)
    names = tuple(name for name, _ in struct_members(law)["states"])
    values = (ctypes.c_float * len(names)).in_dll(loaded, f"{prefix}_initial")
    first = np.array(list(values), dtype=np.float32)
    inputs = len(struct_members(law)["inputs"])
    return Program(tick, first, inputs - words, names, loaded)


def bench_library() -> Path:
    """The plant of one axis, built once per content."""
    here = Path(__file__).parent
    sources = [here / "axis_bench.cpp", here.parent / "plant.h"]
    options = ["-O3", "-fPIC", "-ffp-contract=off", *MACROS]
    texts = [*(file.read_text() for file in sources), *options, runtime.toolchain()]
    folder = BUILD / "servo" / hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]
    path = folder / "axis_bench.so"
    with runtime.only_one(folder):
        if not runtime.sealed(path):
            folder.mkdir(exist_ok=True)
            options += [*machine_flag(), f"-I{here.parent}"]
            built = ["-std=c++17", "-shared", str(sources[0]), "-o", str(path)]
            runtime.run([runtime.compiler(), *options, *built], folder)
            runtime.seal(path)
    return path
