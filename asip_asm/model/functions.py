# SPDX-License-Identifier: Apache-2.0
"""Functions that the core has no unit for, and which the compiler approximates by a polynomial:
exact values, derivatives and stated errors, for the bound of a program and for tests.

The programs are in `expand`; what is made of these functions is stated in `combinations`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
TURN = 2 * math.pi
LARGEST_TURNS = 256 / TURN
"""As far as the sine unit goes."""


@dataclass(frozen=True)
class Function:
    """An approximated function: exact value and partial derivatives in double precision, largest
    error in units of 2^-23 of the result plus `absolute`, and the domain (low, high) where they
    hold. outside: what the program gives beyond, for users; own: what depends on the arguments in
    another way, to be added; unchanged: up to this size the result is the argument itself, and the
    function differs from its argument x by at most x^2.
    """

    exact: Callable[..., Real]
    partials: Callable[..., tuple[Real, ...]]
    ulp: float
    absolute: float
    domain: tuple[float, float]
    outside: str = ""
    own: Callable[..., Real] | None = None
    unchanged: float = 0.0


def _erf(x: Real) -> Real:
    return np.vectorize(math.erf, otypes=[float])(x)


EVERYWHERE = (-3e38, 3e38)
NEAR_ZERO = 2.0**-26
"""Up to here x + x^2 rounds to x."""

FUNCTIONS: dict[str, Function] = {
    "exp": Function(
        np.exp, lambda x: (np.exp(x),), 1.3, 3e-38, (-86.5, 88.3),
        "2.5e-38 below, 3.0e38 above",
    ),
    "expm1": Function(
        np.expm1, lambda x: (np.exp(x),), 1.8, 1e-44, (-86.5, 88.3), "-1 below, 3.0e38 above",
        unchanged=NEAR_ZERO,
    ),
    "log": Function(
        np.log, lambda x: (1 / x,), 1.3, 1e-44, (2.0**-126, 1.2e38),
        "-3e38 at 0, NaN below 0, a wrong number for subnormal x and above",
    ),
    "log1p": Function(
        np.log1p, lambda x: (1 / (1 + x),), 2.5, 1e-44, (-0.9999999, 1.2e38),
        "NaN at -1 and below, a wrong number above", unchanged=NEAR_ZERO,
    ),
    "atan": Function(
        np.arctan, lambda x: (1 / (1 + x * x),), 1.6, 1e-44, EVERYWHERE, "pi/2 with the sign of x",
        unchanged=NEAR_ZERO,
    ),
    "asin": Function(
        np.arcsin, lambda x: (1 / np.sqrt(np.maximum(1 - x * x, 1e-30)),), 2.2, 1e-44,
        (-1.0, 1.0), "NaN", unchanged=NEAR_ZERO,
    ),
    "acos": Function(
        np.arccos, lambda x: (-1 / np.sqrt(np.maximum(1 - x * x, 1e-30)),), 2.2, 1e-44,
        (-1.0, 1.0), "NaN",
    ),
    "tanh": Function(
        np.tanh, lambda x: (1 - np.tanh(x) ** 2,), 2.8, 1e-44, EVERYWHERE, "1 with the sign of x"
    ),
    "erf": Function(
        _erf, lambda x: (2 / math.sqrt(math.pi) * np.exp(-x * x),), 1.8, 1e-44, EVERYWHERE,
        "1 with the sign of x",
    ),
}  # fmt: skip
"""By name in CasADi; they are the user's too."""

HALVES: dict[str, Function] = {
    "half_exp": Function(
        lambda x: np.exp(x) / 2, lambda x: (np.exp(x) / 2,), 1.3, 1e-44, (0.0, 89.4)
    ),
    "half_expm1": Function(
        lambda x: np.expm1(x) / 2, lambda x: (np.exp(x) / 2,), 1.8, 1e-44, (0.0, 89.4)
    ),
}
"""Of sizes, for hyperbolic functions that are finite where the exponential is not."""


BELOW: dict[str, Function] = {
    "expm1_below": Function(
        lambda x: np.expm1(np.minimum(x, 0)),
        lambda x: (np.where(x <= 0, np.exp(np.minimum(x, 0)), 0.0),),
        0.9, 1e-44, EVERYWHERE, unchanged=NEAR_ZERO,
    ),
}  # fmt: skip
"""The part of a function that is not constant, as exponential linear units take it."""


def _turns(x: Real, scale: Real, offset: Real | float = 0.0) -> Real:
    return TURN * (x * scale + offset)


def _slopes(cosine: bool) -> Callable[..., tuple[Real, ...]]:
    def partials(*angle: Real) -> tuple[Real, ...]:
        slope = TURN * (-np.sin(_turns(*angle)) if cosine else np.cos(_turns(*angle)))
        return (slope * angle[1], slope * angle[0], slope)[: len(angle)]

    return partials


def _angle_lost(*angle: Real) -> Real:
    """Rounding of the angle in turns, as radians: none of a multiple by a power of two."""
    exact = len(angle) == 2 and np.all(np.abs(np.frexp(angle[1])[0]) == 0.5)
    return (0.0 if exact else 2.0**-24 * (1 + 1e-6)) * np.abs(_turns(*angle))


TURNS: dict[str, Function] = {
    f"{name}_turns": Function(
        lambda *angle, exact=exact: exact(_turns(*angle)),
        _slopes(name == "cos"),
        1.4,
        1e-13,
        (-LARGEST_TURNS, LARGEST_TURNS),
        own=_angle_lost,
    )
    for name, exact in (("sin", np.sin), ("cos", np.cos))
}
"""Sine and cosine of 2 pi (scale x + offset) on the multiply-add pipes, see `sine`; arguments x,
scale and, if it is not 0, offset; the domain is that of the angle in turns.
"""
MARKED = FUNCTIONS | HALVES | BELOW | TURNS
