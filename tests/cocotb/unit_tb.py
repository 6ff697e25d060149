# SPDX-License-Identifier: Apache-2.0
"""Each arithmetic unit against numpy: corner values, operands that round hard, flags, latency.

A test runs on the unit that its name begins or ends with; test_units.py starts them.
"""

from __future__ import annotations

import cocotb
import numpy as np

from asip_asm.machine import fp_latencies
from sim.cocotb import bins, golden
from sim.cocotb.unit import Unit
from tests.bench.seed import SEED
from tests.fpu import stimulus
from tests.fpu.tb import generator

LATENCY = fp_latencies()
FEW = 300  # random operands for a test
LEAST, HALF = np.uint32(0x0080_0000), np.uint32(0x3F00_0000)  # 2**-126, 0.5
SPECIAL = np.array([0, golden.ONE, 0x7F80_0000], np.uint32)  # 0, 1, infinity
SPECIAL = np.concatenate((SPECIAL, SPECIAL | golden.SIGN, [golden.NAN]))
FOLDED_INTERVAL = 7  # clocks from an operation of fp_divsqrt_folded to the next one
# op_i of fp_cmp, and what it makes of its operands.
COMPARISONS = {
    "eq": lambda a, b, c: one(golden.compare(a, b, "eq")),
    "lt": lambda a, b, c: one(golden.compare(a, b, "lt")),
    "le": lambda a, b, c: one(golden.compare(a, b, "le")),
    "min": lambda a, b, c: golden.least(a, b),
    "max": lambda a, b, c: golden.most(a, b),
    "abs": lambda a, b, c: quiet(a & ~golden.SIGN),
    "neg": lambda a, b, c: quiet(a ^ golden.SIGN),
    "mov": lambda a, b, c: quiet(a),
    "sgn": lambda a, b, c: golden.sign(a),
    "sat": golden.saturate,
    "sel": lambda a, b, c: choose(golden.single(a) != 0, a, b, c),
    "selge": lambda a, b, c: choose(golden.single(a) >= 0, a, b, c),
    "selgt": lambda a, b, c: choose(golden.single(a) > 0, a, b, c),
    "iadd": lambda a, b, c: quiet(a + b),
    "isub": lambda a, b, c: quiet(a - b),
}


def quiet(bits):
    """A result without exceptions."""
    return bits, np.zeros(len(bits), np.uint8)


def one(found):
    """1.0 or 0.0 for a comparison."""
    return found[0] * golden.ONE, found[1]


def choose(condition, a, b, c):
    """b where the condition holds, else c; of a NaN c."""
    return quiet(np.where(condition & ~np.isnan(golden.single(a)), b, c))


def operands(kind: str, columns: int) -> list[np.ndarray]:
    """Columns of operands: `corners` crossed (every pair of SPECIAL, some of the others), `random`
    ones near each other's exponent, or such whose product, sum and quotient are next to the least
    normal number.
    """
    rng = generator(f"cocotb {kind} {columns}")
    corners = stimulus.corners()
    if kind == "corners":
        if columns == 1:
            return [corners]
        rows = stimulus.cross(corners, corners)
        some = rows[rng.permutation(len(rows))[:2000]]
        rows = np.concatenate((stimulus.cross(SPECIAL, SPECIAL), some))
        found = [rows[:, 0], rows[:, 1], rng.permutation(rows[:, 0])]
    elif kind == "least":
        steps = np.arange(-8, 9).astype(np.uint32)
        pairs = [stimulus.cross((LEAST << np.uint32(scale)) + steps, one + steps)
                 for scale, one in ((0, golden.ONE), (1, HALF))]  # fmt: skip
        rows = np.concatenate((*pairs, below(rng, -1), below(rng, 1)))
        found = [rows[:, 0], rows[:, 1], rng.integers(0, 4, len(rows)).astype(np.uint32)]
    else:
        rows = np.concatenate((stimulus.add_pairs(rng, FEW), stimulus.mul_pairs(rng, FEW)))
        found = [rows[:, 0], rows[:, 1], rng.permutation(rows[:, 0])]
    return [column.copy() for column in found[:columns]]


