# SPDX-License-Identifier: Apache-2.0
"""Every custom instruction of both platforms under cocotb: the tests of custom_tb.py."""

from sim.rtl.custom_table import load
from tests.cocotb import custom_tb
from tests.cocotb.bench import Run, one_test_each

RUNS = {
    name: Run("ci_slaves", custom_tb, f"^{name}__", {"Platform": number})
    for number, name in enumerate(("fpga1", "fpga2"), 1)
}

test_scenario = one_test_each(RUNS, quick=("fpga2-*",))


def test_tables__have_every_instruction():
    bounds = {"fsat_pair", "fsat_set", "fsat_low", "fsat_high"}
    mine = {*custom_tb.GOLDEN, *bounds, "fsin", "fcos"}
    assert set(load()["fpga2"].instructions) == mine
    assert set(load()["fpga1"].instructions) == set(custom_tb.FIRST_GENERATION)
