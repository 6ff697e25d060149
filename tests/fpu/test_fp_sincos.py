# SPDX-License-Identifier: Apache-2.0
"""fp_sincos against MPFR: the error in ulp, flags, exact cases and the ends of the range.

The error is |result - exact| in units of the last place of the binade that holds the exact value.
BOUND_ULP is half an ulp of rounding plus the errors before it, relative and in units of 2^-31:
table and cubic 0.6, three truncated sums of Horner's rule 1.1 (units of 2^-32 in a value above
1.41), the last factor cut to five bytes 1.0, truncation of the last product 0.7, reduction 0.7 (two
units of 2^-61 in 2^-28.5): together 2^-29, which is at most 2^-5 of an ulp.
"""

from __future__ import annotations

import functools
import math
import os
import sys

import gmpy2
import numpy as np
import pytest

from asip_asm.machine import load_machine
from sim.rtl.assertion_files import assertions_of
from sim.rtl.plain import plain
from sim.rtl.sources import sources_of
from tests.bench.commands import output
from tests.bench.seed import SEED
from tests.bench.self_running import Program
from tests.fpu import stimulus
from tests.fpu.tb import ROOT, generator, package_constant

ITERATIVE, OVERLAPPED = "fp_sincos", "fp_sincos_overlapped"
LATENCY = {unit: package_constant(f"{unit.upper()}_LATENCY") for unit in (ITERATIVE, OVERLAPPED)}
INTERVAL = {
    ITERATIVE: LATENCY[ITERATIVE],
    OVERLAPPED: load_machine("fast").units["sincos"].interval,
}
BOUND_ULP = 0.5 + 2.0**-5
CASES = 100_000
FILES = {"stimulus": ".in", "response": ".out"}
BENCH = "sim/rtl/sincos_stream.sv"
INEXACT, UNDERFLOW_INEXACT, INVALID = 0b00001, 0b00011, 0b10000
CANON_NAN, ONE, SIGN = 0x7FC00000, 0x3F800000, 0x80000000
LIMIT = 0x43800000  # 256
PRECISION = 200  # bits: 24 of the result after up to 29 cancelled ones, with room


@functools.cache
def executable(unit: str) -> Program:
    """The Verilated stream bench of a unit, built once per session."""
    units = [*dict.fromkeys([*sources_of(ITERATIVE), *sources_of(OVERLAPPED)])]
    overlapped = f"-GOverlapped={int(unit == OVERLAPPED)}"
    sources = [*units, *assertions_of(units), ROOT / BENCH]
    return Program("sincos_stream", sources, ROOT / "build/sim" / unit, overlapped)


