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
from tests.formal.logic import RNE, RTN, RTP, Logic

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


class Ieee:
    """Specifications over one `Logic`."""

    def __init__(self, logic: Logic) -> None:
        self.logic = logic

    # ---- operands ----
    def nan(self, bits: Term) -> Term:
        """Is a NaN."""
        return self.logic.op(Kind.FP_IS_NAN, self.logic.number(bits))

    def signalling(self, bits: Term) -> Term:
        """Is a signalling NaN (clause 6.2.1: first fraction bit clear)."""
        return self.logic.all(self.nan(bits), self.logic.no(self.logic.bit(bits, 22)))

    def infinite(self, bits: Term) -> Term:
        """Is an infinity."""
        return self.logic.op(Kind.FP_IS_INF, self.logic.number(bits))

    def zero(self, bits: Term) -> Term:
        """Is +0 or -0."""
        return self.logic.op(Kind.FP_IS_ZERO, self.logic.number(bits))

    def finite(self, *operands: Term) -> Term:
        """All are finite."""
        logic = self.logic
        return logic.all(*(logic.no(logic.any(self.nan(x), self.infinite(x))) for x in operands))

    def signal(self, *operands: Term) -> Term:
        """Any is a signalling NaN."""
        return self.logic.any(*(self.signalling(x) for x in operands))

    # ---- results ----
    def matches(self, result: Term, flags: Term, outcome: Outcome) -> Term:
        """Result and flags are those of the outcome; a NaN is the canonical one."""
        logic = self.logic
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

    def flags(
        self,
        nv: Term | None = None,
        dz: Term | None = None,
        of: Term | None = None,
        uf: Term | None = None,
        nx: Term | None = None,
    ) -> Term:
        """Flag vector; flags not given are clear."""
        none = self.logic.tm.mk_false()
        return self.logic.vector(*(none if f is None else f for f in (nv, dz, of, uf, nx)))

    def widened(self, bits: Term, to: tuple[int, int]) -> Term:
        """The same number in another format that holds it."""
        number = self.logic.number(bits)
        if to == BINARY32:
            return number
        return self.logic.fp(Kind.FP_TO_FP_FROM_FP, RNE, number, indices=to)

    def arithmetic(
        self, operation: Operation, operands: tuple[Term, ...], nv: Term, dz: Term | None = None
    ) -> Outcome:
        """An operation to nearest even, all flags; `operation(mode, format)` computes it."""
        logic = self.logic
        nearest, up, down = (operation(mode, BINARY32) for mode in (RNE, RTP, RTN))
        finite = self.finite(*operands)
        inexact = logic.all(finite, logic.no(nv), logic.no(logic.op(Kind.FP_EQUAL, up, down)))
        overflow = logic.all(finite, logic.op(Kind.FP_IS_INF, nearest))
        if dz is not None:
            overflow = logic.all(overflow, logic.no(dz))
        magnitude = logic.op(Kind.FP_ABS, operation(RNE, WIDE))
        least = self.widened(logic.bv(32, LEAST_NORMAL), WIDE)
        tiny = logic.op(Kind.FP_LT, magnitude, least)
        return Outcome(nearest, self.flags(nv, dz, overflow, logic.all(tiny, inexact), inexact))

    def scaled(self, sign: Term, magnitude: Term, exponent: Term, bias: int) -> Term:
        """The exact number (-1)^sign * magnitude * 2^(exponent + bias), in a format that holds it.

        `magnitude` and `exponent` are unsigned bit vectors; exponents up to 2^14 fit.
        """
        logic = self.logic
        to = (16, max(logic.width(magnitude), 24))
        integer = logic.fp(Kind.FP_TO_FP_FROM_UBV, RNE, magnitude, indices=to)
        field = logic.add(logic.extend(exponent, 16), logic.bv(16, (1 << 15) - 1 + bias))
        power = logic.cat(logic.bv(1, 0), field, logic.bv(to[1] - 1, 0))
        product = logic.fp(Kind.FP_MUL, RNE, integer, logic.number(power, *to))
        negative = logic.eq(sign, 1)
        return logic.ite(negative, logic.op(Kind.FP_NEG, product), product)

    def rounded(self, exact: Term) -> Outcome:
        """A number of a wider format rounded to binary32, with overflow, underflow and inexact."""
        logic = self.logic

        def to(mode: RoundingMode, form: tuple[int, int]) -> Term:
            return logic.fp(Kind.FP_TO_FP_FROM_FP, mode, exact, indices=form)

        return self.arithmetic(to, (), logic.tm.mk_false())

    def product(self, a: Term, b: Term, exact: Term, sign: Term) -> Outcome:
        """a * b from its `exact` value (a wide number), used where both are finite and not zero."""
        logic = self.logic
        zeros, infinities = (logic.any(test(a), test(b)) for test in (self.zero, self.infinite))
        invalid = logic.any(self.signal(a, b), logic.all(zeros, infinities))
        nan = logic.any(self.nan(a), self.nan(b), invalid)
        finite = self.rounded(exact)
        number = self.choose(
            (nan, CANON_NAN),
            (infinities, PLUS_INF),
            (zeros, 0),
            otherwise=finite.number,
            sign=sign,
        )
        special = logic.any(nan, infinities, zeros)
        return Outcome(number, logic.ite(special, self.flags(nv=invalid), finite.flags))

    def product_sum(
        self, a: Term, b: Term, c: Term, exact: Term, signs: tuple[Term, Term]
    ) -> Outcome:
        """(+-a * b) +- c from its `exact` value (a wide number), used where all are finite.

        `signs` are those of the product and of the addend, signs of the operands included. Zero
        times infinity raises nv whatever the addend, as clause 7.2 allows.
        """
        logic = self.logic
        sign_p, sign_c = signs
        p_infinite = logic.any(self.infinite(a), self.infinite(b))
        undefined = logic.all(p_infinite, logic.any(self.zero(a), self.zero(b)))
        any_nan = logic.any(*(self.nan(x) for x in (a, b, c)))
        opposite = logic.all(p_infinite, self.infinite(c), logic.ne(sign_p, sign_c))
        invalid = logic.any(self.signal(a, b, c), undefined, logic.all(opposite, logic.no(any_nan)))
        infinity = logic.bv(31, 0x7F800000)
        infinite = logic.cat(logic.ite(p_infinite, sign_p, sign_c), infinity)
        # Clause 6.3: an exact zero sum is +0 unless both addends have the sign -.
        zero = logic.cat(logic.op(Kind.BV_AND, sign_p, sign_c), logic.bv(31, 0))
        finite = self.rounded(exact)
        is_zero = logic.op(Kind.FP_IS_ZERO, exact)
        all_finite = self.finite(a, b, c)
        number = logic.ite(
            logic.any(any_nan, invalid),
            logic.number(logic.bv(32, CANON_NAN)),
            logic.ite(
                logic.no(all_finite),
                logic.number(infinite),
                logic.ite(is_zero, logic.number(zero), finite.number),
            ),
        )
        return Outcome(number, logic.ite(all_finite, finite.flags, self.flags(nv=invalid)))

    def choose(self, *choices: tuple[Term, int], otherwise: Term, sign: Term) -> Term:
        """The first choice whose condition holds: a signed zero or infinity, or the NaN."""
        logic = self.logic
        for condition, bits in reversed(choices):
            nan = bits == CANON_NAN
            value = logic.bv(32, bits) if nan else logic.cat(sign, logic.bv(31, bits))
            otherwise = logic.ite(condition, logic.number(value), otherwise)
        return otherwise

    def quotient(self, a: Term, b: Term, exact: Term, sign: Term) -> Outcome:
        """a / b from its `exact` value (a wide number), used where both are finite, not zero."""
        logic = self.logic
        a_zero, b_zero, a_inf, b_inf = (
            test(x) for test in (self.zero, self.infinite) for x in (a, b)
        )
        undefined = logic.any(logic.all(a_zero, b_zero), logic.all(a_inf, b_inf))
        invalid = logic.any(self.signal(a, b), undefined)
        nan = logic.any(self.nan(a), self.nan(b), undefined)
        by_zero = logic.all(b_zero, self.finite(a), logic.no(a_zero))
        finite = self.rounded(exact)
        number = self.choose(
            (nan, CANON_NAN),
            (logic.any(a_inf, b_zero), PLUS_INF),
            (logic.any(a_zero, b_inf), 0),
            otherwise=finite.number,
            sign=sign,
        )
        special = logic.any(nan, a_inf, b_inf, a_zero, b_zero)
        flags = logic.ite(special, self.flags(nv=invalid, dz=by_zero), finite.flags)
        return Outcome(number, flags)

    def root(self, a: Term, exact: Term) -> Outcome:
        """Square root of a from its `exact` value, used where a is finite and positive."""
        logic = self.logic
        zero, nan, infinite = self.zero(a), self.nan(a), self.infinite(a)
        negative = logic.all(logic.bit(a, 31), logic.no(logic.any(nan, zero)))
        finite = self.rounded(exact)
        number = self.choose(
            (logic.any(nan, negative), CANON_NAN),
            (infinite, PLUS_INF),
            (zero, 0),  # keeps its sign
            otherwise=finite.number,
            sign=logic.bits(a, 31, 31),
        )
        special = logic.any(nan, negative, infinite, zero)
        invalid = self.flags(nv=logic.any(self.signal(a), negative))
        return Outcome(number, logic.ite(special, invalid, finite.flags))

    # ---- operations ----
    def add(self, a: Term, b: Term) -> Outcome:
        """a + b"""
        logic = self.logic
        invalid = logic.any(
            self.signal(a, b),
            logic.all(
                self.infinite(a),
                self.infinite(b),
                logic.ne(logic.bits(a, 31, 31), logic.bits(b, 31, 31)),
            ),
        )
        return self.arithmetic(
            lambda mode, to: logic.fp(Kind.FP_ADD, mode, self.widened(a, to), self.widened(b, to)),
            (a, b),
            invalid,
        )

    def from_integer(self, a: Term, signed: bool) -> Outcome:
        """32-bit integer to binary32."""
        logic = self.logic
        kind = Kind.FP_TO_FP_FROM_SBV if signed else Kind.FP_TO_FP_FROM_UBV
        near, up, down = (logic.fp(kind, mode, a, indices=BINARY32) for mode in (RNE, RTP, RTN))
        return Outcome(near, self.flags(nx=logic.no(logic.op(Kind.FP_EQUAL, up, down))))

    def to_integer(self, a: Term, mode: RoundingMode) -> Outcome:
        """binary32 to int32, saturating; NaN gives the greatest integer (as RISC-V fcvt.w.s)."""
        logic = self.logic
        number = logic.number(a)
        integral = logic.fp(Kind.FP_RTI, mode, number)
        low, high = (logic.number(logic.bv(32, bits)) for bits in (0xCF000000, 0x4F000000))
        inside = logic.all(
            logic.op(Kind.FP_LEQ, low, integral), logic.op(Kind.FP_LT, integral, high)
        )
        below = logic.op(Kind.FP_LT, integral, low)
        value = logic.ite(
            inside,
            logic.fp(Kind.FP_TO_SBV, mode, number, indices=(32,)),
            logic.ite(below, logic.bv(32, 1 << 31), logic.bv(32, (1 << 31) - 1)),
        )
        inexact = logic.all(inside, logic.no(logic.op(Kind.FP_EQUAL, integral, number)))
        return Outcome(value, self.flags(nv=logic.no(inside), nx=inexact), exact=True)

    def computed(self, record: OperationRecord, **operands: Term) -> Outcome:
        """What the record of an operation of fp_cmp says, in the theory of floating point."""
        backend = _Terms(self, operands)
        invalid = render(record.invalid, backend, truth=True) if record.invalid else None
        return Outcome(render(record.result, backend), self.flags(nv=invalid), exact=True)


