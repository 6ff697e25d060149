# SPDX-License-Identifier: Apache-2.0
"""The golden model in numpy against SoftFloat: result bits and flags."""

import numpy as np
import pytest

from sim.cocotb import golden
from sim.core.fpbench import softfloat
from sim.core.fpbench.softfloat import COMPARISONS
from tests.fpu import stimulus
from tests.fpu.tb import generator

PAIRS = {
    "add": (golden.add, softfloat.add),
    "sub": (golden.sub, softfloat.sub),
    "mul": (golden.mul, softfloat.mul),
    "div": (golden.div, softfloat.div),
    "fma": (golden.fma, softfloat.mul_add),
    "sqrt": (golden.sqrt, softfloat.sqrt),
    "i2f": (golden.float_of, softfloat.i32_to_f32),
    "u2f": (lambda a: golden.float_of(a, unsigned=True), softfloat.u32_to_f32),
    "eq": (lambda a, b: golden.compare(a, b, "eq"), softfloat.eq),
    "lt": (lambda a, b: golden.compare(a, b, "lt"), softfloat.lt),
    "le": (lambda a, b: golden.compare(a, b, "le"), softfloat.le),
    "min": (golden.least, COMPARISONS["MIN"][1]),
    "max": (golden.most, COMPARISONS["MAX"][1]),
    "sgn": (golden.sign, COMPARISONS["SGN"][1]),
    "sat": (golden.saturate, COMPARISONS["SAT"][1]),
}
PAIRS |= {
    f"f2i_{mode}": (
        lambda a, mode=mode: golden.int_of(a, truncate=mode == "truncate"),
        softfloat.f32_to_i32_saturated(softfloat.MODES[mode]),
    )
    for mode in ("truncate", "nearest")
}
COLUMNS = {"fma": 3, "sat": 3, "sqrt": 1, "i2f": 1, "u2f": 1, "sgn": 1}
COLUMNS |= {"f2i_truncate": 1, "f2i_nearest": 1}


@pytest.mark.parametrize("name", PAIRS)
def test_golden__operation__is_that_of_softfloat(name):
    rng = generator(f"golden {name}")
    corners = stimulus.cross(stimulus.corners(), stimulus.corners())
    rows = (corners, stimulus.add_pairs(rng, 3000), stimulus.mul_pairs(rng, 3000))
    a, b = (column.copy() for column in np.concatenate(rows).T)
    cancelling = golden.mul(a, b)[0] ^ golden.SIGN
    c = np.where(rng.integers(0, 2, len(a)) == 1, rng.permutation(b), cancelling)
    columns = (a, b, c.astype(np.uint32))[: COLUMNS.get(name, 2)]
    mine, theirs = (function(*columns) for function in PAIRS[name])
    wrong = np.flatnonzero((mine[0] != theirs[0]) | (mine[1] != theirs[1]))
    shown = [[f"{int(x[i]):08x}" for x in (*columns, mine[0], theirs[0])] for i in wrong[:4]]
    assert not shown
