# SPDX-License-Identifier: Apache-2.0
"""Every custom instruction at the slave port of the CPU against numpy, with and without stalls.

Names of the tests begin with the platform; test_custom.py starts them.
"""

from __future__ import annotations

import random
from collections.abc import Callable

import cocotb
import numpy as np

from sim.cocotb import golden
from sim.cocotb.clocked import word
from sim.cocotb.custom import CustomInstructions
from tests.bench.seed import SEED
from tests.cocotb.unit_tb import operands

# Result bits of an instruction of platform 2 on columns of operand bits.
GOLDEN: dict[str, Callable] = {
    "fadd": lambda a, b: golden.add(a, b)[0],
    "fsub": lambda a, b: golden.sub(a, b)[0],
    "fmul": lambda a, b: golden.mul(a, b)[0],
    "fdiv": lambda a, b: golden.div(a, b)[0],
    "fsqrt": lambda a: golden.sqrt(a)[0],
    "floatis": lambda a: golden.float_of(a)[0],
    "fixsi": lambda a: golden.int_of(a)[0],
    "fabs": lambda a: a & ~golden.SIGN,
    "fneg": lambda a: a ^ golden.SIGN,
    "fmin": lambda a, b: golden.least(a, b)[0],
    "fmax": lambda a, b: golden.most(a, b)[0],
    "fsign": lambda a: golden.sign(a)[0],
    "fcmpeq": lambda a, b: golden.compare(a, b, "eq")[0],
    "fcmpne": lambda a, b: golden.compare(a, b, "eq")[0] ^ 1,
    "fcmplt": lambda a, b: golden.compare(a, b, "lt")[0],
    "fcmple": lambda a, b: golden.compare(a, b, "le")[0],
    "fcmpgt": lambda a, b: golden.compare(b, a, "lt")[0],
    "fcmpge": lambda a, b: golden.compare(b, a, "le")[0],
    "fsat": lambda a, b: golden.saturate(a, b | golden.SIGN, b & ~golden.SIGN)[0],
}
FIRST_GENERATION = {
    "fadd": golden.flushed(golden.add),
    "fsub": golden.flushed(golden.sub),
    "fmul": golden.flushed(golden.mul),
    "fdiv": golden.flushed(golden.div),
}
CYCLES = {"fadd": 3, "fsub": 3, "fmul": 3, "fdiv": 17, "fsqrt": 17, "floatis": 4, "fixsi": 3}
CYCLES |= {"fsat": 3, "fsin": 37, "fcos": 37}  # The others take one.
FIRST_CYCLES = {"fadd": 10, "fsub": 10, "fmul": 12, "fdiv": 35}
STALLS = [0.0, 0.5]
COUNT = 50  # calls with operands of each kind
SPECIAL = np.array(
    [0, 1 << 31, 1, 0x807FFFFF, 0x3F800000, 0xBF800000, 0xC0490FDB, 0x4EFFFFFF, 0x7F800000]
    + [0xFF800000, 0x7FC00000, 0x7F800001],
    np.uint32,
)


async def started(dut, platform: int = 2, stalls: float = 0.0) -> CustomInstructions:
    """The port out of reset; with stalls also with idle clocks between instructions."""
    cpu = CustomInstructions(dut, platform, seed=SEED, stalls=stalls, gaps=stalls)
    await cpu.reset()
    return cpu


async def expect(cpu: CustomInstructions, name: str, want, cycles: int, *columns) -> None:
    """The instruction gives these bits in so many enabled clocks."""
    for row in zip(want.tolist(), *(column.tolist() for column in columns), strict=True):
        got = await cpu.call(name, *row[1:])
        shown = " ".join(f"{value:08x}" for value in row[1:])
        assert got.bits == row[0], f"{name} {shown}: {got.bits:08x}, numpy {row[0]:08x}"
        assert got.cycles == cycles, f"{name} {shown}: {got.cycles} cycles, not {cycles}"


def columns_of(count: int) -> list[np.ndarray]:
    """Every pair of special values, some corner values, then random operands."""
    pairs = np.array(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)
    both = zip(pairs, operands("corners", 2), operands("random", 2), strict=True)
    found = [np.concatenate((pair, corner[:COUNT], some[:COUNT])) for pair, corner, some in both]
    return [column.astype(np.uint32) for column in found[:count]]


@cocotb.test()
@cocotb.parametrize(name=list(GOLDEN), stalls=STALLS)
async def fpga2__instruction(dut, name, stalls):
    cpu = await started(dut, stalls=stalls)
    columns = columns_of(len(cpu.instruction(name).arguments))
    await expect(cpu, name, GOLDEN[name](*columns), CYCLES.get(name, 1), *columns)


