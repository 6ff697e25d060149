# SPDX-License-Identifier: Apache-2.0
"""What is proved of the arithmetic units, and a fault for each proof that must break it.

A proof yields cases; a case claims that its assumptions imply a property for all values of the
free bit vectors. Where the cases split the inputs, a case of its own claims that they cover them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from bitwuzla import Kind, Term

from scripts.synth_unit import sources_of
from tests.formal.ieee import ONE, Ieee, Outcome
from tests.formal.logic import RNE, RTZ, Logic
from tests.formal.netlist import ElaborationError, Netlist, Run, elaborate
from tests.fpu.tb import package_constant


@dataclass(frozen=True)
class Case:
    """`assume` implies `claim`; `show` are the bit vectors that a counterexample lists."""

    name: str
    claim: Term
    assume: tuple[Term, ...] = ()
    show: Mapping[str, Term] = field(default_factory=dict)


@dataclass(frozen=True)
class Fault:
    """Replacement in one file of a copy of rtl/ that must make a case of the proof fail."""

    file: str
    old: str
    new: str


class Context:
    """What a proof builds its terms from. `rtl` has the sources, `build` takes netlists."""

    def __init__(self, rtl: Path, build: Path) -> None:
        self.rtl = rtl
        self.build = build
        self.logic = Logic()
        self.ieee = Ieee(self.logic)

    def run(
        self, top: str, parameters: Mapping[str, int] | None = None, cut: tuple[str, ...] = ()
    ) -> Run:
        """Symbolic run of a module."""
        text = elaborate(top, sources_of(top, (self.rtl,)), self.build, parameters)
        return Run(self.logic, Netlist(text), cut)

    def check(
        self, name: str, run: Run, latency: int, outcome: Outcome, assume: tuple[Term, ...] = ()
    ) -> Case:
        """Result, flags and valid of a unit `latency` cycles after its operands."""
        logic = self.logic
        result, flags, valid = (
            run.output(port, latency) for port in ("result_o", "flags_o", "valid_o")
        )
        claim = logic.all(
            self.ieee.matches(result, flags, outcome), logic.eq(valid, run.input("valid_i"))
        )
        show = {port: run.input(port) for port in run.netlist.inputs if port.endswith("_i")}
        show |= {"result_o": result, "flags_o": flags, "expected flags": outcome.flags}
        return Case(name, claim, assume, show)


@dataclass(frozen=True)
class Proof:
    """One line of the table in docs/formal.md."""

    name: str
    unit: str
    claim: str
    inputs: str
    cases: Callable[[Context], Iterator[Case]]
    faults: tuple[Fault, ...]
    timeout: int = 120  # seconds per case
    quick: bool = False  # also run by pytest


PROOFS: list[Proof] = []


def proof(
    unit: str, claim: str, inputs: str, faults: tuple[Fault, ...], **options: bool | int
) -> Callable:
    """Register the decorated function, a generator of cases, as a proof of its own name."""

    def register(cases: Callable[[Context], Iterator[Case]]) -> Callable:
        PROOFS.append(Proof(cases.__name__, unit, claim, inputs, cases, faults, **options))
        return cases

    return register


# ---- conversions ----


@proof(
    "fp_i2f",
    "int32 and uint32 to binary32: result and flags",
    "all",
    (Fault("fpu/fp_i2f.sv", "|normal_e2[5:0]", "|normal_e2[5:1]"),),
    quick=True,
)
def i2f(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_i2f"), package_constant("FP_I2F_LATENCY")
    for name, unsigned in (("signed", 0), ("unsigned", 1)):
        outcome = ctx.ieee.from_integer(run.input("a_i"), signed=not unsigned)
        assume = ctx.logic.eq(run.input("unsigned_i"), unsigned)
        yield ctx.check(name, run, latency, outcome, (assume,))


@proof(
    "fp_f2i",
    "binary32 to int32, to nearest even and toward zero: result and flags",
    "all",
    (Fault("fpu/fp_f2i.sv", "a_i == 32'hcf00_0000", "a_i == 32'hcf00_0001"),),
    quick=True,
)
def f2i(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_f2i"), package_constant("FP_F2I_LATENCY")
    for name, mode, truncate in (("nearest", RNE, 0), ("toward zero", RTZ, 1)):
        outcome = ctx.ieee.to_integer(run.input("a_i"), mode)
        assume = ctx.logic.eq(run.input("truncate_i"), truncate)
        yield ctx.check(name, run, latency, outcome, (assume,))


# ---- comparisons, selections, sign operations ----

COMPARE = "EQ LT LE MIN MAX ABS NEG MOV SGN SAT SEL SELGE SELGT IADD ISUB".split()


@proof(
    "fp_cmp",
    "every operation (comparison, minimum, maximum, absolute value, negation, signum, saturate, "
    "selections, integer sum and difference; code 15 as a copy): result and flags",
    "all",
    (
        Fault("fpu/fp_cmp.sv", "(a[30:0] < b[30:0]) != a[31]", "a[30:0] < b[30:0]"),
        Fault("fpu/fp_cmp.sv", "!(a_zero_e1 && c_zero_e1)", "!a_zero_e1"),
        Fault("fpu/fp_cmp.sv", "other_e1 = a_zero_e1 ? 32'd0 :", "other_e1 ="),
    ),
    quick=True,
)
def compare(ctx: Context) -> Iterator[Case]:
    run, latency = ctx.run("fp_cmp"), package_constant("FP_CMP_LATENCY")
    a, b, c = (run.input(f"{port}_i") for port in "abc")
    for name in [*COMPARE, "15"]:
        code = 15 if name == "15" else package_constant(f"FP_CMP_{name}")
        outcome = ctx.ieee.compare(name, a, b, c)
        assume = ctx.logic.eq(run.input("op_i"), code)
        yield ctx.check(name, run, latency, outcome, (assume,))


# ---- building blocks ----


@proof(
    "fp_lzc",
    "the count is the number of leading zeros, 4 and 5 bits of count",
    "all",
    (Fault("fpu/fp_lzc.sv", "empty[k][2*g+1] && empty[k][2*g]", "empty[k][2*g+1]"),),
    quick=True,
)
def leading_zeros(ctx: Context) -> Iterator[Case]:
    logic = ctx.logic
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
            logic.eq(logic.eq(run.output("zero_o", 0), 1), logic.eq(value, 0)),
            logic.any(logic.eq(value, 0), logic.eq(count, expected)),
        )
        yield Case(f"{width} bits", claim, (), {"value_i": value, "count_o": count})


@proof(
    "fp_normalise",
    "the value is shifted left until its top bit is one, by the count given",
    "all but zero; the zero output for all",
    (Fault("fpu/fp_normalise.sv", "4'b001?: bits = 2'd2", "4'b001?: bits = 2'd3"),),
    quick=True,
)
def normalise(ctx: Context) -> Iterator[Case]:
    logic, run = ctx.logic, ctx.run("fp_normalise")
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
    (Fault("fpu/fp_shift_right.sv", "level[k][Dropped-1:0]", "level[k][Dropped-1:1]"),),
    quick=True,
)
def shift_right(ctx: Context) -> Iterator[Case]:
    logic = ctx.logic
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
    "all within the contract (exponent 1..510, subnormals with exponent 1, not zero)",
    (
        Fault(
            "fpu/fp_round.sv", "(&sig_i[22:0]) && guard_i && round_i", "(&sig_i[22:0]) && guard_i"
        ),
        Fault("fpu/fp_round.sv", "sticky_i || sig_i[0]", "sticky_i"),
    ),
    quick=True,
)
def rounding(ctx: Context) -> Iterator[Case]:
    logic, run = ctx.logic, ctx.run("fp_round")
    sign, exponent, sig = (run.input(f"{name}_i") for name in ("sign", "exp", "sig"))
    tail = logic.free(4, "tail")  # bits that the sticky bit stands for
    magnitude = logic.cat(sig, run.input("guard_i"), run.input("round_i"), tail)
    normal = logic.bit(sig, 23)
    assume = (
        logic.ne(exponent, 0),
        logic.ne(exponent, 511),
        logic.any(normal, logic.eq(exponent, 1)),
        logic.ne(magnitude, 0),
        logic.eq(run.input("sticky_i"), logic.vector(logic.ne(tail, 0))),
    )
    # sig has its unit bit at place 29 of 30
    exact = ctx.ieee.scaled(sign, magnitude, logic.extend(exponent, 12), -127 - 29)
    outcome = ctx.ieee.rounded(exact)
    result, flags = run.output("result_o", 0), run.output("flags_o", 0)
    show = {port: run.input(port) for port in run.netlist.inputs}
    show |= {"tail": tail, "result_o": result, "flags_o": flags}
    yield Case("all", ctx.ieee.matches(result, flags, outcome), assume, show)


# ---- addition ----


def exponent_of(logic: Logic, bits: Term, width: int = 10) -> Term:
    """Biased exponent of a binary32 number, that of the least normal for subnormals and zero."""
    field = logic.bits(bits, 30, 23)
    return logic.extend(logic.ite(logic.eq(field, 0), logic.bv(8, 1), field), width)


def significand_of(logic: Logic, bits: Term, width: int = 24) -> Term:
    """Significand as an integer, hidden bit included."""
    hidden = logic.vector(logic.ne(logic.bits(bits, 30, 23), 0))
    return logic.extend(logic.cat(hidden, logic.bits(bits, 22, 0)), width)


NEAR = 27  # places; beyond it the smaller operand is below the round bit


@proof(
    "fp_add",
    "sum and difference are those of IEEE 754: result and flags",
    "all; cases by distance of the exponents, signs, and length of a difference at distance 0",
    (
        Fault("fpu/fp_add.sv", "far_e2 ? (|small_e1_q)", "far_e2 ? 1'b0"),
        Fault("fpu/fp_add.sv", "&& subtract_e2_q && !inf_e2_q", "&& !inf_e2_q"),
    ),
    timeout=600,
)
def add(ctx: Context) -> Iterator[Case]:
    run, latency, logic = ctx.run("fp_add"), package_constant("FP_ADD_LATENCY"), ctx.logic
    a, b, sub = (run.input(f"{name}_i") for name in ("a", "b", "sub"))
    addend = logic.cat(logic.op(Kind.BV_XOR, logic.bits(b, 31, 31), sub), logic.bits(b, 30, 0))
    outcome = ctx.ieee.add(a, addend)
    yield from covered(ctx, sum_splits(ctx, a, addend), run, latency, outcome)


def sum_splits(ctx: Context, a: Term, b: Term) -> list[tuple[str, tuple[Term, ...]]]:
    """Cases of a sum: distance, signs, and length of a difference at distance 0."""
    logic = ctx.logic
    finite = ctx.ieee.finite(a, b)
    distance = logic.sub(exponent_of(logic, a), exponent_of(logic, b))
    differ = logic.ne(logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    sig_a, sig_b = significand_of(logic, a, 25), significand_of(logic, b, 25)
    larger_a = logic.ule(sig_b, sig_a)
    difference = logic.ite(larger_a, logic.sub(sig_a, sig_b), logic.sub(sig_b, sig_a))

    splits: list[tuple[str, tuple[Term, ...]]] = [("not finite", (logic.no(finite),))]
    far_a = logic.op(Kind.BV_SGT, distance, logic.bv(10, NEAR))
    far_b = logic.op(Kind.BV_SLT, distance, logic.bv(10, -NEAR))
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


def covered(
    ctx: Context,
    splits: list[tuple[str, tuple[Term, ...]]],
    run: Run,
    latency: int,
    outcome: Outcome,
    given: tuple[Term, ...] = (),
) -> Iterator[Case]:
    """A case per split and one that claims that `given` implies at least one of them."""
    logic = ctx.logic
    yield Case(
        "the cases cover all inputs", logic.any(*(logic.all(*terms) for _, terms in splits)), given
    )
    for name, terms in splits:
        yield ctx.check(name, run, latency, outcome, (*given, *terms))


# ---- products ----
# The 24 x 24 bit multiplication is proved alone; in the units its two addends are free vectors
# whose sum P has only the properties that `product_facts` lists and `product_facts_hold` proves.

CUT = (".outer_o", ".cross_o")


def product_of(logic: Logic, outer: Term, cross: Term) -> Term:
    """The product that the two outputs of fp_product stand for, 48 bits."""
    return logic.add(logic.extend(outer, 48), logic.shl(logic.extend(cross, 48), 17))


def product_facts(logic: Logic, a: Term, b: Term, p: Term) -> dict[str, Term]:
    """What the proofs of the units use of p = a * b, for 24-bit a and b."""
    facts = {
        "zero": logic.eq(logic.eq(p, 0), logic.any(logic.eq(a, 0), logic.eq(b, 0))),
        "two subnormals": logic.any(logic.bit(a, 23), logic.bit(b, 23), logic.ult(p, 1 << 46)),
    }
    facts["second is 1"] = logic.any(
        logic.ne(b, 1 << 23), logic.eq(p, logic.shl(logic.extend(a, 48), 23))
    )
    for name, x, y in (("first", a, b), ("second", b, a)):
        for k in range(24):  # y normal, x of k + 1 bits
            there = logic.all(
                logic.bit(y, 23), logic.ule(logic.bv(24, 1 << k), x), logic.ule(x, (2 << k) - 1)
            )
            inside = logic.all(
                logic.ule(logic.bv(48, 1 << (k + 23)), p), logic.ule(p, (4 << (k + 23)) - 1)
            )
            facts[f"{name} of {k + 1} bits"] = logic.any(logic.no(there), inside)
    return facts


@proof(
    "fp_product",
    "outer + cross * 2^17 is the product, by distributivity over the halves of the operands; "
    "its range and when it is zero, as the proofs of fp_mul and fp_fma use them",
    "all",
    (Fault("fpu/fp_product.sv", "24'(a_i[16:0] * b_i[23:17])", "23'(a_i[16:0] * b_i[23:17])"),),
    quick=True,
)
def product(ctx: Context) -> Iterator[Case]:
    logic, run = ctx.logic, ctx.run("fp_product")
    a, b = run.input("a_i"), run.input("b_i")
    show = {"a_i": a, "b_i": b}
    outputs = [run.output(name, 0) for name in ("outer_o", "cross_o")]

    def times(x: Term, y: Term, width: int = 48) -> Term:
        return logic.op(Kind.BV_MUL, logic.extend(x, width), logic.extend(y, width))

    def narrow(x: Term, y: Term) -> Term:
        return logic.extend(times(x, y, logic.width(x) + logic.width(y)), 48)

    def schoolbook(multiply: Callable[[Term, Term], Term]) -> Term:
        (x1, x0), (y1, y0) = halves
        return logic.add(
            logic.shl(multiply(x1, y1), 34),
            multiply(x0, y0),
            logic.shl(multiply(x0, y1), 17),
            logic.shl(multiply(x1, y0), 17),
        )

    halves = [(logic.bits(x, 23, 17), logic.bits(x, 16, 0)) for x in (a, b)]
    claim = logic.eq(product_of(logic, *outputs), schoolbook(narrow))
    yield Case("the unit adds four partial products", claim, (), show)
    for i, x in enumerate(halves[0]):
        for j, y in enumerate(halves[1]):
            claim = logic.eq(narrow(x, y), times(x, y))
            yield Case(f"partial product {i}{j} fits its width", claim, (), show)
    scale = logic.bv(48, 1 << 17)
    for name, x, (high, low) in zip("ab", (a, b), halves, strict=True):
        whole = logic.add(times(high, logic.bv(48, 1 << 17)), logic.extend(low, 48))
        yield Case(f"{name} is the sum of its halves", logic.eq(logic.extend(x, 48), whole))
    w, x, y, z = (logic.free(48, name) for name in "wxyz")

    def mul(*factors: Term) -> Term:
        return logic.op(Kind.BV_MUL, *factors)

    left = mul(logic.add(mul(w, scale), x), logic.add(mul(y, scale), z))
    right = logic.add(
        logic.shl(mul(w, y), 34), mul(x, z), logic.shl(mul(x, y), 17), logic.shl(mul(w, z), 17)
    )
    yield Case("distributivity, for any four numbers", logic.eq(left, right))
    for name, fact in product_facts(logic, a, b, times(a, b)).items():
        yield Case(f"range, {name}", fact, (), show)


@proof(
    "fp_mul",
    "the result is the exact product rounded as IEEE 754 states, product of the significands "
    "abstracted to its range (fp_product): result and flags",
    "all; cases both normal and other",
    (
        Fault("fpu/fp_mul.sv", "high_e3 && shifted_e3[0]", "1'b0"),
        Fault("fpu/fp_mul.sv", "fp_pkg::is_zero(a_i) && fp_pkg::is_inf(b_i)", "1'b0"),
    ),
    timeout=900,
)
def mul(ctx: Context) -> Iterator[Case]:
    logic, latency = ctx.logic, package_constant("FP_MUL_LATENCY")
    run = ctx.run("fp_mul", cut=CUT)
    a, b = run.input("a_i"), run.input("b_i")
    abstracted = abstracted_product(ctx, run, run.output("result_o", latency), a, b)
    yield abstracted.inputs
    sign = logic.op(Kind.BV_XOR, logic.bits(a, 31, 31), logic.bits(b, 31, 31))
    exponent = logic.add(exponent_of(logic, a), exponent_of(logic, b))
    exact = ctx.ieee.scaled(sign, abstracted.product, exponent, -2 * (127 + 23))
    outcome = ctx.ieee.product(a, b, exact, sign)
    normal = logic.all(*(logic.bit(significand_of(logic, x), 23) for x in (a, b)))
    splits = [("both normal", (normal,)), ("subnormal or zero", (logic.no(normal),))]
    yield from covered(ctx, splits, run, latency, outcome, abstracted.facts)


@dataclass(frozen=True)
class Abstracted:
    """A unit's run in which the product is free but for `facts`."""

    product: Term
    facts: tuple[Term, ...]
    inputs: Case  # the multiplier receives the significands that the facts speak of


