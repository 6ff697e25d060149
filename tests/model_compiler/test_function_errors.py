# SPDX-License-Identifier: Apache-2.0
"""Functions without a unit keep their stated errors: directed points, binades float by float."""

from __future__ import annotations

import functools
import math

import casadi as ca
import gmpy2
import numpy as np
import pytest

from asip_asm.model import expand
from asip_asm.model.bound import SINE_ULP
from asip_asm.model.combinations import COMBINATIONS, Combination
from asip_asm.model.compiler import Compiled, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.functions import FUNCTIONS, HALVES
from asip_asm.model.law import Law, Port

STATED = {
    name: Combination(f.exact, f.ulp, f.absolute, (f.domain,), "", f.outside)
    for name, f in FUNCTIONS.items()
} | COMBINATIONS
ONE = [name for name, made in STATED.items() if len(made.domain) == 1]
TWO = [name for name in STATED if name not in ONE]
DRAWN = [name for name in TWO if name != "pow, constant y"]
PIECES = {
    "exp": [(0.5, 1.0)], "expm1": [(0.25, 0.5), (0.5, 1.0)], "log": [(1.0, 2.0)],
    "log1p": [(0.5, 1.0)], "atan": [(0.25, 0.5), (1.0, 2.0), (4.0, 8.0)],
    "asin": [(0.25, 0.5), (0.5, 1.0)], "acos": [(0.25, 0.5), (0.5, 1.0), (-1.0, -0.5)],
    "erf": [(0.5, 1.0), (1.0, 2.0)], "tan": [(1.0, 2.0)], "sinh": [(0.25, 0.5), (16.0, 32.0)],
    "cosh": [(1.0, 2.0)], "tanh": [(0.125, 0.25), (0.25, 0.5)], "asinh": [(1.0, 2.0)],
    "acosh": [(1.0, 2.0)], "atanh": [(0.5, 1.0)], "floor": [(1024.0, 2048.0), (-2.0, -1.0)],
    "ceil": [(1024.0, 2048.0), (-2.0, -1.0)], "atan2": [(0.5, 1.0)], "hypot": [(0.5, 1.0)],
    "fmod": [(1024.0, 2048.0)], "remainder": [(1024.0, 2048.0)], "pow": [(1.0, 2.0)],
}  # fmt: skip
"""A binade of each branch that is tried float by float; of two arguments the first one."""
PARTNERS = {
    "atan2": (0.1, 10.0), "hypot": (0.1, 10.0), "fmod": (0.01, 3000.0),
    "remainder": (0.01, 3000.0), "pow": (1e-3, 80.0),
}  # fmt: skip
"""Sizes of the second argument next to a binade of the first."""
CHUNK = 1 << 15
LARGEST = float(np.finfo(np.float32).max)
SMALL = (0.0, 2.0**-149, 1e-44, 1e-40, 2.0**-126, 1e-30, 2.0**-24, 2.0**-12)
PLAIN = (0.1, 0.125, 0.25, 0.35, 0.5, 0.7, 1.0, 1.05, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 20.0, 88.0,
         1e4, 2.0**22, 2.0**23 + 1, 2.0**24, 1e9, 1e18, 1e19, 1e20, 1e30, 1e38,
         LARGEST)  # fmt: skip
HALF_LOGARITHMS = [(k + 0.5) * math.log(2) for k in range(-124, 127)]
POWERS_OF_2 = [1.5 * 2.0**k for k in range(-60, 60)]
BRANCHES = {
    "exp": HALF_LOGARITHMS, "expm1": HALF_LOGARITHMS, "log": POWERS_OF_2,
    "log1p": [x - 1 for x in POWERS_OF_2 if x > 0.1],
    "atan": [expand.ATAN_MIDDLE, expand.ATAN_FAR], "asin": [0.5], "acos": [0.5],
    "erf": [1.0, 4.0], "tan": [k * math.pi / 2 for k in range(1, 163)], "sinh": [0.5],
    "tanh": [0.25, expand.TANH_FAR], "asinh": [expand.LARGE],
    "cosh": [(k + 0.5) * math.log(2) for k in range(129)],
}  # fmt: skip
"""Where the program of a function changes its reduction or polynomial."""
WHOLE = {name: [k / 2 for k in range(-64, 65)] for name in ("floor", "ceil")}
NEIGHBOURS = 200
POWERS = [k / 2 for k in range(-128, 129)]
Floats = np.ndarray


