# SPDX-License-Identifier: Apache-2.0
"""Whole ticks of the tracking programs on the core's netlist beside its RTL."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from sim.core_backends import is_register
from sim.harness.asip_bus import register_address
from sim.harness.asip_rtl import HARNESS, AsipRtl
from sim.harness.build import build_library
from sim.model.parameters import Robot
from sim.model.records import COUNTS, SET_POINTS
from tests.asip.tracking_path import reversing_path
from tests.silicon.netlist import ROOT, make_netlist

PROGRAMS = ("tracking_as_printed", "tracking_optimised")
SHARD = 1000  # ticks of one call


class AsipNetlist(AsipRtl):
    """The core mapped to ECP5 cells; else as the RTL. folders: where its sources stand."""

    folders: Sequence[Path] = (ROOT / "rtl",)

    def _library(self, parameters: Mapping[str, int]) -> Path:
        netlist = make_netlist("asip", parameters, folders=self.folders)
        return build_library(self.top, netlist.sources, HARNESS)


@dataclass(frozen=True)
class Shard:
    """Ticks compared, and the first that differs (None without one); cycles of the slowest."""

    ticks: int
    differs: int | None
    cycles: int


def inputs(ticks: int) -> np.ndarray:
    """Words of the set-points and counts of a path with reversals (ticks, 20)."""
    path, counts = reversing_path(Robot.load(), ticks)
    words = np.ascontiguousarray(path.words(), dtype=np.float32).view(np.uint32)
    return np.concatenate((words, counts.astype(np.int32).view(np.uint32)), axis=1)


def compared(image: Image, ticks: int, netlist: AsipRtl, rtl: AsipRtl) -> Iterator[Shard]:
    """Outputs, exports, states, STATUS and CYCLES of every tick, shard by shard."""
    places = {entry.name: entry.register for entry in (*image.exports, *image.states)}
    reads = [register_address(place) for place in places.values() if is_register(place)]
    data = inputs(ticks)
    for core in (rtl, netlist):
        core.load(image)
    reads += rtl.output_addresses([output.name for output in image.outputs])
    addresses = rtl.input_addresses([*SET_POINTS, *COUNTS])
    for first in range(0, ticks, SHARD):
        part = data[first : first + SHARD]
        one, other = (core.run(addresses, part, reads) for core in (rtl, netlist))
        pairs = ((one.words, other.words), (one.status, other.status), (one.cycles, other.cycles))
        if any(len(a) != len(b) for a, b in pairs):
            yield Shard(len(part), first + min(len(one.cycles), len(other.cycles)), 0)
            return
        rows = [(a != b).reshape(len(a), -1).any(axis=1) for a, b in pairs]
        wrong = np.flatnonzero(np.any(rows, axis=0))
        yield Shard(len(part), first + int(wrong[0]) if len(wrong) else None, one.cycles.max())


def program(name: str, configuration: str) -> Image:
    """Image of one of PROGRAMS."""
    return assemble(ROOT / f"asip_asm/programs/{name}.s", configuration=configuration)
