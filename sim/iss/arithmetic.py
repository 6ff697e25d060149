# SPDX-License-Identifier: Apache-2.0
"""Operations of the ASIP on 32-bit words, computed by Berkeley SoftFloat and MPFR.

A word is a `softfloatpy.Float32` holding any 32 bits. Round to nearest even, tininess after
rounding, canonical NaN 7fc00000; exceptions accumulate in SoftFloat's global flags, whose bits are
{nv, dz, of, uf, nx} with nx as bit 0. Semantics: the `doc` lines of `isa.toml`, IEEE 754-2019.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import gmpy2
import softfloatpy as sf

Word = sf.Float32
NV, DZ, OF, UF, NX = 16, 8, 4, 2, 1
SINE_LIMIT = 256.0  # rad

SinCos = Callable[[int, bool], tuple[int, int]]
"""(bits of the argument, cosine?) -> (bits of the result, flags)."""


def word(bits: int) -> Word:
    """Word of 32 bits given as an unsigned or signed integer."""
    return Word.from_bytes((bits & 0xFFFF_FFFF).to_bytes(4, "big"))


def bits_of(value: Word) -> int:
    """The 32 bits as an unsigned integer."""
    return int.from_bytes(value.to_bytes(), "big")


def from_float(value: float) -> Word:
    """Nearest binary32 (ties to even) of a Python float; OverflowError if it is too large."""
    return Word.from_bytes(struct.pack(">f", value))


def to_float(value: Word) -> float:
    """The word read as binary32."""
    return struct.unpack(">f", value.to_bytes())[0]


def to_int(value: Word) -> int:
    """The word read as int32."""
    return int.from_bytes(value.to_bytes(), "big", signed=True)


ZERO, ONE, MINUS_ONE, NAN = word(0), from_float(1.0), from_float(-1.0), word(0x7FC0_0000)

add, sub, mul, fma, div, sqrt = (
    sf.f32_add,
    sf.f32_sub,
    sf.f32_mul,
    sf.f32_mul_add,
    sf.f32_div,
    sf.f32_sqrt,
)
_negate, _lt, _le, _eq = sf.f32_neg, sf.f32_lt, sf.f32_le, sf.f32_eq
_lt_quiet, _is_nan, _is_snan = sf.f32_lt_quiet, sf.f32_is_nan, sf.f32_is_signaling_nan


@contextmanager
def environment() -> Iterator[None]:
    """Rounding and tininess modes of the core and clear flags; restores the caller's on leaving."""
    before = sf.get_rounding_mode(), sf.get_tininess_mode(), sf.get_exception_flags()
    sf.set_rounding_mode(sf.RoundingMode.NEAR_EVEN)
    sf.set_tininess_mode(sf.TininessMode.AFTER_ROUNDING)
    sf.set_exception_flags(0)
    try:
        yield
    finally:
        sf.set_rounding_mode(before[0])
        sf.set_tininess_mode(before[1])
        sf.set_exception_flags(before[2])


def flags() -> int:
    """Exceptions raised since `environment` was entered."""
    return sf.get_exception_flags()


def _raise(raised: int) -> None:
    sf.set_exception_flags(sf.get_exception_flags() | raised)


def _invalid() -> Word:
    _raise(NV)
    return NAN


def fmsub(a: Word, b: Word, c: Word) -> Word:
    return fma(a, b, _negate(c))


def fnmsub(a: Word, b: Word, c: Word) -> Word:
    return fma(_negate(a), b, c)


def fnmadd(a: Word, b: Word, c: Word) -> Word:
    return fma(_negate(a), b, _negate(c))


def fnmul(a: Word, b: Word) -> Word:
    return mul(_negate(a), b)


def feq(a: Word, b: Word) -> Word:
    return ONE if _eq(a, b) else ZERO


def flt(a: Word, b: Word) -> Word:
    return ONE if _lt(a, b) else ZERO


def fle(a: Word, b: Word) -> Word:
    return ONE if _le(a, b) else ZERO


def _number_order(a: Word, b: Word) -> tuple[Word, Word]:
    """(smaller, larger) by value, -0 < +0; a number beats a NaN, two NaNs give the canonical."""
    if _is_snan(a) or _is_snan(b):
        _raise(NV)
    if _is_nan(a) or _is_nan(b):
        number = NAN if _is_nan(a) and _is_nan(b) else b if _is_nan(a) else a
        return number, number
    if _lt_quiet(a, b) or (_eq(a, b) and bits_of(a) >> 31):
        return a, b
    return b, a


def fmin(a: Word, b: Word) -> Word:
    return _number_order(a, b)[0]


