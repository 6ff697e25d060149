# SPDX-License-Identifier: Apache-2.0
"""Proofs of the adder, and of fp_fma as an adder, against the IEEE 754 sum."""

from __future__ import annotations

from collections.abc import Iterator

from bitwuzla import Kind, Term

from tests.formal import ieee, logic
from tests.formal.catalogue import Case, Context, covered, exponent_of, proof, significand_of
from tests.fpu.tb import package_constant

NEAR = 27  # places; beyond it the smaller operand is below the round bit


@proof(
    "fp_add",
    "sum and difference are those of IEEE 754: result and flags",
    "all; cases by distance of the exponents, signs, and length of a difference at distance 0",
    timeout=600,
)
def add(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_add"), package_constant("FP_ADD_LATENCY")
    a, b, sub = (run.input(f"{name}_i") for name in ("a", "b", "sub"))
    addend = logic.cat(logic.xor(logic.bits(b, 31, 31), sub), logic.bits(b, 30, 0))
    outcome = ieee.add(a, addend)
    yield from covered(sum_splits(a, addend), run, latency, outcome)


def sum_splits(a: Term, b: Term) -> list[tuple[str, tuple[Term, ...]]]:
    """Cases of a sum: distance, signs, and length of a difference at distance 0."""
    finite = ieee.all_finite(a, b)
    distance = logic.sub(exponent_of(a), exponent_of(b))
    differ = logic.ne(logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    sig_a, sig_b = significand_of(a, 25), significand_of(b, 25)
    larger_a = logic.ule(sig_b, sig_a)
    difference = logic.ite(larger_a, logic.sub(sig_a, sig_b), logic.sub(sig_b, sig_a))

    splits: list[tuple[str, tuple[Term, ...]]] = [("not finite", (logic.no(finite),))]
    far_a = logic.op(Kind.BV_SGT, distance, logic.bv(10, NEAR))
    far_b = logic.slt(distance, -NEAR)
    for signs, truth in (("equal signs", logic.no(differ)), ("unequal signs", differ)):
        splits.append((f"{signs}, first far above", (finite, truth, far_a)))
        splits.append((f"{signs}, second far above", (finite, truth, far_b)))
        for d in range(-NEAR, NEAR + 1):
            here = (finite, truth, logic.eq(distance, d))
            if d or truth is not differ:
                splits.append((f"{signs}, distance {d}", here))
                continue
            splits.append((f"{signs}, cancellation", (*here, logic.eq(difference, 0))))
            for order, larger in (("first", larger_a), ("second", logic.no(larger_a))):
                for length in range(1, 25):  # bits of the difference
                    low = logic.bv(25, 1 << (length - 1))
                    long = logic.all(logic.ule(low, difference), logic.ult(difference, 1 << length))
                    name = f"{signs}, distance 0, {order} larger, {length} bits"
                    splits.append((name, (*here, larger, long)))
    return splits


@proof(
    "fp_fma",
    "as an adder: sum and difference are those of IEEE 754: result and flags",
    "all, whatever the second factor; cases as for fp_add",
    timeout=600,
)
def fma_sum(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_fma"), package_constant("FP_FMA_LATENCY")

    def negated(port: str, by: str) -> Term:
        bits = run.input(port)
        sign = logic.xor(logic.bits(bits, 31, 31), run.input(by))
        return logic.cat(sign, logic.bits(bits, 30, 0))

    a, c = negated("a_i", "neg_product_i"), negated("c_i", "neg_addend_i")
    kind = logic.eq(run.input("kind_i"), package_constant("FMA_KIND_ADD"))
    outcome = ieee.add(a, c)
    yield from covered(sum_splits(a, c), run, latency, outcome, (kind,))