@cocotb.test()
@cocotb.parametrize(name=list(FIRST_GENERATION), stalls=STALLS)
async def fpga1__instruction(dut, name, stalls):
    cpu = await started(dut, 1, stalls)
    columns = [column[::2] for column in columns_of(2)]
    await expect(cpu, name, FIRST_GENERATION[name](*columns), FIRST_CYCLES[name], *columns)


@cocotb.test()
@cocotb.parametrize(name=["fsin", "fcos"], stalls=STALLS)
async def fpga2__sine_and_cosine(dut, name, stalls):
    cpu = await started(dut, stalls=stalls)
    draw = random.Random(SEED)
    angles = np.array([draw.uniform(-256, 256) for _ in range(150)])
    angles = np.concatenate((angles, np.arange(-8, 9) * np.pi / 2)).astype(np.float32)
    a = angles.view(np.uint32)
    calls = [await cpu.call(name, angle) for angle in a.tolist()]
    assert {call.cycles for call in calls} == {CYCLES[name]}
    got = np.array([call.bits for call in calls], np.uint32)
    error = golden.sine_error(a, got, name == "fcos")
    assert error.max() < golden.SINE_ULP, f"{error.max()} ulp at {angles[error.argmax()]}"
    for outside in (0x43800001, 0xC3800001, 0x7F800000, 0x7FC00000):
        assert (await cpu.call(name, outside)).bits == golden.NAN


@cocotb.test()
@cocotb.parametrize(stalls=STALLS)
async def fpga2__saturation__pairs_of_bounds(dut, stalls):
    """Each of the 32 internal registers holds its own two bounds, also exchanged ones."""
    cpu = await started(dut, stalls=stalls)
    low, high = (column[:32] for column in operands("random", 2))
    for i in cpu.random.sample(range(32), 32):
        assert (await cpu.call("fsat_set", int(low[i]), int(high[i]), rc=i)).cycles == 3
    for i in range(32):
        assert (await cpu.call("fsat_low", 0, ra=i)).bits == low[i]
        assert (await cpu.call("fsat_high", 0, ra=i)).bits == high[i]
    a = operands("random", 1)[0][:COUNT]
    pick = np.array([cpu.random.randrange(32) for _ in a])
    want = golden.saturate(a, low[pick], high[pick])[0]
    for value, i, bits in zip(a.tolist(), pick.tolist(), want.tolist(), strict=True):
        assert (await cpu.call("fsat_pair", value, rb=i)).bits == bits


@cocotb.test()
async def fpga2__number_without_instruction__ends_at_once_with_zero(dut):
    cpu = await started(dut)
    taken = {item.n for item in cpu.instructions.values()} | set(range(0xE0, 0xF2))
    for n in sorted(set(range(256)) - taken):
        dut.multi_n_i.value, dut.multi_start_i.value = n, 1
        await cpu.settle()
        assert word(dut.multi_done_o) == 1 and word(dut.multi_result_o) == 0, n
        await cpu.next()
        dut.multi_start_i.value = 0
        await cpu.settle()
        assert word(dut.multi_done_o) == 0, n
        await cpu.next()


@cocotb.test()
async def fpga2__instructions_in_random_order__share_their_units(dut):
    """Sum and difference, quotient and root, sine and cosine have one unit each."""
    cpu = await started(dut, stalls=0.2)
    a, b = columns_of(2)
    for i in range(len(a)):
        name = cpu.random.choice(list(GOLDEN))
        row = (a[i : i + 1], b[i : i + 1])[: len(cpu.instruction(name).arguments)]
        want = int(GOLDEN[name](*row)[0])
        assert (await cpu.call(name, *(int(x[0]) for x in row))).bits == want, name


@cocotb.test()
@cocotb.parametrize(platform=[2])
async def fpga2__reset_within_an_instruction(dut, platform):
    await reset_within(dut, platform, GOLDEN, CYCLES)


@cocotb.test()
@cocotb.parametrize(platform=[1])
async def fpga1__reset_within_an_instruction(dut, platform):
    await reset_within(dut, platform, FIRST_GENERATION, FIRST_CYCLES)


async def reset_within(dut, platform: int, model, cycles) -> None:
    """A reset in any clock of an instruction ends it; the next one is right."""
    cpu = await started(dut, platform)
    one, three = np.uint32([0x3F800000]), np.uint32([0x40400000])
    for name in ("fadd", "fmul", "fdiv"):
        for early in range(1, cycles[name]):
            item = cpu.instruction(name)
            dut.multi_n_i.value, dut.multi_start_i.value = item.n, 1
            await cpu.next()
            dut.multi_start_i.value = 0
            await cpu.cycles(early - 1)
            await cpu.reset()
            await cpu.settle()
            assert word(dut.multi_done_o) == 0, f"{name} goes on after a reset"
            await cpu.next()
            await expect(cpu, name, model[name](one, three), cycles[name], one, three)
