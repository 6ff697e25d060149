# SPDX-License-Identifier: Apache-2.0
"""The ASIP under cocotb: the tracking law tick by tick, operations, faults, resets, host accesses.

test_asip.py starts the tests on both configurations, and some of them in Icarus.
"""

from __future__ import annotations

import os

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge
from cocotb.utils import get_sim_time

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.bench.run.bounds import bounds
from sim.cocotb import golden
from sim.cocotb.asip import Asip, AsipMonitor
from sim.cocotb.clocked import word
from sim.core.iss.path import preset
from sim.robot import tracking
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, OUTPUTS, SET_POINTS, SetPoints
from sim.rtl.asip_bus import (
    BLOCK,
    CLEAR,
    CSR,
    IRQ_ALL,
    IRQ_DONE,
    IRQ_FAULT,
    START,
    STATUS,
    run_words,
)
from tests.asip.tracking_path import reversing_path
from tests.bench.seed import SEED
from tests.cocotb.unit_tb import operands

PROGRAMS = ROOT / "asip_asm/programs"
LEG = ROOT / "sim/core/host/leg_length.s"
# Cycles of one tick, whatever the data are.
CYCLES = {
    ("fast", "as_printed"): 204,
    ("fast", "optimised"): 111,
    ("small", "as_printed"): 518,
    ("small", "optimised"): 264,
    ("fast", "leg"): 59,
    ("small", "leg"): 60,
}
PERIODS = [8000, 10000]  # 125 MHz and 100 MHz [ps]
TICKS = int(os.environ.get("TICKS", "12"))
LEG_TICK = {"x": 3.0, "y": 0.5, "z": 4.0, "counter": 7}
LEG_OUTPUTS = {"length": 5.0, "inverse": float(np.float32(0.2)), "total": 25.0, "way": 7.0}


async def started(dut, period: int = 8000, pause: float = 0.0) -> Asip:
    """The core out of reset."""
    core = Asip(dut, period, SEED, pause)
    await core.reset()
    return core


async def with_leg(dut, **options) -> tuple[Asip, int]:
    """The core with the program of a leg's length; cycles of its tick."""
    core = await started(dut, **options)
    image = await core.load(LEG)
    return core, CYCLES[image.configuration, "leg"]


async def written(core: Asip, tmp: str, text: str):
    """Load a program given as text; `tmp` names its file."""
    file = os.path.abspath(f"{tmp}.s")
    with open(file, "w", encoding="utf-8") as out:
        out.write(text)
    return await core.load(file)


# ---------------------------------------------------------------- the tracking law
@cocotb.test()
@cocotb.parametrize(program=["as_printed", "optimised"], period=PERIODS)
async def tracking__each_tick_of_a_path__within_bounds_of_numpy(dut, program, period):
    """Outputs keep the derived error bounds; cycles and time are those of the schedule."""
    robot = Robot.load()
    path, counts = reversing_path(robot, 600)
    short = SetPoints.from_words(path.words()[:TICKS])
    want = tracking.run(robot, short, counts[:TICKS])
    limit = bounds(robot, short, want, program == "optimised").output
    core = await started(dut, period)
    image = await core.load(PROGRAMS / f"tracking_{program}.s")
    await core.preset(preset(image.to_json(), robot, counts[0].tolist()))
    cycles = CYCLES[image.configuration, program]
    for tick in range(TICKS):
        inputs = dict(zip(SET_POINTS, short.words()[tick].tolist(), strict=True))
        inputs |= dict(zip(COUNTS, counts[tick].tolist(), strict=True))
        await core.set(**inputs)
        await core.start()
        begun = get_sim_time("ps")
        await RisingEdge(dut.irq_o)
        # `start` ends half a clock after the edge that accepts it; irq_o is one register later.
        clocks = (get_sim_time("ps") - begun) / period
        assert clocks == cycles + 0.5, f"tick {tick}: {clocks} clocks"
        await core.next()
        got = await core.result()
        assert (got.fault, got.cycles) == ("NONE", cycles)
        error = np.abs([got.outputs[name] for name in OUTPUTS] - want.output[tick])
        assert np.all(error <= limit[tick]), f"tick {tick}: {error}, bounds {limit[tick]}"


