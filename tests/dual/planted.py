# SPDX-License-Identifier: Apache-2.0
"""The table of planted faults (faults.toml), and a model that holds all, one chosen at a time.

A model with both cores takes half a minute to build, so there is one: a fault is an expression
`(chosen == id ? wrong : right)`, and `chosen` comes from the environment when a model is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from sim.rtl import build
from sim.rtl.build import ROOT
from tests.bench.faults import BY_NUMBER, RTL, Fault, load, plant, write_if_changed

TABLE = Path(__file__).with_name("faults.toml")
COPY = ROOT / "build/dual/planted"
HARNESS = Path(__file__).with_name("planted_harness.cpp")
VARIABLE = "PLANTED_FAULT"
CHOICE = f"""
  import "DPI-C" function int planted_fault();  // {VARIABLE} of the environment, else 0
  int chosen;
  initial chosen = planted_fault();
"""


def planted(text: str, faults: Sequence[Fault]) -> str:
    """`text` of one module with its faults; without a choice it does what it did."""
    head, ports, body = plant(text, faults, BY_NUMBER).partition("\n);\n")
    return head + ports + CHOICE + body


def sources(faults: Sequence[Fault], original: Sequence[Path]) -> list[Path]:
    """The files of a model, those with faults replaced by copies that hold them."""
    COPY.mkdir(parents=True, exist_ok=True)
    paths = []
    for path in original:
        mine = [fault for fault in faults if RTL / fault.file == path]
        if mine:
            write_if_changed(COPY / path.name, planted(path.read_text(), mine))
        paths.append(COPY / path.name if mine else path)
    return paths


def build_with_faults(
    top: str,
    original: Sequence[Path],
    harness: Path,
    *parameters: Mapping[str, int],
    headers: Sequence[Path] = (),
    **options,
) -> Path:
    """In place of `build.build_library` in `dual_rtl`: the model with all faults of the table."""
    files, headers = sources(load(TABLE), original), [harness, *headers]
    return build.build_library(top, files, HARNESS, *parameters, headers=headers, **options)
