# SPDX-License-Identifier: Apache-2.0
"""Ranges of a value over many boxes of inputs at once: intervals, and affine forms within them.

A form encloses a value that depends on symbols e_s of -1..1, the same for all forms of a box:
value = c + sum_s g_s e_s + r, |r| at most `rest`, and low <= value <= high. Without `g` it is the
interval alone. Every operation rounds outwards: bounds of an interval by more than an ulp, an
affine form by adding SLACK of the sizes of its terms to its rest. L. H. de Figueiredo and J.
Stolfi, Affine arithmetic, Numerical Algorithms 37, 2004.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
ULP = 2.0**-51
"""More than an ulp of double precision, by which a rounded bound moves outwards."""
SLACK = 2.0**-44
"""Allowance for the roundings of an affine form, as a share of the sizes of its terms."""
LIBRARY = 2.0**-46
"""Largest relative error of numpy's elementary functions in double precision, with a margin."""


@dataclass(frozen=True, eq=False)
class Form:
    """Enclosure of a value in each of B boxes: low, high, c, rest (B,), g (symbols, B) or None."""

    low: Real
    high: Real
    c: Real | None = None
    g: Real | None = None
    rest: Real | None = None

    @property
    def size(self) -> Real:
        """Largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def parts(self) -> tuple[Real, Real, Real] | None:
        """c, g and rest; None of an interval."""
        if self.c is None or self.g is None or self.rest is None:
            return None
        return self.c, self.g, self.rest

    def centred(self) -> tuple[Real, Real | None, Real]:
        """c, g, rest; of an interval its middle and half width."""
        if (parts := self.parts) is not None:
            return parts
        c = 0.5 * self.low + 0.5 * self.high
        rest = np.maximum(self.high - c, c - self.low) * (1 + ULP)
        return c, None, rest

    def spread(self) -> Real:
        """Largest distance from c."""
        c, g, rest = self.centred()
        if g is None:
            return rest
        far = np.maximum(np.abs(self.high - c), np.abs(c - self.low))
        return np.fmin(np.abs(g).sum(axis=0) + rest, far) * (1 + SLACK)


def interval(low: Real, high: Real) -> Form:
    """The form of bounds that were computed with one rounding."""
    low, high = low - np.abs(low) * ULP, high + np.abs(high) * ULP
    return Form(np.fmax(low, -np.inf), np.fmin(high, np.inf))


def constant(value: float, boxes: int) -> Form:
    """A number."""
    return Form(*(np.full(boxes, float(value)) for _ in range(2)))


def affine(low: Real, high: Real, c: Real, g: Real, rest: Real, terms: Real) -> Form:
    """A form whose affine part was computed with roundings, from terms of that size.

    Where the interval is narrower than the rest the interval takes its place.
    """
    spread = np.abs(g).sum(axis=0)
    rest = (rest + SLACK * terms) * (1 + SLACK)
    whole = (spread + rest) * (1 + SLACK) + SLACK * np.abs(c)
    low, high = np.fmax(low, c - whole), np.fmin(high, c + whole)
    middle = 0.5 * low + 0.5 * high
    half = np.maximum(high - middle, middle - low) * (1 + ULP)
    plain = ~(rest < half)
    if plain.any():
        c, rest, g = np.where(plain, middle, c), np.where(plain, half, rest), np.where(plain, 0, g)
    return Form(low, high, c, g, rest)


def widened(x: Form, error: Real, symbol: int | None = None) -> Form:
    """The value with an error; its share of -1..1 is the symbol's if one is given."""
    low, high = x.low - error, x.high + error
    low, high = low - np.abs(low) * ULP, high + np.abs(high) * ULP
    if (parts := x.parts) is None:
        return Form(low, high)
    c, g, rest = parts
    if symbol is None:
        return Form(low, high, c, g, (rest + error) * (1 + ULP))
    g = g.copy()
    g[symbol] += error
    return Form(low, high, c, g, rest + SLACK * (error + np.abs(g[symbol])))


