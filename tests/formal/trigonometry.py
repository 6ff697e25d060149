# SPDX-License-Identifier: Apache-2.0
"""Proofs of fp_sincos: operands outside the reduction, symmetry, independence of earlier operands.

Between 2^-12 and 256 rad the unit approximates; `microtick fp campaign` measures the error of every
operand there. `angle_outside` proves the rest of the operands, `angle_symmetry` that the result is
a function of the operand alone and has the symmetry of the function, so that what was measured
with one operand after another holds in any order.

Below 2^-12, 0 < |x| - |sin x| < |x|^3 / 6 < 2^-26 |x| and 0 < 1 - cos x < x^2 / 2 < 2^-25
(truncated alternating series). Rounding is monotone, so the correctly rounded result and its flags
follow from those of numbers on a grid in these two intervals, which `angle_outside` claims.
"""

from __future__ import annotations

from collections.abc import Iterator

from bitwuzla import Kind, Term

from tests.formal import ieee, logic
from tests.formal.catalogue import Case, Context, delivers, exponent_of, proof, significand_of
from tests.formal.ieee import CANON_NAN, Outcome
from tests.formal.netlist import Run
from tests.fpu.tb import package_constant

LATENCY = package_constant("FP_SINCOS_LATENCY")
LAST = LATENCY - 1  # step in front of the result
OUTSIDE = (
    "operands above 256 rad, infinities and NaN give the canonical NaN, with nv unless it was a "
    "quiet NaN; below 2^-12 every number near enough to be the sine or the cosine rounds to the "
    "result, with the same flags; of zeros they are exact"
)
BITS_256, BITS_2_M12 = 0x43800000, 0x39800000  # binary32 of 256 and of 2^-12


def below_operand(a: Term) -> tuple[Term, Term]:
    """Any x - d 2^-26 ulp with an integer d from 1 to the significand of x, that is down to
    (1 - 2^-26) x, and that d is in range, which is to be assumed."""
    deficit = logic.free(24, "deficit")
    magnitude = logic.sub(
        logic.shl(logic.extend(significand_of(a), 50), 26), logic.extend(deficit, 50)
    )
    exact = ieee.scaled(logic.bits(a, 31, 31), magnitude, exponent_of(a), -127 - 23 - 26)
    inside = logic.all(logic.ne(deficit, 0), logic.ule(deficit, significand_of(a)))
    return exact, inside


def below_one() -> tuple[Term, Term]:
    """Any 1 - d 2^-50 with 1 <= d < 2^25, and that d is in range, which is to be assumed."""
    deficit = logic.free(25, "deficit")
    magnitude = logic.sub(logic.bv(51, 1 << 50), logic.extend(deficit, 51))
    exact = ieee.scaled(logic.bv(1, 0), magnitude, logic.bv(10, 0), -50)
    return exact, logic.ne(deficit, 0)


def outside(run: Run, latency: int, state: tuple[Term, ...] = ()) -> Iterator[Case]:
    """Cases of an operand that is not approximated, accepted in cycle 0 of a unit in `state`."""
    a, cos = run.input("a_i"), run.input("cos_i")
    magnitude = logic.bits(a, 30, 0)
    taken = (*state, run.on("ready_o", 0), run.on("valid_i"))
    above = logic.any(
        ieee.is_nan(a),
        logic.op(
            Kind.FP_GT,
            logic.op(Kind.FP_ABS, logic.number(a)),
            logic.number(logic.bv(32, BITS_256)),
        ),
    )
    quiet = logic.all(ieee.is_nan(a), logic.no(ieee.is_signalling(a)))
    nan = Outcome(logic.bv(32, CANON_NAN), ieee.raised(nv=logic.no(quiet)), exact=True)
    yield delivers("above 256 rad, infinity, NaN", run, latency, nan, (*taken, above))

    zero = (*taken, ieee.is_zero(a))
    exact = Outcome(logic.number(a), ieee.raised())
    yield delivers("sine of zero", run, latency, exact, (*zero, logic.eq(cos, 0)))
    one = Outcome(logic.number(logic.bv(32, 0x3F800000)), ieee.raised())
    yield delivers("cosine of zero", run, latency, one, (*zero, logic.eq(cos, 1)))

    small = (*taken, logic.ult(magnitude, BITS_2_M12), logic.ne(magnitude, 0))
    for name, number, code in (("sine", below_operand(a), 0), ("cosine", below_one(), 1)):
        exact, inside = number
        outcome = ieee.rounded(exact)
        assume = (*small, inside, logic.eq(cos, code))
        yield delivers(f"{name} below 2^-12", run, latency, outcome, assume)


@proof(
    "fp_sincos",
    OUTSIDE,
    "all above 256 rad or below 2^-12, both signs",
    quick=True,
)
def angle_outside(ctx: Context) -> Iterator[Case]:
    # What the reduction delivers is anything: it must not matter.
    yield from outside(ctx.run("fp_sincos", cut=("rounded", "rounded_flags")), LATENCY)