def stream(
    unit: str, cosine: np.ndarray, operands: np.ndarray, idle: np.ndarray | int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """(result bits, flags) of every operand; asserts latency and interval of each.

    `cosine`, `operands` and `idle`, the clocks without an operand before each, are of one length.
    """
    program = executable(unit)
    stem = program.folder / "stream"
    words = operands.astype(np.uint64) | cosine.astype(np.uint64) << np.uint64(32)
    clocks = np.broadcast_to(idle, words.shape)
    rows = zip(words.tolist(), clocks.tolist(), strict=True)
    stem.with_suffix(".in").write_text("".join(f"{word:09x} {wait}\n" for word, wait in rows))
    files = [f"+{name}={plain(stem.with_suffix(end))}" for name, end in FILES.items()]
    done = program.run(*files, seed=SEED)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = stem.with_suffix(".out").read_text().split()
    latency, interval, flags, bits = (
        np.array([int(word, 16) for word in lines[i::4]]) for i in range(4)
    )
    assert len(bits) == len(operands)
    assert set(latency.tolist()) == {LATENCY[unit]}
    assert set(interval.tolist()) == {INTERVAL[unit]}
    return bits.astype(np.uint32), flags.astype(np.uint8)


def run(cosine: bool, operands: np.ndarray, gaps: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """(result bits, flags) of fp_sincos for every operand."""
    idle = generator("gaps").integers(0, 4, len(operands)) if gaps else 0
    return stream(ITERATIVE, np.full(len(operands), cosine), operands, idle)


def value(bits: int) -> float:
    return float(np.uint32(bits).view(np.float32))


def error_ulp(cosine: bool, operand: int, result: int) -> float:
    """Distance of a finite non-zero result from the exact value."""
    with gmpy2.context(precision=PRECISION):
        exact = (gmpy2.cos if cosine else gmpy2.sin)(gmpy2.mpfr(value(operand)))
        exponent = max(gmpy2.get_exp(exact) - 24, -149)  # get_exp: exact = 0.1.. * 2^exponent
        return float(abs(gmpy2.mpfr(value(result)) - exact) / gmpy2.exp2(exponent))


def expected_flags(cosine: bool, operand: int) -> int:
    magnitude = operand & ~SIGN
    if magnitude == 0:
        return 0
    return UNDERFLOW_INEXACT if magnitude < 0x00800000 and not cosine else INEXACT


def check(cosine: bool, operands: np.ndarray, gaps: bool = False) -> float:
    """Compare operands in range with MPFR; returns the largest error in ulp."""
    name = "cos" if cosine else "sin"
    if os.environ.get("CASE", "").startswith(name + " "):
        operands = np.array([int(os.environ["CASE"].split()[1], 16)], dtype=np.uint32)
    results, flags = run(cosine, operands, gaps)
    worst, failures = (0.0, 0), []
    rows = zip(operands.tolist(), results.tolist(), flags.tolist(), strict=True)
    for operand, result, flag in rows:
        error = error_ulp(cosine, operand, result) if operand & ~SIGN else 0.0
        worst = max(worst, (error, operand))
        if not error <= BOUND_ULP or flag != expected_flags(cosine, operand):
            failures.append(f"{name} {operand:08x}  {result:08x} flags {flag:05b} {error:.4f} ulp")
    sys.stdout.write(f"{name}: {worst[0]:.4f} ulp at {worst[1]:08x}, {len(operands)} operands\n")
    assert not failures, (
        f"{len(failures)} of {len(operands)} wrong (SEED={SEED}), bound {BOUND_ULP} ulp\n"
        + "\n".join(failures[:8])
        + f'\nreplay: CASE="{" ".join(failures[0].split()[:2])}" .venv/bin/python -m pytest '
        "tests/fpu/test_fp_sincos.py -k random"
    )
    return worst[0]


def random_angles(rng: np.random.Generator, count: int) -> np.ndarray:
    """Half uniform in [-256, 256], half of uniform exponent from 2^-16 to 2^7."""
    uniform = rng.uniform(-256, 256, count // 2).astype(np.float32).view(np.uint32)
    scaled = stimulus.with_exponents(rng, rng.integers(111, 135, count - count // 2))
    return np.concatenate((uniform, scaled))


def near_multiples() -> np.ndarray:
    """The binary32 numbers next to every multiple of pi/4 in range, both signs.

    Among the multiples of pi/2 is 437ce5f1, the closest of all numbers in range (2^-28.48 quarter
    turns away); those of pi/4 change the quadrant.
    """
    with gmpy2.context(precision=PRECISION):
        quarter = gmpy2.const_pi() / 4
        nearest = np.array([float(quarter * k) for k in range(1, 326)]).astype(np.float32)
    bits = nearest[nearest < 255.9].view(np.uint32)
    around = (bits[:, None] + np.arange(-2, 3)).ravel().astype(np.uint32)
    return np.concatenate((around, around | np.uint32(SIGN)))


def edges() -> np.ndarray:
    """Zeros, subnormals, powers of two and the ends of the range, with neighbours, both signs."""
    powers = np.arange(0, 136, dtype=np.int64) << 23
    subnormal = np.array([1, 2, 3, 0x3FFFFF, 0x400000, 0x555555, 0x7FFFFF])
    bits = np.concatenate(((powers[:, None] + np.arange(-2, 3)).ravel(), subnormal))
    bits = bits[(bits >= 0) & (bits <= LIMIT)]
    segments = (np.arange(1, 33) / 64 * math.pi / 2).astype(np.float32).view(np.uint32)
    bits = np.concatenate((bits, (segments[:, None] + np.arange(-2, 3)).ravel(), [LIMIT]))
    return np.concatenate((bits, bits | SIGN)).astype(np.uint32)


FUNCTIONS = pytest.mark.parametrize("cosine", [False, True], ids=["sin", "cos"])


@pytest.mark.quick("sin")
@FUNCTIONS
def test_sincos__random_angles__within_bound(cosine: bool) -> None:
    check(cosine, random_angles(generator(f"sincos {cosine}"), CASES))


@FUNCTIONS
def test_sincos__next_to_multiples_of_eighth_turns__within_bound(cosine: bool) -> None:
    operands = near_multiples()
    assert 0x437CE5F1 in operands
    check(cosine, operands)


@FUNCTIONS
def test_sincos__edges_of_range_segments_and_binades__within_bound(cosine: bool) -> None:
    check(cosine, edges(), gaps=True)


@FUNCTIONS
def test_sincos__zeros__exact_without_flags(cosine: bool) -> None:
    bits, flags = run(cosine, np.array([0, SIGN], dtype=np.uint32))
    assert bits.tolist() == ([ONE, ONE] if cosine else [0, SIGN])
    assert not flags.any()


@FUNCTIONS
def test_sincos__outside_range_and_nan__canonical_nan(cosine: bool) -> None:
    invalid = [LIMIT + 1, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0x7FBFFFFF, 0x44000000]
    quiet = [0x7FC00000, 0x7FFFFFFF]
    operands = np.array(invalid + quiet, dtype=np.uint32)
    operands = np.concatenate((operands, operands | np.uint32(SIGN)))
    bits, flags = run(cosine, operands)
    assert set(bits.tolist()) == {CANON_NAN}
    assert flags.tolist() == 2 * (len(invalid) * [INVALID] + len(quiet) * [0])


def test_sincos__negated_angle__sine_odd_and_cosine_even() -> None:
    operands = random_angles(generator("symmetry"), 4000)
    mirrored = operands ^ np.uint32(SIGN)
    sine, cosine = run(False, operands)[0], run(True, operands)[0]
    assert np.array_equal(run(False, mirrored)[0], sine ^ np.uint32(SIGN))
    assert np.array_equal(run(True, mirrored)[0], cosine)


def test_sincos__committed_table__is_what_the_script_generates() -> None:
    output(sys.executable, ROOT / "scripts/sincos_coefficients.py", "--check")
