# SPDX-License-Identifier: Apache-2.0
"""Terms of the Bitwuzla solver with the operators that the proofs need.

Bit vectors are `Term`s of sort `(_ BitVec n)`, truth values of sort `Bool`, numbers of an SMT-LIB
`FloatingPoint` sort (IEEE 754 as the standard theory of SMT-LIB defines it). Widths follow the
operands; there is no implicit extension. All terms of a process have one manager, `TERMS`, which
has to outlive them: no module keeps a term.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial, reduce

from bitwuzla import Kind, RoundingMode, Term, TermManager

RNE, RTP, RTN, RTZ = RoundingMode.RNE, RoundingMode.RTP, RoundingMode.RTN, RoundingMode.RTZ
TERMS = TermManager()


def op(kind: Kind, *terms: Term, indices: Iterable[int] = ()) -> Term:
    """Any operator of the solver."""
    return TERMS.mk_term(kind, list(terms), list(indices))


def free(width: int, name: str) -> Term:
    """Unconstrained bit vector."""
    return TERMS.mk_const(TERMS.mk_bv_sort(width), name)


def bv(width: int, value: int) -> Term:
    """Constant, modulo 2^width."""
    return TERMS.mk_bv_value(TERMS.mk_bv_sort(width), str(value % (1 << width)), 10)


def width(term: Term) -> int:
    """Number of bits of a bit vector."""
    return term.sort().bv_size()


def _binary(kind: Kind) -> Callable[[Term, Term | int], Term]:
    """An operator of two operands. The second may be a number: it gets the width of the first."""

    def apply(x: Term, y: Term | int) -> Term:
        return op(kind, x, bv(width(x), y) if isinstance(y, int) else y)

    return apply


eq = _binary(Kind.EQUAL)  # identity, of numbers too: NaN equals NaN, +0 differs from -0
sub, mul = _binary(Kind.BV_SUB), _binary(Kind.BV_MUL)  # modulo 2^width
xor = _binary(Kind.BV_XOR)
shl, shr = _binary(Kind.BV_SHL), _binary(Kind.BV_SHR)  # shifts, the right one logical
ult, ule = _binary(Kind.BV_ULT), _binary(Kind.BV_ULE)  # x < y, x <= y, unsigned
slt, sle = _binary(Kind.BV_SLT), _binary(Kind.BV_SLE)  # x < y, x <= y, signed
neg = partial(op, Kind.BV_NEG)  # modulo 2^width
no = partial(op, Kind.NOT)
implies = partial(op, Kind.IMPLIES)
ite = partial(op, Kind.ITE)  # condition, then, other


# ---- bit vectors ----
def bits(term: Term, high: int, low: int) -> Term:
    """term[high:low]"""
    return op(Kind.BV_EXTRACT, term, indices=(high, low))


def bit(term: Term, index: int) -> Term:
    """term[index] as a truth value."""
    return eq(bits(term, index, index), 1)


def cat(*terms: Term) -> Term:
    """Concatenation, most significant part first."""
    return reduce(partial(op, Kind.BV_CONCAT), terms)


def add(*terms: Term | int) -> Term:
    """Sum modulo 2^width."""
    return reduce(_binary(Kind.BV_ADD), terms)


def extend(term: Term, to: int) -> Term:
    """Zero extension to so many bits."""
    return op(Kind.BV_ZERO_EXTEND, term, indices=(to - width(term),))


def sign_extend(term: Term, to: int) -> Term:
    """Sign extension to so many bits."""
    return op(Kind.BV_SIGN_EXTEND, term, indices=(to - width(term),))


def vector(*truths: Term) -> Term:
    """Truth values as bits, most significant first."""
    one, zero = bv(1, 1), bv(1, 0)
    return cat(*(ite(truth, one, zero) for truth in truths))


# ---- truth values ----
true, false = TERMS.mk_true, TERMS.mk_false


def ne(x: Term, y: Term | int) -> Term:
    """Not identical."""
    return no(eq(x, y))


def all(*truths: Term) -> Term:
    """Conjunction."""
    return reduce(partial(op, Kind.AND), truths, true())


def any(*truths: Term) -> Term:
    """Disjunction."""
    return reduce(partial(op, Kind.OR), truths, false())


# ---- numbers ----
def number(word: Term, exponent: int = 8, significand: int = 24) -> Term:
    """Number with this IEEE encoding; `significand` counts the hidden bit."""
    return op(Kind.FP_TO_FP_FROM_BV, word, indices=(exponent, significand))


def fp(kind: Kind, mode: RoundingMode, *terms: Term, indices: Iterable[int] = ()) -> Term:
    """Rounded operation: FP_ADD, FP_MUL, FP_TO_FP_FROM_FP, ..."""
    return op(kind, TERMS.mk_rm_value(mode), *terms, indices=indices)
