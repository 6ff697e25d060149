# SPDX-License-Identifier: Apache-2.0
"""Proofs of fp_divsqrt: the digit recurrence stage by stage, and rounding of its outcome.

Integers of entry s, in front of digit stage s, k = 2s digits known: remainder R, digits Q, divisor
D. `recurrence_start` proves the values of entry 0, `recurrence_stages` that every stage keeps the
invariant

    quotient: 2^k R0 = Q D + R,             R < D                          D = 8 sb, R0 = 4 sa
    root:     2^k R0 = Q^2 2^(26-k) + R,    R < (2 Q + 1) 2^(26-k)         D = (4 Q + 1) 2^(25-k)

(sa, sb: significands of 24 bits with leading one; R0 = 2 sa or 4 sa for roots). `numbers` has what
follows for the digits. `recurrence_rounded` proves that the unit rounds Q and R correctly.
"""

from __future__ import annotations

from collections.abc import Iterator

from bitwuzla import Term

from tests.formal import ieee, logic
from tests.formal.catalogue import Case, Context, delivers, exponent_of, proof, significand_of
from tests.formal.ieee import Outcome
from tests.formal.netlist import Run
from tests.fpu.tb import package_constant

STAGES = 13
ENTERED = (
    package_constant("FP_DIVSQRT_LATENCY") - STAGES - 1
)  # cycle that entry 0 holds operands in
DIGITS, REMAINDER, DIVISOR = ("digits_q", 24), ("remainder", 27), ("divisor_q", 27)
ROOM = 60  # bits that hold every integer here


def entry(run: Run, register: tuple[str, int], stage: int, cycle: int) -> Term:
    """Register of an entry as a number of ROOM bits."""
    name, width = register
    bits = logic.bits(run.signal(name, cycle), width * (stage + 1) - 1, width * stage)
    return logic.extend(bits, ROOM)


def square_step(digits: Term, new: int, k: int) -> Term:
    """((4 Q + q)^2 - 16 Q^2) 2^(24-k) = (8 Q q + q^2) 2^(24-k)"""
    inner = logic.add(logic.mul(digits, 8 * new), new * new)
    return logic.shl(inner, 24 - k)


def steps_of(root: bool, q: Term, d: Term, k: int) -> list[Term]:
    """What the digits 0 to 3 after k others take off 4 R; d is the divisor of a quotient."""
    if root:
        return [square_step(q, digit, k) for digit in range(4)]
    return [logic.mul(d, digit) for digit in range(4)]


def one_of(index: Term, choices: list[Term]) -> Term:
    """choices[index]"""
    result = choices[-1]
    for number, choice in reversed(list(enumerate(choices[:-1]))):
        result = logic.ite(logic.eq(index, number), choice, result)
    return result


def invariant(root: bool, k: int, r: Term, q: Term, d: Term) -> tuple[Term, ...]:
    """Bounds of entry k / 2, without the equation that `numbers` composes."""
    small = [logic.ult(q, 1 << k)]
    if k <= 22:  # nothing below bit 3, but bits 1 and 2 of an operand
        small += [logic.eq(logic.bits(r, 2 if k else 0, 0), 0), logic.eq(logic.bits(d, 2, 0), 0)]
    if not root:
        return (
            *small,
            logic.ult(r, d),
            logic.ule(logic.bv(ROOM, 1 << 26), d),
            logic.ult(d, 1 << 27),
        )
    bound = logic.shl(logic.add(logic.mul(q, 2), 1), 26 - k)
    divisor = logic.shl(logic.add(logic.mul(q, 4), 1), 25 - k)
    return (*small, logic.ult(r, bound), logic.eq(d, divisor))


class Operand:
    """Normalised significand of a binary32 number and its biased exponent, plus 512."""

    def __init__(self, bits: Term) -> None:
        sig = significand_of(bits)
        zeros, self.significand = logic.bv(12, 0), sig
        for count in range(1, 24):
            here = logic.all(
                logic.ult(sig, 1 << (24 - count)), logic.ule(logic.bv(24, 1 << (23 - count)), sig)
            )
            zeros = logic.ite(here, logic.bv(12, count), zeros)
            self.significand = logic.ite(here, logic.shl(sig, count), self.significand)
        biased = logic.add(exponent_of(bits, 12), 512)
        self.exponent = logic.sub(biased, zeros)

    def radicand(self) -> Term:
        """R0 of a root: m / 4 in units of 2^-26; m is doubled for an odd unbiased exponent."""
        wide = logic.extend(self.significand, ROOM)
        odd = logic.no(logic.bit(self.exponent, 0))  # unbiased: minus 127
        return logic.ite(odd, logic.shl(wide, 2), logic.shl(wide, 1))


