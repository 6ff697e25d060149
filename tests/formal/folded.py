# SPDX-License-Identifier: Apache-2.0
"""Proofs of fp_divsqrt_folded: its start, every clock of the recurrence, rounding of its outcome.

The invariant is that of `recurrence`, with the same integers: digits Q, remainder R, divisor D. The
registers hold w, which need not be restored, instead of R, and fewer bits of D:

    R / 2 = w, or for w < 0: w + T              -T <= w < T
    quotient: T = 4 divisor = D / 2
    root:     T = (2 Q + 1) 2^(25-k)            4 divisor = (Q without its last digit) 2^(26-k)

(k digits known: the last digit of a root is one if w >= 0, and joins the divisor later.)
`folded_start` proves the values of clock 2, `folded_clocks` that clocks 2 to 13 make two digits of
it, or leave it as it is where digits are left out, `folded_rounded` that clocks 14 and 15 make the
IEEE result of it. Assumed is what the contract states: no operation starts in the Interval - 1
clocks before and after.
"""

from __future__ import annotations

from collections.abc import Iterator

from bitwuzla import Kind, Term

from scripts.units_page import interval
from tests.formal import ieee, logic
from tests.formal.catalogue import Case, Context, delivers, proof
from tests.formal.ieee import Outcome
from tests.formal.netlist import Run
from tests.formal.recurrence import (
    ROOM,
    Operand,
    last_digits,
    one_of,
    rounded_digits,
    square_step,
    steps_of,
)
from tests.fpu.tb import package_constant

UNIT = "fp_divsqrt_folded"
INTERVAL = interval(UNIT)
LATENCY = package_constant("FP_DIVSQRT_LATENCY")
WIDTH, DIVISOR = 27, 24  # bits of the registers
BEGIN, MOVE, FINAL = 2, 8, 14  # clocks: first digits, last ones of the first half, last ones


def half_of(clock: int) -> int:
    """Half that holds the operation in a clock."""
    return int(clock > MOVE)


def part(run: Run, name: str, width: int, index: int, cycle: int) -> Term:
    """Element of a packed array."""
    return logic.bits(run.signal(name, cycle), width * (index + 1) - 1, width * index)


def wide(term: Term) -> Term:
    """As a number of ROOM bits."""
    return logic.extend(term, ROOM)


def below(root: bool, k: int, digits: Term, divisor: Term) -> Term:
    """T: what w is below."""
    if not root:
        return divisor
    return logic.shl(logic.add(logic.mul(digits, 2), 1), 25 - k)


class State:
    """What a clock begins with as numbers of ROOM bits, R in the units of `recurrence`."""

    def __init__(self, run: Run, clock: int, cycle: int, root: bool) -> None:
        k = 2 * (clock - BEGIN)
        if clock == BEGIN:
            self.digits = logic.bv(ROOM, 0)
        else:
            self.digits = wide(digits_of(run, clock, cycle))
        half = half_of(clock)
        self.w = logic.sign_extend(part(run, "w", WIDTH, half, cycle), ROOM)
        self.divisor = divisor_of(part(run, "divisor_q", DIVISOR, half, cycle))
        self.invariant = invariant(root, k, self.digits, self.w, self.divisor)
        self.remainder = remainder(root, k, self.digits, self.w, self.divisor)

    def same(self, other: State) -> Term:
        """All registers equal."""
        pairs = zip(vars(self).items(), vars(other).values(), strict=True)
        return logic.all(*(logic.eq(x, y) for (name, x), y in pairs if name != "invariant"))


def digits_of(run: Run, clock: int, cycle: int) -> Term:
    """Digits that a clock begins with; the last one is stored as a sign."""
    if clock <= MOVE + 1:
        return run.signal("digits_first", cycle)
    last = logic.no(logic.bit(run.signal("negative_q", cycle), 0))
    return logic.cat(run.signal("digits_q", cycle), logic.vector(last))


