# SPDX-License-Identifier: Apache-2.0
"""The Verilated ASIP with every register and memory open, and the tracking program on it."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.harness import build
from sim.harness.asip_bus import BLOCK, CLEAR, CSR, START, STATUS, load_words, register_address
from sim.iss.path import preset
from sim.model.parameters import Robot
from sim.model.records import COUNTS, OUTPUTS, SET_POINTS
from tests.asip.tracking_path import reversing_path
from tests.silicon.netlist import library_of, make_netlist

PROGRAM = ROOT / "asip_asm/programs/tracking_optimised.s"
HARNESS = ROOT / "sim/harness/upset_harness.cpp"
OPEN = ROOT / "sim/harness/registers.vlt"
FLAGS = ("--flatten", "--vpi")
TOP = "TOP.asip"
TICKS, LATER = 64, 7
"""Ticks of the reference; ticks watched behind the one with the upset."""
UPSET = np.dtype([(name, np.uint32) for name in ("tick", "clock", "site", "element", "bit")])
OUTCOME = np.dtype(
    [(name, np.uint32) for name in ("effect", "cause", "ticks", "unsafe")] + [("worst", np.float64)]
)
EFFECTS = (
    "masked",
    "corrected",
    "wrong once",
    "wrong later",
    "latent",
    "fault reported",
    "run lost",
    "locked up",
)


@contextmanager
def without_assertions() -> Iterator[None]:
    """Models built here have none: an upset is to break what they say."""
    before, build.assertions = build.assertions, False
    try:
        yield
    finally:
        build.assertions = before


class ReferenceError(RuntimeError):
    """The run without an upset did not go through."""


@dataclass(frozen=True)
class Site:
    """A register (one element) or a memory of so many elements of so many bits.

    place: its path in the source, which for a flip-flop of a netlist is not its name.
    """

    name: str
    bits: int
    elements: int
    place: str


def parameters_of(resilient: bool) -> dict[str, int]:
    """Of the core in configuration `fast`."""
    shape = default_isa().configurations["fast"]
    return {
        "FmaPipes": shape.fma_pipes,
        "Slots": len(shape.slots),
        "Resilience": int(resilient),
    }


class Model:
    """One configuration of the core with the program loaded and the reference run.

    idle: clocks between ticks; lengths: clocks of each tick of the host, these included; cycles: of
    the core in a tick; build: a name that changes with the RTL and the harness.
    """

    places: Mapping[str, str] = {}
    """Of sites whose name is not their place."""

    def __init__(self, resilient: bool = False, idle: int = 100) -> None:
        with without_assertions():
            library = self._library(resilient)
        self.build = library.parent.name
        self._resilient, self._idle = resilient, idle
        self._lib = ctypes.CDLL(str(library))
        self._lib.upset_new.restype = ctypes.c_void_p
        self._lib.upset_free.argtypes = [ctypes.c_void_p]
        self._lib.upset_read.restype = ctypes.c_uint32
        self._lib.upset_sites.argtypes = [ctypes.c_void_p]
        self._lib.upset_sites.restype = ctypes.c_char_p
        self._handle = self._lib.upset_new()
        lines = self._lib.upset_sites(self._handle).decode().splitlines()
        self.sites = [
            Site(name, int(bits), int(n), self.places.get(name, name))
            for name, bits, n in (line.split() for line in lines)
        ]
        self.image: Image = assemble(PROGRAM)
        self.lengths = self._reference()
        self.cycles: int = self._lib.upset_read(ctypes.c_void_p(self._handle), CSR["CYCLES"])

    def _library(self, resilient: bool) -> Path:
        sources = [OPEN, *build.file_list("asip/asip.f")]
        return build.build_library(
            "asip", sources, HARNESS, parameters_of(resilient), model_flags=FLAGS
        )

    def __del__(self) -> None:
        if handle := getattr(self, "_handle", None):
            self._lib.upset_free(handle)

    def _reference(self) -> np.ndarray:
        image, robot = self.image, Robot.load()
        path, counts = reversing_path(robot, TICKS + LATER + 1)
        named = dict(
            zip(SET_POINTS, path.words().T.astype(np.float32).view(np.uint32), strict=True)
        )
        named |= dict(zip(COUNTS, counts.T.astype(np.int32).view(np.uint32), strict=True))
        words = np.ascontiguousarray(np.stack([named[each.name] for each in image.inputs], axis=1))
        first = {
            name: int(np.float32(value).view(np.uint32))
            if next(s.type for s in image.states if s.name == name) == "float"
            else int(value) & 0xFFFFFFFF
            for name, value in preset(image.to_json(), robot, counts[0].tolist()).items()
        }
        load = dict(load_words(image))
        for state in image.states:
            if state.name in first:
                load[register_address(state.register)] = first[state.name]
        host = [
            CSR["STATUS"],
            CSR["CONTROL"],
            START,
            CLEAR,
            STATUS["busy"].mask,
            STATUS["done"].mask,
            STATUS["fault"].mask,
            STATUS["cause"].mask,
            STATUS["cause"].low,
            STATUS["repaired"].mask if self._resilient else 0,
            int(self._resilient),
            self._idle,
            4 * image.watchdog + 2000,
        ]
        limits = dict(zip(OUTPUTS, robot.output_max, strict=True))
        lengths = np.zeros(len(words), dtype=np.uint32)
        arrays = [
            np.array(host, dtype=np.uint32),
            np.array(list(load.items()), dtype=np.uint32),
            np.array([BLOCK["constants"] + each.index for each in image.inputs], dtype=np.uint32),
            words,
            np.array([BLOCK["outputs"] + each.index for each in image.outputs], dtype=np.uint32),
            np.array([int(each.safe, 16) for each in image.outputs], dtype=np.uint32),
            np.array([limits[each.name] for each in image.outputs], dtype=np.float32),
        ]
        at = [ctypes.c_void_p(array.ctypes.data) for array in (*arrays, lengths)]
        failed = self._lib.upset_reference(
            ctypes.c_void_p(self._handle), at[0], at[1], len(load), at[2], len(image.inputs),
            at[3], len(words), at[4], at[5], at[6], len(image.outputs), at[7],
        )  # fmt: skip
        if failed:
            raise ReferenceError(f"tick {failed - 1} of the run without an upset did not end well")
        return lengths

    def inject(self, upsets: np.ndarray) -> np.ndarray:
        """What each of the upsets (N, UPSET) does, (N, OUTCOME)."""
        upsets = np.ascontiguousarray(upsets, dtype=UPSET)
        outcomes = np.zeros(len(upsets), dtype=OUTCOME)
        self._lib.upset_inject(
            ctypes.c_void_p(self._handle),
            ctypes.c_void_p(upsets.ctypes.data),
            len(upsets),
            LATER,
            ctypes.c_void_p(outcomes.ctypes.data),
        )
        return outcomes


class NetlistModel(Model):
    """The core mapped to ECP5 cells; its sites are flip-flops and memories of cells."""

    def _library(self, resilient: bool) -> Path:
        netlist = make_netlist("asip", parameters_of(resilient))
        self.places = {
            f"{TOP}.{cell}.Q": f"{TOP}.{place}" for cell, place in netlist.flip_flops.items()
        }
        return library_of(netlist, HARNESS, [OPEN], FLAGS)