@proof(
    "fp_divsqrt",
    "operands enter the recurrence normalised, root and quotient: first remainder, divisor, "
    "no digits",
    "all finite operands that are not zero",
    quick=True,
)
def recurrence_start(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_divsqrt")
    a, b, sqrt = (run.input(name) for name in ("a_i", "b_i", "sqrt_i"))
    first, second = Operand(a), Operand(b)
    r, q, d = (entry(run, register, 0, ENTERED) for register in (REMAINDER, DIGITS, DIVISOR))
    for root in (False, True):
        used = (a,) if root else (a, b)
        assume = [logic.eq(sqrt, int(root)), ieee.all_finite(*used)]
        assume += [logic.no(ieee.is_zero(x)) for x in used]
        divisor = logic.shl(logic.extend(second.significand, ROOM), 3)
        start = first.radicand()
        if not root:
            start = logic.shl(logic.extend(first.significand, ROOM), 2)
        claim = [logic.eq(r, start), logic.eq(q, 0), *invariant(root, 0, r, q, d)]
        claim += [logic.eq(d, logic.bv(ROOM, 1 << 25) if root else divisor)]
        claim += [logic.eq(logic.bits(run.signal("sqrt_q", ENTERED), 0, 0), sqrt)]
        name = "root" if root else "quotient"
        yield Case(name, logic.all(*claim), tuple(assume), {"a": a, "b": b})


@proof(
    "fp_divsqrt",
    "each of the twelve inner digit stages keeps the invariant of the recurrence: bounds of the "
    "remainder, two new digits, divisor, and 4 R = step(Q, digits) + R'; the steps add up to its "
    "equation; the leading digits are not zero; an exact quotient has no digits 24 and 25",
    "all states that meet the invariant",
)
def recurrence_stages(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_divsqrt")
    yield from numbers()
    for stage in range(STAGES - 1):
        k = 2 * stage
        now, then = (
            [entry(run, register, s, cycle) for register in (REMAINDER, DIGITS, DIVISOR)]
            for s, cycle in ((stage, 0), (stage + 1, 1))
        )
        r, q, d = now
        r_next, q_next, d_next = then
        sqrt = logic.bits(run.signal("sqrt_q", 0), stage, stage)
        sqrt_next = logic.bits(run.signal("sqrt_q", 1), stage + 1, stage + 1)
        new = logic.bits(q_next, 1, 0)
        for root in (False, True):
            steps = steps_of(root, q, d, k)
            claim = logic.all(
                *invariant(root, k + 2, r_next, q_next, d_next),
                logic.eq(q_next, logic.add(logic.shl(q, 2), logic.extend(new, ROOM))),
                logic.eq(logic.shl(r, 2), logic.add(one_of(new, steps), r_next)),
                logic.eq(sqrt_next, sqrt),
                logic.true() if root else logic.eq(d_next, d),
            )
            assume = (logic.eq(sqrt, int(root)), *invariant(root, k, r, q, d))
            show = {"R": r, "Q": q, "D": d, "R'": r_next, "Q'": q_next, "D'": d_next}
            yield Case(f"{'root' if root else 'quotient'}, stage {stage}", claim, assume, show)


def numbers() -> Iterator[Case]:
    """Arithmetic after the recurrence, for all numbers of the widths in use."""
    q, d, r, c, new = (logic.free(64, name) for name in ("Q", "D", "R", "c", "new"))
    mul = logic.mul
    four, sixteen = logic.bv(64, 4), logic.bv(64, 16)
    more = logic.add(mul(q, four), new)
    left = mul(four, logic.add(mul(q, d), r))
    right = logic.add(mul(more, d), logic.sub(mul(r, four), mul(new, d)))
    yield Case("quotient: 4 (Q D + R) = (4 Q + q) D + (4 R - q D)", logic.eq(left, right))
    two = logic.bv(64, 2)
    square = mul(logic.add(c, new), logic.add(c, new))
    parts = logic.add(mul(c, c), mul(two, mul(c, new)), mul(new, new))
    yield Case("root: (x + y)^2 = x^2 + 2 x y + y^2", logic.eq(square, parts))
    claim = logic.eq(mul(mul(q, four), mul(q, four)), mul(sixteen, mul(q, q)))
    yield Case("root: (4 Q)^2 = 16 Q^2, so that (4 Q + q)^2 = 16 Q^2 + step", claim)
    square, step = logic.free(64, "Q^2"), logic.free(64, "step")
    left = mul(four, logic.add(mul(square, mul(four, c)), r))
    more = logic.add(mul(sixteen, square), step)
    right = logic.add(mul(more, c), logic.sub(mul(r, four), mul(step, c)))
    yield Case("root: 4 (4 c Q^2 + R) = c (16 Q^2 + step) + (4 R - c step)", logic.eq(left, right))

    sa, sb = (logic.free(24, name) for name in ("sa", "sb"))
    wa, wb = (logic.extend(x, ROOM) for x in (sa, sb))
    normal = (logic.bit(sa, 23), logic.bit(sb, 23))
    digits = logic.free(24, "digits")
    wide, rest = logic.extend(digits, ROOM), logic.free(ROOM, "rest")
    eight_b = logic.shl(wb, 3)
    yield Case(
        "quotient: the first or second digit is one",
        logic.ule(logic.bv(24, 1 << 22), digits),
        (
            *normal,
            logic.eq(logic.add(logic.mul(wide, eight_b), rest), logic.shl(wa, 26)),
            logic.ult(rest, eight_b),
        ),
    )
    start = logic.free(ROOM, "R0")
    four_squares = logic.shl(logic.mul(wide, wide), 2)
    bound = logic.shl(logic.add(logic.shl(wide, 1), 1), 2)
    yield Case(
        "root: the first digit is one",
        logic.bit(digits, 23),
        (
            logic.ule(logic.bv(ROOM, 1 << 24), start),
            logic.ult(start, 1 << 26),
            logic.eq(logic.add(four_squares, rest), logic.shl(start, 24)),
            logic.ult(rest, bound),
        ),
    )
    # Q sb = 2^25 sa: the low 25 bits of the product are zero; sb = 2^t (2 h + 1), t <= 23
    all_digits, half = logic.free(26, "Q26"), logic.free(26, "h")
    odd = logic.add(logic.shl(half, 1), 1)
    for t in range(24):
        product = logic.mul(all_digits, logic.shl(odd, t))
        yield Case(
            f"exact quotient, divisor with {t} trailing zeros: digits 24 and 25 are zero",
            logic.eq(logic.bits(all_digits, 1, 0), 0),
            (logic.eq(logic.bits(product, 24, 0), 0),),
        )


@proof(
    "fp_divsqrt",
    "result and flags are the quotient or root, rounded as IEEE 754 states, of which the "
    "recurrence gives the digits; its outcome is abstracted to the invariant",
    "all",
    timeout=900,
)
def recurrence_rounded(ctx: Context) -> Iterator[Case]:
    latency = package_constant("FP_DIVSQRT_LATENCY")
    for root in (False, True):
        name = "root" if root else "quotient"
        # Special operands need not meet the invariant: nothing is replaced there.
        for special in (True, False):
            run = ctx.run("fp_divsqrt")
            digits, r, d = (logic.free(width, name) for name, width in (DIGITS, REMAINDER, DIVISOR))
            if not special:
                replace_recurrence(run, digits, r, d)
            state = [logic.extend(term, ROOM) for term in (r, digits, d)]
            outcome, ordinary, given = rounded_digits(root, run, digits, *state)
            operation = logic.eq(run.input("sqrt_i"), int(root))
            if special:
                assume = (operation, logic.no(ordinary))
                yield delivers(f"{name}, special operands", run, latency, outcome, assume)
            else:
                yield delivers(name, run, latency, outcome, (operation, ordinary, *given))


def replace_recurrence(run: Run, digits: Term, r: Term, d: Term) -> None:
    """Free digits in every entry and free remainder and divisor in the last one.

    An entry has the upper digits of the next one, as `recurrence_stages` proves.
    """
    last = STAGES - 1
    for stage in range(1, STAGES):
        name, width = DIGITS
        known = logic.shr(digits, 24 - 2 * stage)
        run.replace(name, width * (stage + 1) - 1, width * stage, stage + ENTERED, known)
    # The registers of the remainder start at entry 1.
    for name, width, place, term in (("remainder_q", 27, last - 1, r), (*DIVISOR, last, d)):
        run.replace(name, width * (place + 1) - 1, width * place, last + ENTERED, term)


def last_digits(steps: list[Term], r: Term) -> tuple[Term, Term]:
    """Two digits more, the largest for which the remainder is not negative; if nothing is left."""
    new, taken = logic.bv(2, 0), steps[0]
    for digit in range(1, 4):
        fits = logic.ule(steps[digit], logic.shl(r, 2))
        new = logic.ite(fits, logic.bv(2, digit), new)
        taken = logic.ite(fits, steps[digit], taken)
    return new, logic.eq(logic.shl(r, 2), taken)


def rounded_digits(
    root: bool, run: Run, digits: Term, r: Term, q: Term, d: Term
) -> tuple[Outcome, Term, list[Term]]:
    """Outcome from 24 digits and a remainder, when it is used, and what is known of them."""
    a, b = run.input("a_i"), run.input("b_i")
    first, second = Operand(a), Operand(b)
    new, exact = last_digits(steps_of(root, q, d, 24), r)
    magnitude = logic.cat(digits, new, logic.vector(logic.no(exact)))
    used = (a,) if root else (a, b)
    ordinary = logic.all(ieee.all_finite(*used), *(logic.no(ieee.is_zero(x)) for x in used))
    known = [*invariant(root, 24, r, q, d)]
    if root:
        # floor((e - 127) / 2) = floor((e + 512 + 1) / 2) - 320; `exponent` is e + 512
        halved = logic.shr(logic.add(first.exponent, 1), 1)
        value = ieee.scaled(logic.bv(1, 0), magnitude, halved, -320 - 26)
        return ieee.root(a, value), ordinary, [*known, logic.bit(digits, 23)]
    sign = logic.xor(logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    difference = logic.sub(logic.add(first.exponent, 512), second.exponent)
    value = ieee.scaled(sign, magnitude, difference, -512 - 26)
    known += [
        logic.ule(logic.bv(24, 1 << 22), digits),
        logic.eq(d, logic.shl(logic.extend(second.significand, ROOM), 3)),
        logic.any(logic.no(exact), logic.eq(new, 0)),
    ]
    return ieee.quotient(a, b, value, sign), ordinary, known