def divisor_of(register: Term) -> Term:
    """The register in the units of w."""
    return logic.shl(wide(register), 2)


def invariant(root: bool, k: int, digits: Term, w: Term, divisor: Term) -> tuple[Term, ...]:
    """What holds of the registers with k digits, or fewer of a quotient."""
    top = below(root, k, digits, divisor)
    bounds = (logic.ult(digits, 1 << k), logic.sle(logic.neg(top), w), logic.slt(w, top))
    if root:
        negative = logic.slt(w, 0)
        last = logic.bits(digits, 0, 0)
        signed = logic.ne(last, logic.vector(negative)) if k else logic.no(negative)
        others = logic.shl(logic.sub(digits, wide(last)), 26 - k)
        return (*bounds, signed, logic.eq(divisor, others))
    return (*bounds, logic.ule(logic.bv(ROOM, 1 << 25), divisor), logic.ult(divisor, 1 << 26))


def remainder(root: bool, k: int, digits: Term, w: Term, divisor: Term) -> Term:
    """R, in units of 2^-26."""
    top = below(root, k, digits, divisor)
    negative = logic.slt(w, 0)
    return logic.shl(logic.ite(negative, logic.add(w, top), w), 1)


def alone(run: Run, clocks: range) -> tuple[Term, ...]:
    """No operation starts in these clocks, relative to clock 0 of the run."""
    before = [k for k in range(1, INTERVAL) if -k in clocks]
    none = [
        logic.no(logic.bit(run.signal(name, 0), k - 1))
        for name in ("valid_q", "root_q")
        for k in before
    ]
    return (*none, *(logic.eq(run.input("valid_i", t), 0) for t in clocks if t > 0))


def others(run: Run, clock: int) -> tuple[Term, ...]:
    """In this clock of an operation no other one uses its half or enters it."""
    first, last = (BEGIN, MOVE) if clock <= MOVE else (MOVE + 1, FINAL)
    loads = () if clock == MOVE else (BEGIN - 1,) if clock < MOVE else (MOVE,)
    empty = [k for k in range(first, last + 1) if k != clock]
    empty += range(MOVE + 1, FINAL + 1) if clock == MOVE else ()
    valid, roots = (run.signal(name, 0) for name in ("valid_q", "root_q"))
    free = [logic.no(logic.bit(roots, k - 1)) for k in empty]
    free += [logic.no(logic.bit(valid, k - 1)) for k in (*empty, *loads)]
    return (logic.bit(valid, clock - 1), *free)


@proof(
    UNIT,
    "operands enter the recurrence normalised, root and quotient: first remainder, divisor, no "
    "digits; the exponent of digit 0",
    "all finite operands that are not zero, no operation closer than the interval",
    quick=True,
)
def folded_start(ctx: Context) -> Iterator[Case]:
    run = ctx.run(UNIT)
    a, b, sqrt = (run.input(name) for name in ("a_i", "b_i", "sqrt_i"))
    first, second = Operand(a), Operand(b)
    for root in (False, True):
        used = (a,) if root else (a, b)
        assume = [logic.eq(sqrt, int(root)), ieee.all_finite(*used), run.on("valid_i")]
        assume += [logic.no(ieee.is_zero(x)) for x in used]
        assume += alone(run, range(1 - INTERVAL, INTERVAL))
        state = State(run, BEGIN, BEGIN, root)
        start = first.radicand() if root else logic.shl(wide(first.significand), 2)
        divisor = logic.shl(wide(second.significand), 2)
        exponent = part(run, "exp_q", 10, 0, BEGIN + 1)
        expected = logic.sub(logic.add(first.exponent, 126), second.exponent)
        if root:  # exponents are 512 too large
            doubled = logic.add(logic.sub(first.exponent, 512), 125)
            expected = logic.op(Kind.BV_ASHR, doubled, logic.bv(12, 1))
        claim = [*state.invariant, logic.eq(state.remainder, start)]
        claim += [
            logic.eq(state.divisor, logic.bv(ROOM, 0) if root else divisor),
            logic.eq(logic.sign_extend(exponent, 12), expected),
            logic.eq(logic.bits(run.signal("root_q", BEGIN), BEGIN - 1, BEGIN - 1), sqrt),
            logic.bit(run.signal("valid_q", BEGIN), BEGIN - 1),
        ]
        name = "root" if root else "quotient"
        yield Case(name, logic.all(*claim), tuple(assume), {"a": a, "b": b})


