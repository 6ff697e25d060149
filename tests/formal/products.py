# SPDX-License-Identifier: Apache-2.0
"""Proofs of the multiplications; the product of the significands is proved once, in fp_product.

In the units the addends of the product are free vectors whose sum has only the properties
that `product_facts` lists and the proof `product` shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from bitwuzla import Kind, Term

from tests.formal import ieee, logic
from tests.formal.catalogue import (
    Case,
    Context,
    covered,
    delivers,
    exponent_of,
    proof,
    significand_of,
)
from tests.formal.netlist import ElaborationError, Run
from tests.fpu.tb import package_constant

CUT = (".outer_o", ".cross_low_o", ".cross_high_o")
WIDE = 50  # bits of the sum of the addends, which the product does not fill


def product_of(outer: Term, *crosses: Term) -> Term:
    """The product that the outputs of fp_product represent."""
    terms = [logic.shl(logic.extend(cross, WIDE), 17) for cross in crosses]
    return logic.add(logic.extend(outer, WIDE), *terms)


def product_facts(a: Term, b: Term, p: Term) -> dict[str, Term]:
    """What the proofs of the units use of p = a * b, for 24-bit a and b."""
    facts = {
        "48 bits": logic.ult(p, 1 << 48),
        "zero": logic.eq(logic.eq(p, 0), logic.any(logic.eq(a, 0), logic.eq(b, 0))),
        "two subnormals": logic.any(logic.bit(a, 23), logic.bit(b, 23), logic.ult(p, 1 << 46)),
    }
    facts["second is 1"] = logic.any(
        logic.ne(b, 1 << 23), logic.eq(p, logic.shl(logic.extend(a, WIDE), 23))
    )
    for name, x, y in (("first", a, b), ("second", b, a)):
        for k in range(24):  # y normal, x of k + 1 bits
            there = logic.all(
                logic.bit(y, 23), logic.ule(logic.bv(24, 1 << k), x), logic.ule(x, (2 << k) - 1)
            )
            inside = logic.all(
                logic.ule(logic.bv(WIDE, 1 << (k + 23)), p), logic.ule(p, (4 << (k + 23)) - 1)
            )
            facts[f"{name} of {k + 1} bits"] = logic.any(logic.no(there), inside)
    return facts


@proof(
    "fp_product",
    "the addends sum up to the product, by distributivity over the halves of the operands; "
    "its range and when it is zero, as the proofs of fp_mul and fp_fma use them",
    "all",
    quick=True,
)
def product(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_product")
    a, b = run.input("a_i"), run.input("b_i")
    show = {"a_i": a, "b_i": b}
    outputs = [run.output(ending[1:], 0) for ending in CUT]

    def times(x: Term, y: Term, width: int = WIDE) -> Term:
        return logic.mul(logic.extend(x, width), logic.extend(y, width))

    def narrow(x: Term, y: Term) -> Term:
        return logic.extend(times(x, y, logic.width(x) + logic.width(y)), WIDE)

    def schoolbook(multiply: Callable[[Term, Term], Term]) -> Term:
        (x1, x0), (y1, y0) = halves
        return logic.add(
            logic.shl(multiply(x1, y1), 34),
            multiply(x0, y0),
            logic.shl(multiply(x0, y1), 17),
            logic.shl(multiply(x1, y0), 17),
        )

    halves = [(logic.bits(x, 23, 17), logic.bits(x, 16, 0)) for x in (a, b)]
    claim = logic.eq(product_of(*outputs), schoolbook(narrow))
    yield Case("the unit adds four partial products", claim, (), show)
    for i, x in enumerate(halves[0]):
        for j, y in enumerate(halves[1]):
            claim = logic.eq(narrow(x, y), times(x, y))
            yield Case(f"partial product {i}{j} fits its width", claim, (), show)
    scale = logic.bv(WIDE, 1 << 17)
    for name, x, (high, low) in zip("ab", (a, b), halves, strict=True):
        whole = logic.add(times(high, scale), logic.extend(low, WIDE))
        yield Case(f"{name} is the sum of its halves", logic.eq(logic.extend(x, WIDE), whole))
    w, x, y, z = (logic.free(WIDE, name) for name in "wxyz")
    mul = logic.mul
    left = mul(logic.add(mul(w, scale), x), logic.add(mul(y, scale), z))
    right = logic.add(
        logic.shl(mul(w, y), 34), mul(x, z), logic.shl(mul(x, y), 17), logic.shl(mul(w, z), 17)
    )
    yield Case("distributivity, for any four numbers", logic.eq(left, right))
    for name, fact in product_facts(a, b, times(a, b)).items():
        yield Case(f"range, {name}", fact, (), show)


@proof(
    "fp_mul",
    "the result is the exact product rounded as IEEE 754 states, product of the significands "
    "abstracted to its range (fp_product): result and flags",
    "all; cases both normal and other",
    timeout=900,
)
def mul(ctx: Context) -> Iterator[Case]:
    latency = package_constant("FP_MUL_LATENCY")
    run = ctx.run("fp_mul", cut=CUT)
    a, b = run.input("a_i"), run.input("b_i")
    factors = abstracted_product(run, latency, a, b)
    sign = logic.xor(logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    yield from rounded_product(run, latency, factors, sign)


@dataclass(frozen=True)
class Abstracted:
    """A unit's run in which the product of a and b is free except for `given`."""

    a: Term
    b: Term
    product: Term
    given: tuple[Term, ...]
    inputs: Case  # the multiplier receives the significands that are spoken of