def abstracted_product(ctx: Context, run: Run, result: Term, a: Term, b: Term) -> Abstracted:
    """Of a run with CUT whose `result` is that of the product of a and b."""
    logic = ctx.logic
    names = [run.named(ending) for ending in CUT]
    cycles = {run.cycle_of(name, result) for name in names}
    if len(cycles) != 1:
        raise ElaborationError(f"the addends of the product enter in cycles {sorted(cycles)}")
    cycle = cycles.pop()
    p = product_of(logic, *(run.signal(name, cycle) for name in names))
    sig_a, sig_b = significand_of(logic, a), significand_of(logic, b)
    instance = names[0].removesuffix(CUT[0])
    factors = [run.signal(f"{instance}.{port}", cycle) for port in ("a_i", "b_i")]
    claim = logic.all(*(logic.eq(x, y) for x, y in zip(factors, (sig_a, sig_b), strict=True)))
    inputs = Case("the multiplier receives the significands", claim)
    return Abstracted(p, tuple(product_facts(logic, sig_a, sig_b, p).values()), inputs)


# ---- fused multiply-add ----

FMA_FAULTS = {
    "fma": Fault("fpu/fp_fma.sv", "subtract_e2_q && !lost_e3}", "subtract_e2_q}"),
    "fma_product": Fault("fpu/fp_fma.sv", "(kind_i == fp_pkg::FMA_KIND_MUL) || ", ""),
    "fma_sum": Fault("fpu/fp_fma.sv", "? fp_pkg::ONE : b_i", "? fp_pkg::PLUS_INF : b_i"),
}
FAR_ABOVE, FAR_BELOW = -51, 27  # places of the product's last bit above that of the addend


