# SPDX-License-Identifier: Apache-2.0
"""Terms of the Bitwuzla solver with the operators that the proofs need.

Bit vectors are `Term`s of sort `(_ BitVec n)`, truth values of sort `Bool`, numbers of an SMT-LIB
`FloatingPoint` sort (IEEE 754 as the standard theory of SMT-LIB defines it).
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce

from bitwuzla import Kind, RoundingMode, Sort, Term, TermManager

RNE, RTP, RTN, RTZ = RoundingMode.RNE, RoundingMode.RTP, RoundingMode.RTN, RoundingMode.RTZ


class Logic:
    """Term builder. Widths follow the operands; no implicit extension."""

    def __init__(self) -> None:
        self.tm = TermManager()
        self._fp: dict[tuple[int, int], Sort] = {}

    # ---- bit vectors ----
    def free(self, width: int, name: str) -> Term:
        """Unconstrained bit vector."""
        return self.tm.mk_const(self.tm.mk_bv_sort(width), name)

    def bv(self, width: int, value: int) -> Term:
        """Constant, modulo 2^width."""
        return self.tm.mk_bv_value(self.tm.mk_bv_sort(width), str(value % (1 << width)), 10)

    def op(self, kind: Kind, *terms: Term, indices: Iterable[int] = ()) -> Term:
        """Any operator of the solver."""
        return self.tm.mk_term(kind, list(terms), list(indices))

    def width(self, term: Term) -> int:
        """Number of bits of a bit vector."""
        return term.sort().bv_size()

    def bits(self, term: Term, high: int, low: int) -> Term:
        """term[high:low]"""
        return self.op(Kind.BV_EXTRACT, term, indices=(high, low))

    def bit(self, term: Term, index: int) -> Term:
        """term[index] as a truth value."""
        return self.eq(self.bits(term, index, index), self.bv(1, 1))

    def cat(self, *terms: Term) -> Term:
        """Concatenation, most significant part first."""
        return reduce(lambda high, low: self.op(Kind.BV_CONCAT, high, low), terms)

    def extend(self, term: Term, width: int) -> Term:
        """Zero extension to so many bits."""
        return self.op(Kind.BV_ZERO_EXTEND, term, indices=(width - self.width(term),))

    def sign_extend(self, term: Term, width: int) -> Term:
        """Sign extension to so many bits."""
        return self.op(Kind.BV_SIGN_EXTEND, term, indices=(width - self.width(term),))

    def add(self, *terms: Term) -> Term:
        """Sum modulo 2^width."""
        return reduce(lambda x, y: self.op(Kind.BV_ADD, x, y), terms)

    def sub(self, x: Term, y: Term) -> Term:
        """Difference modulo 2^width."""
        return self.op(Kind.BV_SUB, x, y)

    def shl(self, term: Term, amount: Term | int) -> Term:
        """Left shift."""
        by = self.bv(self.width(term), amount) if isinstance(amount, int) else amount
        return self.op(Kind.BV_SHL, term, by)

    def shr(self, term: Term, amount: Term | int) -> Term:
        """Logical right shift."""
        by = self.bv(self.width(term), amount) if isinstance(amount, int) else amount
        return self.op(Kind.BV_SHR, term, by)

    def ult(self, x: Term, y: Term | int) -> Term:
        """x < y, unsigned."""
        return self.op(Kind.BV_ULT, x, self.bv(self.width(x), y) if isinstance(y, int) else y)

    def ule(self, x: Term, y: Term | int) -> Term:
        """x <= y, unsigned."""
        return self.op(Kind.BV_ULE, x, self.bv(self.width(x), y) if isinstance(y, int) else y)

    def slt(self, x: Term, y: Term | int) -> Term:
        """x < y, signed."""
        return self.op(Kind.BV_SLT, x, self.bv(self.width(x), y) if isinstance(y, int) else y)

    def sle(self, x: Term, y: Term | int) -> Term:
        """x <= y, signed."""
        return self.op(Kind.BV_SLE, x, self.bv(self.width(x), y) if isinstance(y, int) else y)

    def neg(self, term: Term) -> Term:
        """-term modulo 2^width."""
        return self.op(Kind.BV_NEG, term)

    def vector(self, *truths: Term) -> Term:
        """Truth values as bits, most significant first."""
        one, zero = self.bv(1, 1), self.bv(1, 0)
        return self.cat(*(self.ite(truth, one, zero) for truth in truths))

    # ---- truth values ----
    def true(self) -> Term:
        """The truth value."""
        return self.tm.mk_true()

    def implies(self, x: Term, y: Term) -> Term:
        """Not x, or y."""
        return self.op(Kind.IMPLIES, x, y)

    def eq(self, x: Term, y: Term | int) -> Term:
        """Identity (of numbers too: NaN equals NaN, +0 differs from -0)."""
        return self.op(Kind.EQUAL, x, self.bv(self.width(x), y) if isinstance(y, int) else y)

    def ne(self, x: Term, y: Term | int) -> Term:
        """Not identical."""
        return self.no(self.eq(x, y))

    def no(self, x: Term) -> Term:
        """Negation."""
        return self.op(Kind.NOT, x)

    def all(self, *truths: Term) -> Term:
        """Conjunction."""
        return reduce(lambda x, y: self.op(Kind.AND, x, y), truths, self.tm.mk_true())

    def any(self, *truths: Term) -> Term:
        """Disjunction."""
        return reduce(lambda x, y: self.op(Kind.OR, x, y), truths, self.tm.mk_false())

    def ite(self, condition: Term, then: Term, other: Term) -> Term:
        """Selection."""
        return self.op(Kind.ITE, condition, then, other)

    # ---- numbers ----
    def format(self, exponent: int, significand: int) -> Sort:
        """FloatingPoint sort; `significand` counts the hidden bit."""
        key = (exponent, significand)
        if key not in self._fp:
            self._fp[key] = self.tm.mk_fp_sort(*key)
        return self._fp[key]

    def number(self, bits: Term, exponent: int = 8, significand: int = 24) -> Term:
        """Number with this IEEE encoding."""
        return self.op(Kind.FP_TO_FP_FROM_BV, bits, indices=(exponent, significand))

    def rounding(self, mode: RoundingMode) -> Term:
        """Rounding mode."""
        return self.tm.mk_rm_value(mode)

    def fp(self, kind: Kind, mode: RoundingMode, *terms: Term, indices: Iterable[int] = ()) -> Term:
        """Rounded operation: FP_ADD, FP_MUL, FP_TO_FP_FROM_FP, ..."""
        return self.op(kind, self.rounding(mode), *terms, indices=indices)
