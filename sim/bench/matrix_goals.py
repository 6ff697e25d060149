# SPDX-License-Identifier: Apache-2.0
"""Goals of programs whose constants come from streams: cycles, bits, error and use of the pipes.

The program is a product of a constant 16x16 matrix and a vector, `cosine_transform.s`. The
reference is the formula of its matrix in double precision, not the words of its image.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.project import ROOT
from sim.core.api import Core
from sim.report.goals import Goal, at_least, at_most, exactly

PROGRAM = ROOT / "asip_asm/programs/cosine_transform.s"
SIZE = 16
SEED = 20261126
INPUTS = {False: 100, True: 10_000}
SHARE = 80.0  # per cent of the slots, as for the products of a policy
HALF_ULP = 2.0**-24


def matrix() -> np.ndarray:
    """Matrix of the cosine transform (DCT-II), (rows, columns)."""
    row, column = np.mgrid[:SIZE, :SIZE]
    return np.cos(np.pi * row * (2 * column + 1) / (2 * SIZE))


def rows(full: bool) -> Iterator[Goal]:
    """Rows of the matrix-vector product; the instruction-set model runs every input."""
    image = assemble(PROGRAM)
    x = np.random.default_rng(SEED).normal(size=(INPUTS[full], SIZE)).astype(np.float32)
    inputs = {f"x{i}": x[:, i] for i in range(SIZE)}
    results = {}
    for backend in ("rtl", "iss"):
        with Core(image, backend=backend) as core:
            results[backend] = core.batch(inputs)
    rtl, iss = results["rtl"], results["iss"]
    names = [f"y{i}" for i in range(SIZE)]
    assert rtl.cycles is not None and image.cycles is not None
    off = int((rtl.cycles != image.cycles).sum())
    yield exactly(
        "matrix product 16x16: runs whose cycles are not those announced",
        off,
        0,
        "",
        f"{image.cycles} cycles, {len(x)} runs",
    )
    unequal = sum(
        int((rtl[name].view(np.uint32) != iss[name].view(np.uint32)).sum()) for name in names
    )
    cure = "make goals T=matrix RUN=full runs 10 000 inputs"
    yield exactly("matrix product 16x16: words unlike the model's", unequal, 0, "", cure)
    right = x.astype(float) @ matrix().T
    # SIZE roundings of a sum and one of each matrix word: |error| <= (SIZE + 1) u sum |w| |x| to
    # first order in u. The factor 1.01 covers the rest.
    bound = 1.01 * (SIZE + 1) * HALF_ULP * (np.abs(x).astype(float) @ np.abs(matrix()).T)
    error = np.abs(np.stack([rtl[name] for name in names], axis=1) - right)
    worst = float((error / bound).max())
    yield at_most("matrix product 16x16: largest error, of its bound", worst, 1.0, "", cure)
    products = SIZE * SIZE
    share = 100 * products / (2 * image.cycles)
    yield at_least("matrix product 16x16: multiply-add slots used", share, SHARE, "%")