# Bits of the registers that depend on the operand alone, and the step from which on they do.
KNOWN: tuple[tuple[str, int, int, int], ...] = (
    ("a_q", 30, 0, 1),
    ("cos_q", 0, 0, 1),
    ("x_q", 33, 0, 1),
    ("y_q", 8, 0, 1),
    ("window_q", 6, 0, 1),
    ("order_q", 1, 0, 1),
    ("byte_base_q", 2, 0, 1),
    *((name, 0, 0, 1) for name in ("load_q", "final_q", "last_byte_q", "clear_q")),
    ("acc_q", 41, 0, 2),
    *((f"{name}_pair_q", 37, 0, 2) for name in ("low", "high")),
    *((f"{name}_carry_q", 0, 0, 2) for name in ("low", "high")),
    # filled from the top
    *(("low_q", 38, max(0, 31 - 8 * shift), 3 + shift) for shift in range(5)),
    ("high_q", 21, 0, 12),
    ("segment_q", 4, 0, 12),
    ("leading_q", 1, 0, 12),
    ("sine_q", 0, 0, 12),
    ("u_result.sig_q", 25, 0, LAST),
    ("u_result.exp_q", 7, 0, LAST),
)
# The byte taken in step 11 is not one of f yet; its product is cleared.
VOID = {
    ("y_q", 12),
    *((f"{name}_{part}_q", 13) for name in ("low", "high") for part in ("pair", "carry")),
}
CLEARED = (1, 13)
SIGN_KNOWN = 12  # the step from which on the sign of the result depends on the operand alone


def same(runs: tuple[Run, Run], step: int, cycle: int) -> list[Term]:
    """Both units hold the same in what a step knows, except for the sign of an odd function."""
    truths = [
        logic.eq(*(logic.bits(run.signal(name, cycle), high, low) for run in runs))
        for name, high, low, since in KNOWN
        if step >= since and (name, step) not in VOID
    ]
    if step == SIGN_KNOWN:
        truths += [run.on("load_q", cycle) for run in runs]
    elif 0 < step < SIGN_KNOWN:  # neither cubic nor last product has begun
        truths += [
            logic.eq(run.signal(name, cycle), 0) for run in runs for name in ("load_q", "final_q")
        ]
    if step in CLEARED:
        truths += [run.on("clear_q", cycle) for run in runs]
    if step >= SIGN_KNOWN:
        even = [logic.xor(run.signal("sign_q", cycle), turned(run, cycle)) for run in runs]
        truths.append(logic.eq(*even))
    return truths


def turned(run: Run, cycle: int) -> Term:
    """One for the sine of a negative operand."""
    plain = logic.op(Kind.BV_NOT, run.signal("cos_q", cycle))
    return logic.op(Kind.BV_AND, logic.bits(run.signal("a_q", cycle), 31, 31), plain)


@proof(
    "fp_sincos",
    "sin(-x) = -sin(x) and cos(-x) = cos(x), flags included, and the result is a function of the "
    "operand, whatever was computed before and is at the inputs meanwhile: two units stay "
    "equal, step by step, in all that the operand determines",
    "all",
    quick=True,
)
def angle_symmetry(ctx: Context) -> Iterator[Case]:
    first = ctx.run("fp_sincos")
    runs = (first, Run(first.netlist))
    show = {"a_q": runs[0].signal("a_q", 0), "other a_q": runs[1].signal("a_q", 0)}
    idle = [logic.eq(first.signal("step_q", 0), 0), logic.eq(first.input("valid_i"), 0)]
    waits = [logic.eq(first.signal("step_q", 1), 0), logic.eq(first.output("valid_o", 1), 0)]
    yield Case("no operand", logic.all(*waits), tuple(idle))
    for step in range(LATENCY):
        assume = [logic.eq(run.signal("step_q", 0), step) for run in runs]
        assume += same(runs, step, 0)
        if not step:
            ports = [[run.input(name) for name in ("a_i", "cos_i", "valid_i")] for run in runs]
            assume += [logic.eq(valid, 1) for _, _, valid in ports]
            assume += [logic.eq(*(cos for _, cos, _ in ports))]
            assume += [logic.eq(*(logic.bits(a, 30, 0) for a, _, _ in ports))]
        claim = [logic.eq(run.signal("step_q", 1), (step + 1) % LATENCY) for run in runs]
        claim += [logic.eq(run.output("valid_o", 1), int(step == LAST)) for run in runs]
        if not step:
            claim += [logic.eq(run.signal("a_q", 1), run.input("a_i")) for run in runs]
        elif step < LAST:
            claim += [logic.eq(*(run.signal("a_q", cycle) for cycle in (0, 1))) for run in runs]
        if step < LAST:
            yield Case(
                f"step {step}",
                logic.all(*claim, *same(runs, step + 1, 1)),
                tuple(assume),
                show,
            )
            continue
        results, flags = ([run.output(name, 1) for run in runs] for name in ("result_o", "flags_o"))
        nan = logic.ult(logic.bv(31, BITS_256), logic.bits(runs[0].signal("a_q", 0), 30, 0))
        odd = logic.xor(*(turned(run, 0) for run in runs))
        difference = logic.xor(*results)
        wanted = logic.ite(nan, logic.bv(32, 0), logic.cat(odd, logic.bv(31, 0)))
        claim += [logic.eq(difference, wanted), logic.eq(*flags)]
        yield Case("result", logic.all(*claim), tuple(assume), show)