class FmaRun:
    """fp_fma for one kind of operation, product abstracted."""

    def __init__(self, ctx: Context, kind: str) -> None:
        logic = ctx.logic
        self.latency = package_constant("FP_FMA_LATENCY")
        self.run = run = ctx.run("fp_fma", cut=CUT)
        self.a, self.b, self.c = (run.input(f"{name}_i") for name in "abc")
        if kind == "ADD":
            self.b = logic.bv(32, ONE)
        self.kind = logic.eq(run.input("kind_i"), package_constant(f"FMA_KIND_{kind}"))
        sign_a, sign_b, sign_c = (logic.bits(x, 31, 31) for x in (self.a, self.b, self.c))
        self.sign_p = logic.op(
            Kind.BV_XOR, logic.op(Kind.BV_XOR, sign_a, sign_b), run.input("neg_product_i")
        )
        self.sign_c = logic.op(Kind.BV_XOR, sign_c, run.input("neg_addend_i"))
        result = run.output("result_o", self.latency)
        self.abstracted = abstracted_product(ctx, run, result, self.a, self.b)
        self.given = (self.kind, *self.abstracted.facts)
        inputs = self.abstracted.inputs
        self.inputs = Case(inputs.name, inputs.claim, (self.kind,))


@proof(
    "fp_fma",
    "as a multiplier: the exact product rounded, product of the significands abstracted "
    "(fp_product): result and flags",
    "all, whatever the addend",
    (FMA_FAULTS["fma_product"],),
    timeout=900,
)
def fma_product(ctx: Context) -> Iterator[Case]:
    logic, fma = ctx.logic, FmaRun(ctx, "MUL")
    yield fma.inputs
    exponent = logic.add(exponent_of(logic, fma.a), exponent_of(logic, fma.b))
    exact = ctx.ieee.scaled(fma.sign_p, fma.abstracted.product, exponent, -2 * (127 + 23))
    outcome = ctx.ieee.product(fma.a, fma.b, exact, fma.sign_p)
    normal = logic.all(*(logic.bit(significand_of(logic, x), 23) for x in (fma.a, fma.b)))
    splits = [("both normal", (normal,)), ("subnormal or zero", (logic.no(normal),))]
    yield from covered(ctx, splits, fma.run, fma.latency, outcome, fma.given)