@cocotb.test()
@cocotb.parametrize(program=["as_printed", "optimised"])
async def tracking__far_away__outputs_at_the_limits(dut, program):
    robot = Robot.load()
    path, counts = reversing_path(robot, 600)
    core = await started(dut)
    image = await core.load(PROGRAMS / f"tracking_{program}.s")
    for sign in (1, -1):
        away = counts[0] - sign * np.array((40000, 40000, 40000, 9000, 9000))
        await core.preset(preset(image.to_json(), robot, away.tolist()))
        inputs = dict(zip(SET_POINTS, path.words()[0].tolist(), strict=True))
        got = await core.tick(**inputs, **dict(zip(COUNTS, away.tolist(), strict=True)))
        limits = dict(zip(OUTPUTS, robot.output_max, strict=True))
        assert got.outputs == {name: sign * limit for name, limit in limits.items()}


# ---------------------------------------------------------------- operations
# Result of a line of assembly on inputs p, q, r (bits) and n (int32), by numpy.
OPERATIONS = {
    "fmadd  {}, p, q, r": lambda p, q, r, n: golden.fma(p, q, r),
    "fmsub  {}, p, q, r": lambda p, q, r, n: golden.fma(p, q, minus(r)),
    "fnmsub {}, p, q, r": lambda p, q, r, n: golden.fma(minus(p), q, r),
    "fnmadd {}, p, q, r": lambda p, q, r, n: golden.fma(minus(p), q, minus(r)),
    "fmul   {}, p, q": lambda p, q, r, n: golden.mul(p, q),
    "fnmul  {}, p, q": lambda p, q, r, n: golden.mul(minus(p), q),
    "fadd   {}, p, q": lambda p, q, r, n: golden.add(p, q),
    "fsub   {}, p, q": lambda p, q, r, n: golden.sub(p, q),
    "fdiv   {}, p, q": lambda p, q, r, n: golden.div(p, q),
    "fsqrt  {}, p": lambda p, q, r, n: golden.sqrt(p),
    "feq    {}, p, q": lambda p, q, r, n: relation(p, q, "eq"),
    "flt    {}, p, q": lambda p, q, r, n: relation(p, q, "lt"),
    "fle    {}, p, q": lambda p, q, r, n: relation(p, q, "le"),
    "fmin   {}, p, q": lambda p, q, r, n: golden.least(p, q),
    "fmax   {}, p, q": lambda p, q, r, n: golden.most(p, q),
    "fabs   {}, p": lambda p, q, r, n: (p & ~golden.SIGN, 0),
    "fneg   {}, p": lambda p, q, r, n: (p ^ golden.SIGN, 0),
    "fsgn   {}, p": lambda p, q, r, n: golden.sign(p),
    "fsat   {}, p, q, r": lambda p, q, r, n: golden.saturate(p, q, r),
    "sel    {}, p, q, r": lambda p, q, r, n: chosen(golden.single(p) != 0, p, q, r),
    "selge  {}, p, q, r": lambda p, q, r, n: chosen(golden.single(p) >= 0, p, q, r),
    "selgt  {}, p, q, r": lambda p, q, r, n: chosen(golden.single(p) > 0, p, q, r),
    "i2f    {}, n": lambda p, q, r, n: golden.float_of(n),
    "f2i    {}, p": lambda p, q, r, n: golden.int_of(p, truncate=False),
    "f2it   {}, p": lambda p, q, r, n: golden.int_of(p),
    "iadd   {}, n, n": lambda p, q, r, n: (n + n, 0),
    "isub   {}, m, n": lambda p, q, r, n: (np.uint32(5) - n, 0),
}
ROWS = 12  # ticks for one operation


