# SPDX-License-Identifier: Apache-2.0
"""Proofs of the combinational blocks and of the units of two ranks."""

from __future__ import annotations

from collections.abc import Iterator

from bitwuzla import Term

from asip_asm.isa import default_isa
from asip_asm.isa_records import OperationRecord
from tests.formal import ieee, logic
from tests.formal.catalogue import Case, Context, delivers, proof
from tests.formal.ieee import CANON_NAN, PLUS_INF, Outcome
from tests.formal.logic import RNE, RTZ
from tests.formal.netlist import Run
from tests.fpu.tb import package_constant

ISA = default_isa()

# ---- conversions ----


@proof(
    "fp_i2f",
    "int32 and uint32 to binary32: result and flags",
    "all",
    quick=True,
)
def i2f(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_i2f"), package_constant("FP_I2F_LATENCY")
    for name, unsigned in (("signed", 0), ("unsigned", 1)):
        outcome = ieee.from_integer(run.input("a_i"), signed=not unsigned)
        assume = logic.eq(run.input("unsigned_i"), unsigned)
        yield delivers(name, run, latency, outcome, (assume,))


@proof(
    "fp_f2i",
    "binary32 to int32, to nearest even and toward zero: result and flags",
    "all",
    quick=True,
)
def f2i(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_f2i"), package_constant("FP_F2I_LATENCY")
    for name, mode, truncate in (("nearest", RNE, 0), ("toward zero", RTZ, 1)):
        outcome = ieee.to_integer(run.input("a_i"), mode)
        assume = logic.eq(run.input("truncate_i"), truncate)
        yield delivers(name, run, latency, outcome, (assume,))


# ---- comparisons, selections, sign operations ----


@proof(
    "fp_cmp",
    "every operation (comparison, minimum, maximum, absolute value, negation, signum, saturate, "
    "selections, integer sum and difference; code 15 as a copy): result and flags",
    "all",
    quick=True,
)
def compare(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_cmp"), package_constant("FP_CMP_LATENCY")
    a, b, c = (run.input(f"{port}_i") for port in "abc")
    spares = {str(code): (code, ISA.comparisons["MOV"]) for code in ISA.spare_comparisons.values()}
    for name, (code, record) in (codes() | spares).items():
        outcome = ieee.computed(record, a=a, b=b, c=c)
        assume = logic.eq(run.input("op_i"), code)
        yield delivers(name, run, latency, outcome, (assume,))


def codes() -> dict[str, tuple[int, OperationRecord]]:
    """Code and record of the operations of fp_cmp by their name in fp_pkg, FP_CMP_*."""
    return {
        name: (package_constant(f"FP_CMP_{name}"), record)
        for name, record in ISA.comparisons.items()
    }


OTHERS = ("divsqrt", "i2f", "f2i", "sincos", "memory")


@proof(
    "asip_aux",
    "absolute value, negation, signum, saturate and the other operations of fp_cmp reach the write "
    "port of the slot: result and flags",
    "all, in a cycle in which no other unit delivers",
    quick=True,
)
def aux_compare(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("aux_compare"), package_constant("FP_CMP_LATENCY")
    a, b, c = (run.input(f"{port}_i") for port in "abc")
    result, flags = run.output("result_o", latency), run.output("flags_o", latency)
    ports = [run.named(f".u_{unit}.valid_o") for unit in OTHERS]
    quiet = [logic.eq(run.signal(port, latency), 0) for port in ports]
    show = {"a": a, "b": b, "c": c, "result_o": result, "flags_o": flags}
    for name, (code, record) in codes().items():
        outcome = ieee.computed(record, a=a, b=b, c=c)
        issued = (logic.eq(run.input("op_i"), code), run.on("valid_i"))
        yield Case(name, ieee.matches(result, flags, outcome), (*issued, *quiet), show)


# ---- building blocks ----


@proof(
    "fp_lzc",
    "the count is the number of leading zeros, 4 and 5 bits of count",
    "all",
    quick=True,
)
def leading_zeros(ctx: Context) -> Iterator[Case]:
    for count_width in (4, 5):
        run = ctx.run("fp_lzc", {"CountWidth": count_width})
        value, count = run.input("value_i"), run.output("count_o", 0)
        width = 1 << count_width
        expected = logic.bv(count_width, width - 1)
        for i in range(1, width):  # the highest one wins
            expected = logic.ite(
                logic.bit(value, i), logic.bv(count_width, width - 1 - i), expected
            )
        claim = logic.all(
            logic.eq(run.on("zero_o", 0), logic.eq(value, 0)),
            logic.any(logic.eq(value, 0), logic.eq(count, expected)),
        )
        yield Case(f"{width} bits", claim, (), {"value_i": value, "count_o": count})


@proof(
    "fp_normalise",
    "the value is shifted left until its top bit is one, by the count given",
    "all but zero; the zero output for all",
    quick=True,
)
def normalise(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_normalise")
    value = run.input("value_i")
    result, count, zero = (run.output(name, 0) for name in ("value_o", "count_o", "zero_o"))
    claim = logic.all(
        logic.eq(logic.eq(zero, 1), logic.eq(value, 0)),
        logic.any(
            logic.eq(value, 0),
            logic.all(
                logic.bit(result, 23),
                logic.ult(count, 24),
                # nothing is lost: shifting back gives the value
                logic.eq(logic.shr(result, logic.extend(count, 24)), value),
            ),
        ),
    )
    yield Case("shift", claim, (), {"value_i": value, "value_o": result, "count_o": count})


SHIFTERS = ((32, 5, 0), (33, 6, 1), (27, 5, 1), (58, 6, 1), (48, 6, 1))


@proof(
    "fp_shift_right",
    "logical right shift with the OR of the bits shifted out, for every width used",
    "all",
    quick=True,
)
def shift_right(ctx: Context) -> Iterator[Case]:
    for width, amount_width, widest_first in SHIFTERS:
        parameters = {"Width": width, "AmountWidth": amount_width, "WidestFirst": widest_first}
        run = ctx.run("fp_shift_right", parameters)
        value, amount = run.input("value_i"), run.input("amount_i")
        shifted, sticky = run.output("value_o", 0), run.output("sticky_o", 0)
        # Twice the width: the lower half receives what leaves the upper one.
        room = width + (1 << amount_width)
        both = logic.cat(value, logic.bv(room - width, 0))
        both = logic.shr(both, logic.extend(amount, room))
        claim = logic.all(
            logic.eq(shifted, logic.bits(both, room - 1, room - width)),
            logic.eq(logic.eq(sticky, 1), logic.ne(logic.bits(both, room - width - 1, 0), 0)),
        )
        show = {"value_i": value, "amount_i": amount, "value_o": shifted, "sticky_o": sticky}
        yield Case(f"{width} bits", claim, (), show)


@proof(
    "fp_round",
    "a magnitude with any bits below the round bit, as an exact number of a wide format, is "
    "rounded to binary32: result, overflow, underflow, inexact",
    "all within the contract (exponent 1..511, subnormals with exponent 1, not zero)",
    quick=True,
)
def rounding(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_round")
    tail, assume, outcome = magnitude_rounded(run)
    result, flags = run.output("result_o", 0), run.output("flags_o", 0)
    show = {port: run.input(port) for port in run.netlist.inputs}
    show |= {"tail": tail, "result_o": result, "flags_o": flags}
    yield Case("all", ieee.matches(result, flags, outcome), assume, show)


def magnitude_rounded(run: Run) -> tuple[Term, tuple[Term, ...], Outcome]:
    """Bits below the round bit, the contract of fp_round, its magnitude rounded."""
    sign, exponent, sig = (run.input(f"{name}_i") for name in ("sign", "exp", "sig"))
    tail = logic.free(4, "tail")  # bits that the sticky bit represents
    magnitude = logic.cat(sig, run.input("guard_i"), run.input("round_i"), tail)
    normal = logic.bit(sig, 23)
    assume = (
        logic.ne(exponent, 0),
        logic.any(normal, logic.eq(exponent, 1)),
        logic.ne(magnitude, 0),
        logic.eq(run.input("sticky_i"), logic.vector(logic.ne(tail, 0))),
    )
    # sig has its unit bit at place 29 of 30
    exact = ieee.scaled(sign, magnitude, logic.extend(exponent, 12), -127 - 29)
    return tail, assume, ieee.rounded(exact)


@proof(
    "fp_pack",
    "NaN before infinity before zero, with the flags invalid and division by zero as requested, "
    "and else the magnitude rounded as in fp_round, without flags if the input says exact",
    "all; the magnitude within the contract of fp_round where no special result is wanted",
    quick=True,
)
def pack(ctx: Context) -> Iterator[Case]:
    run = ctx.run("fp_pack")
    tail, contract, rounded = magnitude_rounded(run)
    sign = run.input("sign_i")
    nan, inf, zero, invalid, by_zero, exact = (
        run.on(f"{name}_i") for name in ("nan", "inf", "zero", "invalid", "by_zero", "exact")
    )
    result, flags = run.output("result_o", 0), run.output("flags_o", 0)
    show = {port: run.input(port) for port in run.netlist.inputs}
    show |= {"tail": tail, "result_o": result, "flags_o": flags}
    special = ieee.choose(
        (nan, CANON_NAN),
        (inf, PLUS_INF),
        otherwise=logic.number(logic.cat(sign, logic.bv(31, 0))),
        sign=sign,
    )
    raised = ieee.raised(nv=logic.all(nan, invalid), dz=logic.all(logic.no(nan), inf, by_zero))
    claim = ieee.matches(result, flags, Outcome(special, raised))
    yield Case("special results", claim, (logic.any(nan, inf, zero),), show)
    raised = logic.ite(exact, ieee.raised(), rounded.flags)
    claim = ieee.matches(result, flags, Outcome(rounded.number, raised))
    plain = (*contract, logic.no(logic.any(nan, inf, zero)))
    yield Case("rounded", claim, plain, show)
