# SPDX-License-Identifier: Apache-2.0
"""The tracking law in C on the Nios II systems, tick by tick against the golden model in numpy.

Names of the tests begin with the platform; test_systems.py starts them.
"""

from __future__ import annotations

import functools

import cocotb
import numpy as np

from sim.bench.run.bounds import bounds
from sim.cocotb.clocked import word
from sim.cocotb.nios import Nios
from sim.robot import float32, tracking
from sim.robot.parameters import Robot
from sim.robot.published import Published
from sim.robot.records import COUNTS, OUTPUTS, SET_POINTS, SetPoints
from tests.asip.tracking_path import reversing_path
from tests.bench.seed import SEED

TICKS = {1: 2, 2: 6}
START_CLOCKS = 2_000


@functools.cache
def path():
    """The robot, the first ticks of a path with reversals, and counts near it."""
    robot = Robot.load()
    points, counts = reversing_path(robot, 600)
    most = max(TICKS.values())
    return robot, SetPoints.from_words(points.words()[:most]), counts[:most]


def inputs_of(tick: int) -> dict[str, int]:
    """Words of a tick by name."""
    _, points, counts = path()
    words = points.words()[tick].astype(np.float32).view(np.uint32).tolist()
    whole = counts[tick].tolist()
    return dict(zip((*SET_POINTS, *COUNTS), (*words, *whole), strict=True))


async def started(dut, platform: int) -> Nios:
    """The system with the law, just enabled, at the first point of the path."""
    nios = Nios(dut, seed=SEED)
    await nios.reset()
    program = await nios.load(f"tracking_fpga{platform}")
    parameters = np.concatenate(list(float32.Constants(path()[0]).block().values()))
    await nios.write(program.address("tracking_parameters"), parameters.view(np.uint32).tolist())
    await nios.set(**inputs_of(0))
    await nios.start(START_CLOCKS)
    return nios


async def law(dut, platform: int, ticks: int) -> None:
    """Outputs keep the derived error bounds; a tick takes no longer than published."""
    robot, points, counts = path()
    short = SetPoints.from_words(points.words()[:ticks])
    want = tracking.run(robot, short, counts[:ticks])
    limit = bounds(robot, short, want, optimised=False).output
    most = Published.load().time[f"FPGA{platform}"]["cycles"]
    nios = await started(dut, platform)
    for tick in range(ticks):
        got = await nios.tick(**inputs_of(tick))
        words = np.array([got.words[name] for name in OUTPUTS], np.uint32)
        error = np.abs(words.view(np.float32).astype(float) - want.output[tick])
        assert np.all(error <= limit[tick]), f"tick {tick}: {error}, bounds {limit[tick]}"
        assert 0 < got.cycles < most, f"tick {tick}: {got.cycles} cycles"
    assert not word(dut.overrun_o)


@cocotb.test()
async def fpga1__law_in_c__within_bounds_of_numpy(dut):
    await law(dut, 1, TICKS[1])


@cocotb.test()
async def fpga2__law_in_c__within_bounds_of_numpy(dut):
    await law(dut, 2, TICKS[2])


@cocotb.test()
async def fpga2__second_trigger_in_a_tick__is_an_overrun(dut):
    nios = await started(dut, 2)
    await nios.set(**inputs_of(0))
    await nios.trigger()
    await nios.cycles(50)
    assert word(dut.pending_o) and not word(dut.overrun_o)
    await nios.trigger()
    await nios.cycles(2)
    assert word(dut.overrun_o)
    await nios.result()


@cocotb.test()
async def fpga2__reset_in_a_tick__same_outputs_again(dut):
    """The core is stopped in a tick; loaded again it gives the words of the first run."""
    nios = await started(dut, 2)
    first = await nios.tick(**inputs_of(0))
    for early in (1, 777):
        await nios.trigger()
        await nios.cycles(early)
        nios = await restarted(nios)
        again = await nios.tick(**inputs_of(0))
        assert again.words == first.words, f"reset {early} clocks after the trigger"


async def restarted(nios: Nios) -> Nios:
    """The system after a reset, its data loaded again; the code is still there."""
    await nios.reset()
    memory = nios.map.memories["dtcm"]
    await nios.write(memory.base, nios.program.memories["dtcm"])
    parameters = np.concatenate(list(float32.Constants(path()[0]).block().values()))
    place = nios.program.address("tracking_parameters")
    await nios.write(place, parameters.view(np.uint32).tolist())
    await nios.set(**inputs_of(0))
    await nios.start(START_CLOCKS)
    return nios


@cocotb.test()
async def fpga2__host_reads_in_a_tick__change_nothing(dut):
    """Reads of the data memory in random clocks cost the tick no cycle and no bit."""
    nios = await started(dut, 2)
    alone = [await nios.tick(**inputs_of(tick)) for tick in range(2)]
    nios = await restarted(nios)
    place = nios.program.address("tracking_parameters")
    held = await nios.read(place)
    for tick, want in enumerate(alone):
        await nios.set(**inputs_of(tick))
        await nios.trigger()
        while word(dut.pending_o):
            assert await nios.read(place) == held
            await nios.cycles(nios.random.randrange(20))
        got = await nios.result()
        assert got.words == want.words