@proof(
    UNIT,
    "clocks 2 to 13 keep the invariant of the recurrence: two new digits and 4 R = step(Q, digits) "
    "+ R', or nothing changes where digits are left out: in the clocks before 2 p + exp >= 0 of "
    "clock p + 3, in the second half one later, never in clocks 2 and 9",
    "all states that meet the invariant",
    timeout=600,
)
def folded_clocks(ctx: Context) -> Iterator[Case]:
    run = ctx.run(UNIT)
    for clock in range(BEGIN, FINAL):
        k = 2 * (clock - BEGIN)
        exponent = logic.sign_extend(part(run, "exp_q", 10, half_of(clock + 1), 1), 12)
        places = k - 2 if clock <= MOVE else k - 4
        runs = logic.sle(logic.bv(12, 0), logic.add(exponent, places))
        if clock in (BEGIN, MOVE + 1):
            runs = logic.true()
        for root in (False, True):
            now = State(run, clock, 0, root)
            then = State(run, clock + 1, 1, root)
            new = logic.bits(then.digits, 1, 0)
            if root:
                steps = [square_step(now.digits, digit, k) for digit in range(4)]
            else:
                double = logic.shl(now.divisor, 1)
                steps = [logic.mul(double, digit) for digit in range(4)]
            step = one_of(new, steps)
            made = logic.all(
                *then.invariant,
                logic.eq(then.digits, logic.add(logic.shl(now.digits, 2), wide(new))),
                logic.eq(logic.shl(now.remainder, 2), logic.add(step, then.remainder)),
                logic.true() if root else logic.eq(then.divisor, now.divisor),
            )
            claim = made if root else logic.ite(runs, made, now.same(then))
            at, after = (run.signal("root_q", cycle) for cycle in (0, 1))
            claim = logic.all(claim, logic.eq(logic.bits(after, clock, clock), int(root)))
            assume = [*now.invariant, *others(run, clock)]
            assume += [logic.eq(logic.bits(at, clock - 1, clock - 1), int(root))]
            if root:
                assume.append(logic.sle(logic.bv(12, 0), exponent))
            show = {
                "Q": now.digits,
                "w": now.w,
                "D": now.divisor,
                "exp": exponent,
                "Q'": then.digits,
            }
            yield Case(
                f"{'root' if root else 'quotient'}, clock {clock}", claim, tuple(assume), show
            )


@proof(
    UNIT,
    "result and flags are the quotient or root, rounded as IEEE 754 states, of which the "
    "recurrence gives the digits; its state in clock 14 is abstracted to the invariant; no "
    "quotient has 24 leading ones and a remainder",
    "all operands, no operation closer than the interval",
    timeout=900,
)
def folded_rounded(ctx: Context) -> Iterator[Case]:
    yield from ones()
    for root in (False, True):
        name = "root" if root else "quotient"
        for special in (True, False):
            run = ctx.run(UNIT)
            free = ((25, "Q"), (WIDTH, "w"), (DIVISOR, "D"))
            digits, register, divisor = (logic.free(width, name) for width, name in free)
            if not special:
                run.replace("w_q", 2 * WIDTH - 1, WIDTH, FINAL, register)
                run.replace("divisor_q", 2 * DIVISOR - 1, DIVISOR, FINAL, divisor)
                run.replace("digits_q", 23, 0, FINAL, logic.bits(digits, 24, 1))
                run.replace("negative_q", 0, 0, FINAL, logic.vector(logic.no(logic.bit(digits, 0))))
            q, d = wide(digits), divisor_of(divisor)
            w = logic.sign_extend(register, ROOM)
            r = remainder(root, 24, q, w, d)
            operation = [
                logic.eq(run.input("sqrt_i"), int(root)),
                run.on("valid_i"),
                *alone(run, range(1 - INTERVAL, INTERVAL)),
            ]
            kept = logic.bits(digits, 23, 0)
            if root:
                outcome, ordinary, given = rounded_digits(
                    True, run, kept, r, q, logic.add(logic.mul(q, 8), 2)
                )
                given = [given[-1]]
            else:
                outcome, ordinary, given = quotient(run, kept, r, q, logic.shl(d, 1))
            given += invariant(root, 24, q, w, d)
            if special:
                assume = (*operation, logic.no(ordinary))
                yield delivers(f"{name}, special operands", run, LATENCY, outcome, assume)
            else:
                assume = (*operation, ordinary, *given)
                yield delivers(name, run, LATENCY, outcome, assume)


