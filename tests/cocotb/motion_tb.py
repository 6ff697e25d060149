# SPDX-License-Identifier: Apache-2.0
"""The motion front-end against sums of its records and ideal lines in numpy, edge by edge.

test_systems.py starts the tests.
"""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.triggers import First, RisingEdge, Timer

from sim.cocotb.agent import Agent, signed
from sim.cocotb.clocked import word
from sim.rtl.gen.motion_regmap import REGMAP
from sim.rtl.interpolator_rtl import PLANES
from sim.rtl.motion_rtl import Edges
from sim.rtl.phase_record import DIRECTION, FIRST, LAST, UNITS_PER_PULSE, Record
from tests.bench.seed import SEED

RECORDS = REGMAP.blocks["records"].base
CLOCKS_PER_TICK = 100
MHZ = 16_000_000 << 32  # velocity of a record
LIMIT = 60_000  # clocks of a move
AXES = 5


class Motion(Agent):
    """The front-end, with a monitor of its drive lines."""

    def __init__(self, dut) -> None:
        super().__init__(dut, REGMAP, seed=SEED)
        self.changes: list[tuple[int, int, int]] = []
        self.heads = [0] * AXES

    async def started(self, length: int = 1, space: int = 1, setup: int = 1, hold: int = 1):
        """Out of reset, with these times of the drives in clocks."""
        await self.reset()
        await self.put("STEP_TIMING", length=length, space=space)
        await self.put("DIRECTION_TIMING", setup=setup, hold=hold)
        await self.put("IRQ_ENABLE", idle=1, fault=1)
        cocotb.start_soon(self._watch())
        return self

    async def _watch(self) -> None:
        lines = (0, 0)
        for clock in range(1 << 30):
            await self.next()
            before, lines = lines, (word(self.dut.step_o), word(self.dut.direction_o))
            if lines != before:
                self.changes.append((clock, *lines))

    def edges(self) -> Edges:
        """Changes of the lines so far."""
        rows = np.array(self.changes, np.int64).reshape(-1, 3)
        return Edges(*rows.T)

    async def run(self, moves: dict[int, list[Record]]) -> None:
        """Release the records of all axes together and wait until they rest."""
        await self.release(moves)
        await self.rest()

    async def release(self, moves: dict[int, list[Record]]) -> None:
        """Write records and release them."""
        for axis, records in moves.items():
            for record in records:
                place = RECORDS + 64 * axis + 8 * (self.heads[axis] % 8)
                for i, data in enumerate(record.words()):
                    await self.write(place + i, data)
                self.heads[axis] = (self.heads[axis] + 1) % 16
        await self.put("HEAD", **{f"axis{axis}": head for axis, head in enumerate(self.heads)})

    async def rest(self) -> None:
        """Wait for the interrupt."""
        await self.cycles(3)
        if not word(self.dut.irq_o):
            await First(RisingEdge(self.dut.irq_o), Timer(LIMIT * self.period, unit="ps"))
        await self.next()
        assert word(self.dut.irq_o), f"no interrupt in {LIMIT} clocks"