def minus(bits):
    """The numbers with the other sign, NaNs as they are."""
    return np.where(np.isnan(golden.single(bits)), bits, bits ^ golden.SIGN)


def relation(p, q, name):
    """1.0 or 0.0."""
    true, raised = golden.compare(p, q, name)
    return true * golden.ONE, raised


def chosen(condition, p, q, r):
    """q or r, bit for bit."""
    return np.where(condition & ~np.isnan(golden.single(p)), q, r), 0


@cocotb.test()
@cocotb.parametrize(name=[line.split()[0] for line in OPERATIONS])
async def operation__alone_in_a_program__bits_and_flags_of_numpy(dut, name):
    (line,) = (line for line in OPERATIONS if line.split()[0] == name)
    core = await started(dut)
    text = f"""
        .program "one operation"
        .input p, q, r
        .input n : int
        .input m : int
        .output done, safe = 0.0
        .export y
        {line.format("y")}
        mov done, 1.0
        halt
        """
    await written(core, name, text)
    both = zip(operands("corners", 3), operands("random", 3), strict=True)
    p, q, r = (np.concatenate((c[:ROWS], some[:ROWS])) for c, some in both)
    n = np.roll(p, 1)
    want, raised = OPERATIONS[line](p, q, r, n)
    raised = np.broadcast_to(raised, want.shape)
    places = {entry.name: BLOCK["constants"] + entry.index for entry in core.image.inputs}
    if "m" in places:
        await core.write(places["m"], 5)
    for i in range(len(p)):
        for pin, column in (("p", p), ("q", q), ("r", r), ("n", n)):
            if pin in places:
                await core.write(places[pin], int(column[i]))
        got, bits = await core.tick(), await core.bits_of("y")
        shown = f"{line}: p {int(p[i]):08x} q {int(q[i]):08x} r {int(r[i]):08x} n {int(n[i]):08x}"
        assert bits == want[i], f"{shown}: {bits:08x}, numpy {int(want[i]):08x}"
        assert got.flags == raised[i], f"{shown}: flags {got.flags:05b}, numpy {raised[i]:05b}"


@cocotb.test()
@cocotb.parametrize(inexact=["y", "z"])
async def operation__two_products_at_once__flags_of_either(dut, inexact):
    """With two multiply-add pipes, each of them is the inexact one in one of the cases."""
    core = await started(dut)
    text = """
        .program "two products"
        .input p, q
        .output y, safe = 0.0
        .output z, safe = 0.0
        fmul a, p, p
        fmul b, q, q
        mov  y, a
        mov  z, b
        halt
        """
    await written(core, "two", text)
    names = {"y": "p", "z": "q"}
    values = {pin: 1.1 if name == inexact else 3.0 for name, pin in names.items()}
    got = await core.tick(**values)
    square, raised = golden.mul(*[np.float32([1.1]).view(np.uint32)] * 2)
    assert got.words[inexact] == square[0]
    assert [got.outputs[name] for name in names if name != inexact] == [9.0]
    assert got.flags == raised[0] != 0


@cocotb.test()
@cocotb.parametrize(name=["fsin", "fcos"])
async def operation__sine_and_cosine__within_their_bound(dut, name):
    core = await started(dut)
    await written(
        core,
        name,
        f'.program "wave"\n.input p\n.output y, safe = 0.0\n {name} y, p\n halt\n',
    )
    angles = np.float32([core.random.uniform(-256, 256) for _ in range(ROWS)])
    got = [(await core.tick(p=float(angle))).words["y"] for angle in angles]
    error = golden.sine_error(angles.view(np.uint32), np.array(got, np.uint32), name == "fcos")
    assert error.max() < golden.SINE_ULP


