# SPDX-License-Identifier: Apache-2.0
"""Every custom instruction, alone and in ci_slaves, against SoftFloat and MPFR, with stalls.

Each check gives the same operands to the component alone and through the interconnect of its
platform, with clk_en low in half of the cycles and idle cycles with random pins in between.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from sim.core.fpbench import softfloat as reference
from sim.core.fpbench.softfloat import COMPARISONS as COMPARED
from tests.bench.seed import SEED
from tests.custom.ci_bench import ALONE, HALF, PLATFORMS, SLAVES, CiBench, fields
from tests.fpu import stimulus
from tests.fpu.tb import generator
from tests.fpu.test_fp_sincos import BOUND_ULP, LIMIT, error_ulp, near_multiples, random_angles

SIGN, CANON_NAN = stimulus.SIGN, np.uint32(0x7FC00000)
FPGA1, FPGA2 = PLATFORMS["fpga1"], PLATFORMS["fpga2"]
RANDOM = 5_000  # of a unit that tests/fpu covers
RANDOM_OWN = 60_000  # ci_faddsub and ci_fmul are arithmetic of their own
OWN = {"fpga2.fadd", "fpga2.fsub", "fpga2.fmul"}


@pytest.fixture(scope="module")
def bench() -> CiBench:
    return CiBench()


def flushed(bits: np.ndarray) -> np.ndarray:
    """Subnormal numbers as zeros of their sign."""
    return np.where(bits & 0x7F800000 == 0, bits & SIGN, bits).astype(np.uint32)


def bits_of(function: Callable) -> Callable:
    """A reference without its flags."""
    return lambda *operands: function(*operands)[0].astype(np.uint32)


def fph1(function: Callable) -> Callable:
    """What FPH1 makes of an operation: subnormal numbers are zero on both sides."""
    return lambda a, b: flushed(function(flushed(a), flushed(b))[0])


def fixsi(a: np.ndarray) -> np.ndarray:
    """SoftFloat's truncation in range; saturated outside, 2^31 - 1 for a NaN."""
    with np.errstate(invalid="ignore"):
        value = a.view(np.float32).astype(np.float64)
        outside = ~(np.abs(value) < 2.0**31)
        limit = np.where((value < 0) & ~np.isnan(value), 0x80000000, 0x7FFFFFFF)
    return np.where(outside, limit, reference.f32_to_i32(a)[0]).astype(np.uint32)


