# SPDX-License-Identifier: Apache-2.0
"""Whole numbers over bit vectors: sums and comparisons that cannot overflow.

An `Int` is a signed bit vector; the results of its operators have as many bits as they need, so a
specification written with them is about integers. `bits` cuts to a width, for registers of an
observer whose range an invariant bounds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bitwuzla import Term

from tests.formal import logic


@dataclass(frozen=True, eq=False)
class Int:
    """A whole number, two's complement."""

    term: Term

    @classmethod
    def unsigned(cls, term: Term) -> Int:
        """Value of a bit vector without sign."""
        return cls(logic.extend(term, logic.width(term) + 1))

    @classmethod
    def count(cls, truth: Truth) -> Int:
        """1 if it is true, else 0."""
        return cls.unsigned(logic.vector(truth.term))

    def _pair(self, other: Int | int, spare: int = 0) -> tuple[Term, Term]:
        if isinstance(other, int):
            other = Int(logic.bv(other.bit_length() + 1, other))
        width = max(logic.width(self.term), logic.width(other.term)) + spare
        return logic.sign_extend(self.term, width), logic.sign_extend(other.term, width)

    def __add__(self, other: Int | int) -> Int:
        return Int(logic.add(*self._pair(other, 1)))

    def __sub__(self, other: Int | int) -> Int:
        return Int(logic.sub(*self._pair(other, 1)))

    def __neg__(self) -> Int:
        return Int(logic.neg(self._pair(0, 1)[0]))

    def twice(self) -> Int:
        """2 x"""
        return Int(logic.cat(self.term, logic.bv(1, 0)))

    def size(self) -> Int:
        """Its magnitude."""
        return (self < 0).ite(-self, self)

    def bits(self, width: int) -> Term:
        """Modulo 2^width."""
        if logic.width(self.term) < width:
            return logic.sign_extend(self.term, width)
        return logic.bits(self.term, width - 1, 0)

    def __lt__(self, other: Int | int) -> Truth:
        return Truth(logic.slt(*self._pair(other)))

    def __le__(self, other: Int | int) -> Truth:
        return Truth(logic.sle(*self._pair(other)))

    def __gt__(self, other: Int | int) -> Truth:
        return ~(self <= other)

    def __ge__(self, other: Int | int) -> Truth:
        return ~(self < other)

    def same(self, other: Int | int) -> Truth:
        """Equality (`==` stays that of Python objects)."""
        return Truth(logic.eq(*self._pair(other)))


@dataclass(frozen=True, eq=False)
class Truth:
    """A truth value with operators; `term` is what the solver gets."""

    term: Term

    def __and__(self, other: Truth) -> Truth:
        return Truth(logic.all(self.term, other.term))

    def __or__(self, other: Truth) -> Truth:
        return Truth(logic.any(self.term, other.term))

    def __invert__(self) -> Truth:
        return Truth(logic.no(self.term))

    def implies(self, other: Truth) -> Truth:
        """Not this, or the other."""
        return ~self | other

    def matches(self, other: Truth) -> Truth:
        """Both or neither."""
        return Truth(logic.eq(self.term, other.term))

    def ite(self, then: Int, other: Int | int) -> Int:
        """One of two numbers."""
        return Int(logic.ite(self.term, *then._pair(other)))

    def pick(self, then: Truth, other: Truth) -> Truth:
        """One of two truths."""
        return Truth(logic.ite(self.term, then.term, other.term))


def always() -> Truth:
    """Truth itself."""
    return Truth(logic.true())


def signed(values: Mapping[str, Term], *names: str) -> list[Int]:
    """Some of the values, which have a sign."""
    return [Int(values[name]) for name in names]


def flag(term: Term) -> Truth:
    """Whether a bit is 1."""
    return Truth(logic.eq(term, 1))
