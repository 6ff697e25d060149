# SPDX-License-Identifier: Apache-2.0
"""Proofs of fp_sincos_overlapped, which works on three operations: their steps, and operands
outside the approximation in any order.

An observer remembers which of the last clocks accepted an operation. The unit's counters must say
the same in every clock, and no two operations may use the second multiplier together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bitwuzla import Term

from tests.formal.catalogue import Case, Context, proof
from tests.formal.induction import Values, inductive
from tests.formal.logic import Logic
from tests.formal.netlist import Run
from tests.formal.trigonometry import OUTSIDE, outside
from tests.fpu.tb import package_constant

UNIT = "fp_sincos_overlapped"
LATENCY = package_constant("FP_SINCOS_OVERLAPPED_LATENCY")
INTERVAL = 11
# Steps that a counter tells: it is 1 in the first of them.
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


class Steps:
    """Bit k - 1: an operation is in its step k, accepted k clocks ago."""

    widths = {"steps": LATENCY}

    def after_reset(self, logic: Logic) -> Values:
        return {"steps": logic.bv(LATENCY, 0)}

    def next(self, run: Run, own: Values) -> Values:
        logic = run.logic
        accepted = logic.all(
            logic.eq(run.output("ready_o", 0), 1), logic.eq(run.input("valid_i"), 1)
        )
        older = logic.bits(own["steps"], LATENCY - 2, 0)
        return {"steps": logic.cat(older, logic.vector(accepted))}

    def assumed(self, run: Run, own: Values, then: Values) -> Mapping[str, Term]:
        return {}

    def invariant(self, run: Run, own: Values, cycle: int) -> Mapping[str, Term]:
        logic, steps = run.logic, own["steps"]

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
        logic = run.logic

        def among(name: str, *values: int) -> Term:
            return logic.any(*(logic.eq(run.signal(name, 0), value) for value in values))

        def one_of(*users: Term) -> Term:
            pairs = [(a, b) for i, a in enumerate(users) for b in users[:i]]
            return logic.all(*(logic.no(logic.all(*pair)) for pair in pairs))

        loading = [logic.eq(run.signal("first_load", 0), 1)]
        loading += [logic.eq(run.signal(name, 0), 1) for name in ("load_held", "load_sum")]
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
                    logic.eq(run.signal("first_loaded_q", 0), 1),
                    logic.eq(logic.bits(first, 1, 0), 0),
                ),
            ),
        }  # fmt: skip


@proof(
    UNIT,
    "each operation that is accepted is answered after the latency, and nothing else is; the "
    "counters tell the steps of three operations; the second multiplier has the factors of one "
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
    steps = ctx.logic.free(LATENCY, "steps")
    state = Steps().invariant(run, {"steps": steps}, 0)
    yield from outside(ctx, run, LATENCY, tuple(state.values()))
