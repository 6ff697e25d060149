# SPDX-License-Identifier: Apache-2.0
"""Bounded proof of forwarding, waiting and redirection: within some cycles of reset no program of
logic, rotate, branch and custom instructions retires a wrong address, word, destination or value,
whatever the branch table, the registers and the length of the custom instructions are.
"""

from __future__ import annotations

import pytest

from tests.bench.needs import require

require("bitwuzla", in_module=True)
require("yosys", in_module=True)

from bitwuzla import Bitwuzla, Options, Result  # noqa: E402

from sim.rtl.build import ROOT, file_list  # noqa: E402
from tests.formal import logic  # noqa: E402
from tests.formal.netlist import Netlist, Run, elaborate  # noqa: E402

SHADOW = ROOT / "tests/formal_nios/n2_shadow.sv"
FOLDER = ROOT / "build/formal_nios"
DEPTH, DEPTH_FULL = 9, 11  # clock cycles from reset on; the first instruction retires in the 7th
# Signals that the chosen instructions never select: anything goes there.
CUT = ("product_a", "quotient_a", "load_a", "sum_e", "control_m", "address_m")


def bad_cycle(depth: int) -> tuple[int | None, int | None]:
    """(First cycle in which bad_o can be high, first one with a record); None for never."""
    sources = [*file_list("nios/n2_core.f"), SHADOW]
    netlist = Netlist(elaborate("n2_shadow", sources, FOLDER))
    run = Run(netlist, cut=[f"u_core.{name}" for name in CUT])
    solver = Bitwuzla(logic.TERMS, Options())

    def possible(name: str, cycle: int) -> bool:
        solver.push()
        solver.assert_formula(run.on(name, cycle))
        result = solver.check_sat()
        solver.pop()
        return result != Result.UNSAT

    first = None
    for cycle in range(depth + 1):
        reset = 0 if cycle == 0 else 1
        solver.assert_formula(logic.eq(run.input("resetn_i", cycle), reset))
        if cycle == 0:
            continue
        if first is None and possible("retired_o", cycle):
            first = cycle
        if possible("bad_o", cycle):
            return cycle, first
    return None, first


@pytest.mark.parametrize("depth", [DEPTH, pytest.param(DEPTH_FULL, marks=pytest.mark.full)])
def test_pipeline__any_program_from_reset__retires_what_a_simple_machine_does(depth):
    bad, first = bad_cycle(depth)
    assert first is not None and first < depth
    assert bad is None