@cocotb.test()
@cocotb.parametrize(negative=[0, 1])
async def records__pulses_follow_the_integral_of_the_rate(dut, negative):
    """An S-curve up, a cruise and one down: every pulse is within its tick's place."""
    motion = await Motion(dut).started()
    slope, jerk = MHZ // 400, MHZ // 40_000
    sign = DIRECTION * negative
    up = Record(FIRST | sign, 60, 0, slope, jerk)
    top = up.velocity + 60 * up.slope + up.jerk * (60 * 61 // 2)
    cruise = Record(sign, 40, top, 0, 0)
    down = Record(LAST | sign, 50, top, -top // 60, 0)
    records = [up, cruise, down]
    await motion.run({1: records})
    rates = [record.published(i) for record in records for i in range(record.count)]
    places = np.cumsum(rates) / UNITS_PER_PULSE
    at = motion.edges().pulses(1)
    # The first pulse is where the integral is one half; ticks are 100 clocks apart.
    first = int(np.argmax(places >= 0.5))
    begin = at[0] - CLOCKS_PER_TICK * first
    for late in range(-CLOCKS_PER_TICK, CLOCKS_PER_TICK + 1, 10):
        ends = begin + late + CLOCKS_PER_TICK * np.arange(1, len(rates) + 1)
        error = np.searchsorted(at, ends) - places
        if np.all(np.abs(error) <= 1):
            break
    else:
        raise AssertionError("pulses are more than one from the integral")
    count = int(np.floor(places[-1] + 0.5))
    assert len(at) == count
    assert signed(await motion.register("POSITION", 1)) == (-count if negative else count)
    assert await motion.register("STATUS") == 0


@cocotb.test()
async def five_axes__released_together__begin_in_one_tick(dut):
    motion = await Motion(dut).started()
    rates = [motion.random.randrange(1, 12) for _ in range(AXES)]
    await motion.run({a: [Record(FIRST | LAST, 50, rate * MHZ // 4, 0, 0)] for a, rate in
                      enumerate(rates)})  # fmt: skip
    want = [int(np.floor(rate / 4 * 50 + 0.5)) for rate in rates]
    found = [signed(await motion.register("POSITION", a)) for a in range(AXES)]
    assert found == want
    edges = motion.edges()
    for axis, rate in enumerate(rates):
        gaps = np.diff(edges.pulses(axis))
        assert np.all(np.abs(gaps - 400 / rate) < 1), f"axis {axis}: {gaps}"


@cocotb.test()
@cocotb.parametrize(times=[(3, 5, 40, 30), (20, 25, 7, 90)])
async def drive_timing__is_kept_through_turns(dut, times):
    length, space, setup, hold = times
    motion = await Motion(dut).started(length, space, setup, hold)
    for turn in range(4):
        sign = DIRECTION * (turn & 1)
        await motion.run({0: [Record(FIRST | LAST | sign, 10, MHZ, 0, 0)]})
    seen = motion.edges().drive_times(0)
    assert seen.kept(length, space, setup, hold), seen
    assert signed(await motion.register("POSITION", 0)) == 0


@cocotb.test()
async def records_that_run_out__are_an_underrun_until_an_abort(dut):
    motion = await Motion(dut).started()
    await motion.run({3: [Record(FIRST, 10, MHZ, 0, 0)]})
    assert await motion.field("STATUS", "underrun") == 1 << 3
    await motion.put("CONTROL", abort=1 << 3)
    assert await motion.register("STATUS") == 0
    await motion.run({3: [Record(FIRST | LAST, 10, MHZ, 0, 0)]})
    assert await motion.register("STATUS") == 0


@cocotb.test()
async def steps_too_fast_for_the_drive__are_an_overrun(dut):
    motion = await Motion(dut).started(100, 100)
    await motion.run({2: [Record(FIRST | LAST, 100, 2 * MHZ, 0, 0)]})
    assert await motion.field("STATUS", "overrun") == 1 << 2


@cocotb.test()
async def abort__in_any_clock_of_a_move__no_further_pulse(dut):
    motion = await Motion(dut).started()
    for early in (1, 99, 100, 101, 350, 777):
        await motion.release({0: [Record(FIRST | LAST, 1000, MHZ, 0, 0)]})
        await motion.cycles(early)
        await motion.put("CONTROL", abort=1)
        motion.heads[0] = await motion.field("HEAD", "axis0")
        await motion.cycles(3)
        count = len(motion.edges().pulses(0))
        position = await motion.register("POSITION", 0)
        await motion.cycles(300)
        assert len(motion.edges().pulses(0)) == count == position
        assert await motion.field("STATUS", "running") == 0
        motion.heads[0] = await motion.field("TAIL", "axis0")
        await motion.put("HEAD", axis0=motion.heads[0])


@cocotb.test()
@cocotb.parametrize(end=[(37, 12), (-9, 50), (-20, -20), (31, 0)])
async def line__steps_stay_within_half_a_step_of_it(dut, end):
    motion = await Motion(dut).started()
    await motion.put("SOURCE", 0b11)
    await motion.put("PATH_FEED", period=40)
    for index, value in zip((2, 3), end, strict=True):
        await motion.put("PATH_WORD", value, index=index)
    await motion.put("PATH_COMMAND", kind=0, plane=PLANES["xy"], combined=1)
    await motion.rest()
    _, steps = motion.edges().steps(2, 20)
    places = np.cumsum(steps, axis=0)
    assert tuple(places[-1]) == end
    direction = np.array(end) / np.hypot(*end)
    off = places @ np.array([-direction[1], direction[0]])
    assert np.abs(off).max() <= 0.5 + 1e-9, np.abs(off).max()
    assert await motion.register("PATH_STATUS") == 0


@cocotb.test()
async def reset__in_a_move__rests_at_zero(dut):
    motion = await Motion(dut).started()
    await motion.release({axis: [Record(FIRST, 1000, MHZ, 0, 0)] for axis in range(AXES)})
    await motion.cycles(1000)
    await motion.reset()
    assert word(dut.step_o) == 0 and word(dut.irq_o) == 0
    assert await motion.register("STATUS") == 0 and await motion.register("HEAD") == 0
    assert [await motion.register("POSITION", axis) for axis in range(AXES)] == [0] * AXES