def truth(function: Callable, invert: bool = False, swap: bool = False) -> Callable:
    def compare(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        bits = function(b, a)[0] if swap else function(a, b)[0]
        return (bits ^ np.uint32(invert)).astype(np.uint32)

    return compare


REFERENCE: dict[str, Callable] = {
    "fpga1.fmul": fph1(reference.mul),
    "fpga1.fadd": fph1(reference.add),
    "fpga1.fsub": fph1(reference.sub),
    "fpga1.fdiv": fph1(reference.div),
    "fpga2.fmul": bits_of(reference.mul),
    "fpga2.fadd": bits_of(reference.add),
    "fpga2.fsub": bits_of(reference.sub),
    "fpga2.fdiv": bits_of(reference.div),
    "fpga2.fsqrt": bits_of(reference.sqrt),
    "fpga2.floatis": bits_of(reference.i32_to_f32),
    "fpga2.fixsi": fixsi,
    "fpga2.fabs": bits_of(COMPARED["ABS"][1]),
    "fpga2.fneg": bits_of(COMPARED["NEG"][1]),
    "fpga2.fmin": bits_of(COMPARED["MIN"][1]),
    "fpga2.fmax": bits_of(COMPARED["MAX"][1]),
    "fpga2.fsign": bits_of(COMPARED["SGN"][1]),
    "fpga2.fcmpeq": truth(reference.eq),
    "fpga2.fcmpne": truth(reference.eq, invert=True),
    "fpga2.fcmplt": truth(reference.lt),
    "fpga2.fcmple": truth(reference.le),
    "fpga2.fcmpgt": truth(reference.lt, swap=True),
    "fpga2.fcmpge": truth(reference.le, swap=True),
    "fpga2.fsat": lambda a, b: COMPARED["SAT"][1](a, b | SIGN, b & ~SIGN)[0],
}
MULTIPLICATIVE = {"fmul", "fdiv"}


def operands(platform: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Corner values crossed, and random pairs of the kind that the operation finds hard."""
    rng = generator(f"ci {platform} {name}")
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    pairs = stimulus.mul_pairs if name in MULTIPLICATIVE else stimulus.add_pairs
    count = RANDOM_OWN if f"{platform}.{name}" in OWN else RANDOM
    rows = np.concatenate((corners, pairs(rng, count), stimulus.mixed(rng, count // 2, 2)))
    return rows[:, 0].copy(), rows[:, 1].copy()


def expect_equal(name: str, device: str, got, want, *columns: np.ndarray) -> None:
    wrong = np.flatnonzero(got != want)
    if not len(wrong):
        return
    lines = [
        " ".join(f"{int(column[i]):08x}" for column in columns)
        + f"  want {int(want[i]):08x}  got {int(got[i]):08x}"
        for i in wrong[:8]
    ]
    raise AssertionError(
        f"{name} by {device}: {len(wrong)} of {len(got)} differ (SEED={SEED})\n"
        + "\n".join(lines)
        + f"\nreplay: make test T='{name.split('.')[1]} and components' SEED={SEED}"
    )


@pytest.mark.quick("fpga2.f[aimps]*", "fpga2.fs*")
@pytest.mark.parametrize("name", REFERENCE)
def test_components__every_instruction__matches_reference_in_its_cycles(bench, name):
    platform, short = name.split(".")
    item = PLATFORMS[platform].instructions[short]
    kind = PLATFORMS[platform].components[item.component].type
    a, b = operands(platform, short)
    want = REFERENCE[name](*(a, b)[: len(item.arguments)])
    if kind == "combinational":
        outputs = bench.combinational(item.n, a, b)
        for device in sorted({item.component, platform} & set(outputs)):
            expect_equal(name, device, outputs[device], want, a, b)
        return
    alone = ALONE[item.component.removeprefix("ci_")]
    ways = (
        (item.component, alone, 0 if kind == "variable" else item.cycles),
        ("ci_slaves", SLAVES[platform], 0),
    )
    for device, select, fixed in ways:
        got, cycles = bench.run(select, item.n, a, b, fields(item), fixed, stalls=HALF, gaps=3)
        assert set(cycles.tolist()) == {item.cycles}, f"{name} by {device}"
        expect_equal(name, device, got, want, a, b)


@pytest.mark.parametrize("name", ["fsin", "fcos"])
def test_components__sine_and_cosine__within_the_unit_s_bound_of_mpfr(bench, name):
    item, cosine = FPGA2.instructions[name], name == "fcos"
    rng = generator(f"ci {name}")
    angles = np.concatenate((random_angles(rng, 3000), rng.permutation(near_multiples())[:300]))
    outside = np.array([LIMIT + 1, 0x7F800000, 0xFF800000, 0x7FC00000, 0xC3800001], np.uint32)
    for device, select, fixed in ((name, ALONE[name], item.cycles), ("ci_slaves", 2, 0)):
        got, cycles = bench.run(
            select, item.n, angles, 0, fields(item), cycles=fixed, stalls=HALF, gaps=3
        )
        assert set(cycles.tolist()) == {item.cycles}
        worst = max(
            (error_ulp(cosine, x, y), x) for x, y in zip(angles.tolist(), got.tolist(), strict=True)
        )
        assert worst[0] <= BOUND_ULP, f"{device}: {worst[0]} ulp at {worst[1]:08x} SEED={SEED}"
        got, _ = bench.run(select, item.n, outside, 0, fields(item), cycles=fixed)
        assert set(got.tolist()) == {int(CANON_NAN)}


@pytest.mark.parametrize("select", [ALONE["fsat"], SLAVES["fpga2"]], ids=["alone", "slaves"])
def test_components__saturation__bounds_of_every_internal_register(bench, select):
    rng = generator("ci fsat registers")
    item = FPGA2.instructions
    bounds = stimulus.mixed(rng, 32, 2)
    low, high = np.minimum(*bounds.view(np.float32).T), np.maximum(*bounds.view(np.float32).T)
    ordered = rng.integers(0, 4, 32) != 0  # the others as they come: exchanged, NaN
    low = np.where(ordered, low.view(np.uint32), bounds[:, 0])
    high = np.where(ordered, high.view(np.uint32), bounds[:, 1])
    index = np.arange(32)

    def run(name, register, place, a=0, b=0):
        word = fields(item[name]) | register.astype(np.uint32) << place
        fixed = item[name].cycles if select == ALONE["fsat"] else 0
        got, cycles = bench.run(select, item[name].n, a, b, word, fixed, stalls=HALF, gaps=2)
        assert set(cycles.tolist()) == {item[name].cycles}
        return got

    order = rng.permutation(32)
    written = run("fsat_set", order, 10, low[order], high[order])
    assert not written.any()
    assert np.array_equal(run("fsat_low", index, 0), low)
    assert np.array_equal(run("fsat_high", index, 0), high)
    values, pick = stimulus.mixed(rng, 4000, 1)[:, 0], rng.integers(0, 32, 4000)
    got = run("fsat_pair", pick, 5, values)
    want = COMPARED["SAT"][1](values, low[pick], high[pick])[0]
    expect_equal("fpga2.fsat", "register pair", got, want, values, low[pick], high[pick])
    assert np.array_equal(run("fsat_low", index, 0), low), "only writerc = 0 writes"


def test_components__saturation__other_selections_of_registers_write_nothing(bench):
    index, select = np.arange(32, dtype=np.uint32), ALONE["fsat"]
    item = FPGA2.instructions
    ones, cycles = np.full(32, 0x3F800000, np.uint32), item["fsat_set"].cycles
    bench.run(select, 244, ones, ones, fields(item["fsat_set"]) | index << 10, cycles=cycles)
    for readra, readrb in ((0, 0), (0, 1), (1, 0)):
        word = (readra << 15 | readrb << 16) | index << 10
        got, _ = bench.run(select, 244, ones * 0, ones * 0, word, cycles=cycles)
        assert not got.any()
    got, _ = bench.run(select, 244, ones, ones, fields(item["fsat_low"]) | index, cycles=cycles)
    assert np.array_equal(got, ones)


def test_components__fph1__flushes_operands_and_results(bench):
    """Named cases: a subnormal is a zero of its sign, whichever side it is on."""
    cases = {
        "subnormal_operand": ("fadd", 0x807FFFFF, 0x00000000, 0x00000000),
        "sign_of_flushed_operand": ("fmul", 0x80000001, 0x3F800000, 0x80000000),
        "division_by_flushed_operand": ("fdiv", 0x3F800000, 0x80000001, 0xFF800000),
        "subnormal_result": ("fmul", 0x00800000, 0x3F000000, 0x00000000),
        "subnormal_difference": ("fsub", 0x00800000, 0x00800001, 0x80000000),
        "rounded_up_to_normal_stays": ("fmul", 0x00FFFFFF, 0x3F000000, 0x00800000),
        "nan_is_canonical": ("fadd", 0xFFFFFFFF, 0x3F800000, 0x7FC00000),
    }
    for name, (operation, a, b, want) in cases.items():
        item = FPGA1.instructions[operation]
        got, cycles = bench.run(ALONE["fph1"], item.n, np.array([a]), b)
        assert (int(got[0]), int(cycles[0])) == (want, item.cycles), name


def test_components__every_instruction_and_component_is_under_test():
    tested = set(REFERENCE) | {"fpga2.fsin", "fpga2.fcos"}
    tested |= {f"fpga2.fsat_{kind}" for kind in ("pair", "set", "low", "high")}
    assert tested == {f"{p.name}.{name}" for p in PLATFORMS.values() for name in p.instructions}
    multicycle = {
        c.name.removeprefix("ci_")
        for p in PLATFORMS.values()
        for c in p.components.values()
        if c.type != "combinational"
    }
    assert multicycle == set(ALONE)


# ---- protocol ----


@pytest.mark.parametrize("platform", SLAVES)
def test_slaves__numbers_without_component__end_at_once_with_zero(bench, platform):
    own = {n for part in PLATFORMS[platform].components.values() for n in part.numbers}
    used = {item.n for item in PLATFORMS[platform].instructions.values()}
    free = np.array(sorted(set(range(256)) - own))
    a = stimulus.raw_bits(generator("ci free"), len(free), 2)
    got, cycles = bench.run(SLAVES[platform], free, a[:, 0], a[:, 1], stalls=HALF, gaps=2)
    assert not got.any() and set(cycles.tolist()) == {1}
    every = np.array(sorted(set(range(256)) - used))
    a = stimulus.raw_bits(generator("ci free"), len(every), 2)
    assert not bench.combinational(every, a[:, 0], a[:, 1])[platform].any()


@pytest.mark.parametrize("platform", SLAVES)
def test_slaves__instructions_back_to_back__none_disturbs_the_next(bench, platform):
    """Instructions in random order, without a cycle in between, then with stalls and gaps."""
    names = [n for n in REFERENCE if n.startswith(platform)]
    items = [PLATFORMS[platform].instructions[n.split(".")[1]] for n in names]
    parts = PLATFORMS[platform].components
    pool = [(n, i) for n, i in zip(names, items, strict=True) if parts[i.component].type[0] != "c"]
    rng = generator(f"ci mixed {platform}")
    pick = rng.integers(0, len(pool), 4000)
    rows = stimulus.mixed(rng, len(pick), 2)
    n = np.array([pool[k][1].n for k in pick])
    want, cycles = np.zeros(len(pick), np.uint32), np.array([pool[k][1].cycles for k in pick])
    for k, (name, item) in enumerate(pool):
        mine = pick == k
        want[mine] = REFERENCE[name](*rows[mine].T[: len(item.arguments)])
    for stalls, gaps in ((0, 0), (HALF, 3)):
        got, took = bench.run(SLAVES[platform], n, rows[:, 0], rows[:, 1], stalls=stalls, gaps=gaps)
        assert np.array_equal(took, cycles)
        expect_equal(f"{platform}.mixed", "ci_slaves", got, want, n, rows[:, 0], rows[:, 1])


@pytest.mark.parametrize(
    ("select", "name"),
    [
        *((ALONE["fph1"], f"fpga1.{name}") for name in FPGA1.instructions),
        *((SLAVES["fpga1"], f"fpga1.{name}") for name in FPGA1.instructions),
        *((SLAVES["fpga2"], f"fpga2.{name}") for name in ("fadd", "fmul", "fdiv", "fsin", "fsat")),
    ],
)
def test_slaves__reset_in_an_instruction__no_done_after_it_and_the_next_is_whole(
    bench, select, name
):
    platform, short = name.split(".")
    item = PLATFORMS[platform].instructions[short]
    want, first = None, np.array([0x40490FDB], np.uint32)
    for cycles in range(1, item.cycles):
        bench.abandon(select, item.n, 0x3FC00000, 0x3F000000, cycles)
        assert bench.done_when_idle(select, item.n, 2 * item.cycles) == 0, f"after {cycles}"
        bench.abandon(select, item.n, 0x3FC00000, 0x3F000000, cycles)
        got, took = bench.run(select, item.n, first, 0x3F000000)
        assert int(took[0]) == item.cycles
        want = int(got[0]) if want is None else want
        assert int(got[0]) == want
    if name in REFERENCE:
        operands = (first, np.array([0x3F000000], np.uint32))
        assert want == int(REFERENCE[name](*operands)[0])


@pytest.mark.parametrize("platform", SLAVES)
def test_package__combinational_mask__bits_of_the_combinational_components(platform):
    part = PLATFORMS[platform]
    want = {n for c in part.components.values() if c.type == "combinational" for n in c.numbers}
    assert {n for n in range(256) if part.combinational >> n & 1} == want