def scaled(x: Form, factor: float) -> Form:
    """factor * x, exact for 1 and -1."""
    if factor == 1:
        return x
    parts = x.parts
    if factor == -1:
        if parts is None:
            return Form(-x.high, -x.low)
        return Form(-x.high, -x.low, -parts[0], -parts[1], parts[2])
    ends = (x.low, x.high) if factor > 0 else (x.high, x.low)
    found = interval(factor * ends[0], factor * ends[1])
    if parts is None:
        return found
    c, g, rest = parts
    terms = abs(factor) * (np.abs(c) + x.spread())
    return affine(found.low, found.high, factor * c, factor * g, abs(factor) * rest, terms)


def plus(x: Form, y: Form, sign: int = 1) -> Form:
    """x + y, or with sign -1 x - y."""
    other = (y.low, y.high) if sign > 0 else (-y.high, -y.low)
    found = interval(x.low + other[0], x.high + other[1])
    (c1, g1, r1), (c2, g2, r2) = x.centred(), y.centred()
    c, rest = c1 + sign * c2, r1 + r2
    if g1 is not None and g2 is not None:
        g = g1 + g2 if sign > 0 else g1 - g2
    elif g1 is not None:
        g = g1
    elif g2 is not None:
        g = sign * g2
    else:
        return found
    terms = np.abs(c1) + np.abs(c2) + x.spread() + y.spread()
    return affine(found.low, found.high, c, g, rest, terms)


def times(x: Form, y: Form) -> Form:
    """x * y; of one and the same form the square."""
    if x is y:
        return _square(x)
    ends = [a * b for a in (x.low, x.high) for b in (y.low, y.high)]
    low = np.fmin(np.fmin(ends[0], ends[1]), np.fmin(ends[2], ends[3]))
    high = np.fmax(np.fmax(ends[0], ends[1]), np.fmax(ends[2], ends[3]))
    found = interval(low, high)
    (c1, g1, r1), (c2, g2, r2) = x.centred(), y.centred()
    s1, s2 = x.spread(), y.spread()
    if g1 is not None and g2 is not None:
        g = c1 * g2 + c2 * g1
    elif g1 is not None:
        g = c2 * g1
    elif g2 is not None:
        g = c1 * g2
    else:
        return found
    rest = np.abs(c1) * r2 + np.abs(c2) * r1 + s1 * s2
    terms = (np.abs(c1) + s1) * (np.abs(c2) + s2)
    return affine(found.low, found.high, c1 * c2, g, rest, terms)


def _square(x: Form) -> Form:
    a, b = x.low * x.low, x.high * x.high
    straddles = (x.low < 0) & (x.high > 0)
    found = interval(np.where(straddles, 0.0, np.minimum(a, b)), np.maximum(a, b))
    if (parts := x.parts) is None:
        return found
    c, g, rest = parts
    s = x.spread()
    rest = 2 * np.abs(c) * rest + 0.5 * s * s
    terms = (np.abs(c) + s) ** 2
    return affine(found.low, found.high, c * c + 0.5 * s * s, 2 * c * g, rest, terms)


def union(x: Form, y: Form) -> Form:
    """One of the two."""
    return Form(np.minimum(x.low, y.low), np.maximum(x.high, y.high))


def within(x: Form, low: Real, high: Real) -> Form:
    """The value, known to be between these too."""
    return Form(np.maximum(x.low, low), np.minimum(x.high, high), x.c, x.g, x.rest)


def polar(x: Form, a: Real | float, b: Real | float, errors: Real) -> Form:
    """x, known to be a' cos w + b' sin w of one angle with |a'| <= a, |b'| <= b; errors: of the
    cosine and the sine together.
    """
    most = np.sqrt(np.square(a) + np.square(b)) * (1 + errors + 2.0**-40)
    return within(x, -most, most)


