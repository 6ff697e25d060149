# SPDX-License-Identifier: Apache-2.0
"""Functions without a unit: errors over their domains against MPFR, and as programs on the core."""

from __future__ import annotations

import casadi as ca
import gmpy2
import numpy as np
import pytest

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.exact import evaluate
from asip_asm.model.functions import FUNCTIONS
from asip_asm.model.law import Law, Port
from sim.laws.prove_program import rounded_sine
from tests.model_compiler.proof import proved

NEAR_ONE = (-1.0, 1.0)
DOMAINS = {
    "tan": (-1.5, 1.5), "sinh": (-20.0, 20.0), "cosh": (-20.0, 20.0), "tanh": (-30.0, 30.0),
    "asinh": (-1e4, 1e4), "acosh": (1.001, 1e4), "atanh": (-0.99, 0.99), "floor": (-1e6, 1e6),
    "ceil": (-1e6, 1e6), "exp": (-20.0, 20.0), "expm1": (-20.0, 20.0), "log": (1e-6, 1e6),
    "log1p": (-0.9, 1e4), "atan": (-1e3, 1e3), "asin": NEAR_ONE, "acos": NEAR_ONE,
    "erf": (-5.0, 5.0),
}  # fmt: skip


def law_of(name: str, *domains: tuple[float, float]) -> Law:
    """The function alone, of an argument in each domain."""
    names = ["x", "y"][: len(domains)]
    symbols = [ca.SX.sym(n) for n in names]
    function = ca.Function("f", symbols, [getattr(ca, name)(*symbols)], names, ["r"])
    ports = [Port("input", n, limits=limits) for n, limits in zip(names, domains, strict=True)]
    return Law(name, function, [*ports, Port("output", "r")])


def floats(domain: tuple[float, float], step: int) -> np.ndarray:
    """Every `step`-th binary32 number of the domain, ends included."""
    bits = np.arange(0, 0x7F800000, step, dtype=np.int64).astype(np.uint32)
    positive = bits.view(np.float32)
    both = np.concatenate((positive, -positive, np.array(domain, np.float32)))
    return both[(both >= domain[0]) & (both <= domain[1])]


def errors(name: str, x: np.ndarray) -> np.ndarray:
    """Distance from MPFR in units of 2^-23 of the result, less the absolute part."""
    compiled = compile_law(law_of(name, FUNCTIONS[name].domain))
    got = evaluate(compiled.graph, {"x": x}, rounded_sine)[compiled.graph.outputs["r"]]
    want = FUNCTIONS[name].exact(x.astype(np.float64))
    gap = np.abs(got.astype(np.float64) - want) - FUNCTIONS[name].absolute
    return gap / (2.0**-23 * np.maximum(np.abs(want), 1e-300))


@pytest.mark.parametrize("name", [name for name, each in FUNCTIONS.items() if each.unchanged])
def test_argument_next_to_zero_is_the_result(name):
    limit = FUNCTIONS[name].unchanged
    x = floats((-limit, limit), 9973)
    compiled = compile_law(law_of(name, FUNCTIONS[name].domain))
    got = evaluate(compiled.graph, {"x": x}, rounded_sine)[compiled.graph.outputs["r"]]
    assert np.array_equal(got, x)
    exact = FUNCTIONS[name].exact(x.astype(float))
    assert (np.abs(exact - x) <= x.astype(float) ** 2).all()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_error_is_as_stated_over_the_domain(name):
    x = floats(FUNCTIONS[name].domain, 9973)
    found = errors(name, x)
    worst = int(found.argmax())
    assert 0.3 < found[worst] < FUNCTIONS[name].ulp, f"{name}({x[worst]!r}): {found[worst]}"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_reference_in_double_precision_is_that_of_mpfr(name):
    function = getattr(gmpy2, name)
    for x in floats(FUNCTIONS[name].domain, 50_000_017)[:60]:
        want = float(function(gmpy2.mpfr(float(x))))
        assert FUNCTIONS[name].exact(np.array([float(x)]))[0] == pytest.approx(want, rel=1e-14)


@pytest.mark.parametrize("name", DOMAINS)
def test_function_is_a_program_that_keeps_its_bound(tmp_path, name):
    proved(law_of(name, DOMAINS[name]), tmp_path, Options(reassociate=True), 150)


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("atan2", (-3.0, 3.0), (-3.0, 3.0)),
        ("fmod", (-50.0, 50.0), (0.7, 3.0)),
        ("remainder", (-50.0, 50.0), (0.7, 3.0)),
        ("hypot", (-4.0, 4.0), (-4.0, 4.0)),
        ("power", (0.1, 9.0), (-3.0, 3.0)),
        ("copysign", (0.5, 4.0), (-4.0, 4.0)),
    ],
)
def test_function_of_two_is_a_program_that_keeps_its_bound(tmp_path, name, first, second):
    proved(law_of(name, first, second), tmp_path, count=150)


def test_remainder_of_division_is_exact():
    compiled = compile_law(law_of("fmod", (-1e4, 1e4), (0.1, 9.0)))
    rng = np.random.default_rng(5)
    x = rng.uniform(-1e4, 1e4, 20000).astype(np.float32)
    y = rng.uniform(0.1, 9.0, 20000).astype(np.float32)
    got = evaluate(compiled.graph, {"x": x, "y": y}, rounded_sine)[compiled.graph.outputs["r"]]
    want = np.fmod(x.astype(np.float64), y.astype(np.float64)).astype(np.float32)
    assert np.array_equal(got, want)