class _Terms:
    """Backend of `asip_asm.semantics`: terms of the solver."""

    compares = {"<": Kind.FP_LT, "<=": Kind.FP_LEQ, "==": Kind.FP_EQUAL}
    words = {
        **{"&": Kind.BV_AND, "|": Kind.BV_OR, "^": Kind.BV_XOR},
        **{"+": Kind.BV_ADD, "-": Kind.BV_SUB},
    }

    def __init__(self, ieee: Ieee, operands: Mapping[str, Term]) -> None:
        self.ieee, self.logic, self.operands = ieee, ieee.logic, operands
        self.choose, self.both = self.logic.ite, self.logic.all
        self.either, self.negation = self.logic.any, self.logic.no

    def operand(self, name: str) -> Term:
        return self.operands[name]

    def constant(self, bits: int) -> Term:
        return self.logic.bv(32, bits)

    def compare(self, operator: str, left: Term, right: Term) -> Term:
        numbers = self.logic.number(left), self.logic.number(right)
        return self.logic.op(self.compares[operator], *numbers)

    def test(self, name: str, word: Term) -> Term:
        if name == "negative":
            return self.logic.bit(word, 31)
        return {"nan": self.ieee.nan, "signalling": self.ieee.signalling}[name](word)

    def bits(self, operator: str, left: Term, right: Term) -> Term:
        return self.logic.op(self.words[operator], left, right)

    def rounded(self, name: str, words: Sequence[Term]) -> Term:
        raise NotImplementedError(f"{name} is proved in pieces, see products, sums, recurrence")
