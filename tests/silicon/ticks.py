# SPDX-License-Identifier: Apache-2.0
"""Whole ticks of the tracking programs on the core's netlist next to its RTL, shard by shard.

A shard begins with the program loaded again and its part of the path, so shards are tasks of the
campaign runner (sim/core/fpbench/campaign.py): finished shards are cached, so a stopped
comparison continues.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from asip_asm.isa import default_isa
from sim.core.backends import is_register
from sim.report.cache import fingerprint
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, SET_POINTS
from sim.rtl.asip_bus import register_address
from sim.rtl.asip_rtl import HARNESS, AsipRtl
from tests.asip.tracking_path import reversing_path
from tests.silicon.netlist import BUILD, ROOT, Netlist, library_of, make_netlist

PROGRAMS = ("tracking_as_printed", "tracking_optimised")
SHARD = 500  # ticks


class AsipNetlist(AsipRtl):
    """The core mapped to ECP5 cells; else as the RTL."""

    def _library(self, parameters: Mapping[str, int]) -> Path:
        return library_of(make_netlist("asip", parameters), HARNESS)


def netlist_of(configuration: str) -> Netlist:
    """Netlist of the core in a configuration."""
    shape = default_isa().configurations[configuration]
    return make_netlist("asip", {"FmaPipes": shape.fma_pipes, "Slots": len(shape.slots)})


@dataclass(frozen=True)
class Task:
    """Some ticks of a program from `first` on, of the path of `path` ticks."""

    configuration: str
    program: str
    first: int
    ticks: int
    path_ticks: int
    fingerprint: str

    @property
    def name(self) -> str:
        """Its name among all shards."""
        part = f"{self.first}-{self.ticks}-of-{self.path_ticks}"
        return f"{self.configuration}-{self.program}-{part}"

    @property
    def path(self) -> Path:
        """Where its result belongs."""
        return BUILD / f"ticks/{self.name}.json"


def tasks_of(program_name: str, configuration: str, ticks: int) -> Iterator[Task]:
    """Every shard of so many ticks; their fingerprint is of the netlist and of what runs it."""
    netlist = netlist_of(configuration)
    program_file = ROOT / f"asip_asm/programs/{program_name}.s"
    bench = [Path(inspect.getfile(part)) for part in (AsipRtl, reversing_path)]
    of = fingerprint([*netlist.sources, Path(__file__), HARNESS, program_file, *bench])
    for first in range(0, ticks, SHARD):
        part = min(SHARD, ticks - first)
        yield Task(configuration, program_name, first, part, ticks, of)


@functools.cache
def _cores(configuration: str) -> tuple[AsipNetlist, AsipRtl]:
    return AsipNetlist(configuration), AsipRtl(configuration)


def execute(task: Task) -> dict:
    """Compare one shard (in a worker).

    {"ticks", "differs", "cycles"}: ticks compared, the first that differs (None without one), of
    the whole path, and cycles of the slowest.
    """
    data = inputs(task.path_ticks)[task.first : task.first + task.ticks]
    image = program(task.program, task.configuration)
    differs, cycles = compared(image, data, *_cores(task.configuration))
    return {
        "ticks": task.ticks,
        "differs": None if differs is None else task.first + differs,
        "cycles": cycles,
    }


def inputs(ticks: int) -> np.ndarray:
    """Words of the set-points and counts of a path with reversals (ticks, 20)."""
    path, counts = reversing_path(Robot.load(), ticks)
    words = np.ascontiguousarray(path.words(), dtype=np.float32).view(np.uint32)
    return np.concatenate((words, counts.astype(np.int32).view(np.uint32)), axis=1)


def compared(
    image: Image, data: np.ndarray, netlist: AsipRtl, rtl: AsipRtl
) -> tuple[int | None, int]:
    """Outputs, exports, states, STATUS and CYCLES of every tick of data (ticks, 20).

    The first tick that differs, None without one; cycles of the slowest.
    """
    places = {entry.name: entry.register for entry in (*image.exports, *image.states)}
    reads = [register_address(place) for place in places.values() if is_register(place)]
    for core in (rtl, netlist):
        core.load(image)
    reads += rtl.output_addresses([output.name for output in image.outputs])
    addresses = rtl.input_addresses([*SET_POINTS, *COUNTS])
    one, other = (core.run(addresses, data, reads) for core in (rtl, netlist))
    pairs = ((one.words, other.words), (one.status, other.status), (one.cycles, other.cycles))
    done = min(len(one.cycles), len(other.cycles))
    if done < len(data):  # a fault ends a run, of one or of both
        return done, 0
    rows = [(a != b).reshape(len(a), -1).any(axis=1) for a, b in pairs]
    wrong = np.flatnonzero(np.any(rows, axis=0))
    return int(wrong[0]) if len(wrong) else None, int(one.cycles.max())


def program(name: str, configuration: str) -> Image:
    """Image of one of PROGRAMS."""
    return assemble(ROOT / f"asip_asm/programs/{name}.s", configuration=configuration)