@functools.cache
def compiled(name: str, power: float | None = None) -> Compiled:
    """The function alone as a program; power: a constant second argument."""
    symbols = [ca.SX.sym("x"), ca.SX.sym("y")][: 1 if name in ONE or power is not None else 2]
    x, y = symbols[0], power if power is not None else symbols[-1]
    made = x**y if name.startswith("pow") else getattr(ca, name)(*symbols)
    names = ["x", "y"][: len(symbols)]
    ports = [Port("input", n, limits=(-1.0, 1.0)) for n in names] + [Port("output", "r")]
    return compile_law(Law("f", ca.Function("f", symbols, [made], names, ["r"]), ports))


def sine_at_its_worst(sign: int):
    """Sine too large and cosine too small by what the unit may be wrong, or with -1 the reverse."""

    def sine(angle: Floats, cosine: bool) -> Floats:
        exact = (np.cos if cosine else np.sin)(angle.astype(np.float64))
        near = exact.astype(np.float32)
        away = np.where(exact >= 0, np.inf, -np.inf) * (-sign if cosine else sign)
        other = np.nextafter(near, away.astype(np.float32))
        unit = np.spacing(np.minimum(np.abs(near), np.abs(other))).astype(np.float64)
        wrong = np.abs(other - exact) <= SINE_ULP * unit
        return np.where(wrong & (angle != 0), other, near)

    return sine


def program(name: str, *arguments: Floats, power: float | None = None, sign: int = 1) -> Floats:
    graph = compiled(name, power).graph
    values = dict(zip("xy", arguments, strict=False))
    return evaluate(graph, values, sine_at_its_worst(sign))[graph.outputs["r"]]


def excess(name: str, *arguments: Floats, power: float | None = None, sign: int = 1) -> Floats:
    """Error as a part of the stated one; infinite where either is not a number."""
    got = program(name, *arguments, power=power, sign=sign).astype(np.float64)
    made = STATED[name]
    wide = [a.astype(np.float64) for a in arguments]
    if power is not None:
        wide.append(np.full_like(wide[0], power))
    with np.errstate(all="ignore"):
        want = made.exact(*wide)
        units = made.ulp + (made.growth(*wide) if made.growth else 0.0)
        allowed = units * 2.0**-23 * np.abs(want) + made.absolute
        gap = np.abs(got - want)
        part = np.where(gap == 0, 0.0, gap / np.where(allowed == 0, 1e-300, allowed))
    return np.where(np.isnan(part), np.inf, part)


def check(name: str, *arguments: Floats, power: float | None = None) -> float:
    """Largest part of the stated error, at arguments inside the domain; it must be below 1."""
    worst = 0.0
    for begin in range(0, len(arguments[0]), CHUNK):
        some = [a[begin : begin + CHUNK] for a in arguments]
        with np.errstate(all="ignore"):
            wide = [a.astype(np.float64) for a in some]
            more = [np.full_like(wide[0], power)] if power is not None else []
            inside = STATED[name].holds(*wide, *more)
        some = [a[inside] for a in some]
        if not inside.any():
            continue
        for sign in (1, -1) if name == "tan" else (1,):
            part = excess(name, *some, power=power, sign=sign)
            i = int(part.argmax())
            assert part[i] <= 1, (name, power, [float(a[i]) for a in some], float(part[i]))
            worst = max(worst, float(part[i]))
    return worst


STEP = 13  # odd: all of the last bits come


def binade(low: float, high: float, step: int = 1) -> Floats:
    """Floats from low to high, of one sign."""
    ends = sorted(int(np.float32(abs(x)).view(np.uint32)) for x in (low, high))
    size = np.arange(*ends, step, dtype=np.uint32).view(np.float32)
    return size if high > 0 else -size


def neighbours(points: list[float]) -> Floats:
    """Points of both signs with the floats next to them."""
    bits = np.abs(np.array(points, np.float32)).view(np.int32)[:, None].astype(np.int64)
    near = bits + np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    size = near[(near >= 0) & (near < 0x7F800000)].astype(np.uint32).view(np.float32)
    return np.concatenate((size, -size))


