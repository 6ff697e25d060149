# SPDX-License-Identifier: Apache-2.0
"""Functions that the core has no unit for, and which the compiler approximates by a polynomial:
exact values, derivatives and stated errors, for the bound of a program and for tests.

The programs are in `expand`, where also the functions stand that are exact combinations of these.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Function:
    """An approximated function: exact value and partial derivatives in double precision, largest
    error in units of 2^-23 of the result plus `absolute`, and the domain (low, high) where they
    hold.
    """

    exact: Callable[..., Real]
    partials: Callable[..., tuple[Real, ...]]
    ulp: float
    absolute: float
    domain: tuple[float, float]


def _erf(x: Real) -> Real:
    return np.vectorize(math.erf, otypes=[float])(x)


FUNCTIONS: dict[str, Function] = {
    "exp": Function(np.exp, lambda x: (np.exp(x),), 1.3, 3e-38, (-86.5, 88.3)),
    "expm1": Function(np.expm1, lambda x: (np.exp(x),), 1.8, 1e-44, (-86.5, 88.3)),
    "log": Function(np.log, lambda x: (1 / x,), 1.3, 1e-44, (2.0**-126, 1.2e38)),
    "log1p": Function(np.log1p, lambda x: (1 / (1 + x),), 2.5, 1e-44, (-0.9999999, 1.2e38)),
    "atan": Function(np.arctan, lambda x: (1 / (1 + x * x),), 1.6, 1e-44, (-3e38, 3e38)),
    "asin": Function(
        np.arcsin, lambda x: (1 / np.sqrt(np.maximum(1 - x * x, 1e-30)),), 2.2, 1e-44, (-1.0, 1.0)
    ),
    "acos": Function(
        np.arccos, lambda x: (-1 / np.sqrt(np.maximum(1 - x * x, 1e-30)),), 2.2, 1e-44, (-1.0, 1.0)
    ),
    "erf": Function(
        _erf, lambda x: (2 / math.sqrt(math.pi) * np.exp(-x * x),), 1.8, 1e-44, (-3e38, 3e38)
    ),
}
