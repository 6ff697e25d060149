# SPDX-License-Identifier: Apache-2.0
"""The front-end of the drives: decoders, modulators and gates against sums and windows in numpy.

test_systems.py starts the tests.
"""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge

from sim.cocotb.agent import Agent, signed
from sim.cocotb.clocked import word
from sim.rtl.gen.drive_regmap import REGMAP
from tests.bench.seed import SEED

AXES = 5
HALF = 1250  # clocks of half a period of the carrier after a reset
SLOW = 64  # bits of one of the three windows of a sample
BRAKE, RUN = 1, 2
ALL = (1 << AXES) - 1
PINS = ("core_readdata_i", "core_waitrequest_i", "core_irq_i", "order_i", "stop_i", "bus_i")
PINS += ("a_i", "b_i", "z_i", "bit_a_i", "bit_b_i", "bit_c_i", "fault_i")


async def started(dut) -> Agent:
    """The front-end out of reset."""
    drive = Agent(dut, REGMAP, seed=SEED, quiet=PINS)
    await drive.reset()
    return drive


# ---------------------------------------------------------------- encoders
def lines(positions: list[int]) -> dict[str, int]:
    """A, B of every axis, 00, 10, 11, 01 upwards, and Z at the positions that 64 divides."""
    quarters = [position & 3 for position in positions]
    columns = {
        "a": [quarter in (1, 2) for quarter in quarters],
        "b": [quarter in (2, 3) for quarter in quarters],
        "z": [position % 64 == 2 for position in positions],
    }
    return {name: sum(bit << i for i, bit in enumerate(row)) for name, row in columns.items()}


async def show(drive: Agent, positions: list[int]) -> None:
    for name, value in lines(positions).items():
        getattr(drive.dut, f"{name}_i").value = value


@cocotb.test()
@cocotb.parametrize(filter_=[0, 3])
async def encoders__random_tours_of_every_axis__positions_and_indices(dut, filter_):
    drive = await started(dut)
    await drive.put("ENCODER", filter=filter_)
    draw = np.random.default_rng([SEED, filter_])
    biased = draw.choice([-1, 1], (400, AXES), p=[0.3, 0.7])
    tour = np.cumsum(biased, axis=0)
    indices = [None] * AXES
    for positions in tour.tolist():
        await show(drive, positions)
        indices = [p if p % 64 == 2 else i for p, i in zip(positions, indices, strict=True)]
        await drive.cycles(filter_ + 1 + int(draw.integers(0, 4)))
    await drive.cycles(8 + filter_)
    found = [signed(await drive.register("POSITION", axis)) for axis in range(AXES)]
    assert found == tour[-1].tolist()
    for axis, index in enumerate(indices):
        seen = await drive.field("STATUS", "index") >> axis & 1
        assert seen == (index is not None)
        assert not seen or signed(await drive.register("INDEX", axis)) == index
    assert await drive.field("STATUS", "illegal") == 0


@cocotb.test()
async def encoder__both_lines_at_once__is_counted_and_trips_if_guarded(dut):
    drive = await started(dut)
    await drive.put("ENCODER", filter=0)
    for guarded, trips in ((0, 0), (1, 1 << 1)):
        await drive.put("GUARD", encoder=guarded)
        for step in range(5):
            dut.a_i.value = dut.b_i.value = (step & 1) << 1 ^ 2
            await drive.cycles(6)
        assert await drive.register("ILLEGAL", 1) == 5 and await drive.register("ILLEGAL", 0) == 0
        assert await drive.field("STATUS", "illegal") == 1 << 1
        assert await drive.field("STATUS", "trip") == trips
        dut.a_i.value = dut.b_i.value = 0
        await drive.reset()
        await drive.put("ENCODER", filter=0)


# ---------------------------------------------------------------- modulators
async def feed(drive: Agent, log: list[tuple[int, int]]) -> None:
    """A random bit for every modulator with each clock of theirs."""
    density = 0.5
    while True:
        await RisingEdge(drive.dut.mclk_o)
        if len(log) % 100 == 0:
            density = drive.random.choice((0.0, 0.2, 0.5, 0.9, 1.0))
        pair = tuple(
            sum((drive.random.random() < density) << axis for axis in range(AXES)) for _ in "ab"
        )
        drive.dut.bit_a_i.value, drive.dut.bit_b_i.value = pair
        log.append(pair)