@cocotb.test()
async def loop__with_a_branch__ends_when_numpy_s_does(dut):
    """Newton's iteration for a square root, as often as an input says."""
    core = await started(dut)
    await written(
        core,
        "loop",
        """
        .program "Newton"
        .input p, steps
        .output root, safe = 0.0
        .output left, safe = 0.0
        mov x, p
        mov n, steps
again:  fdiv q, p, x
        fadd s, x, q
        fmul half, s, 0.5
        fsub less, n, 1.0
        mov x, half
        mov n, less
        bnz n, again
        mov root, x
        mov left, n
        halt
        """,
    )
    for steps in (1, 2, 7):
        got = await core.tick(p=2.0, steps=float(steps))
        x = p = np.float32(2.0)
        for _ in range(steps):
            x = np.float32(0.5) * (x + p / x)
        assert got.outputs == {"root": float(x), "left": 0.0}


# ---------------------------------------------------------------- faults
async def faulty(core: Asip, cause: str, info: int | None, **inputs: float) -> None:
    """The next tick ends with this fault; outputs are safe; after a clear the core runs again."""
    safe = {out.name: int(out.safe, 16) for out in core.image.outputs}
    got = await core.tick(**inputs)
    assert got.fault == cause and info in (None, got.fault_info), got
    assert got.words == safe
    await core.write(CSR["CONTROL"], START)
    for _ in range(20):
        await core.settle()
        assert not word(core.dut.trace_issue_o), "a faulted core started"
        await core.next()
    status = await core.register("STATUS")
    assert STATUS["fault"].of(status) and not STATUS["busy"].of(status), "a faulted core started"
    await core.write(CSR["CONTROL"], CLEAR)
    assert await core.register("STATUS") & ~STATUS["flags"].mask == 0
    assert (await core.result()).words == safe
    await core.load(LEG)
    assert (await core.tick(**LEG_TICK)).outputs == LEG_OUTPUTS


@cocotb.test()
async def fault__illegal_operation(dut):
    core, _ = await with_leg(dut)
    await core.write(BLOCK["program"] + 4 * 2, 0)
    await core.write(BLOCK["program"] + 4 * 2 + 1, 0)
    await faulty(core, "ILLEGAL", 2, **LEG_TICK)


@cocotb.test()
async def fault__address_beyond_the_data(dut):
    core = await started(dut)
    text = """
        .program "table"
        .input i : int
        .data table = 1.5, 2.5
        .output y, safe = 7.0
        ld v, table[i]
        mov y, v
        halt
        """
    image = await written(core, "table", text)
    load = next(n for n, ops in enumerate(image.sources) if any(e.op == "ld" for e in ops))
    for i, value in enumerate((1.5, 2.5)):
        assert (await core.tick(i=i)).outputs == {"y": value}
    await faulty(core, "ADDRESS", load, i=1 << 20)


