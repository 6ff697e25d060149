# SPDX-License-Identifier: Apache-2.0
"""Proofs of fp_sincos_overlapped, which works on three operations: their steps, the operands
outside the approximation in any order, and the clocks of the reduction.

An observer remembers which of the last clocks accepted an operation. The unit's counters must say
the same in every clock, and no two operations may use the second multiplier together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import gmpy2
from bitwuzla import Term

from tests.formal import logic
from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Observer, Values, inductive
from tests.formal.netlist import Run
from tests.formal.trigonometry import OUTSIDE, outside
from tests.fpu.tb import package_constant

UNIT = "fp_sincos_overlapped"
LATENCY = package_constant("FP_SINCOS_OVERLAPPED_LATENCY")
INTERVAL = 11
# Steps that a counter marks: it is 1 in the first of them.
COUNTERS = {"reduce_q": 1, "cubic_q": 12, "last_q": 22}
COUNTED = 10
SPLIT, ROUND = 11, (32, 33)
FIRST_AT = 4  # of cubic_q, or of last_q of the operation before: c3 t is loaded


def is_loaded(cubic: int, last: int) -> bool:
    """Whether c3 t has been loaded before the clock with these counters."""
    return cubic > FIRST_AT or (last > FIRST_AT and 0 < cubic > last - FIRST_AT)


def loads(cubic: int, last: int) -> bool:
    """Whether c3 t is loaded in the clock with these counters."""
    return cubic > 0 and not is_loaded(cubic, last) and FIRST_AT in (cubic, last)


class Steps(Observer):
    """Bit k - 1: an operation is in its step k, accepted k clocks ago."""

    widths = {"steps": LATENCY}

    def next(self, run: Run, own: Values) -> Values:
        accepted = logic.all(run.on("ready_o", 0), run.on("valid_i"))
        older = logic.bits(own["steps"], LATENCY - 2, 0)
        return {"steps": logic.cat(older, logic.vector(accepted))}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        steps = own["steps"]

        def at(step: int) -> Term:
            return logic.bit(steps, step - 1)

        def counter(name: str, value: int) -> Term:
            return logic.eq(run.signal(name, cycle), value)

        parts = {
            "no two operations closer than the interval": logic.all(
                *(
                    logic.no(logic.all(at(step), at(step + gap)))
                    for gap in range(1, INTERVAL)
                    for step in range(1, LATENCY - gap + 1)
                )
            )
        }
        for name, first in COUNTERS.items():
            parts[f"{name} tells the step"] = logic.all(
                logic.ule(run.signal(name, cycle), COUNTED),
                *(
                    logic.eq(logic.vector(counter(name, n + 1)), logic.vector(at(first + n)))
                    for n in range(COUNTED)
                ),
            )
        single = {"split_q": (SPLIT,), "round_q": ROUND[::-1]}
        for name, which in single.items():
            told = logic.vector(*(at(step) for step in which))
            parts[f"{name} tells the step"] = logic.eq(run.signal(name, cycle), told)
        parts["a result after the latency, and no other"] = logic.eq(
            run.output("valid_o", cycle), logic.vector(at(LATENCY))
        )
        first = []
        for cubic in range(COUNTED + 1):
            for last in range(COUNTED + 1):
                known = [is_loaded(cubic, last)]
                known += [loads(cubic - ago, max(last - ago, 0)) for ago in (3, 2, 1)]
                value = logic.bv(4, int("".join(str(int(bit)) for bit in known), 2))
                told = logic.cat(
                    run.signal("first_loaded_q", cycle), run.signal("first_step_q", cycle)
                )
                here = logic.all(counter("cubic_q", cubic), counter("last_q", last))
                first.append(logic.implies(here, logic.eq(told, value)))
        parts["the first product begins once"] = logic.all(*first)
        return parts

    def claims(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        def among(name: str, *values: int) -> Term:
            return logic.any(*(logic.eq(run.signal(name, 0), value) for value in values))

        def one_of(*users: Term) -> Term:
            pairs = [(a, b) for i, a in enumerate(users) for b in users[:i]]
            return logic.all(*(logic.no(logic.all(*pair)) for pair in pairs))

        loading = [run.on("first_load", 0)]
        loading += [run.on(name, 0) for name in ("load_held", "load_sum")]
        first = run.signal("first_step_q", 0)
        return {
            "ready when no operation is in the reduction": logic.eq(
                run.output("ready_o", 0),
                logic.vector(logic.eq(logic.bits(own["steps"], INTERVAL - 2, 0), 0)),
            ),
            "one factor is loaded at a time": logic.all(
                one_of(loading[0], logic.any(*loading[1:])),
            ),
            "one product in the second multiplier": one_of(
                logic.bit(first, 0), among("cubic_q", 8, 9), among("last_q", 2, 3),
                among("last_q", 6, 7, 8),
            ),
            "c3 t is complete when c2 is added": logic.implies(
                among("cubic_q", 7),
                logic.all(
                    run.on("first_loaded_q", 0),
                    logic.eq(logic.bits(first, 1, 0), 0),
                ),
            ),
        }  # fmt: skip


@proof(
    UNIT,
    "each operation that is accepted is answered after the latency, and nothing else is; the "
    "counters give the steps of three operations; the second multiplier has the factors of one "
    "product at a time, and c3 t is complete when c2 is added",
    "any operations, in any clocks, after reset",
    quick=True,
)
def overlapped_steps(ctx: Context) -> Iterator[Case]:
    yield from inductive(ctx, UNIT, Steps())


@proof(
    UNIT,
    OUTSIDE,
    "all above 256 rad or below 2^-12, both signs; any operations before and after",
    quick=True,
)
def overlapped_outside(ctx: Context) -> Iterator[Case]:
    # What the approximation delivers is anything: it must not matter.
    run = ctx.run(UNIT, cut=("rounded", "rounded_flags"))
    steps = logic.free(LATENCY, "steps")
    state = Steps().invariant(run, {"steps": steps}, 0)
    yield from outside(run, LATENCY, tuple(state.values()))


# ---- the reduction ----
BYTES = 9  # of 2/pi
EXP_MIN, EXP_MAX = 115, 135  # of 2^-12 and of 256, biased
with gmpy2.context(precision=300):
    TWO_OVER_PI = int(gmpy2.floor(gmpy2.mul_2exp(2 / gmpy2.const_pi(), 71)))
ANGLE, SUM = 33, 29  # bits of the accumulator and of the rows of half a byte
FIRST_LOW = 6  # the step from which on bytes of the angle are stored


def times_digit(x: Term, digit: int) -> Term:
    """x times a radix-4 Booth digit -2 .. 2, given by three bits."""
    value = (digit & 1) + (digit >> 1 & 1) - 2 * (digit >> 2)
    size = logic.shl(x, 1) if abs(value) == 2 else x
    return logic.bv(SUM, 0) if not value else logic.neg(size) if value < 0 else size


@proof(
    UNIT,
    "the reduction, clock by clock: the factors are the nine bytes of 2/pi that matter for the "
    "exponent, each half gives the significand times two Booth digits, and the accumulator adds "
    "the halves to its 256th part, without overflow; the bytes shifted out are saved",
    "all of magnitude 2^-12 to 256 rad, any operations before and after",
    quick=True,
)
def overlapped_reduction(ctx: Context) -> Iterator[Case]:
    run = ctx.run(UNIT)
    a = run.input("a_i")
    exponent = logic.bits(a, 30, 23)
    assume = (
        logic.eq(run.signal("reduce_q", 0), 0), run.on("valid_i"),
        logic.ule(logic.bv(8, EXP_MIN), exponent), logic.ule(exponent, EXP_MAX),
    )  # fmt: skip
    wide = logic.bv(8 * BYTES + 8, TWO_OVER_PI)
    down = logic.extend(logic.sub(logic.bv(8, EXP_MAX), exponent), 8 * BYTES + 8)
    factor = logic.shr(wide, down)  # its top bit is zero: signed and unsigned bytes are the same
    claim = [logic.eq(logic.bits(factor, 8 * BYTES - 1, 8 * BYTES - 1), 0)]
    for k in range(BYTES):
        below = logic.bits(factor, 8 * k - 1, 8 * k - 1) if k else logic.bv(1, 0)
        digits = logic.cat(logic.bits(factor, 8 * k + 7, 8 * k), below)
        claim.append(logic.eq(run.signal("digits_q", k + 1), digits))
    claim += [logic.eq(run.signal("a_q", cycle), a) for cycle in range(1, SPLIT + 1)]
    claim += [logic.eq(run.signal("reduce_q", k), k) for k in range(1, COUNTED + 1)]
    yield Case("bytes of 2/pi", logic.all(*claim), assume, {"a_i": a})

    fraction = logic.bits(run.signal("a_q", 0), 22, 0)
    x = logic.extend(logic.cat(logic.bv(1, 1), fraction), SUM)
    for half, low in (("low", 0), ("high", 4)):
        digits = logic.bits(run.signal("digits_q", 0), low + 4, low)
        carry = logic.extend(run.signal(f"{half}_carry_q", 1), SUM)
        made = logic.add(run.signal(f"{half}_pair_q", 1), carry)
        for code in range(32):
            upper = logic.shl(times_digit(x, code >> 2), 2)
            rows = logic.add(times_digit(x, code & 7), upper)
            yield Case(
                f"{half} half, digits {code}", logic.eq(made, rows), (logic.eq(digits, code),)
            )

    step, angle = run.signal("reduce_q", 0), run.signal("angle_q", 0)
    shifted = logic.sign_extend(logic.bits(angle, ANGLE - 1, 8), ANGLE)

    def row(half: str) -> tuple[Term, Term]:
        pair = logic.sign_extend(run.signal(f"{half}_pair_q", 0), ANGLE)
        return pair, logic.extend(run.signal(f"{half}_carry_q", 0), ANGLE)

    total = logic.add(shifted, *row("low"))
    total = logic.add(total, *(logic.shl(part, 4) for part in row("high")))
    then = run.signal("angle_q", 1)
    begins = (logic.eq(step, 1),)
    yield Case("the accumulator begins with zero", logic.eq(then, 0), begins)
    yield Case("a byte is added", logic.eq(then, total), (logic.ne(step, 1),))
    kept = logic.cat(logic.bits(angle, 7, 0), logic.bits(run.signal("low_q", 0), 38, 8))
    late = (logic.ule(logic.bv(4, FIRST_LOW), step),)
    yield Case("a byte is kept", logic.eq(run.signal("low_q", 1), kept), late)

    # A signed byte with its carry in is -128 .. 128, the significand below 2^24.
    old, byte = logic.free(ANGLE, "old"), logic.free(ANGLE, "byte")
    most, more = logic.bv(ANGLE, 1 << 31), logic.bv(ANGLE, (1 << 31) + (1 << 24))

    def within(term: Term, limit: Term) -> tuple[Term, Term]:
        return logic.sle(term, limit), logic.sle(logic.neg(limit), term)

    part = logic.sign_extend(logic.bits(old, ANGLE - 1, 8), ANGLE)
    both = logic.add(logic.sign_extend(part, ANGLE + 1), logic.sign_extend(byte, ANGLE + 1))
    fits = logic.eq(both, logic.sign_extend(logic.add(part, byte), ANGLE + 1))
    yield Case(
        "no overflow",
        logic.all(fits, *within(logic.add(part, byte), more)),
        (*within(old, more), *within(byte, most)),
    )
