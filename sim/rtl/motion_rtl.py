# SPDX-License-Identifier: Apache-2.0
"""The Verilated motion front-end as a Python object: records in, edges of the drive lines out."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim.rtl.build import ROOT, build_library
from sim.rtl.gen.motion_regmap import REGMAP
from sim.rtl.interpolator_rtl import PLANES
from sim.rtl.phase_record import Record
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated

TOP = "motion_front_end"
FOLDERS = (ROOT / "rtl",)  # where its sources are; tests put changed copies first
CLOCK_HZ = 100_000_000
RECORDS = 8  # in the ring of an axis
COUNTED = REGMAP.registers["HEAD"].fields["axis0"].mask + 1  # records count modulo this


class MotionError(RuntimeError):
    """The front-end did not do what was asked; the message says what it did."""


@dataclass(frozen=True)
class DriveTimes:
    """Times on the lines of an axis [clocks], one per pulse or turn; lengths once each.

    hold: from the end of the last pulse to the turn, negative for a turn inside a pulse.
    """

    lengths: np.ndarray
    space: np.ndarray
    setup: np.ndarray
    hold: np.ndarray

    def kept(self, length: int, space: int, setup: int, hold: int) -> bool:
        """Whether each pulse has its length and every other time is at least as long."""
        pairs = ((self.space, space), (self.setup, setup), (self.hold, hold))
        return self.lengths.tolist() == [length] and all(np.all(t >= least) for t, least in pairs)


@dataclass(frozen=True)
class Edges:
    """Level changes of the drive lines: clock since reset, and all lines from then on."""

    clock: np.ndarray
    step: np.ndarray
    direction: np.ndarray

    def pulses(self, axis: int) -> np.ndarray:
        """Clocks of the rising edges of an axis's step line."""
        level = self.step >> axis & 1
        before = np.concatenate(([0], level[:-1]))
        return self.clock[(level == 1) & (before == 0)]

    def moves(self, axes: int) -> list[tuple[int, int, int]]:
        """All pulses of the first axes in their order: clock, axis, 1 or -1."""
        found: list[tuple[int, int, int]] = []
        for axis in range(axes):
            at = self.pulses(axis)
            negative = self.direction[np.searchsorted(self.clock, at)] >> axis & 1
            found += [(int(t), axis, -1 if n else 1) for t, n in zip(at, negative, strict=True)]
        return sorted(found)

    def steps(self, axes: int, apart: int) -> tuple[np.ndarray, np.ndarray]:
        """Clocks of the steps of a path, and (n, axes) arrays of -1, 0, 1.

        Pulses less than `apart` clocks after the first of a step belong to it: a change of
        direction delays an axis. Raises MotionError if one axis has two of them.
        """
        clocks: list[int] = []
        rows: list[list[int]] = []
        for clock, axis, sign in self.moves(axes):
            if not clocks or clock - clocks[-1] >= apart:
                clocks.append(clock)
                rows.append([0] * axes)
            if rows[-1][axis]:
                raise MotionError(f"axis {axis} has two pulses within {apart} clocks of {clock}")
            rows[-1][axis] = sign
        return np.array(clocks, dtype=np.int64), np.array(rows, dtype=np.int64).reshape(-1, axes)

    def drive_times(self, axis: int) -> DriveTimes:
        """What the drive of an axis sees. Raises MotionError if its step line never rose."""
        step, direction = self.step >> axis & 1, self.direction >> axis & 1
        edge = np.diff(step.astype(np.int64), prepend=0)
        rises, falls = self.clock[edge == 1], self.clock[edge == -1]
        turns = self.clock[np.diff(direction.astype(np.int64), prepend=0) != 0]
        if len(rises) == 0 or len(falls) != len(rises):
            raise MotionError(f"axis {axis}: {len(rises)} pulses begin, {len(falls)} end")
        behind = np.searchsorted(rises, turns)  # the pulse after each turn
        inside, after = behind < len(rises), np.searchsorted(rises, turns, side="right") > 0
        ended = falls[np.searchsorted(rises, turns[after], side="right") - 1]
        return DriveTimes(
            np.unique(falls - rises),
            rises[1:] - falls[:-1],
            rises[behind[inside]] - turns[inside],
            turns[after] - ended,
        )


def extended(position: int, word: int) -> int:
    """Steps sent in all, from the register POSITION, which counts them modulo 2^32.

    position: the result of the last read, at most 2^31 - 1 steps ago.
    """
    moved = (word - position) % (1 << 32)
    return position + moved - (1 << 32 if moved >> 31 else 0)


