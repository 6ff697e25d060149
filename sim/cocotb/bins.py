# SPDX-License-Identifier: Apache-2.0
"""Functional coverage: which bins the checks of a cocotb test have hit.

A bin is a name of several words, such as `rounding fp_add tie`. The first hit of a bin in a
simulation is appended to the file that BINS of the environment names; without it nothing is done.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.cocotb import golden

FLAGS = {"nv": golden.NV, "dz": golden.DZ, "of": golden.OF, "uf": golden.UF, "nx": golden.NX}
LARGEST = 0x7F7FFFFF
_hit: set[str] = set()


def hit(*words: object) -> None:
    """Note that a bin was hit."""
    name = " ".join(map(str, words))
    if name not in _hit and os.environ.get("BINS"):
        with Path(os.environ["BINS"]).open("a", encoding="utf-8") as file:
            file.write(name + "\n")
    _hit.add(name)


def read(files: Iterable[Path]) -> set[str]:
    """All bins that are in the files."""
    return {line for file in files for line in file.read_text(encoding="utf-8").splitlines()}


def results(operation: str, bits: NDArray[np.uint32], raised: NDArray[np.uint8]) -> None:
    """Exceptions of an operation, and the classes of its results: bins `exception`, `result`."""
    for name, flag in FLAGS.items():
        if np.any(raised & flag):
            hit("exception", operation, name)
    if np.any(raised == 0):
        hit("exception", operation, "none")
    size = bits & 0x7FFFFFFF
    classes = {
        "zero": size == 0,
        "subnormal": (size > 0) & (size < 0x00800000),
        "normal": (size >= 0x00800000) & (size <= LARGEST),
        "infinite": size == 0x7F800000,
        "nan": size > 0x7F800000,
    }
    for name, those in classes.items():
        if np.any(those):
            hit("result", operation, name)


def rounding(operation: str, exact: Fraction, bits: int) -> None:
    """Which way a finite result was rounded: bins `rounding`, up and down being in size."""
    if bits & 0x7FFFFFFF > LARGEST:
        return
    got = fraction(bits)
    if exact == got:
        hit("rounding", operation, "exact")
        return
    way = "up" if abs(got) > abs(exact) else "down"
    size = bits & 0x7FFFFFFF
    near = size - 1 if way == "up" else size + 1
    tie = near <= LARGEST and abs(fraction(near)) + abs(got) == 2 * abs(exact)
    hit("rounding", operation, f"tie_{way}" if tie else way)


def fraction(bits: int) -> Fraction:
    """Value of a finite number."""
    return Fraction(float(np.uint32(bits).view(np.float32)))