@cocotb.test()
async def modulators__samples_are_weighted_windows_of_the_bits(dut):
    """All ten currents of a half period are the windows that end with the same bit."""
    drive, log = await started(dut), []
    cocotb.start_soon(feed(drive, log))
    samples = []
    for _ in range(8):
        now = await drive.register("TIME")
        await drive.cycles((600 - now) % HALF)
        samples.append(
            [
                signed(await drive.register(f"CURRENT_{name}", axis))
                for name in "AB"
                for axis in range(AXES)
            ]
        )
    bits = np.array([[pair[n] >> axis & 1 for n in (0, 1) for axis in range(AXES)] for pair in log])
    box = np.ones(SLOW, np.int64)
    weights = np.convolve(np.convolve(box, box), box)
    windows = np.array([np.convolve(row, weights, "valid") for row in bits.T]).T - SLOW**3 // 2
    ends = []
    for sample in samples[2:]:
        (at,) = np.flatnonzero(np.all(windows == sample, axis=1))
        ends.append(int(at))
    assert set(np.diff(ends)) <= {HALF // 6, HALF // 6 + 1}, ends


@cocotb.test()
@cocotb.parametrize(axis=[0, 4])
async def overcurrent__trips_its_axis_alone(dut, axis):
    """Zero current is half of the bits; all bits 1 are full scale, 256 fast units."""
    drive = await started(dut)
    await drive.put("CURRENT_LIMIT", size=200)

    async def calm(short: list[int]) -> None:
        while True:
            await RisingEdge(dut.mclk_o)
            dut.bit_a_i.value = (ALL if len(short) & 1 else 0) | short[0] << axis
            dut.bit_b_i.value = ALL if len(short) & 1 else 0
            short.append(0)

    state = [0]
    cocotb.start_soon(calm(state))
    await drive.cycles(600)
    await drive.put("CONTROL", clear=ALL)
    await drive.cycles(1200)
    assert await drive.field("STATUS", "trip") == 0
    state[0] = 1
    await drive.cycles(6 * 40)
    assert await drive.field("STATUS", "trip") == 1 << axis


# ---------------------------------------------------------------- gates
async def gates(drive: Agent, clocks: int) -> tuple[np.ndarray, np.ndarray]:
    """High and low gates of all phases in so many clocks, (clocks, 3 * AXES)."""
    rows = []
    for _ in range(clocks):
        await drive.next()
        rows.append((word(drive.dut.high_o), word(drive.dut.low_o)))
    columns = np.array(rows)[:, :, np.newaxis] >> np.arange(3 * AXES) & 1
    return columns[:, 0].astype(bool), columns[:, 1].astype(bool)


async def running(dut, half: int, dead: int, values: list[int]) -> Agent:
    """Every axis in run with these clocks of its three phases."""
    drive = await started(dut)
    await drive.put("PWM", half_period=half, minimum=0)
    await drive.put("DEAD_TIME", clocks=dead)
    await drive.put("CONTROL", clear=ALL)
    for i, value in enumerate(values):
        last = i == len(values) - 1
        await drive.put("COMPARE", value=value, phase=i % 3, axis=i // 3, commit=last)
    await drive.put("MODE", **{f"axis{axis}": RUN for axis in range(AXES)})
    await drive.cycles(2 * HALF + 2 * half)
    return drive


@cocotb.test()
@cocotb.parametrize(dead=[0, 30])
async def gates__a_period_of_every_phase__widths_and_dead_time(dut, dead):
    """A gate is on for its clocks of a period less the dead time; never both, never sooner."""
    half, least = 150, max(dead, 12)
    draw = np.random.default_rng([SEED, dead])
    values = [0, half, *draw.integers(20, half - 20, 3 * AXES - 2).tolist()]
    drive = await running(dut, half, dead, values)
    high, low = await gates(drive, 4 * half)
    assert not (high & low).any()
    for phase, value in enumerate(values):
        on = [int(column[:, phase].sum()) for column in (high, low)]
        if value in (0, half):
            assert on == ([0, 4 * half] if value == 0 else [4 * half, 0])
            continue
        # Two periods; the dead time begins in the clock after the last one of a gate.
        assert on == [2 * (2 * value - least), 2 * (2 * (half - value) - least)], (phase, value)
        lit = np.flatnonzero((high | low)[:, phase])
        gaps = np.diff(lit) - 1
        assert np.all((gaps == 0) | (gaps >= least)), (phase, gaps)


@cocotb.test()
async def brake__all_low_gates_are_on(dut):
    drive = await running(dut, 100, 12, [50] * 3 * AXES)
    await drive.put("MODE", **{f"axis{axis}": BRAKE for axis in range(AXES)})
    await drive.cycles(20)
    high, low = await gates(drive, 250)
    assert not high.any() and low.all()


@cocotb.test()
@cocotb.parametrize(cause=["fault", "bus", "overvoltage", "stop"])
async def trip__of_each_cause__gates_off_until_a_clear(dut, cause):
    """A fault of the power stage is its axis' own, the others concern every axis."""
    drive = await running(dut, 100, 12, [50] * 3 * AXES)
    dut.bus_i.value = 500
    await drive.put("GUARD", bus=400)
    await drive.put("BUS_LIMIT", most=600)
    await drive.put("LINK", orders=1)
    await drive.put("BRAKE", release=ALL)
    await drive.cycles(5)
    assert word(dut.release_o) == ALL and await drive.field("STATUS", "trip") == 0
    pin, bad, good, tripped = {
        "fault": (dut.fault_i, 1 << 2, 0, 1 << 2),
        "bus": (dut.bus_i, 399, 400, ALL),
        "overvoltage": (dut.bus_i, 601, 600, ALL),
        "stop": (dut.stop_i, 1, 0, ALL),
    }[cause]
    pin.value = bad
    await drive.cycles(5)
    high, low = await gates(drive, 250)
    off = [bool(tripped >> axis & 1) for axis in range(AXES)]
    on = (high | low).reshape(250, AXES, 3).any(axis=(0, 2))
    assert on.tolist() == [not each for each in off]
    assert word(dut.release_o) == ALL & ~tripped
    await drive.put("CONTROL", clear=ALL, link=1)
    await drive.cycles(3)
    assert await drive.field("STATUS", "trip") == tripped, "the cause is still there"
    pin.value = good
    await drive.cycles(5)
    assert await drive.field("STATUS", "trip") == tripped
    await drive.put("CONTROL", clear=0, link=1)
    await drive.cycles(2)
    await drive.put("CONTROL", clear=ALL)
    await drive.cycles(5)
    assert await drive.field("STATUS", "trip") == 0
    high, low = await gates(drive, 250)
    assert high.any(axis=0).all() and low.any(axis=0).all()


@cocotb.test()
async def overvoltage__gates_off_after_three_clocks_and_the_chopper_is_on(dut):
    """The chopper is on before the trip, stays on with it, and goes off at its own level."""
    drive = await running(dut, 100, 12, [50] * 3 * AXES)
    dut.bus_i.value = 560
    await drive.put("BUS_LIMIT", most=640)
    await drive.put("CHOPPER", on=615, off=590)
    for volts, on in ((615, 0), (616, 1), (590, 1), (589, 0), (615, 0), (640, 1)):
        dut.bus_i.value = volts
        await drive.cycles(2)
        assert word(dut.chopper_o) == on == await drive.field("STATUS", "chopper"), volts
        assert await drive.field("STATUS", "trip") == 0
    while not word(dut.high_o):
        await drive.next()
    dut.bus_i.value = 641
    await drive.cycles(3)
    high, low = await gates(drive, 250)
    assert not high.any() and not low.any()
    assert await drive.field("STATUS", "overvoltage") == 1
    assert await drive.field("STATUS", "trip") == ALL and word(dut.chopper_o) == 1
    dut.bus_i.value = 589
    await drive.cycles(2)
    assert word(dut.chopper_o) == 0