def rounded_product(run: Run, latency: int, factors: Abstracted, sign: Term) -> Iterator[Case]:
    """The multiplier has the significands, and the result is the product rounded."""
    yield factors.inputs
    a, b = factors.a, factors.b
    exponent = logic.add(exponent_of(a), exponent_of(b))
    exact = ieee.scaled(sign, factors.product, exponent, -2 * (127 + 23))
    outcome = ieee.product(a, b, exact, sign)
    normal = logic.all(*(logic.bit(significand_of(x), 23) for x in (a, b)))
    splits = [("both normal", (normal,)), ("subnormal or zero", (logic.no(normal),))]
    yield from covered(splits, run, latency, outcome, factors.given)


def abstracted_product(
    run: Run, latency: int, a: Term, b: Term, given: tuple[Term, ...] = ()
) -> Abstracted:
    """Of a run with CUT, the product of a and b under an assumption."""
    result = run.output("result_o", latency)
    names = [run.named(ending) for ending in CUT]
    cycles = {run.cycle_of(name, result) for name in names}
    if len(cycles) != 1:
        raise ElaborationError(f"the addends of the product enter in cycles {sorted(cycles)}")
    cycle = cycles.pop()
    p = product_of(*(run.signal(name, cycle) for name in names))
    sig_a, sig_b = significand_of(a), significand_of(b)
    instance = names[0].removesuffix(CUT[0])
    factors = [run.signal(f"{instance}.{port}", cycle) for port in ("a_i", "b_i")]
    claim = logic.all(*(logic.eq(x, y) for x, y in zip(factors, (sig_a, sig_b), strict=True)))
    inputs = Case("the multiplier receives the significands", claim, given)
    return Abstracted(a, b, p, (*given, *product_facts(sig_a, sig_b, p).values()), inputs)


# ---- fused multiply-add ----

FAR_ABOVE, FAR_BELOW = -51, 27  # places of the product's last bit above that of the addend


class FmaRun:
    """fp_fma for one kind of operation, product abstracted."""

    def __init__(self, ctx: Context, operation: str) -> None:
        self.latency = package_constant("FP_FMA_LATENCY")
        self.run = run = ctx.run("fp_fma", cut=CUT)
        self.a, self.b, self.c = (run.input(f"{name}_i") for name in "abc")
        kind = logic.eq(run.input("kind_i"), package_constant(f"FMA_KIND_{operation}"))
        sign_a, sign_b, sign_c = (logic.bits(x, 31, 31) for x in (self.a, self.b, self.c))
        self.sign_p = logic.xor(logic.xor(sign_a, sign_b), run.input("neg_product_i"))
        self.sign_c = logic.xor(sign_c, run.input("neg_addend_i"))
        self.factors = abstracted_product(run, self.latency, self.a, self.b, (kind,))