def chosen(mask: NDArray[np.bool_], x: Form, y: Form) -> Form:
    """x in the boxes of the mask, y in the others."""
    if mask.all():
        return x
    if not mask.any():
        return y
    low, high = np.where(mask, x.low, y.low), np.where(mask, x.high, y.high)
    if x.g is None and y.g is None:
        return Form(low, high)
    (c1, g1, r1), (c2, g2, r2) = x.centred(), y.centred()
    zero = np.zeros_like(g1 if g1 is not None else g2)
    g = np.where(mask, zero if g1 is None else g1, zero if g2 is None else g2)
    return Form(low, high, np.where(mask, c1, c2), g, np.where(mask, r1, r2))


def _linear(x: Form, found: Form, value: Real, slope: Real, second: Real) -> Form:
    """f(x) in `found`, with f(c), f'(c) and a bound of |f''| over the range of x."""
    if (parts := x.parts) is None:
        return found
    c, g, rest = parts
    s = x.spread()
    rest = np.abs(slope) * rest + 0.5 * second * s * s
    terms = np.abs(value) + np.abs(slope) * s
    inside = (c >= x.low) & (c <= x.high) & np.isfinite(rest)  # else f'' is not known there
    rest = np.where(inside, rest, np.inf)
    g = np.where(np.isfinite(rest), slope, 0.0) * g
    value = np.where(np.isfinite(value), value, 0.0)
    return affine(found.low, found.high, value, g, rest, terms + LIBRARY / SLACK * np.abs(value))


def inverse(x: Form) -> Form:
    """1 / x; infinite where x can be 0."""
    zero = (x.low <= 0) & (x.high >= 0)
    ends = interval(1 / x.high, 1 / x.low)
    found = Form(np.where(zero, -np.inf, ends.low), np.where(zero, np.inf, ends.high))
    if x.c is None:
        return found
    least = np.where(zero, 0.0, np.minimum(np.abs(x.low), np.abs(x.high)))
    return _linear(x, found, 1 / x.c, -1 / (x.c * x.c), 2 / least**3)


def root(x: Form) -> Form:
    """Square root of what is not negative."""
    low, high = np.sqrt(np.maximum(x.low, 0)), np.sqrt(np.maximum(x.high, 0))
    found = interval(low, high)
    if x.c is None:
        return found
    value = np.sqrt(np.maximum(x.c, 0))
    return _linear(x, found, value, 0.5 / value, 0.25 / (low * low * low))


def sine_and_cosine(x: Form) -> tuple[Form, Form]:
    """Both of an angle in radians."""
    return _wave(x, 0.0), _wave(x, 0.5)


def _of_small_angle(x: Form, sine: Form) -> Form:
    """The sine in [x - x^3/6, x] of angles up to 1: near 0 its relative error is small too, as a
    quotient sin(x)/x needs it.
    """
    ends = []
    for end, outwards in ((x.low, -1), (x.high, 1)):
        towards_0 = end * (1 - end * end / 6)
        bound = np.where(outwards * end > 0, end, towards_0)
        ends.append(bound + outwards * 2.0**-50 * np.abs(bound))
    small = x.size <= 1
    return chosen(small, within(sine, *ends), sine)


def _wave(x: Form, ahead: float) -> Form:
    """sin(x + ahead * pi), ahead 0 or 1/2."""
    function: Callable = np.cos if ahead else np.sin
    a, b = function(x.low), function(x.high)
    low, high = np.minimum(a, b) - LIBRARY, np.maximum(a, b) + LIBRARY
    # Quarter turns up to each end: a peak lies between them where a whole number does.
    margin = SLACK * (1 + x.size)
    for peak, sign in ((0.5, 1), (1.5, -1)):
        turns = [(end / math.pi + ahead - peak) / 2 for end in (x.low - margin, x.high + margin)]
        hit = np.floor(turns[1]) >= np.ceil(turns[0])
        if sign > 0:
            high = np.where(hit, 1.0, high)
        else:
            low = np.where(hit, -1.0, low)
    low, high = np.fmax(low, -1.0), np.fmin(high, 1.0)
    found = Form(low, high)
    if not ahead:
        found = _of_small_angle(x, found)
    if x.c is None:
        return found
    slope = -np.sin(x.c) if ahead else np.cos(x.c)
    return _linear(x, found, function(x.c), slope, np.ones_like(x.c))