def below(rng: np.random.Generator, direction: int) -> np.ndarray:
    """Pairs whose product (direction -1) or quotient (1) is 2^k below the least normal number, for
    each k up to 2 more than the digits of a significand.
    """
    k = np.repeat(np.arange(26), 4)
    first = rng.uniform(1, 2, len(k)) * 2.0**-100
    second = rng.uniform(1, 2, len(k)) * np.exp2(direction * (26.0 + k))
    return np.stack((first, second), axis=1).astype(np.float32).view(np.uint32)


async def started(dut, latency: str, interval: int = 1) -> Unit:
    """The unit out of reset, a third of the clocks without an operation."""
    rank = LATENCY[f"FP_{latency}_LATENCY"]
    unit = Unit(dut, rank, seed=SEED, bubbles=0.3, interval=interval)
    await unit.reset()
    return unit


async def expect(unit: Unit, want, exact=None, name: str = "", **columns) -> None:
    """The unit's results and flags are these. exact: result of finite operands as a fraction.

    The classes of exceptions, results and roundings are counted under the name of the unit, or
    `name`.
    """
    got = await unit.stream(**columns)
    wrong = np.flatnonzero((got[0] != want[0]) | (got[1] != want[1]))
    pins = {name: np.broadcast_to(column, len(want[0])) for name, column in columns.items()}
    lines = [
        " ".join(f"{name}={int(column[i]):08x}" for name, column in pins.items())
        + f": {int(got[0][i]):08x} {int(got[1][i]):05b}"
        + f", numpy {int(want[0][i]):08x} {int(want[1][i]):05b}"
        for i in wrong[:5]
    ]
    assert not len(wrong), f"{len(wrong)} of {len(want[0])} differ\n" + "\n".join(lines)
    name = name or unit.dut._name
    bins.results(name, *got)
    if exact:
        operands_ = [pins[pin].tolist() for pin in exact.__code__.co_varnames]
        for row in zip(*operands_, want[0].tolist(), strict=True):
            if all(bits & 0x7F800000 != 0x7F800000 for bits in row):
                value = exact(*map(bins.fraction, row[:-1]))
                if value is not None:
                    bins.rounding(name, value, row[-1])


KINDS = ["corners", "random", "least"]


@cocotb.test()
@cocotb.parametrize(kind=KINDS, sub=[0, 1])
async def fp_add__sum_and_difference(dut, kind, sub):
    unit = await started(dut, "ADD")
    a, b = operands(kind, 2)
    exact = (lambda a, b: a - b) if sub else (lambda a, b: a + b)
    await expect(unit, (golden.sub if sub else golden.add)(a, b), exact, a=a, b=b, sub=sub)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_mul__product(dut, kind):
    unit = await started(dut, "MUL")
    a, b = operands(kind, 2)
    await expect(unit, golden.mul(a, b), lambda a, b: a * b, a=a, b=b)


@cocotb.test()
@cocotb.parametrize(kind=KINDS, neg_product=[0, 1], neg_addend=[0, 1])
async def fp_fma__multiply_add(dut, kind, neg_product, neg_addend):
    unit = await started(dut, "FMA")
    a, b, c = operands(kind, 3)
    signs = {"neg_product": neg_product, "neg_addend": neg_addend}
    want = golden.fma(negated(a, neg_product), b, negated(c, neg_addend))
    exact = (lambda a, b, c: a * b + c) if not neg_product and not neg_addend else None
    await expect(unit, want, exact, a=a, b=b, c=c, kind=0, **signs)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_fma__exact_cancellation(dut, kind):
    """The addend is the rounded product: what is left is the product's rounding error."""
    unit = await started(dut, "FMA")
    a, b = operands(kind, 2)
    c = golden.mul(a, b)[0] ^ golden.SIGN
    await expect(unit, golden.fma(a, b, c), a=a, b=b, c=c, kind=0, neg_product=0, neg_addend=0)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_fma__product_alone(dut, kind):
    unit = await started(dut, "FMA")
    a, b, c = operands(kind, 3)
    await expect(unit, golden.mul(a, b), a=a, b=b, c=c, kind=1, neg_product=0, neg_addend=0)