def log_uniform(rng: np.random.Generator, low: float, high: float, count: int) -> Floats:
    size = np.exp(rng.uniform(math.log(low), math.log(high), count))
    return (size * rng.choice([-1, 1], count)).astype(np.float32)


@pytest.mark.parametrize("name", ONE)
def test_directed_points_keep_the_stated_error(name):
    ends = [end for end in STATED[name].domain[0] if abs(end) <= LARGEST]
    check(name, neighbours([*SMALL, *PLAIN, *BRANCHES.get(name, []), *WHOLE.get(name, []), *ends]))


@pytest.mark.parametrize("name", TWO)
def test_directed_pairs_keep_the_stated_error(name):
    size = np.array([*SMALL, *PLAIN], np.float32)
    points = np.concatenate((size, -size))
    if name not in DRAWN:
        for power in POWERS:
            check(name, np.concatenate((points, binade(0.5, 2.0, 10007))), power=power)
        return
    x, y = (a.ravel() for a in np.meshgrid(points, points))
    check(name, x, y)
    multiples = (np.arange(1, 400)[:, None] * np.abs(points).astype(np.float64) / 2).ravel()
    with np.errstate(over="ignore"):
        near = multiples.astype(np.float32)
        below, above = (np.nextafter(near, np.float32(end)) for end in (0, np.inf))
    steps = np.tile(np.abs(points), 399)
    for other in (near, below, above):
        check(name, other, steps)
        check(name, -other, steps)


@pytest.mark.parametrize("step", [STEP, pytest.param(1, marks=pytest.mark.full)])
@pytest.mark.parametrize(
    ("name", "low", "high"), [(name, *piece) for name, found in PIECES.items() for piece in found]
)
def test_floats_of_a_binade_keep_the_stated_error(name, low, high, step):
    """One of STEP floats, and in the full set every one."""
    x = binade(low, high, step)
    if name in ONE:
        worst = check(name, x)
    else:
        partner = log_uniform(np.random.default_rng(7), *PARTNERS[name], len(x))
        worst = check(name, x, partner)
    exact = STATED[name].ulp == 0
    assert exact or worst > 0.2, f"{name}: the statement is far from the error, {worst:.3f} of it"


@pytest.mark.full
@pytest.mark.parametrize("name", ONE)
def test_every_float_of_the_domain_keeps_the_stated_error(name):
    for exponent in range(255):
        size = np.arange(exponent << 23, (exponent + 1) << 23, dtype=np.uint32).view(np.float32)
        check(name, size)
        check(name, -size)


@pytest.mark.full
@pytest.mark.parametrize("name", DRAWN)
def test_many_pairs_of_the_domain_keep_the_stated_error(name):
    rng = np.random.default_rng(11)
    for _ in range(64):
        x = log_uniform(rng, 2.0**-140, 2.0**127, 1 << 18)
        low, high = PARTNERS[name]
        check(name, x, log_uniform(rng, 2.0**-140, 2.0**127, 1 << 18))
        check(name, x, log_uniform(rng, low, high, 1 << 18))
        ratio = log_uniform(rng, 2.0**-21.9, 2.0**10, 1 << 18).astype(np.float64)
        check(name, x, np.clip(x * ratio, -LARGEST, LARGEST).astype(np.float32))


@pytest.mark.parametrize(("name", "part"), [("cosh", "half_exp"), ("sinh", "half_expm1")])
def test_halves_keep_the_error_that_the_bound_takes(name, part):
    """The parts of the hyperbolic functions, which `bound` counts by themselves."""
    graph = compiled(name).graph
    node = next(i for i, (mark, _) in graph.functions.items() if mark == part)
    x = np.concatenate((neighbours([0.0, 0.5, 89.4]), binade(2.0**-149, 89.4, 4001)))
    x = np.abs(x[np.abs(x) <= 89.4])
    got = evaluate(graph, {"x": x}, sine_at_its_worst(1))[node].astype(np.float64)
    stated = HALVES[part]
    want = stated.exact(x.astype(np.float64))
    assert np.all(np.abs(got - want) <= stated.ulp * 2.0**-23 * want + stated.absolute)


