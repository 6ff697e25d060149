# SPDX-License-Identifier: Apache-2.0
"""Berkeley SoftFloat 3e (softfloatpy) as reference of the arithmetic units.

Every function takes arrays of operand bits and returns `(bits, flags)`: uint32 result bits and
uint8 flags {nv,dz,of,uf,nx} (bit 4 .. bit 0), the order of `fp_pkg::flags_t`. Rounding is to
nearest even and tininess is detected after rounding, set explicitly. This SoftFloat build already
returns the canonical NaN 7fc00000 and raises nv for 0 * inf + qNaN; results are passed unchanged
and `tests/fpu/test_softfloat.py` pins those two facts.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
import softfloatpy as sf

from asip_asm.isa import default_isa
from asip_asm.isa_records import OperationRecord
from sim.core.iss import arithmetic

Bits = np.ndarray  # uint32
Result = tuple[np.ndarray, np.ndarray]  # (uint32 bits, uint8 flags)

SIGN = np.uint32(0x8000_0000)
ONE, CANON_NAN = np.uint32(0x3F800000), np.uint32(0x7FC00000)
INVALID = np.uint8(0b10000)

sf.set_rounding_mode(sf.RoundingMode.NEAR_EVEN)
sf.set_tininess_mode(sf.TininessMode.AFTER_ROUNDING)


def floats(bits: Bits) -> list[sf.Float32]:
    """SoftFloat values of an array of binary32 bits."""
    raw = np.ascontiguousarray(bits, dtype=">u4").tobytes()
    from_bytes = sf.Float32.from_bytes
    return [from_bytes(raw[i : i + 4]) for i in range(0, len(raw), 4)]


def apply(function: Callable, *columns: list) -> Result:
    """Call a SoftFloat function row by row; collect result bits and the flags of each call.

    The result may be any SoftFloat 32-bit value (Float32, Int32, UInt32) or a bool (0 or 1).
    """
    clear, read = sf.set_exception_flags, sf.get_exception_flags
    words: list[bytes] = []
    flags: list[int] = []
    for row in zip(*columns, strict=True):
        clear(0)
        value = function(*row)
        flags.append(read())
        words.append(struct.pack(">I", value) if isinstance(value, bool) else value.to_bytes())
    bits = np.frombuffer(b"".join(words), dtype=">u4").astype(np.uint32)
    return bits, np.array(flags, dtype=np.uint8)


def _of_floats(function: Callable) -> Callable[..., Result]:
    """A SoftFloat function of binary32 operands, by columns of their bits."""
    return lambda *columns: apply(function, *map(floats, columns))


# mul_add: a * b + c with one rounding. The comparisons give 0 or 1; eq is quiet, only a signalling
# NaN raises nv; lt and le are signalling, any NaN does.
add, sub, mul, div = map(_of_floats, (sf.f32_add, sf.f32_sub, sf.f32_mul, sf.f32_div))
sqrt, mul_add = _of_floats(sf.f32_sqrt), _of_floats(sf.f32_mul_add)
eq, lt, le = map(_of_floats, (sf.f32_eq, sf.f32_lt, sf.f32_le))


def mul_sub(a: Bits, b: Bits, c: Bits) -> Result:
    """a * b - c with one rounding."""
    return mul_add(a, b, c ^ SIGN)


def neg_mul_add(a: Bits, b: Bits, c: Bits) -> Result:
    """-(a * b) + c with one rounding."""
    return mul_add(a ^ SIGN, b, c)


def neg_mul_sub(a: Bits, b: Bits, c: Bits) -> Result:
    """-(a * b) - c with one rounding."""
    return mul_add(a ^ SIGN, b, c ^ SIGN)


def neg_mul(a: Bits, b: Bits) -> Result:
    """-(a * b)"""
    return mul(a ^ SIGN, b)


def i32_to_f32(a: Bits) -> Result:
    """Signed 32-bit integer to binary32."""
    return apply(sf.i32_to_f32, [sf.Int32.from_int(int(x)) for x in a.astype(np.int32)])


def f32_to_i32(a: Bits, mode: sf.RoundingMode = sf.RoundingMode.MIN_MAG) -> Result:
    """binary32 to signed 32-bit integer, by default towards zero, nx when inexact."""
    return apply(lambda x: sf.f32_to_i32(x, mode, True), floats(a))


def u32_to_f32(a: Bits) -> Result:
    """Unsigned 32-bit integer to binary32."""
    return apply(sf.ui32_to_f32, [sf.UInt32.from_int(int(x)) for x in a])


def f32_to_i32_saturated(mode: sf.RoundingMode) -> Callable[[Bits], Result]:
    """f32_to_i32 with the units' rule where it is invalid, which is specific to SoftFloat's build:
    the nearest integer beyond 32 bits, 2^31 - 1 of a NaN."""

    def function(a: Bits) -> Result:
        bits, flags = f32_to_i32(a, mode)
        ours = np.where(_is_nan(a) | (a < SIGN), np.uint32(0x7FFFFFFF), SIGN)
        return np.where(flags == INVALID, ours, bits), flags

    return function


MODES = {"truncate": sf.RoundingMode.MIN_MAG, "nearest": sf.RoundingMode.NEAR_EVEN}


def _is_nan(x: np.ndarray) -> np.ndarray:
    return (x & ~SIGN) > 0x7F800000


def _is_snan(x: np.ndarray) -> np.ndarray:
    return _is_nan(x) & (x & 0x00400000 == 0)


def _as_float(compare: Callable) -> Callable[..., Result]:
    """A SoftFloat predicate with its 0 or 1 as 0.0 or 1.0."""

    def function(a: np.ndarray, b: np.ndarray) -> Result:
        bits, flags = compare(a, b)
        return bits * ONE, flags

    return function


def _quiet(compare: Callable, a: np.ndarray, b: np.ndarray | int) -> np.ndarray:
    """Truth of a SoftFloat predicate, flags dropped."""
    return compare(a, np.broadcast_to(np.uint32(b), a.shape))[0] == 1


def _invalid(condition: np.ndarray) -> np.ndarray:
    return np.where(condition, INVALID, 0).astype(np.uint8)


def _extremum(want_less: bool) -> Callable[..., Result]:
    """minimumNumber / maximumNumber: a number beats a NaN, -0 is below +0."""

    def function(a: np.ndarray, b: np.ndarray) -> Result:
        zeros = ((a | b) & ~SIGN) == 0
        a_below = np.where(zeros, a > b, le(a, b)[0] == 1)
        number = np.where(a_below == want_less, a, b)
        bits = np.select(
            [_is_nan(a) & _is_nan(b), _is_nan(a), _is_nan(b)], [CANON_NAN, b, a], number
        )
        return bits, _invalid(_is_snan(a) | _is_snan(b))

    return function


def _sgn(a: np.ndarray) -> Result:
    signs = np.where(_quiet(lt, a, 0), ONE | SIGN, np.where(_quiet(eq, a, 0), np.uint32(0), ONE))
    return np.where(_is_nan(a), CANON_NAN, signs), _invalid(_is_snan(a))


def _sat(a: np.ndarray, low: np.ndarray, high: np.ndarray) -> Result:
    nan = _is_nan(a) | _is_nan(low) | _is_nan(high)
    exchanged = ~nan & _quiet(lt, high, low)
    bits = np.select(
        [nan | exchanged, _quiet(lt, a, low), _quiet(lt, high, a)],
        [CANON_NAN, low, high],
        a,
    )
    return bits, _invalid(_is_snan(a) | _is_snan(low) | _is_snan(high) | exchanged)


def _silent(function: Callable) -> Callable[..., Result]:
    return lambda *operands: (
        function(*operands).astype(np.uint32),
        np.zeros(len(operands[0]), np.uint8),
    )


def _select(condition: Callable) -> Callable[..., Result]:
    return _silent(lambda a, b, c: np.where(condition(a), b, c))


# operation -> operand count, function. A NaN condition of a selection takes c.
_OWN: dict[str, tuple[int, Callable[..., Result]]] = {
    "EQ": (2, _as_float(eq)),
    "LT": (2, _as_float(lt)),
    "LE": (2, _as_float(le)),
    "MIN": (2, _extremum(True)),
    "MAX": (2, _extremum(False)),
    "ABS": (1, _silent(lambda a: a & ~SIGN)),
    "NEG": (1, _silent(lambda a: a ^ SIGN)),
    "MOV": (1, _silent(lambda a: a)),
    "SGN": (1, _sgn),
    "SAT": (3, _sat),
    "SEL": (3, _select(lambda a: ~_is_nan(a) & ~_quiet(eq, a, 0))),
    "SELGE": (3, _select(lambda a: le(np.zeros_like(a), a)[0] == 1)),
    "SELGT": (3, _select(lambda a: lt(np.zeros_like(a), a)[0] == 1)),
    "IADD": (2, _silent(lambda a, b: a + b)),
    "ISUB": (2, _silent(lambda a, b: a - b)),
}


def of_record(record: OperationRecord) -> Callable:
    """Value and flags as the record says them, a case at a time."""
    function = arithmetic.compiled(record)

    def computed(*operands: int) -> tuple[int, int]:
        with arithmetic.environment():
            bits = arithmetic.bits_of(function(*map(arithmetic.word, operands)))
            return bits, arithmetic.flags()

    def rows(*columns: np.ndarray) -> Result:
        bits, flags = np.vectorize(computed, otypes=[np.uint32, np.uint8])(*columns)
        return bits, flags

    return rows


# Operations of fp_cmp without a function here are computed as their records say.
COMPARISONS = {
    name: _OWN.get(name) or (len(record.sources), of_record(record))
    for name, record in default_isa().comparisons.items()
}
