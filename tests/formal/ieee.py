# SPDX-License-Identifier: Apache-2.0
"""Specification: IEEE 754-2019 binary32 by the floating-point theory of SMT-LIB, flags included.

The theory gives results only (C. Barrett et al., SMT-LIB FloatingPoint). Flags follow from it:
inexact if rounding up and down differ, overflow if finite operands give infinity, tiny after
rounding if the result with the exponent range extended by four powers is below 2^-126.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from bitwuzla import Kind, RoundingMode, Term

from asip_asm.isa_records import OperationRecord
from asip_asm.semantics import render
from tests.formal import logic
from tests.formal.logic import RNE, RTN, RTP

CANON_NAN, PLUS_INF = 0x7FC00000, 0x7F800000
LEAST_NORMAL = 0x00800000
BINARY32 = (8, 24)
WIDE = (10, 24)  # same precision, exponents -510..511: products and quotients neither end there
Operation = Callable[[RoundingMode, tuple[int, int]], Term]


@dataclass(frozen=True)
class Outcome:
    """What a unit must deliver: a number (or, with `exact`, bits) and five flags."""

    number: Term
    flags: Term  # {nv, dz, of, uf, nx}
    exact: bool = False


# ---- operands ----
def _test(kind: Kind) -> Callable[[Term], Term]:
    """A test of a number, given by its encoding."""
    return lambda word: logic.op(kind, logic.number(word))


is_nan, is_infinite, is_zero = map(_test, (Kind.FP_IS_NAN, Kind.FP_IS_INF, Kind.FP_IS_ZERO))


def is_signalling(word: Term) -> Term:
    """Is a signalling NaN (clause 6.2.1: first fraction bit clear)."""
    return logic.all(is_nan(word), logic.no(logic.bit(word, 22)))


def all_finite(*operands: Term) -> Term:
    """All are finite."""
    return logic.all(*(logic.no(logic.any(is_nan(x), is_infinite(x))) for x in operands))


def any_signalling(*operands: Term) -> Term:
    """Any is a signalling NaN."""
    return logic.any(*(is_signalling(x) for x in operands))


# ---- results ----
def matches(result: Term, flags: Term, outcome: Outcome) -> Term:
    """Result and flags are those of the outcome; a NaN is the canonical one."""
    if outcome.exact:
        return logic.all(logic.eq(result, outcome.number), logic.eq(flags, outcome.flags))
    return logic.all(
        logic.ite(
            logic.op(Kind.FP_IS_NAN, outcome.number),
            logic.eq(result, CANON_NAN),
            logic.eq(logic.number(result), outcome.number),
        ),
        logic.eq(flags, outcome.flags),
    )


def raised(
    nv: Term | None = None,
    dz: Term | None = None,
    of: Term | None = None,
    uf: Term | None = None,
    nx: Term | None = None,
) -> Term:
    """Flag vector; flags not given are clear."""
    none = logic.false()
    return logic.vector(*(none if flag is None else flag for flag in (nv, dz, of, uf, nx)))


def widened(bits: Term, to: tuple[int, int]) -> Term:
    """The same number in another format that holds it."""
    number = logic.number(bits)
    if to == BINARY32:
        return number
    return logic.fp(Kind.FP_TO_FP_FROM_FP, RNE, number, indices=to)


def arithmetic(operation: Operation, operands: tuple[Term, ...], nv: Term) -> Outcome:
    """An operation to nearest even, all flags; `operation(mode, format)` computes it."""
    nearest, up, down = (operation(mode, BINARY32) for mode in (RNE, RTP, RTN))
    finite = all_finite(*operands)
    inexact = logic.all(finite, logic.no(nv), logic.no(logic.op(Kind.FP_EQUAL, up, down)))
    overflow = logic.all(finite, logic.op(Kind.FP_IS_INF, nearest))
    magnitude = logic.op(Kind.FP_ABS, operation(RNE, WIDE))
    least = widened(logic.bv(32, LEAST_NORMAL), WIDE)
    tiny = logic.op(Kind.FP_LT, magnitude, least)
    return Outcome(nearest, raised(nv, None, overflow, logic.all(tiny, inexact), inexact))


def scaled(sign: Term, magnitude: Term, exponent: Term, bias: int) -> Term:
    """The exact number (-1)^sign * magnitude * 2^(exponent + bias), in a format that holds it.

    `magnitude` and `exponent` are unsigned bit vectors; exponents up to 2^14 fit.
    """
    to = (16, max(logic.width(magnitude), 24))
    integer = logic.fp(Kind.FP_TO_FP_FROM_UBV, RNE, magnitude, indices=to)
    field = logic.add(logic.extend(exponent, 16), (1 << 15) - 1 + bias)
    power = logic.cat(logic.bv(1, 0), field, logic.bv(to[1] - 1, 0))
    product = logic.fp(Kind.FP_MUL, RNE, integer, logic.number(power, *to))
    negative = logic.eq(sign, 1)
    return logic.ite(negative, logic.op(Kind.FP_NEG, product), product)


def rounded(exact: Term) -> Outcome:
    """A number of a wider format rounded to binary32, with overflow, underflow and inexact."""

    def to(mode: RoundingMode, form: tuple[int, int]) -> Term:
        return logic.fp(Kind.FP_TO_FP_FROM_FP, mode, exact, indices=form)

    return arithmetic(to, (), logic.false())


def product(a: Term, b: Term, exact: Term, sign: Term) -> Outcome:
    """a * b from its `exact` value (a wide number), used where both are finite and not zero."""
    zeros, infinities = (logic.any(test(a), test(b)) for test in (is_zero, is_infinite))
    invalid = logic.any(any_signalling(a, b), logic.all(zeros, infinities))
    nan = logic.any(is_nan(a), is_nan(b), invalid)
    finite = rounded(exact)
    number = choose(
        (nan, CANON_NAN),
        (infinities, PLUS_INF),
        (zeros, 0),
        otherwise=finite.number,
        sign=sign,
    )
    special = logic.any(nan, infinities, zeros)
    return Outcome(number, logic.ite(special, raised(nv=invalid), finite.flags))


def product_sum(a: Term, b: Term, c: Term, exact: Term, signs: tuple[Term, Term]) -> Outcome:
    """(+-a * b) +- c from its `exact` value (a wide number), used where all are finite.

    `signs` are those of the product and of the addend, signs of the operands included. Zero
    times infinity raises nv whatever the addend, as clause 7.2 allows.
    """
    sign_p, sign_c = signs
    p_infinite = logic.any(is_infinite(a), is_infinite(b))
    undefined = logic.all(p_infinite, logic.any(is_zero(a), is_zero(b)))
    any_nan = logic.any(*(is_nan(x) for x in (a, b, c)))
    opposite = logic.all(p_infinite, is_infinite(c), logic.ne(sign_p, sign_c))
    invalid = logic.any(any_signalling(a, b, c), undefined, logic.all(opposite, logic.no(any_nan)))
    infinity = logic.bv(31, 0x7F800000)
    infinite = logic.cat(logic.ite(p_infinite, sign_p, sign_c), infinity)
    # Clause 6.3: an exact zero sum is +0 unless both addends have the sign -.
    zero = logic.cat(logic.op(Kind.BV_AND, sign_p, sign_c), logic.bv(31, 0))
    finite = rounded(exact)
    nothing = logic.op(Kind.FP_IS_ZERO, exact)
    ordinary = all_finite(a, b, c)
    number = logic.ite(
        logic.any(any_nan, invalid),
        logic.number(logic.bv(32, CANON_NAN)),
        logic.ite(
            logic.no(ordinary),
            logic.number(infinite),
            logic.ite(nothing, logic.number(zero), finite.number),
        ),
    )
    return Outcome(number, logic.ite(ordinary, finite.flags, raised(nv=invalid)))


def choose(*choices: tuple[Term, int], otherwise: Term, sign: Term) -> Term:
    """The first choice whose condition holds: a signed zero or infinity, or the NaN."""
    for condition, bits in reversed(choices):
        nan = bits == CANON_NAN
        value = logic.bv(32, bits) if nan else logic.cat(sign, logic.bv(31, bits))
        otherwise = logic.ite(condition, logic.number(value), otherwise)
    return otherwise


def quotient(a: Term, b: Term, exact: Term, sign: Term) -> Outcome:
    """a / b from its `exact` value (a wide number), used where both are finite, not zero."""
    a_zero, b_zero, a_inf, b_inf = (test(x) for test in (is_zero, is_infinite) for x in (a, b))
    undefined = logic.any(logic.all(a_zero, b_zero), logic.all(a_inf, b_inf))
    invalid = logic.any(any_signalling(a, b), undefined)
    nan = logic.any(is_nan(a), is_nan(b), undefined)
    by_zero = logic.all(b_zero, all_finite(a), logic.no(a_zero))
    finite = rounded(exact)
    number = choose(
        (nan, CANON_NAN),
        (logic.any(a_inf, b_zero), PLUS_INF),
        (logic.any(a_zero, b_inf), 0),
        otherwise=finite.number,
        sign=sign,
    )
    special = logic.any(nan, a_inf, b_inf, a_zero, b_zero)
    flags = logic.ite(special, raised(nv=invalid, dz=by_zero), finite.flags)
    return Outcome(number, flags)


def root(a: Term, exact: Term) -> Outcome:
    """Square root of a from its `exact` value, used where a is finite and positive."""
    zero, nan, infinite = is_zero(a), is_nan(a), is_infinite(a)
    negative = logic.all(logic.bit(a, 31), logic.no(logic.any(nan, zero)))
    finite = rounded(exact)
    number = choose(
        (logic.any(nan, negative), CANON_NAN),
        (infinite, PLUS_INF),
        (zero, 0),  # keeps its sign
        otherwise=finite.number,
        sign=logic.bits(a, 31, 31),
    )
    special = logic.any(nan, negative, infinite, zero)
    invalid = raised(nv=logic.any(any_signalling(a), negative))
    return Outcome(number, logic.ite(special, invalid, finite.flags))


# ---- operations ----
def add(a: Term, b: Term) -> Outcome:
    """a + b"""
    invalid = logic.any(
        any_signalling(a, b),
        logic.all(
            is_infinite(a),
            is_infinite(b),
            logic.ne(logic.bits(a, 31, 31), logic.bits(b, 31, 31)),
        ),
    )
    return arithmetic(
        lambda mode, to: logic.fp(Kind.FP_ADD, mode, widened(a, to), widened(b, to)),
        (a, b),
        invalid,
    )


def from_integer(a: Term, signed: bool) -> Outcome:
    """32-bit integer to binary32."""
    kind = Kind.FP_TO_FP_FROM_SBV if signed else Kind.FP_TO_FP_FROM_UBV
    near, up, down = (logic.fp(kind, mode, a, indices=BINARY32) for mode in (RNE, RTP, RTN))
    return Outcome(near, raised(nx=logic.no(logic.op(Kind.FP_EQUAL, up, down))))


def to_integer(a: Term, mode: RoundingMode) -> Outcome:
    """binary32 to int32, saturating; NaN gives the greatest integer (as RISC-V fcvt.w.s)."""
    number = logic.number(a)
    integral = logic.fp(Kind.FP_RTI, mode, number)
    low, high = (logic.number(logic.bv(32, bits)) for bits in (0xCF000000, 0x4F000000))
    inside = logic.all(logic.op(Kind.FP_LEQ, low, integral), logic.op(Kind.FP_LT, integral, high))
    below = logic.op(Kind.FP_LT, integral, low)
    value = logic.ite(
        inside,
        logic.fp(Kind.FP_TO_SBV, mode, number, indices=(32,)),
        logic.ite(below, logic.bv(32, 1 << 31), logic.bv(32, (1 << 31) - 1)),
    )
    inexact = logic.all(inside, logic.no(logic.op(Kind.FP_EQUAL, integral, number)))
    return Outcome(value, raised(nv=logic.no(inside), nx=inexact), exact=True)


def computed(record: OperationRecord, **operands: Term) -> Outcome:
    """What the record of an operation of fp_cmp says, in the theory of floating point."""
    backend = _Terms(operands)
    invalid = render(record.invalid, backend, truth=True) if record.invalid else None
    return Outcome(render(record.result, backend), raised(nv=invalid), exact=True)


class _Terms:
    """Backend of `asip_asm.semantics`: terms of the solver."""

    compares = {"<": Kind.FP_LT, "<=": Kind.FP_LEQ, "==": Kind.FP_EQUAL}
    words = {
        **{"&": Kind.BV_AND, "|": Kind.BV_OR, "^": Kind.BV_XOR},
        **{"+": Kind.BV_ADD, "-": Kind.BV_SUB},
    }

    choose, negation = staticmethod(logic.ite), staticmethod(logic.no)
    both, either = staticmethod(logic.all), staticmethod(logic.any)

    def __init__(self, operands: Mapping[str, Term]) -> None:
        self.operands = operands

    def operand(self, name: str) -> Term:
        return self.operands[name]

    def constant(self, bits: int) -> Term:
        return logic.bv(32, bits)

    def compare(self, operator: str, left: Term, right: Term) -> Term:
        numbers = logic.number(left), logic.number(right)
        return logic.op(self.compares[operator], *numbers)

    def test(self, name: str, word: Term) -> Term:
        if name == "negative":
            return logic.bit(word, 31)
        return {"nan": is_nan, "signalling": is_signalling}[name](word)

    def bits(self, operator: str, left: Term, right: Term) -> Term:
        return logic.op(self.words[operator], left, right)

    def rounded(self, name: str, words: Sequence[Term]) -> Term:
        raise NotImplementedError(f"{name} is proved in pieces, see products, sums, recurrence")