@cocotb.test()
@cocotb.parametrize(kind=KINDS, neg_addend=[0, 1])
async def fp_fma__sum_alone(dut, kind, neg_addend):
    unit = await started(dut, "FMA")
    a, b, c = operands(kind, 3)
    want = golden.add(a, negated(c, neg_addend))
    await expect(unit, want, a=a, b=b, c=c, kind=2, neg_product=0, neg_addend=neg_addend)


def negated(bits: np.ndarray, wanted: int) -> np.ndarray:
    """The numbers with the sign inverted if wanted; NaNs as they are."""
    nan = np.isnan(golden.single(bits))
    return np.where(nan, bits, bits ^ np.uint32(wanted << 31))


def unit_name(unit: Unit, operation: str) -> str:
    """Name of one of the two operations of a divider, for its bins."""
    return f"{unit.dut._name}.{operation}"


async def quotients(unit: Unit, kind: str) -> None:
    """Corners and random operands, with operands that would be wrong for the other operation."""
    a, b = operands(kind, 2)
    want = golden.div(a, b)
    await expect(unit, want, lambda a, b: a / b if b else None, unit_name(unit, "quotient"),
                 a=a, b=b, sqrt=0)  # fmt: skip


async def roots(unit: Unit, kind: str) -> None:
    (a,) = operands(kind, 1)
    await expect(unit, golden.sqrt(a), name=unit_name(unit, "root"), a=a, b=np.flip(a), sqrt=1)


async def quotients_and_roots(unit: Unit) -> None:
    """In random order: no operation leaves anything to the next one."""
    a, b = operands("random", 2)
    sqrt = generator("cocotb order").integers(0, 2, len(a))
    both = zip(golden.div(a, b), golden.sqrt(a), strict=True)
    want = [np.where(sqrt, root, quotient) for quotient, root in both]
    await expect(unit, want, name=unit_name(unit, "both"), a=a, b=b, sqrt=sqrt)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_divsqrt__quotient(dut, kind):
    await quotients(await started(dut, "DIVSQRT"), kind)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_divsqrt__root(dut, kind):
    await roots(await started(dut, "DIVSQRT"), kind)


@cocotb.test()
async def fp_divsqrt__quotients_and_roots_in_random_order(dut):
    await quotients_and_roots(await started(dut, "DIVSQRT"))


async def folded(dut) -> Unit:
    """The divider of configuration `small`: seven clocks from an operation to the next one."""
    return await started(dut, "DIVSQRT", interval=FOLDED_INTERVAL)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_divsqrt_folded__quotient(dut, kind):
    await quotients(await folded(dut), kind)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def fp_divsqrt_folded__root(dut, kind):
    await roots(await folded(dut), kind)


@cocotb.test()
async def fp_divsqrt_folded__quotients_and_roots_in_random_order(dut):
    await quotients_and_roots(await folded(dut))


@cocotb.test()
@cocotb.parametrize(op=list(COMPARISONS))
async def fp_cmp__operation(dut, op):
    unit = await started(dut, "CMP")
    a, b, c = operands("corners", 3)
    code = list(COMPARISONS).index(op)
    await expect(unit, COMPARISONS[op](a, b, c), name=f"fp_cmp.{op}", a=a, b=b, c=c, op=code)


@cocotb.test()
@cocotb.parametrize(unsigned=[0, 1])
async def fp_i2f__integer_to_float(dut, unsigned):
    unit = await started(dut, "I2F")
    near = 1 << np.arange(32, dtype=np.uint64)
    near = np.concatenate((near - 1, near, near + 1)).astype(np.uint32)
    a = np.concatenate((near, operands("random", 1)[0]))
    await expect(unit, golden.float_of(a, bool(unsigned)), a=a, unsigned=unsigned)