def fmax(a: Word, b: Word) -> Word:
    return _number_order(a, b)[1]


def fabs(a: Word) -> Word:
    return word(bits_of(a) & 0x7FFF_FFFF)


def fneg(a: Word) -> Word:
    return word(bits_of(a) ^ 0x8000_0000)


def mov(a: Word) -> Word:
    return a


def fsgn(a: Word) -> Word:
    if _is_nan(a):
        if _is_snan(a):
            _raise(NV)
        return NAN
    return ONE if _lt_quiet(ZERO, a) else MINUS_ONE if _lt_quiet(a, ZERO) else ZERO


def fsat(a: Word, low: Word, high: Word) -> Word:
    """a within low..high; a NaN operand gives NaN, low > high is invalid and gives NaN."""
    if _is_nan(a) or _is_nan(low) or _is_nan(high):
        if _is_snan(a) or _is_snan(low) or _is_snan(high):
            _raise(NV)
        return NAN
    if _lt_quiet(high, low):
        return _invalid()
    return low if _lt_quiet(a, low) else high if _lt_quiet(high, a) else a


def sel(a: Word, b: Word, c: Word) -> Word:
    return c if _is_nan(a) or bits_of(a) & 0x7FFF_FFFF == 0 else b


def selge(a: Word, b: Word, c: Word) -> Word:
    return c if _is_nan(a) or _lt_quiet(a, ZERO) else b


def selgt(a: Word, b: Word, c: Word) -> Word:
    return c if _is_nan(a) or not _lt_quiet(ZERO, a) else b


def iadd(a: Word, b: Word) -> Word:
    return word(to_int(a) + to_int(b))


def isub(a: Word, b: Word) -> Word:
    return word(to_int(a) - to_int(b))


def i2f(a: Word) -> Word:
    return sf.i32_to_f32(sf.Int32.from_bytes(a.to_bytes()))


def f2i(a: Word) -> Word:
    return Word.from_bytes(sf.f32_to_i32(a, sf.RoundingMode.NEAR_EVEN, True).to_bytes())


def f2it(a: Word) -> Word:
    return Word.from_bytes(sf.f32_to_i32(a, sf.RoundingMode.MIN_MAG, True).to_bytes())


_BINARY32 = gmpy2.context(precision=24, emax=128, emin=-148, subnormalize=True)


def sincos_rounded(bits: int, cosine: bool) -> tuple[int, int]:
    """Correctly rounded sine or cosine (MPFR) and flags; invalid beyond SINE_LIMIT."""
    value = struct.unpack(">f", bits.to_bytes(4, "big"))[0]
    if value != value:
        quiet = bits >> 22 & 1
        return 0x7FC0_0000, 0 if quiet else NV
    if not abs(value) <= SINE_LIMIT:
        return 0x7FC0_0000, NV
    if value == 0.0:
        return (0x3F80_0000 if cosine else bits), 0
    with gmpy2.context(_BINARY32):
        result = float((gmpy2.cos if cosine else gmpy2.sin)(gmpy2.mpfr(value)))
    tiny = abs(result) < 2.0**-126  # sine and cosine of another binary32 number are never exact
    return int.from_bytes(struct.pack(">f", result), "big"), NX | (UF if tiny else 0)


def sine_operations(sincos: SinCos) -> dict[str, Callable[[Word], Word]]:
    """fsin and fcos made of a function on bits."""

    def operation(cosine: bool) -> Callable[[Word], Word]:
        def apply(a: Word) -> Word:
            result, raised = sincos(bits_of(a), cosine)
            _raise(raised)
            return word(result)

        return apply

    return {"fsin": operation(False), "fcos": operation(True)}


OPERATIONS: dict[str, Callable[..., Word]] = {
    "fmadd": fma,
    "fnmsub": fnmsub,
    "fmsub": fmsub,
    "fnmadd": fnmadd,
    "fmul": mul,
    "fnmul": fnmul,
    "fadd": add,
    "fsub": sub,
    "feq": feq,
    "flt": flt,
    "fle": fle,
    "fmin": fmin,
    "fmax": fmax,
    "fabs": fabs,
    "fneg": fneg,
    "mov": mov,
    "fsgn": fsgn,
    "fsat": fsat,
    "sel": sel,
    "selge": selge,
    "selgt": selgt,
    "iadd": iadd,
    "isub": isub,
    "fdiv": div,
    "fsqrt": sqrt,
    "i2f": i2f,
    "f2i": f2i,
    "f2it": f2it,
}
"""Operations that compute a word from words; fsin, fcos come from `sine_operations`."""
