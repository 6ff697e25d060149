# SPDX-License-Identifier: Apache-2.0
"""Functions that the core has no unit for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Function:
    """An approximated function: its exact value and partial derivatives in double precision,
    largest error in ulp of the result, and absolute error beyond that.
    """

    exact: Callable[..., Real]
    partials: Callable[..., tuple[Real, ...]]
    ulp: float
    absolute: Callable[..., Real]


FUNCTIONS: dict[str, Function] = {}
