# SPDX-License-Identifier: Apache-2.0
"""The Verilated two-processor system as a Python object: two cores, registers, lists, periods."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.isa import default_isa
from sim.rtl.asip_rtl import AsipError, AsipRtl
from sim.rtl.build import build_library
from sim.rtl.gen.dual_regmap import REGMAP
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated

TOP = "dual_asip"
HARNESS = Path(__file__).parent
FLAGS = REGMAP.registers["STATUS"].fields
MEASURED_SOURCE = 32  # of an input list: first measured word
LIST_ENTRIES = 32
LISTS = ("set_points", "inputs", "commands")

PERIOD = np.dtype(
    [
        ("measured", np.uint32, 5),
        ("commands", np.uint32, 5),
        ("words", np.uint32, 15),
        *((name, np.uint32) for name in ("stored", "updates", "command_clock", "set_point_clock")),
        ("cycles", np.uint32, 2),
        *((name, np.uint32) for name in ("torn", "used", "late")),
    ]
)
"""One period as the harness exchanges it: see struct Period of dual_harness.cpp."""


class Core(AsipRtl):
    """One core at the system's host port: the bus of `AsipRtl`, without its own model."""

    def __init__(self, system: DualRtl, block: str, configuration: str) -> None:
        self._system = system
        self._base = REGMAP.blocks[block].base
        self.configuration = configuration

    def write(self, address: int, data: int) -> None:
        """One bus write; waits while the core or the sequencer holds it."""
        self._system.write_word(self._base + address, data)

    def read(self, address: int) -> int:
        """One bus read."""
        return self._system.read_word(self._base + address)

    def queue(self, writes: Sequence[tuple[int, int]]) -> None:
        """See `DualRtl.queue`; addresses are the core's."""
        self._system.queue([(self._base + address, data) for address, data in writes])


class DualRtl(Verilated):
    """The system just out of reset, each core in configuration 'fast' or 'small'.

    The model is built on first use; `library` is its file, named by a hash of all that is in it.
    """

    prefix = "dual"
    top = TOP
    harness = HARNESS / "dual_harness.cpp"
    headers: tuple[Path, ...] = ()
    macros: tuple[str, ...] = ()  # further options of the harness's compiler
    parameters: Mapping[str, int] = MappingProxyType({})  # of the top, besides the cores

    def __init__(self, trajectory: str = "fast", tracking: str = "fast") -> None:
        parameters = dict(self.parameters)
        for name, configuration in (("Trajectory", trajectory), ("Tracking", tracking)):
            record = default_isa().configurations[configuration]
            parameters[f"{name}FmaPipes"] = record.fma_pipes
            parameters[f"{name}Slots"] = len(record.slots)
        self.library = build_library(
            self.top,
            sources_of(self.top),
            self.harness,
            parameters,
            jobs=1,
            headers=(HARNESS / "dual_bench.h", HARNESS / "dual_api.h", *self.headers),
            harness_flags=(f"-I{HARNESS}", *self.macros),
        )
        integer, pointer, u32, u64 = ctypes.c_int, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
        signatures = {
            "clocks": (u64,),
            "lines": (integer,),
            "queued": (u64,),
            "write": (integer, u32, u32),
            "read": (integer, u32, pointer),
            "queue": (None, pointer, u64),
            "clock": (None, u64),
            "run": (u64, pointer, u64),
        }
        super().__init__(self.library, signatures)
        self.trajectory = Core(self, "trajectory", trajectory)
        self.tracking = Core(self, "tracking", tracking)

    # ------------------------------------------------------------------ bus
    def write_word(self, address: int, data: int) -> None:
        """One bus write by word address. Raises AsipError if it is never accepted."""
        if not self._call("write", address, data & 0xFFFFFFFF):
            raise AsipError(f"bus write to {address:#06x} was never accepted")

    def read_word(self, address: int) -> int:
        """One bus read by word address. Raises AsipError if it is never answered."""
        word = self._word("read", address)
        if word is None:
            raise AsipError(f"bus read of {address:#06x} was never answered")
        return word

    def queue(self, writes: Sequence[tuple[int, int]]) -> None:
        """Let the host write (address, data) in this order while periods run, as the bus allows."""
        pairs = np.array(writes, dtype=np.uint32).reshape(-1, 2)
        self._call("queue", pairs.ctypes.data, len(pairs))

    @property
    def queued(self) -> int:
        """Writes that wait."""
        return self._call("queued")

    def write(self, register: str, value: int) -> None:
        """Write a system register by name."""
        self.write_word(REGMAP.address(register), value)

    def set(self, register: str, **fields: int) -> None:
        """Write a system register by its fields, the others 0."""
        self.write(register, REGMAP.registers[register].word(**fields))

    def read(self, register: str) -> int:
        """Read a system register by name."""
        return self.read_word(REGMAP.address(register))

    def flags(self) -> dict[str, int]:
        """Fields of STATUS by name."""
        status = self.read("STATUS")
        return {name: field.of(status) for name, field in FLAGS.items()}

    def set_lists(self, lists: dict[str, Sequence[tuple[int, int]]]) -> None:
        """Write the copy lists, (source, destination) each, by name: all of `LISTS`.

        Raises ValueError for a list that is too long.
        """
        for number, name in enumerate(LISTS):
            entries = lists[name]
            if len(entries) > LIST_ENTRIES:
                raise ValueError(f"list {name} has {len(entries)} entries, room is {LIST_ENTRIES}")
            for i, (source, destination) in enumerate(entries):
                place = REGMAP.blocks["lists"].base + LIST_ENTRIES * number + i
                entry = REGMAP.blocks["lists"].word(source=source, destination=destination)
                self.write_word(place, entry)
        self.set("LENGTHS", **{name: len(lists[name]) for name in LISTS})

    # ------------------------------------------------------------------ time
    def clock(self, clocks: int) -> None:
        """Let time pass."""
        self._call("clock", clocks)

    @property
    def clocks(self) -> int:
        """Clocks since reset."""
        return self._call("clocks")

    @property
    def irq(self) -> bool:
        """Level of irq_o."""
        return bool(self._call("lines") & 1)

    @property
    def stop(self) -> bool:
        """Level of stop_o."""
        return bool(self._call("lines") & 2)

    def run(self, measured: ArrayLike) -> NDArray[np.void]:
        """Run one period per row of measured words (n, 5), int32; returns records (n,) of `PERIOD`.

        Time is after the last period's work, or at the start of the next period if that came
        first. Raises AsipError if no period begins.
        """
        rows = np.asarray(measured, dtype=np.int32).view(np.uint32)
        periods = np.zeros(len(rows), dtype=PERIOD)
        periods["measured"] = rows
        done = self._call("run", periods.ctypes.data, len(periods))
        if done != len(periods):
            raise AsipError(f"period {done} of {len(periods)} never began or never ended")
        if not periods["late"][-1]:
            self.clock(1)  # the registers follow a clock later
        return periods
