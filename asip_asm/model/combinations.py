# SPDX-License-Identifier: Apache-2.0
"""Functions that are made of others: exact values, stated errors, domains and what happens outside.

The programs are in `expand`. The bound of a program follows from the parts; what is here is for
users (docs/function_errors.md is written from it) and for tests. A zero counts as positive,
whatever its sign, and the sign of a zero result is not stated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Inside = NDArray[np.bool_]
LARGEST_QUOTIENT = 2.0**22
LARGEST_ANGLE = 256.0
"""As far as the sine unit goes, rad."""
PURE_POWER = 64


@dataclass(frozen=True)
class Combination:
    """A function made of others: exact value in double precision, largest error in units of 2^-23
    of the result plus `absolute`, domain (low, high) of each argument and, with `inside`, a further
    condition; in words what the domain is and what the program gives outside of it.

    growth: more units, by the arguments, which `growth_text` says in words.
    """

    exact: Callable[..., Real]
    ulp: float
    absolute: float
    domain: tuple[tuple[float, float], ...]
    domain_text: str
    outside: str
    inside: Callable[..., Inside] | None = None
    growth: Callable[..., Real] | None = None
    growth_text: str = ""

    def holds(self, *arguments: Real) -> Inside:
        """Where arguments, arrays (N,), are in the domain."""
        found = np.ones(np.shape(arguments[0]), bool)
        for value, (low, high) in zip(arguments, self.domain, strict=True):
            found &= (value >= low) & (value <= high)
        return found & self.inside(*arguments) if self.inside else found


def ieee_remainder(x: Real, y: Real) -> Real:
    """x - n y with n the whole number nearest to x / y, of two the even one; exact in double
    precision for binary32 arguments.
    """
    step = np.abs(y)
    rest = np.fmod(np.abs(x), 2 * step)
    rest = np.where(
        rest > step / 2, np.where(rest < 1.5 * step, rest - step, rest - 2 * step), rest
    )
    return np.where(np.signbit(x), -rest, rest)


def _small_quotient(x: Real, y: Real) -> Inside:
    return (y != 0) & (np.abs(x) < LARGEST_QUOTIENT * np.abs(y))


def _finite_power(x: Real, y: Real) -> Inside:
    logarithm = y * np.log(x)
    return (logarithm >= -86.4) & (logarithm <= 88.2)


def _pure_power(x: Real, n: Real) -> Inside:
    size = np.abs(x) ** n
    between = np.abs(x) ** np.abs(n)
    normal = (size >= 2.0**-126) & (size <= 3e38) & (between >= 2.0**-126) & (between <= 3e38)
    return (2 * n == np.floor(2 * n)) & ((x > 0) | (n == np.floor(n)) & (x != 0)) & normal


def _symmetric(limit: float) -> tuple[float, float]:
    return -limit, limit


ALL = _symmetric(3.4028234e38)
WHOLE = _symmetric(2.0**31)
BELOW_ONE = _symmetric(1 - 2.0**-24)

COMBINATIONS: dict[str, Combination] = {
    "tan": Combination(
        np.tan, 1.8, 0.0, (_symmetric(LARGEST_ANGLE),), "up to 256 rad in size",
        "NaN",
    ),
    "sinh": Combination(
        np.sinh, 2.0, 1e-44, (_symmetric(89.4),), "up to 89.4 in size",
        "3.4e38 with the sign of x",
    ),
    "cosh": Combination(
        np.cosh, 1.3, 0.0, (_symmetric(89.4),), "up to 89.4 in size", "3.4e38",
    ),
    "asinh": Combination(
        np.arcsinh, 3.0, 1e-44, (_symmetric(6e37),), "up to 6e37 in size", "a wrong number or NaN",
    ),
    "acosh": Combination(
        np.arccosh, 3.0, 0.0, ((1.0, 6e37),), "1 to 6e37", "NaN below, a wrong number or NaN above",
    ),
    "atanh": Combination(
        np.arctanh, 3.0, 1e-44, (BELOW_ONE,), "below 1 in size", "NaN",
    ),
    "atan2": Combination(
        lambda y, x: np.arctan2(y + 0.0, x + 0.0), 2.2, 1e-44, (ALL, ALL),
        "all finite numbers; 0 for two zeros",
        "NaN for two infinities",
    ),
    "hypot": Combination(
        np.hypot, 1.1, 4e-23, (_symmetric(1e19), _symmetric(1e19)), "both up to 1e19 in size",
        "infinity where a square is",
    ),
    "fmod": Combination(
        np.fmod, 0.0, 0.0, (ALL, ALL), "a quotient x/y below 2^22 in size, y not 0",
        "a wrong rest; x where y is 0", inside=_small_quotient,
    ),
    "remainder": Combination(
        ieee_remainder, 0.0, 0.0, (ALL, ALL),
        "a quotient x/y below 2^22 in size, y not 0; a half goes to the even quotient",
        "a wrong rest; x where y is 0", inside=_small_quotient,
    ),
    "floor": Combination(
        np.floor, 0.0, 0.0, (WHOLE,), "up to 2^31 in size", "2^31 with the sign of x",
    ),
    "ceil": Combination(
        np.ceil, 0.0, 0.0, (WHOLE,), "up to 2^31 in size", "2^31 with the sign of x",
    ),
    "pow": Combination(
        np.power, 1.4, 3e-38, ((2.0**-126, 1.2e38), ALL),
        "x a normal number up to 1.2e38, a result of 3e-38 to 2e38",
        "1 for 0^0, 2.5e-38 for 0^y with y above 0, NaN for x below 0, "
        "2.5e-38 or 3.0e38 where the result is smaller or larger",
        inside=_finite_power,
        growth=lambda x, y: 1.9 * np.abs(y * np.log(x)),
        growth_text="1.9 times |ln of the result|",
    ),
    "pow, constant y": Combination(
        np.power, 1.0, 0.0, (ALL, _symmetric(PURE_POWER)),
        "y a multiple of 1/2 up to 64 in size, x not negative unless y is whole, "
        "x^|y| a normal number",
        "0 or infinity where x^|y| leaves binary32, NaN for a root of x below 0",
        inside=_pure_power,
        growth=lambda x, n: 0.5 * np.abs(n),
        growth_text="half of |y|",
    ),
}  # fmt: skip
"""By name in CasADi; `pow` is the ** of Python too."""
