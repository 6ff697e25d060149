# SPDX-License-Identifier: Apache-2.0
"""Golden model of the arithmetic, in numpy: result bits and IEEE 754 exceptions of arrays.

Operands and results are uint32 arrays of binary32 bits or integers. Flags are {nv, dz, of, uf, nx},
nv in bit 4. Sums, products, quotients and roots are numpy's own of float32; the fused multiply-add
and the exceptions come from double precision, where they are exact. NaN results are 7fc00000.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Bits = NDArray[np.uint32]
Result = tuple[Bits, NDArray[np.uint8]]

SIGN, NAN = np.uint32(0x8000_0000), np.uint32(0x7FC0_0000)
NV, DZ, OF, UF, NX = 16, 8, 4, 2, 1
SINE_LIMIT = 256.0  # rad, of the sine unit
SINE_ULP = 0.532  # error bound of the sine unit
ONE = np.uint32(0x3F80_0000)


def single(bits: Bits) -> NDArray[np.float32]:
    """Bits as binary32."""
    return np.ascontiguousarray(bits, np.uint32).view(np.float32)


def double(bits: Bits) -> NDArray[np.float64]:
    """The same values in double precision."""
    with np.errstate(invalid="ignore"):
        return single(bits).astype(np.float64)


def packed(values: NDArray[np.float32]) -> Bits:
    """Bits of results, every NaN the canonical one."""
    return np.where(np.isnan(values), NAN, values.astype(np.float32).view(np.uint32))


def signalling(bits: Bits) -> NDArray[np.bool_]:
    """Whether these are signalling NaNs."""
    return np.isnan(single(bits)) & (bits & 0x0040_0000 == 0)


def flags(**raised: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Flags of the exceptions named nv, dz, of, uf, nx."""
    value = {"nv": NV, "dz": DZ, "of": OF, "uf": UF, "nx": NX}
    every = [np.where(found, value[name], 0) for name, found in raised.items()]
    return np.sum(every, axis=0).astype(np.uint8)


def odd(high: NDArray[np.float64], low: NDArray[np.float64]) -> NDArray[np.float64]:
    """high + low, where low is the rounding error of high, rounded to odd: 53 bits that round to 24
    bits as the exact sum does, and that have 24 bits only if the sum has.
    """
    even = high.view(np.uint64) & np.uint64(1) == 0
    toward = np.nextafter(high, np.where(low > 0, np.inf, -np.inf))
    return np.where((low != 0) & even & np.isfinite(high), toward, high)