@proof(
    "fp_fma",
    "fused multiply-add and its negations: the exact sum of product and addend rounded, product "
    "of the significands abstracted (fp_product): result and flags",
    "all; cases by distance, signs and length of a difference",
    (FMA_FAULTS["fma"],),
    timeout=600,
)
def fma(ctx: Context) -> Iterator[Case]:
    logic, fma = ctx.logic, FmaRun(ctx, "FMA")
    run, a, b, c, p = fma.run, fma.a, fma.b, fma.c, fma.abstracted.product
    yield fma.inputs
    exponent_p = logic.add(*(exponent_of(logic, x, 12) for x in (a, b)))
    exponent_c = exponent_of(logic, c, 12)
    sig_c = significand_of(logic, c)
    # last bit of the product above that of the addend, in places
    above = logic.sub(logic.sub(exponent_p, exponent_c), logic.bv(12, 127 + 23))
    differ = logic.ne(fma.sign_p, fma.sign_c)
    finite = ctx.ieee.finite(a, b, c)
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
        exact = ctx.ieee.scaled(sign, magnitude, exponent, bias)
        splits.append((name, terms, exact))

    zero_c, zero_p = logic.bv(24, 0), logic.bv(48, 0)
    bias_p, bias_c = -2 * (127 + 23), -(127 + 23)
    split("not finite", (logic.no(finite),), p, zero_c, exponent_p, bias_p)
    split("product zero", (finite, no_product), zero_p, sig_c, exponent_c, bias_c)
    split(
        "addend zero",
        (finite, logic.no(no_product), no_addend),
        p,
        zero_c,
        exponent_p,
        bias_p,
    )
    one = logic.bv(1, 1)
    far_up = (both, logic.op(Kind.BV_SLE, above, logic.bv(12, FAR_ABOVE)))
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
        fma.given,
    )
    for name, terms, exact in splits:
        outcome = ctx.ieee.product_sum(a, b, c, exact, (fma.sign_p, fma.sign_c))
        yield ctx.check(name, run, fma.latency, outcome, (*fma.given, *terms))


@proof(
    "fp_fma",
    "as an adder: sum and difference are those of IEEE 754: result and flags",
    "all, whatever the second factor; cases as for fp_add",
    (FMA_FAULTS["fma_sum"],),
    timeout=600,
)
def fma_sum(ctx: Context) -> Iterator[Case]:
    logic, run, latency = ctx.logic, ctx.run("fp_fma"), package_constant("FP_FMA_LATENCY")

    def negated(port: str, by: str) -> Term:
        bits = run.input(port)
        sign = logic.op(Kind.BV_XOR, logic.bits(bits, 31, 31), run.input(by))
        return logic.cat(sign, logic.bits(bits, 30, 0))

    a, c = negated("a_i", "neg_product_i"), negated("c_i", "neg_addend_i")
    kind = logic.eq(run.input("kind_i"), package_constant("FMA_KIND_ADD"))
    outcome = ctx.ieee.add(a, c)
    yield from covered(ctx, sum_splits(ctx, a, c), run, latency, outcome, (kind,))