@proof(
    "fp_fma",
    "as a multiplier: the exact product rounded, product of the significands abstracted "
    "(fp_product): result and flags",
    "all, whatever the addend",
    timeout=900,
)
def fma_product(ctx: Context) -> Iterator[Case]:
    fma = FmaRun(ctx, "MUL")
    yield from rounded_product(fma.run, fma.latency, fma.factors, fma.sign_p)


@proof(
    "fp_fma",
    "fused multiply-add and its negations: the exact sum of product and addend rounded, product "
    "of the significands abstracted (fp_product): result and flags",
    "all; cases by distance, signs and length of a difference",
    timeout=600,
)
def fma(ctx: Context) -> Iterator[Case]:
    fma = FmaRun(ctx, "FMA")
    run, a, b, c, p = fma.run, fma.a, fma.b, fma.c, fma.factors.product
    yield fma.factors.inputs
    exponent_p = logic.add(*(exponent_of(x, 12) for x in (a, b)))
    exponent_c = exponent_of(c, 12)
    sig_c = significand_of(c)
    # last bit of the product above that of the addend, in places
    above = logic.sub(logic.sub(exponent_p, exponent_c), 127 + 23)
    differ = logic.ne(fma.sign_p, fma.sign_c)
    finite = ieee.all_finite(a, b, c)
    no_product, no_addend = logic.eq(p, 0), logic.eq(sig_c, 0)
    both = logic.all(finite, logic.no(no_product), logic.no(no_addend))

    splits: list[tuple[str, tuple[Term, ...], Term]] = []

    def split(name: str, terms: tuple[Term, ...], x: Term, y: Term, exponent: Term, bias: int):
        """x is the product and y the addend, in the same unit 2^(exponent + bias)."""
        width = max(logic.width(x), logic.width(y)) + 1
        x, y = logic.extend(x, width), logic.extend(y, width)
        x_larger = logic.ule(y, x)
        difference = logic.ite(x_larger, logic.sub(x, y), logic.sub(y, x))
        magnitude = logic.ite(differ, difference, logic.add(x, y))
        sign = logic.ite(logic.all(differ, logic.no(x_larger)), fma.sign_c, fma.sign_p)
        exact = ieee.scaled(sign, magnitude, exponent, bias)
        splits.append((name, terms, exact))

    zero_c, zero_p = logic.bv(24, 0), logic.bv(WIDE, 0)
    bias_p, bias_c = -2 * (127 + 23), -(127 + 23)
    split("not finite", (logic.no(finite),), p, zero_c, exponent_p, bias_p)
    split("product zero", (finite, no_product), zero_p, sig_c, exponent_c, bias_c)
    no_c = (finite, logic.no(no_product), no_addend)
    split("addend zero", no_c, p, zero_c, exponent_p, bias_p)
    one = logic.bv(1, 1)
    far_up = (both, logic.sle(above, FAR_ABOVE))
    far_down = (both, logic.op(Kind.BV_SGE, above, logic.bv(12, FAR_BELOW)))
    padded_c, padded_p = logic.cat(sig_c, logic.bv(3, 0)), logic.cat(p, logic.bv(3, 0))
    split("addend far above", far_up, one, padded_c, exponent_c, bias_c - 3)
    split("addend far below", far_down, padded_p, one, exponent_p, bias_p - 3)
    for q in range(FAR_ABOVE + 1, FAR_BELOW):
        x = logic.cat(p, logic.bv(q, 0)) if q > 0 else p
        y = logic.cat(sig_c, logic.bv(-q, 0)) if q < 0 else sig_c
        base = (exponent_c, bias_c) if q > 0 else (exponent_p, bias_p)
        for name, truth in (("equal", logic.no(differ)), ("unequal", differ)):
            split(f"{name} signs, distance {q}", (both, truth, logic.eq(above, q)), x, y, *base)

    yield Case(
        "the cases cover all inputs",
        logic.any(*(logic.all(*terms) for _, terms, _ in splits)),
        fma.factors.given,
    )
    for name, terms, exact in splits:
        outcome = ieee.product_sum(a, b, c, exact, (fma.sign_p, fma.sign_c))
        yield delivers(name, run, fma.latency, outcome, (*fma.factors.given, *terms))
