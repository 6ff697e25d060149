# SPDX-License-Identifier: Apache-2.0
"""Goals of programs whose constants come from streams: cycles, bits, error and use of the pipes.

The program is a product of a constant 16x16 matrix and a vector, `cosine_transform.s`, and the same
with a loop and with vectors. The reference is the formula of its matrix in double precision, not
the words of its image.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.core.api import Core
from sim.report.goals import Goal, at_least, at_most, exactly

PROGRAM = ROOT / "asip_asm/programs/cosine_transform.s"
SIZE = 16
SEED = 20261126
INPUTS = {False: 100, True: 10_000}
SHARE = 80.0  # per cent of the slots, as for the products of a policy
HALF_ULP = 2.0**-24
PARTS = 4
"""Partial sums of a row in lanes: as many as the latency needs."""


def matrix() -> np.ndarray:
    """Matrix of the cosine transform (DCT-II), (rows, columns)."""
    row, column = np.mgrid[:SIZE, :SIZE]
    return np.cos(np.pi * row * (2 * column + 1) / (2 * SIZE))


def looped(rounds: int = SIZE // 2 - 1) -> Image:
    """The same product, two columns of the matrix in each round of a loop: the program has as many
    bundles for any number of columns. Rows 0, 2, .. are sums of pipe A, the others of pipe B.
    """

    def column(v: str, first: bool = False) -> list[str]:
        """A column times its input, which is in the register v."""
        operation, last = ("fmul", "") if first else ("fmadd", ", s{0}")
        text = f"{operation} s{{0}}, W{{1}}+, {v}{last}"
        return [text.format(i, "AB"[i % 2]) for i in range(SIZE)]

    words = matrix().astype(np.float32).T  # by columns
    lines = ['.program "cosine transform, looped"', ".config stream"]
    lines += [f".input x{i}" for i in range(SIZE)]
    lines += [*(f".output y{i}, safe = 0" for i in range(SIZE)), f".space x, {SIZE + 1}"]
    for first, pin in enumerate("AB"):
        block = ", ".join(f"{word!r}" for word in words[:, first::2].ravel().tolist())
        lines.append(f".stream W{pin}, pin {pin} = {block}")
    lines += [f"st x{i}, x+{i}" for i in range(SIZE)]
    lines += ["seek WA", "seek WB", "ld v, x", "ld w, x+1", *column("v", True), "ld v, x+2"]
    lines += ["iadd j, zero, 3", *column("w")]
    lines += [f"loop {rounds}", "ld w, x[j]", *column("v"), "ld v, x+1[j]", "iadd j, j, 2"]
    lines += [*column("w"), "endloop", *(f"mov y{i}, s{i}" for i in range(SIZE)), "halt", ""]
    return _assembled(lines)


def in_lanes(repeated: int = 1) -> Image:
    """The same product with vectors: four rows of a column in each operation, so two bundles for a
    column. Four sums of each pair of pipes hide the latency; `repeated` computes the product again,
    which leaves the sums as they are written last.
    """
    words, lanes = matrix().astype(np.float32), default_isa().lanes_of_a_vector
    lines = ['.program "cosine transform, in lanes"', ".config wide"]
    lines += [f".input x{i}" for i in range(SIZE)]
    lines += [f".output y{i}, safe = 0" for i in range(SIZE)]
    rows_of = {"A": (0, 2 * lanes), "B": (lanes, 3 * lanes)}  # first rows of the vectors of a pipe
    for pin, firsts in rows_of.items():
        block = [
            f"{word!r}"
            for column in range(SIZE)
            for first in firsts
            for word in words[first : first + lanes, column].tolist()
        ]
        lines.append(f".vectors W{pin}, pin {pin} = {', '.join(block)}")
    for _ in range(repeated):
        lines += ["seek WA", "seek WB"]
        for column in range(SIZE):
            for first in range(0, SIZE, lanes):
                pin = next(pin for pin, firsts in rows_of.items() if first in firsts)
                vector = f"s{first}_{column % PARTS}"
                sums = f"vfmadd {vector}, W{pin}+, x{column}, {vector}"
                sums += "  ; -Wno-unused-result: the product is computed again" * (repeated > 1)
                lines.append(sums if column >= PARTS else f"vfmul {vector}, W{pin}+, x{column}")
    for row in range(SIZE):
        first, lane = row - row % lanes, row % lanes
        lines.append(f"vout p{row}_0, zero, s{first}_0, {lane}")
        for part in range(1, PARTS):
            lines.append(f"vout p{row}_{part}, p{row}_{part - 1}, s{first}_{part}, {lane}")
        lines.append(f"mov y{row}, p{row}_{PARTS - 1}")
    return _assembled([*lines, "halt", ""])


def _assembled(lines: list[str]) -> Image:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "product.s"
        source.write_text("\n".join(lines), encoding="utf-8")
        return assemble(source)


def rows(full: bool) -> Iterator[Goal]:
    """Rows of the matrix-vector product, straight and in a loop; the instruction-set model runs
    every input.
    """
    name = "matrix product 16x16"
    straight = assemble(PROGRAM)
    yield from _product(name, straight, full)
    assert straight.cycles is not None
    share = 100 * SIZE * SIZE / (2 * straight.cycles)
    yield at_least(f"{name}: multiply-add slots used", share, SHARE, "%")
    yield from _product(f"looped {name}", looped(), full)
    short, long = looped(3).cycles, looped().cycles
    assert short is not None and long is not None
    per_round = (long - short) / (SIZE // 2 - 1 - 3)
    share = 100 * 2 * SIZE / (2 * per_round)
    yield at_least(f"looped {name}: multiply-add slots used in a round", share, SHARE, "%")
    name = f"{name} in lanes"
    yield from _product(name, in_lanes(), full)
    once, twice = in_lanes().cycles, in_lanes(2).cycles
    assert once is not None and twice is not None
    slots = 2 * default_isa().lanes_of_a_vector
    share = 100 * SIZE * SIZE / (slots * (twice - once))
    yield at_least(f"{name}: lane cycles used by its products", share, SHARE, "%")


def _product(name: str, image: Image, full: bool) -> Iterator[Goal]:
    """Rows of one program that computes the product."""
    x = np.random.default_rng(SEED).normal(size=(INPUTS[full], SIZE)).astype(np.float32)
    inputs = {f"x{i}": x[:, i] for i in range(SIZE)}
    results = {}
    for backend in ("rtl", "iss"):
        with Core(image, backend=backend) as core:
            results[backend] = core.batch(inputs)
    rtl, iss = results["rtl"], results["iss"]
    outputs = [f"y{i}" for i in range(SIZE)]
    assert rtl.cycles is not None and image.cycles is not None
    off = int((rtl.cycles != image.cycles).sum())
    yield exactly(
        f"{name}: runs with a cycle count other than announced",
        off,
        0,
        "",
        f"{image.cycles} cycles, {len(x)} runs",
    )
    unequal = sum(int((rtl[y].view(np.uint32) != iss[y].view(np.uint32)).sum()) for y in outputs)
    cure = "make goals T=matrix RUN=full runs 10 000 inputs"
    yield exactly(f"{name}: words that differ from the model", unequal, 0, "", cure)
    right = x.astype(float) @ matrix().T
    # SIZE roundings of a sum and one of each matrix word: |error| <= (SIZE + 1) u sum |w| |x| to
    # first order in u. The factor 1.01 covers the rest.
    bound = 1.01 * (SIZE + 1) * HALF_ULP * (np.abs(x).astype(float) @ np.abs(matrix()).T)
    error = np.abs(np.stack([rtl[y] for y in outputs], axis=1) - right)
    worst = float((error / bound).max())
    yield at_most(f"{name}: largest error as a fraction of its bound", worst, 1.0, "", cure)