class MotionRtl(Verilated):
    """One front-end of five axes at 100 MHz, just out of reset, with or without interpolators."""

    prefix, end = "motion", "delete"
    AXES = 5

    def __init__(self, interpolators: bool = True) -> None:
        path = build_library(
            TOP,
            sources_of(TOP, FOLDERS),
            Path(__file__).with_name("motion_harness.cpp"),
            {"Interpolators": int(interpolators)},
        )
        pointer, u32, u64 = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
        signatures = {
            "write": (None, u32, u32),
            "read": (ctypes.c_int, u32, pointer),
            "clock": (u64, u64, ctypes.c_int),
            "now": (u64,),
            "edges": (u64, pointer, pointer, pointer, u64),
            "forget_edges": (None,),
        }
        super().__init__(path, signatures)
        self._heads = [0] * self.AXES
        self._positions = [0] * self.AXES  # as last read

    def write(self, register: str, value: int) -> None:
        """Write a register by name."""
        self._call("write", REGMAP.address(register), value)

    def set(self, register: str, **fields: int) -> None:
        """Write a register by its fields, the others 0."""
        self.write(register, REGMAP.registers[register].word(**fields))

    def read(self, register: str, offset: int = 0) -> int:
        """Read a register by name, or the one `offset` after it."""
        return self.load(REGMAP.address(register) + offset)

    def load(self, address: int) -> int:
        """Read the word at an address."""
        word = self._word("read", address)
        if word is None:
            raise MotionError(f"read of word {address:#x} was never answered")
        return word

    def store(self, address: int, value: int) -> None:
        """Write the word at an address."""
        self._call("write", address, value)

    def position(self, axis: int) -> int:
        """Steps sent by an axis since reset, if it is read at least once in 2^31 steps."""
        self._positions[axis] = extended(self._positions[axis], self.read("POSITION", axis))
        return self._positions[axis]

    def status(self, field: str) -> int:
        """One field of STATUS, a bit per axis."""
        return REGMAP.registers["STATUS"].fields[field].of(self.read("STATUS"))

    def clock(self, clocks: int) -> None:
        """Let time pass."""
        self._call("clock", clocks, 0)

    def wait_for_irq(self, limit: int) -> int:
        """Let time pass until the interrupt; returns clocks. Raises MotionError at the limit."""
        clocks = self._call("clock", limit, 1)
        if clocks == limit:
            raise MotionError(f"no interrupt in {limit} clocks")
        return clocks

    @property
    def now(self) -> int:
        """Clocks since reset."""
        return self._call("now")

    def tails(self) -> list[int]:
        """Records taken so far of each axis, modulo `COUNTED`."""
        word, fields = self.read("TAIL"), REGMAP.registers["TAIL"].fields
        return [fields[f"axis{axis}"].of(word) for axis in range(self.AXES)]

    def put(self, moves: Mapping[int, Sequence[Record]]) -> None:
        """Write records per axis and release them together.

        Raises MotionError if a ring is too full.
        """
        base = REGMAP.blocks["records"].base
        tails = self.tails()
        for axis, records in moves.items():
            waiting = (self._heads[axis] - tails[axis]) % COUNTED
            if waiting + len(records) > RECORDS:
                raise MotionError(
                    f"axis {axis}: {len(records)} records, room for {RECORDS - waiting}"
                )
            for record in records:
                place = base + 64 * axis + 8 * (self._heads[axis] % RECORDS)
                for word, value in enumerate(record.words()):
                    self._call("write", place + word, value)
                self._heads[axis] = (self._heads[axis] + 1) % COUNTED
        self.set("HEAD", **{f"axis{axis}": head for axis, head in enumerate(self._heads)})

    def run(self, moves: Mapping[int, Sequence[Record]], limit: int) -> None:
        """Put the records and wait until no axis moves. `limit` in clocks."""
        self.set("IRQ_ENABLE", idle=1, fault=1)
        self.put(moves)
        self.wait_for_irq(limit)

    def line(
        self, end_u: int, end_v: int, plane: str = "xy", combined: bool = False, start: bool = True
    ) -> None:
        """Write a line command, its end from its start; `start`: also begin it."""
        self._path(0, {2: end_u, 3: end_v}, start, plane=PLANES[plane], combined=combined)

    def arc(
        self,
        begin: tuple[int, int],
        end: tuple[int, int],
        radius_squared: int,
        clockwise: bool = False,
        combined: bool = False,
        turns: int = 0,
        plane: str = "xy",
    ) -> None:
        """Write an arc command, nodes from the centre, and begin it."""
        words = [*begin, *end, begin[0] ** 2 + begin[1] ** 2 - radius_squared]
        more = {"clockwise": clockwise, "combined": combined, "turns": turns}
        self._path(1, dict(enumerate(words)), True, plane=PLANES[plane], **more)

    def line_in_all_axes(self, lengths: Sequence[int]) -> None:
        """Write a command for a line in all axes and begin it."""
        self._path(2, dict(enumerate(lengths)), True)

    def _path(self, kind: int, words: Mapping[int, int], start: bool, **fields: int) -> None:
        base = REGMAP.address("PATH_WORD")
        for word, value in words.items():
            self._call("write", base + word, value & 0xFFFFFFFF)
        if start:
            self.set("PATH_COMMAND", kind=kind, **fields)

    def path(self, field: str) -> int:
        """One field of PATH_STATUS."""
        return REGMAP.registers["PATH_STATUS"].fields[field].of(self.read("PATH_STATUS"))

    def path_faults(self) -> Set[str]:
        """Names of the faults in PATH_STATUS."""
        status = self.read("PATH_STATUS")
        fields = REGMAP.registers["PATH_STATUS"].fields
        return {n for n, f in fields.items() if n not in ("pending", "busy") and f.of(status)}

    def edges(self) -> Edges:
        """Level changes since the last call."""
        count = self._call("edges", None, None, None, 0)
        clock = np.zeros(count, dtype=np.uint64)
        step, direction = (np.zeros(count, dtype=np.uint32) for _ in range(2))
        self._call("edges", clock.ctypes.data, step.ctypes.data, direction.ctypes.data, count)
        self._call("forget_edges")
        return Edges(clock.astype(np.int64), step, direction)