INF, NAN = math.inf, math.nan
OUTSIDE = [
    ("exp", (-200.0,), 2.5e-38), ("exp", (LARGEST,), 3.0e38), ("expm1", (-LARGEST,), -1.0),
    ("expm1", (100.0,), 3.0e38), ("log", (0.0,), -3e38), ("log", (-1e-45,), NAN),
    ("log1p", (-1.0,), NAN), ("log1p", (-7.0,), NAN), ("atan", (-INF,), -math.pi / 2),
    ("asin", (1.0000001,), NAN), ("acos", (-2.0,), NAN), ("erf", (-INF,), -1.0),
    ("sinh", (-90.0,), -3.4e38), ("sinh", (INF,), 3.4e38), ("cosh", (-INF,), 3.4e38),
    ("tanh", (-INF,), -1.0), ("acosh", (0.999,), NAN), ("acosh", (-1e30,), NAN),
    ("atanh", (1.0,), NAN), ("atanh", (-1.0,), NAN), ("atanh", (-LARGEST,), NAN),
    ("atan2", (INF, INF), NAN), ("hypot", (3e19, 0.0), INF), ("fmod", (3.0, 0.0), 3.0),
    ("remainder", (-3.0, 0.0), -3.0), ("floor", (1e10,), 2.0**31), ("ceil", (-INF,), -(2.0**31)),
    ("pow", (0.0, 0.0), 1.0), ("pow", (0.0, 2.0), 2.5e-38), ("pow", (-1.0, 2.0), NAN),
    ("pow", (2.0, 200.0), 3.0e38), ("pow", (0.5, 200.0), 2.5e-38),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments", "want"), OUTSIDE)
def test_outside_of_the_domain_happens_what_is_stated(name, arguments, want):
    with np.errstate(all="ignore"):
        assert not STATED[name].holds(*(np.array([a]) for a in arguments))[0]
    got = float(program(name, *(np.array([a], np.float32) for a in arguments))[0])
    assert got == pytest.approx(want, rel=0.03, nan_ok=True)


@pytest.mark.parametrize("power", [0.5, 1.5, -2.5])
def test_a_root_of_a_negative_number_is_no_number(power):
    assert np.isnan(program("pow, constant y", np.array([-2.0], np.float32), power=power)[0])


@pytest.mark.parametrize(
    ("y", "x", "want"),
    [(0.0, 0.0, 0.0), (-0.0, -0.0, 0.0), (0.0, -1.0, math.pi), (-0.0, -1.0, math.pi),
     (-1e-40, 1e-40, -math.pi / 4)],
)  # fmt: skip
def test_arctangent_of_two_takes_a_zero_as_positive(y, x, want):
    got = program("atan2", np.array([y], np.float32), np.array([x], np.float32))[0]
    assert float(got) == pytest.approx(want, rel=1e-6)


@pytest.mark.parametrize("name", COMBINATIONS)
def test_reference_in_double_precision_is_that_of_mpfr(name):
    mpfr = {"pow": lambda x, y: x**y, "pow, constant y": lambda x, y: x**y,
            "remainder": gmpy2.remainder}  # fmt: skip
    function = mpfr.get(name) or getattr(gmpy2, name)
    points = np.array([*PLAIN, -0.3, -2.5, -1e3, 0.01, 77.7], np.float32).astype(np.float64)
    pairs = [points] if name in ONE else [a.ravel() for a in np.meshgrid(points, points)]
    with np.errstate(all="ignore"):
        pairs = [a[STATED[name].holds(*pairs)] for a in pairs]
    assert len(pairs[0]) > 5
    with gmpy2.context(gmpy2.get_context(), precision=200):
        for arguments in zip(*pairs, strict=True):
            want = float(function(*(gmpy2.mpfr(float(a)) for a in arguments)))
            got = STATED[name].exact(*(np.array([a]) for a in arguments))[0]
            assert got == pytest.approx(want, rel=1e-13, abs=0)


def test_zero_divided_has_the_remainder_zero():
    for name in ("fmod", "remainder"):
        got = program(name, np.array([-0.0, 0.0, 4.0], np.float32), np.array([2.0] * 3, np.float32))
        assert np.all(got == 0)