@cocotb.test()
@cocotb.parametrize(truncate=[0, 1])
async def fp_f2i__float_to_integer(dut, truncate):
    unit = await started(dut, "F2I")
    halves = (np.arange(-20, 20) / 4).astype(np.float32).view(np.uint32)
    edges = np.array([0x4EFFFFFF, 0x4F000000, 0xCF000000, 0xCF000001], np.uint32)
    a = np.concatenate((halves, edges, stimulus.corners(), operands("random", 1)[0]))
    await expect(unit, golden.int_of(a, bool(truncate)), a=a, truncate=truncate)


def angles_in_range() -> np.ndarray:
    """Random angles, such that are any power of two away from a quarter turn, and small ones."""
    rng = generator("cocotb angles")
    turns = np.arange(-40, 41) * np.pi / 4
    steps = np.exp2(-rng.uniform(0, 24, FEW)) * rng.choice([-1, 1], FEW)
    beside = rng.choice(turns, FEW) + steps
    small = np.exp2(rng.uniform(-147, 0, FEW // 4)) * rng.choice([-1, 1], FEW // 4)
    return np.concatenate((rng.uniform(-256, 256, FEW), turns, beside, small, [256.0, -256.0]))


async def within_range(unit: Unit, cos: int) -> None:
    """Within the error bound of numpy in double precision; exact at zero; exceptions."""
    angles = angles_in_range()
    a = np.concatenate((angles.astype(np.float32).view(np.uint32), np.uint32([0, 1 << 31])))
    got, raised = await unit.stream(a=a, cos=cos)
    error = golden.sine_error(a, got, bool(cos))
    worst = int(np.argmax(error))
    assert error[worst] < golden.SINE_ULP, f"{error[worst]:.4f} ulp at {int(a[worst]):08x}"
    exact = np.array([golden.ONE] * 2 if cos else [0, 1 << 31], np.uint32)
    assert np.array_equal(got[-2:], exact)
    want = golden.sine_flags(a, bool(cos))
    assert np.array_equal(raised, want), f"flags at {int(a[np.argmax(raised != want)]):08x}"
    bins.results(unit.dut._name, got, raised)


async def outside_of_range(unit: Unit, cos: int) -> None:
    a = np.uint32([0x43800001, 0xC3800001, 0x7F7FFFFF, 0x7F800000, 0xFF800000, 0x7F800001])
    want = np.full(len(a), golden.NAN), np.full(len(a), golden.NV, np.uint8)
    await expect(unit, want, a=a, cos=cos)


@cocotb.test()
@cocotb.parametrize(cos=[0, 1])
async def fp_sincos__within_its_range(dut, cos):
    await within_range(await started(dut, "SINCOS"), cos)


@cocotb.test()
@cocotb.parametrize(cos=[0, 1])
async def fp_sincos__outside_of_its_range(dut, cos):
    await outside_of_range(await started(dut, "SINCOS"), cos)


@cocotb.test()
@cocotb.parametrize(cos=[0, 1])
async def fp_sincos_overlapped__within_its_range(dut, cos):
    await within_range(await started(dut, "SINCOS_OVERLAPPED"), cos)


@cocotb.test()
@cocotb.parametrize(cos=[0, 1])
async def fp_sincos_overlapped__outside_of_its_range(dut, cos):
    await outside_of_range(await started(dut, "SINCOS_OVERLAPPED"), cos)


@cocotb.test()
@cocotb.parametrize(unit=["add", "mul", "fma", "divsqrt", "cmp", "i2f", "f2i", "sincos"])
async def reset__with_an_operation_in_flight(dut, unit):
    """It gives no result, whenever the reset comes."""
    driver = await started(dut, unit.upper())
    for early in range(driver.latency):
        driver.idle()
        dut.valid_i.value = 1
        await driver.next()
        dut.valid_i.value = 0
        await driver.cycles(early)
        await driver.reset()
        for _ in range(driver.latency + 1):
            await driver.settle()
            assert not int(dut.valid_o.value), f"a result after a reset {early} clocks after it"
            await driver.next()
