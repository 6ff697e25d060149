# SPDX-License-Identifier: Apache-2.0
"""Operations of the ASIP on 32-bit words, computed by Berkeley SoftFloat and MPFR.

A word is a `softfloatpy.Float32` holding any 32 bits. Round to nearest even, tininess after
rounding, canonical NaN 7fc00000; exceptions accumulate in SoftFloat's global flags, whose bits are
{nv, dz, of, uf, nx} with nx as bit 0. Semantics: the records of `isa.toml`, IEEE 754-2019.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import gmpy2
import softfloatpy as sf

from asip_asm.isa import default_isa
from asip_asm.isa_records import OperationRecord
from asip_asm.semantics import render

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


ZERO = word(0)


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


def _from_int(a: Word) -> Word:
    return sf.i32_to_f32(sf.Int32.from_bytes(a.to_bytes()))


def _to_int(a: Word) -> Word:
    return Word.from_bytes(sf.f32_to_i32(a, sf.RoundingMode.NEAR_EVEN, True).to_bytes())


def _to_int_truncated(a: Word) -> Word:
    return Word.from_bytes(sf.f32_to_i32(a, sf.RoundingMode.MIN_MAG, True).to_bytes())


def _sine(sincos: SinCos, cosine: bool) -> Callable[[Word], Word]:
    def apply(a: Word) -> Word:
        result, raised = sincos(bits_of(a), cosine)
        _raise(raised)
        return word(result)

    return apply


ROUNDED: dict[str, Callable[..., Word]] = {
    "fma": sf.f32_mul_add,
    "mul": sf.f32_mul,
    "add": sf.f32_add,
    "div": sf.f32_div,
    "sqrt": sf.f32_sqrt,
    "from_int": _from_int,
    "to_int": _to_int,
    "to_int_truncated": _to_int_truncated,
}
"""Operations of `asip_asm.semantics` that raise their flags; sin and cos come with the model."""


class _Text:
    """Backend of `asip_asm.semantics`: Python text over words a, b, c and the names below."""

    names = {
        "word": word,
        "bits": bits_of,
        "nan": sf.f32_is_nan,
        "signalling": sf.f32_is_signaling_nan,
        "less": sf.f32_lt_quiet,
        "less_equal": sf.f32_le_quiet,
        "equal": sf.f32_eq,
    }
    compares = {"<": "less", "<=": "less_equal", "==": "equal"}

    def __init__(self) -> None:
        self.constants: dict[str, Word] = {}

    def operand(self, name: str) -> str:
        return name

    def constant(self, bits: int) -> str:
        name = f"k{bits:08x}"
        self.constants[name] = word(bits)
        return name

    def choose(self, truth: str, first: str, second: str) -> str:
        return f"({first} if {truth} else {second})"

    def both(self, *truths: str) -> str:
        return f"({' and '.join(truths)})"

    def either(self, *truths: str) -> str:
        return f"({' or '.join(truths)})"

    def negation(self, truth: str) -> str:
        return f"(not {truth})"

    def compare(self, operator: str, left: str, right: str) -> str:
        # SoftFloat's comparisons raise NV on a signalling NaN, those of the language nothing.
        numbers = [f"not nan({x})" for x in (left, right) if x not in self.constants]
        return f"({' and '.join([*numbers, f'{self.compares[operator]}({left}, {right})'])})"

    def test(self, name: str, word: str) -> str:
        return f"bits({word}) >> 31" if name == "negative" else f"{name}({word})"

    def bits(self, operator: str, left: str, right: str) -> str:
        return f"word(bits({left}) {operator} bits({right}))"

    def power(self, word: str) -> str:
        return f"word((bits({word}) + 127 & 255) << 23)"

    def rounded(self, name: str, words: Sequence[str]) -> str:
        return f"{name}({', '.join(words)})"


def operations(sincos: SinCos) -> dict[str, Callable[..., Word]]:
    """Every operation of isa.toml that computes a word, as its record says; operands in the order
    of the assembly. `sincos` gives sine and cosine.
    """
    rounded = {"sin": _sine(sincos, False), "cos": _sine(sincos, True)}
    return _without_sincos() | {record.name: compiled(record, rounded) for record in _of_sincos()}


@functools.cache
def _without_sincos() -> dict[str, Callable[..., Word]]:
    """Operations that are the same in all models."""
    records = default_isa().operations.values()
    plain = (record for record in records if record.result and record not in _of_sincos())
    return {record.name: compiled(record, ROUNDED) for record in plain}


@functools.cache
def _of_sincos() -> tuple[OperationRecord, ...]:
    """Operations that are a sine or a cosine."""
    records = default_isa().operations.values()
    return tuple(record for record in records if record.result.startswith(("sin(", "cos(")))


def compiled(
    record: OperationRecord, rounded: dict[str, Callable[..., Word]] = ROUNDED
) -> Callable[..., Word]:
    """What a record says, as a function of its operands in the order of the assembly."""
    operands = ", ".join(record.sources)
    backend = _Text()
    result = render(record.result, backend)
    for name, function in rounded.items():
        if result == f"{name}({operands})":  # nothing but a call: no need for one around it
            return function
    invalid = render(record.invalid, backend, truth=True) if record.invalid else ""
    text = f"def operation({operands}):\n"
    text += f"    if {invalid}:\n        raise_flags({NV})\n" if invalid else ""
    text += f"    return {result}\n"
    names: dict[str, object] = {"raise_flags": _raise, **_Text.names, **rounded}
    names |= backend.constants
    exec(text, names)  # checked by asip_asm.semantics: nothing but its own language
    return names["operation"]  # type: ignore[return-value]  # Defined by the text above.