@cocotb.test()
async def fault__watchdog(dut):
    core, cycles = await with_leg(dut)
    await core.write(CSR["WATCHDOG"], cycles)
    assert (await core.tick(**LEG_TICK)).fault == "NONE"
    await core.write(CSR["WATCHDOG"], cycles // 2)
    await faulty(core, "WATCHDOG", None, **LEG_TICK)


@cocotb.test()
@cocotb.parametrize(x=[0.0, float("nan"), float("inf")])
async def fault__output_that_is_not_finite(dut, x):
    """A leg of length 0 has no reciprocal; a set-point that is no number has no length."""
    core, _ = await with_leg(dut)
    # With x = 0 only the reciprocal is infinite, with the others the schedule says what is first.
    await faulty(core, "NOT_FINITE", 1 if x == 0 else None, x=x, y=0.5, z=0.0, counter=0)


@cocotb.test()
async def fault__output_left_out(dut):
    core, _ = await with_leg(dut)
    await core.write(CSR["OUTPUT_MASK"], 0b11111)
    await faulty(core, "OUTPUT_MISSING", None, **LEG_TICK)


# ---------------------------------------------------------------- reset
@cocotb.test()
async def reset__in_any_clock_of_a_tick__core_is_idle_and_runs_again(dut):
    core, cycles = await with_leg(dut)
    for early in range(0, cycles + 4, 3):
        await core.set(**LEG_TICK)
        await core.start()
        await core.cycles(early)
        await core.reset()
        assert not word(dut.irq_o)
        assert await core.register("STATUS") == 0
        for name in ("WATCHDOG", "ENTRY", "OUTPUT_MASK", "IRQ_ENABLE"):
            assert await core.register(name) == (REGMAP.registers[name].reset or 0), name
        for address, data in run_words(core.image):
            await core.write(address, data)
        await core.write(CSR["IRQ_ENABLE"], IRQ_ALL)
        await core.preset({"sum": 0.0, "before": 0})
        got = await core.tick(**LEG_TICK)
        assert (got.outputs, got.cycles) == (LEG_OUTPUTS, cycles), f"reset in clock {early}"


# ---------------------------------------------------------------- host
@cocotb.test()
async def host__output_read_in_any_clock_of_a_tick__waits_for_its_end(dut):
    """The read gives the new value, takes at least the rest of the run, and costs it no cycle."""
    core, cycles = await with_leg(dut)
    place = BLOCK["outputs"] + core.image.outputs[0].index
    for early in range(0, cycles, 2):
        await core.set(**LEG_TICK | {"z": 4.0 + early})
        await core.start()
        begun = get_sim_time("ps")
        await core.cycles(early)
        length = np.uint32(await core.read(place)).view(np.float32)
        assert (get_sim_time("ps") - begun) // core.period >= cycles
        assert abs(length - np.hypot(3.0, 4.0 + early)) < 1e-6 * length
        assert await core.register("CYCLES") == cycles


@cocotb.test()
async def host__registers_read_in_any_clock_of_a_tick__answer_at_once(dut):
    core, cycles = await with_leg(dut)
    for early in range(0, cycles - 8, 2):
        await core.set(**LEG_TICK)
        await core.start()
        await core.cycles(early)
        begun = get_sim_time("ps")
        assert STATUS["busy"].of(await core.register("STATUS"))
        assert await core.register("ID") == REGMAP.registers["ID"].reset
        assert (get_sim_time("ps") - begun) // core.period <= 12
        await core.wait()
        assert (await core.result()).cycles == cycles


@cocotb.test()
@cocotb.parametrize(name=["WATCHDOG", "ENTRY", "OUTPUT_MASK"])
async def host__write_that_configures_a_run__waits_for_its_end(dut, name):
    core, cycles = await with_leg(dut)
    known = await core.register(name)
    await core.set(**LEG_TICK)
    await core.start()
    begun = get_sim_time("ps")
    await core.write(CSR[name], 1)
    assert (get_sim_time("ps") - begun) // core.period >= cycles
    got = await core.result()
    assert (got.outputs, got.cycles) == (LEG_OUTPUTS, cycles)
    assert await core.register(name) == 1 != known


@cocotb.test()
async def host__constant_written_in_a_tick__counts_for_the_next(dut):
    core, cycles = await with_leg(dut)
    await core.set(**LEG_TICK)
    for early in range(0, cycles, 7):
        await core.preset({"sum": 0.0, "before": 0})
        await core.start()
        await core.cycles(early)
        await core.set(x=6.0)
        assert (await core.result()).outputs == LEG_OUTPUTS
        length = (await core.tick()).outputs["length"]
        assert abs(length - np.hypot(6.0, 4.0)) < 1e-6
        await core.set(x=3.0)


@cocotb.test()
async def host__start_while_busy__is_ignored(dut):
    core, cycles = await with_leg(dut)
    await core.set(**LEG_TICK)
    await core.start()
    for _ in range(cycles // 4):
        await core.write(CSR["CONTROL"], START)
    await core.wait()
    got = await core.result()
    assert (got.outputs, got.cycles) == (LEG_OUTPUTS, cycles)


@cocotb.test()
async def host__interrupts__as_enabled(dut):
    core, _ = await with_leg(dut)
    bad = LEG_TICK | {"x": float("nan")}
    for enabled, good, faulted in ((IRQ_DONE, 1, 0), (IRQ_FAULT, 0, 1), (0, 0, 0), (IRQ_ALL, 1, 1)):
        await core.write(CSR["IRQ_ENABLE"], enabled)
        for inputs, want in ((LEG_TICK, good), (bad, faulted)):
            await core.preset({"sum": 0.0})  # A NaN would stay in it.
            await core.set(**inputs)
            await core.start()
            await core.cycles(2 * core.image.cycles)
            assert word(dut.irq_o) == want, f"IRQ_ENABLE {enabled}"
            await core.write(CSR["CONTROL"], CLEAR)
            assert word(dut.irq_o) == 0


@cocotb.test()
@cocotb.parametrize(pause=[0.0, 0.5])
async def host__memories__hold_what_was_written(dut, pause):
    """Data and banks A, C at random addresses; a word beyond the data reads 0."""
    core = await started(dut, pause=pause)
    draw = core.random
    places = [BLOCK["data"] + draw.randrange(1024) for _ in range(20)]
    places += [
        BLOCK["registers"] + 64 * bank + draw.randrange(64) for bank in (1, 3) for _ in "abc"
    ]
    memory = {}
    for _ in range(80):
        place = draw.choice(places)
        if place in memory and draw.random() < 0.5:
            assert await core.read(place) == memory[place]
        else:
            memory[place] = draw.getrandbits(32)
            await core.write(place, memory[place])
    assert await core.read(BLOCK["data"] + 1024) == 0


@cocotb.test()
async def host__bundle_beyond_the_program__changes_nothing(dut):
    """The map has room for more bundles than the core: they are not those at the start."""
    core, _ = await with_leg(dut)
    room = REGMAP.blocks["program"].words
    bundles = default_isa().program_bundles
    assert room > 4 * bundles
    for bundle in range(bundles, room // 4, 32):
        await core.write(BLOCK["program"] + 4 * bundle, 0)
        await core.write(BLOCK["program"] + 4 * bundle + 1, 0)
    assert (await core.tick(**LEG_TICK)).outputs == LEG_OUTPUTS


@cocotb.test()
async def host__registers__hold_every_bit(dut):
    """Words that set and clear each bit; bits beyond the fields of a register read 0. A core
    without streams has no bit of STREAM.
    """
    core = await started(dut)
    names = [name for name, record in REGMAP.registers.items() if record.access == "rw"]
    names = [name for name in names if name != "STREAM"]
    assert {"WATCHDOG", "ENTRY", "OUTPUT_MASK", "IRQ_ENABLE"} <= set(names)
    draws = [core.random.getrandbits(32) for _ in range(3)]
    for data in (0xFFFFFFFF, 0, *draws):
        for turn, name in enumerate(names):
            await core.write(CSR[name], data ^ turn)
        await core.write(CSR["STREAM"], data)
        assert await core.read(CSR["STREAM"]) == 0
        for turn, name in enumerate(names):
            fields = REGMAP.registers[name].fields.values()
            mask = sum(((1 << field.width) - 1) << field.low for field in fields)
            assert await core.read(CSR[name]) == (data ^ turn) & mask, name


@cocotb.test()
async def states__from_tick_to_tick__are_kept(dut):
    core, cycles = await with_leg(dut)
    monitor = AsipMonitor(core)
    monitor.start()
    total, before = np.float32(0.0), 0
    for i in range(8):
        x, counter = float(i), 3 * i * i
        got = await core.tick(x=x, y=0.5, z=2.0, counter=counter)
        total += np.float32(x * x + 4.0)
        assert got.outputs["total"] == total and got.outputs["way"] == counter - before
        before = counter
        assert await core.value("sum") == total and await core.value("before") == counter
    assert len(monitor.issued) == 8 * len(core.image.bundles)
    outputs = [at for _, at, _ in monitor.written if at.startswith("o")]
    assert len(outputs) == 8 * len(core.image.outputs)