def quotient(run: Run, digits: Term, r: Term, q: Term, d: Term) -> tuple[Outcome, Term, list[Term]]:
    """As `rounded_digits`, for a quotient of which clocks were left out: fewer than 24 digits."""
    a, b = run.input("a_i"), run.input("b_i")
    first, second = Operand(a), Operand(b)
    new, exact = last_digits(steps_of(False, q, d, 24), r)
    magnitude = logic.cat(digits, new, logic.vector(logic.no(exact)))
    ordinary = logic.all(ieee.all_finite(a, b), *(logic.no(ieee.is_zero(x)) for x in (a, b)))
    difference = logic.sub(logic.add(first.exponent, 512), second.exponent)
    # Digits missing: two for every two places that digit 0 is below the exponent 0, up to 20.
    place = logic.sub(difference, 512 - 126)  # exp, signed
    under = logic.add(logic.neg(place), 1)
    pairs = logic.cat(logic.bits(under, 11, 1), logic.bv(1, 0))
    missing = logic.ite(logic.sle(logic.bv(12, 0), place), logic.bv(12, 0), pairs)
    missing = logic.ite(logic.sle(missing, 20), missing, logic.bv(12, 20))
    sign = logic.xor(logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    value = ieee.scaled(sign, magnitude, logic.add(difference, missing), -512 - 26)
    known = logic.sub(logic.bv(12, 24), missing)
    one = logic.bv(24, 1)
    leading = logic.shl(one, logic.extend(logic.sub(known, 2), 24))
    all_ones = [
        logic.all(logic.eq(place, 0), logic.eq(digits, (1 << 23) - 1), logic.bit(new, 1)),
        logic.all(logic.eq(place, -1), logic.eq(digits, (1 << 22) - 1), logic.eq(new, 3)),
    ]
    given = [
        logic.ule(leading, digits),
        logic.eq(logic.shr(digits, logic.extend(known, 24)), 0),
        logic.eq(d, logic.shl(wide(second.significand), 3)),
        logic.any(
            logic.no(logic.any(*all_ones)),
            logic.all(exact, logic.no(logic.all(logic.eq(place, 0), logic.bit(new, 0)))),
        ),
    ]
    return ieee.quotient(a, b, value, sign), ordinary, given


def ones() -> Iterator[Case]:
    """24 leading ones of a quotient leave no remainder."""
    sa, sb = (logic.free(24, name) for name in ("sa", "sb"))
    wa, wb, rest = wide(sa), wide(sb), logic.free(ROOM, "rest")
    normal = (logic.bit(sa, 23), logic.bit(sb, 23))
    filled = logic.mul(wb, (1 << 24) - 1)
    for zeros in (0, 1):
        other = logic.ne(logic.add(filled, rest), logic.shl(wa, 23 + zeros))
        yield Case(
            f"24 ones of a quotient after {zeros} zeros: nothing is left",
            logic.any(logic.eq(rest, 0), other),
            (*normal, logic.ult(rest, wb)),
        )
