# SPDX-License-Identifier: Apache-2.0
"""Is the host's arithmetic a reference? Compares it with Berkeley SoftFloat before any campaign.

The SoftFloat side is also that of the unit tests; nothing is shared with the host side in
softfloat.h. Result bits and all five flags must agree on level-1 products and on random cases of
every operation; sine and cosine are checked against MPFR in `worst_angles` instead.
"""

from __future__ import annotations

from collections.abc import Callable

import gmpy2
import numpy as np

from asip_asm.isa import default_isa
from sim.core.fpbench import softfloat
from sim.core.fpbench.native import Mismatch, Unit, operations

CASES = 12_000
PRECISION = 200  # bits of MPFR


def oracle() -> dict[str, Callable]:
    """Operation -> SoftFloat function from operand columns to (bits, flags)."""
    same = ("add", "sub", "mul", "div", "sqrt", "mul_add", "mul_sub", "neg_mul_add", "neg_mul_sub")
    table: dict[str, Callable] = {name: getattr(softfloat, name) for name in same} | {
        "fma_mul": softfloat.mul,
        "fma_neg_mul": softfloat.neg_mul,
        "fma_add": softfloat.add,
        "fma_sub": softfloat.sub,
        "i2f": softfloat.i32_to_f32,
        "u2f": softfloat.u32_to_f32,
        "f2i": softfloat.f32_to_i32_saturated(softfloat.MODES["truncate"]),
        "f2i_nearest": softfloat.f32_to_i32_saturated(softfloat.MODES["nearest"]),
    }
    compares: dict[str, Callable] = {
        name.lower(): function for name, (_, function) in softfloat.COMPARISONS.items()
    }
    spares = {name.lower(): compares["mov"] for name in default_isa().spare_comparisons}
    return table | compares | spares


def selfcheck(unit: Unit, seed: int = 1, cases: int = CASES) -> tuple[int, list[Mismatch]]:
    """Compare the references of a unit's operations; returns the number of cases, the mismatches.

    `got` of a mismatch is the host, `want` SoftFloat.
    """
    references = oracle()
    total, wrong = 0, []
    for op, (owner, count) in operations().items():
        if owner != unit.name or op not in references:
            continue
        size = unit.size(op, "level1")
        rows = [unit.operands(op, "random", 0, cases, seed)]
        part = min(size, cases)  # evenly through the level-1 product
        step = max(1, size // part)
        rows += [unit.operands(op, "level1", k * step, 1) for k in range(min(part, 4000))]
        table = np.concatenate(rows)
        bits, flags = unit.reference(op, table)
        want_bits, want_flags = references[op](*table[:, :count].T)
        for i in np.flatnonzero((bits != want_bits) | (flags != want_flags)):
            operands = tuple(int(x) for x in table[i, :count])
            values = (int(x[i]) for x in (bits, want_bits, flags, want_flags))
            wrong.append(Mismatch(op, operands, *values))
        total += len(table)
    return total, wrong


def double_error(unit: Unit, op: str, operand: int) -> float:
    """Error of the host's double-precision sine or cosine in ulp of binary32, against MPFR."""
    with gmpy2.context(precision=PRECISION):
        x = gmpy2.mpfr(float(np.uint32(operand).view(np.float32)))
        exact = (gmpy2.cos if op == "cos" else gmpy2.sin)(x)
        unit_exponent = max(gmpy2.get_exp(exact) - 24, -149)
        return float(abs(gmpy2.mpfr(unit.exact(op, operand)) - exact) / gmpy2.exp2(unit_exponent))
