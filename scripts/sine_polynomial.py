# SPDX-License-Identifier: Apache-2.0
"""Coefficients of the sine that the compiler puts on the multiply-add pipes, for
asip_asm/model/sine.py: python scripts/sine_polynomial.py prints them with their error.

sin(2 pi w) = w P(w^2) for |w| <= 1/4, P of degree 4, smallest relative error by the exchange
algorithm of Remez in 50 digits. The coefficients become binary32 one by one, the lowest first, and
those that are left are fitted again.
"""

from __future__ import annotations

import struct

import mpmath as mp

DEGREE = 4
END = mp.mpf(1) / 16  # exact; the largest w^2
POINTS = 500
"""Places where the error is looked at."""
ROUNDS = 6


def ratio(z: mp.mpf) -> mp.mpf:
    """sin(2 pi w) / w as a function of z = w^2."""
    w = mp.sqrt(z)
    return mp.sin(2 * mp.pi * w) / w if z else 2 * mp.pi


def single(number: mp.mpf) -> float:
    """Nearest binary32 number."""
    return struct.unpack("<f", struct.pack("<f", float(number)))[0]


def value(coefficients: list, z: mp.mpf) -> mp.mpf:
    """Polynomial, lowest coefficient first."""
    return mp.fsum(c * z**k for k, c in enumerate(coefficients))


def error(coefficients: list, z: mp.mpf) -> mp.mpf:
    """Relative error of the polynomial."""
    return value(coefficients, z) / ratio(z) - 1


def fit(fixed: list[float]) -> list[mp.mpf]:
    """Coefficients of the smallest relative error whose lowest ones are `fixed`."""
    free = range(len(fixed), DEGREE + 1)
    count = len(free) + 1
    nodes = [END * (1 - mp.cos(mp.pi * k / (count - 1))) / 2 for k in range(count)]
    if fixed:  # the error at 0 cannot be changed any more
        nodes[0] = END / 1000
    grid = [END * mp.mpf(k) / POINTS for k in range(1 if fixed else 0, POINTS + 1)]
    known = [mp.mpf(value) for value in fixed]
    for _ in range(ROUNDS):
        rows = [[z**k / ratio(z) for k in free] + [(-1) ** i] for i, z in enumerate(nodes)]
        right = [1 - value(known, z) / ratio(z) if known else 1 for z in nodes]
        solution = list(mp.lu_solve(mp.matrix(rows), mp.matrix(right)))
        coefficients = known + solution[:-1]
        gaps = [error(coefficients, z) for z in grid]
        nodes = _extremes(grid, gaps, count) or nodes
    return coefficients


def _extremes(grid: list[mp.mpf], gaps: list[mp.mpf], count: int) -> list[mp.mpf] | None:
    """Places of the largest errors of alternating sign; None if there are too few."""
    found: list[int] = []
    for i, gap in enumerate(gaps):
        if found and (gap > 0) == (gaps[found[-1]] > 0):
            if abs(gap) > abs(gaps[found[-1]]):
                found[-1] = i
        else:
            found.append(i)
    while len(found) > count:
        found.pop(0 if abs(gaps[found[0]]) < abs(gaps[found[-1]]) else -1)
    return [grid[i] for i in found] if len(found) == count else None


def coefficients() -> list[float]:
    """Rounded coefficients of P, the lowest first."""
    mp.mp.dps = 50
    rounded: list[float] = []
    while len(rounded) <= DEGREE:
        rounded.append(single(fit(rounded)[len(rounded)]))
    return rounded


def main() -> None:
    """Print them, with the largest error on the grid."""
    rounded = coefficients()
    gaps = [error(rounded, END * mp.mpf(k) / POINTS) for k in range(1, POINTS + 1)]
    print(f"SINE = {tuple(rounded)}")
    print(f"largest relative error of the polynomial {mp.nstr(max(map(abs, gaps)), 3)}")


if __name__ == "__main__":
    main()
