# SPDX-License-Identifier: Apache-2.0
"""The Verilated ASIP with every register and memory open, and the tracking program on it."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.core.iss.path import preset
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, OUTPUTS, SET_POINTS
from sim.rtl import build
from sim.rtl.asip_bus import BLOCK, CLEAR, CSR, START, STATUS, load_words, register_address
from sim.rtl.verilated import Verilated
from tests.asip.tracking_path import reversing_path
from tests.silicon.netlist import library_of, make_netlist

PROGRAM = ROOT / "asip_asm/programs/tracking_optimised.s"
HARNESS = ROOT / "sim/rtl/upset_harness.cpp"
OPEN = ROOT / "sim/rtl/registers.vlt"
FLAGS = ("--flatten", "--vpi")
TOP = "TOP.asip"
TICKS, LATER = 64, 7
"""Ticks of the reference; ticks watched after the one with the upset."""
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


class Model(Verilated):
    """One configuration of the core with the program loaded and the reference run.

    idle: clocks between ticks; lengths: clocks of each tick of the host, these included; cycles: of
    the core in a tick; build: a name that changes with the RTL and the harness.
    """

    prefix = "upset"
    places: Mapping[str, str] = {}
    """Of sites whose name is not their place."""

    def __init__(self, resilient: bool = False, idle: int = 100) -> None:
        with patch.object(build, "assertions", False):  # an upset is to break what they say
            library = self._library(resilient)
        self.build = library.parent.name
        self._resilient, self._idle = resilient, idle
        u32, pointer = ctypes.c_uint32, ctypes.c_void_p
        program, ticks = (pointer, pointer, u32), (pointer, u32, pointer, u32)
        signatures = {
            "sites": (ctypes.c_char_p,),
            "reference": (u32, *program, *ticks, pointer, pointer, pointer, u32, pointer),
            "read": (u32, u32),
            "inject": (None, pointer, u32, u32, pointer),
        }
        super().__init__(library, signatures)
        lines = self._lib.upset_sites(self._handle).decode().splitlines()
        self.sites = [
            Site(name, int(bits), int(n), self.places.get(name, name))
            for name, bits, n in (line.split() for line in lines)
        ]
        self.image: Image = assemble(PROGRAM)
        self.lengths = self._reference()
        self.cycles: int = self._lib.upset_read(self._handle, CSR["CYCLES"])

    def _library(self, resilient: bool) -> Path:
        sources = [OPEN, *build.file_list("asip/asip.f")]
        return build.build_library(
            "asip", sources, HARNESS, parameters_of(resilient), model_flags=FLAGS
        )

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
        loaded = dict(load_words(image))
        for state in image.states:
            if state.name in first:
                loaded[register_address(state.register)] = first[state.name]
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
        numbers = partial(np.array, dtype=np.uint32)
        host, load = numbers(host), numbers(list(loaded.items()))
        inputs = numbers([BLOCK["constants"] + each.index for each in image.inputs])
        outputs = numbers([BLOCK["outputs"] + each.index for each in image.outputs])
        safe = numbers([int(each.safe, 16) for each in image.outputs])
        most = np.array([limits[each.name] for each in image.outputs], dtype=np.float32)
        lengths = np.zeros(len(words), dtype=np.uint32)
        failed = self._lib.upset_reference(
            self._handle, host.ctypes, load.ctypes, len(load), inputs.ctypes, len(inputs),
            words.ctypes, len(words), outputs.ctypes, safe.ctypes, most.ctypes, len(outputs),
            lengths.ctypes,
        )  # fmt: skip
        if failed:
            raise ReferenceError(f"tick {failed - 1} of the run without an upset did not end well")
        return lengths

    def inject(self, upsets: np.ndarray) -> np.ndarray:
        """What each of the upsets (N, UPSET) does, (N, OUTCOME)."""
        upsets = np.ascontiguousarray(upsets, dtype=UPSET)
        outcomes = np.zeros(len(upsets), dtype=OUTCOME)
        self._lib.upset_inject(self._handle, upsets.ctypes, len(upsets), LATER, outcomes.ctypes)
        return outcomes


class NetlistModel(Model):
    """The core mapped to ECP5 cells; its sites are flip-flops and memories of cells."""

    def _library(self, resilient: bool) -> Path:
        netlist = make_netlist("asip", parameters_of(resilient))
        self.places = {
            f"{TOP}.{cell}.Q": f"{TOP}.{place}" for cell, place in netlist.flip_flops.items()
        }
        return library_of(netlist, HARNESS, [OPEN], FLAGS)