def added(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """x + y rounded to odd (Knuth's two-sum)."""
    total = x + y
    part = total - x
    low = (x - (total - part)) + (y - part)
    return odd(total, np.where(np.isfinite(total), low, 0.0))


def tiny(exact: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether a value is below the normal numbers after rounding to 24 bits."""
    return np.abs((exact * 2.0**100).astype(np.float32)) < np.float32(2.0**-26)


def rounded(result: Bits, exact: NDArray[np.float64], *operands: Bits) -> NDArray[np.uint8]:
    """Flags of a result, given its exact value (or that rounded to odd)."""
    finite = np.all([np.isfinite(single(o)) for o in operands], axis=0)
    number = np.all([~np.isnan(single(o)) for o in operands], axis=0)
    snan = np.any([signalling(o) for o in operands], axis=0)
    value = double(result)
    inexact = finite & (value != exact)
    return flags(
        nv=snan | (number & np.isnan(value)),
        of=finite & np.isinf(value),
        uf=inexact & tiny(exact),
        nx=inexact & ~np.isnan(value),
    )


@np.errstate(all="ignore")
def add(a: Bits, b: Bits) -> Result:
    """a + b."""
    result = packed(single(a) + single(b))
    return result, rounded(result, added(double(a), double(b)), a, b)


def sub(a: Bits, b: Bits) -> Result:
    """a - b; the sign of a NaN does not matter."""
    return add(a, np.where(np.isnan(single(b)), b, b ^ SIGN))


@np.errstate(all="ignore")
def mul(a: Bits, b: Bits) -> Result:
    """a * b; the product of doubles is exact."""
    result = packed(single(a) * single(b))
    return result, rounded(result, double(a) * double(b), a, b)


@np.errstate(all="ignore")
def fma(a: Bits, b: Bits, c: Bits) -> Result:
    """a * b + c with one rounding. 0 times infinity is invalid whatever c is."""
    product = double(a) * double(b)
    exact = added(product, double(c))
    result = packed(exact.astype(np.float32))
    nowhere = np.isnan(product) & ~np.isnan(single(a)) & ~np.isnan(single(b))
    return result, rounded(result, exact, a, b, c) | flags(nv=nowhere)


@np.errstate(all="ignore")
def div(a: Bits, b: Bits) -> Result:
    """a / b."""
    x, y = double(a), double(b)
    result = packed(single(a) / single(b))
    quotient = double(result)
    zero = (y == 0) & np.isfinite(x) & (x != 0)
    finite = np.isfinite(x) & np.isfinite(y) & (y != 0)
    inexact = finite & (quotient * y != x)
    invalid = np.isnan(quotient) & ~np.isnan(x) & ~np.isnan(y)
    return result, flags(
        nv=signalling(a) | signalling(b) | invalid,
        dz=zero,
        of=finite & np.isinf(quotient),
        uf=inexact & tiny(x / y),
        nx=inexact,
    )


@np.errstate(all="ignore")
def sqrt(a: Bits) -> Result:
    """Square root of a."""
    result = packed(np.sqrt(single(a)))
    root, x = double(result), double(a)
    inexact = np.isfinite(x) & (x > 0) & (root * root != x)
    return result, flags(nv=signalling(a) | (np.isnan(root) & ~np.isnan(x)), nx=inexact)


def float_of(a: Bits, unsigned: bool = False) -> Result:
    """Integer to binary32."""
    exact = (a if unsigned else a.view(np.int32)).astype(np.float64)
    result = packed(exact.astype(np.float32))
    return result, flags(nx=double(result) != exact)


@np.errstate(all="ignore")
def int_of(a: Bits, truncate: bool = True) -> Result:
    """binary32 to int32, toward zero or to nearest even; saturated, 2^31 - 1 of a NaN."""
    x = double(a)
    whole = np.trunc(x) if truncate else np.rint(x)
    outside = ~((whole >= -(2.0**31)) & (whole < 2.0**31))
    bound = np.where(x < 0, np.uint32(0x8000_0000), np.uint32(0x7FFF_FFFF))
    inside = np.where(outside, 0, whole).astype(np.int64).astype(np.uint32)
    return np.where(outside, bound, inside), flags(nv=outside, nx=~outside & (whole != x))


@np.errstate(all="ignore")
def compare(a: Bits, b: Bits, relation: str) -> Result:
    """1 or 0 for the relations eq, lt, le; nv by a signalling NaN, of lt and le by any."""
    x, y = single(a), single(b)
    true = {"eq": x == y, "lt": x < y, "le": x <= y}[relation]
    snan, nan = signalling(a) | signalling(b), np.isnan(x) | np.isnan(y)
    return true.astype(np.uint32), flags(nv=snan if relation == "eq" else nan)


@np.errstate(all="ignore")
def least(a: Bits, b: Bits) -> Result:
    """minimumNumber: a number rather than a NaN, -0 below +0."""
    x, y = single(a), single(b)
    first = np.isnan(y) | (x < y) | ((x == y) & (a >> 31 > b >> 31))
    first &= ~np.isnan(x)
    result = packed(single(np.where(first, a, b)))
    return result, flags(nv=signalling(a) | signalling(b))


def most(a: Bits, b: Bits) -> Result:
    """maximumNumber."""
    result, raised = least(a ^ SIGN, b ^ SIGN)
    return np.where(result == NAN, NAN, result ^ SIGN), raised


@np.errstate(all="ignore")
def sign(a: Bits) -> Result:
    """-1, +0 for either zero, 1; NaN of a NaN."""
    x = single(a)
    return packed(np.sign(x) + np.float32(0.0)), flags(nv=signalling(a))


@np.errstate(all="ignore")
def saturate(a: Bits, low: Bits, high: Bits) -> Result:
    """a within low .. high; a NaN operand gives NaN; so do exchanged limits, with nv."""
    x, least_, most_ = single(a), single(low), single(high)
    nan = np.isnan(x) | np.isnan(least_) | np.isnan(most_)
    exchanged = least_ > most_
    limited = np.where(x < least_, low, np.where(x > most_, high, a))
    snan = signalling(a) | signalling(low) | signalling(high)
    return np.where(nan | exchanged, NAN, limited), flags(nv=snan | (exchanged & ~nan))


@np.errstate(all="ignore")
def sine_error(a: Bits, got: Bits, cosine: bool = False) -> NDArray[np.float64]:
    """Error of results within the unit's range, in units of the last place of the true value."""
    x = double(a)
    true = np.cos(x) if cosine else np.sin(x)
    ulp = 2.0 ** (np.maximum(np.floor(np.log2(np.maximum(np.abs(true), 1e-300))), -126) - 23)
    return np.abs(double(got) - true) / ulp


def sine_flags(a: Bits, cosine: bool = False) -> NDArray[np.uint8]:
    """Flags of the sine unit within its range: exact at 0 alone; a tiny sine underflows."""
    x = double(a)
    return flags(nx=x != 0, uf=(x != 0) & tiny(np.sin(x)) & (not cosine))


def flushed(function: Callable[[Bits, Bits], Result]) -> Callable[[Bits, Bits], Bits]:
    """An operation of the vendor's first generation: subnormal numbers are zeros of their sign."""

    def zeroed(bits: Bits) -> Bits:
        return np.where(bits & 0x7F80_0000 == 0, bits & SIGN, bits).astype(np.uint32)

    return lambda a, b: zeroed(function(zeroed(a), zeroed(b))[0])
