# SPDX-License-Identifier: Apache-2.0
"""The quadrature decoder over very many edges, as fast as its contract allows: decoder_edges.cpp.

A campaign is made of pieces with a seed each; those done are cached (`BUILD/servo`), under a name
with a hash of the sources in it, so that one that was stopped goes on.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from asip_asm.project import BUILD, ROOT
from sim.rtl.build import build_library
from sim.rtl.sources import sources_of
from sim.rtl.waves import load_model
from tests.servo import clocked

TOP = "quadrature_decoder"
HARNESS = Path(__file__).with_suffix(".cpp")
PIECE = 10_000_000  # edges
PLANTED = 1000  # changes of both lines at once, a piece


def library() -> Path:
    """The model with the harness, built once per content."""
    include = (f"-I{ROOT / 'sim/rtl'}",)
    return build_library(TOP, sources_of(TOP, clocked.FOLDERS), HARNESS, harness_flags=include)


def legal(seed: int, edges: int) -> tuple[int, int]:
    """(clocks in which the count or the flag was wrong, clocks simulated)."""
    function = load_model(library()).decoder_legal
    function.restype, u64 = ctypes.c_uint64, ctypes.c_uint64
    function.argtypes = [u64, u64, ctypes.POINTER(u64)]
    clocks = u64()
    return function(seed, edges, ctypes.byref(clocks)), clocks.value


def illegal(seed: int, planted: int = PLANTED) -> int:
    """Of changes of both lines at once, those not flagged, not counted, or moving the position."""
    function = load_model(library()).decoder_illegal
    function.restype, u64 = ctypes.c_uint64, ctypes.c_uint64
    function.argtypes = [u64, u64]
    return function(seed, planted)


@dataclass(frozen=True)
class Campaign:
    """Edges driven, clocks with a wrong count or flag; illegal changes planted, those missed."""

    edges: int
    wrong: int
    planted: int
    missed: int


def campaign(edges: int, report: Callable[[str], None] = lambda line: None) -> Campaign:
    """At least so many edges, those of earlier calls counted."""
    place = BUILD / "servo" / f"decoder_{library().parent.name.rpartition('-')[2]}.json"
    place.parent.mkdir(parents=True, exist_ok=True)
    done = json.loads(place.read_text()) if place.exists() else []
    while len(done) * PIECE < edges:
        seed = len(done) + 1
        done.append([legal(seed, PIECE)[0], illegal(seed)])
        draft = place.with_suffix(".new")
        draft.write_text(json.dumps(done))
        draft.replace(place)
        if seed % 10 == 0:
            report(f"  {seed * PIECE:.2g} of {edges:.2g} edges")
    wrong, missed = (sum(piece[k] for piece in done) for k in (0, 1))
    return Campaign(len(done) * PIECE, wrong, len(done) * PLANTED, missed)
