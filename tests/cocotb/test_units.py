# SPDX-License-Identifier: Apache-2.0
"""Every arithmetic unit under cocotb: the tests of unit_tb.py."""

from tests.cocotb import unit_tb
from tests.cocotb.bench import Run, one_test_each

UNITS = ("add", "mul", "fma", "divsqrt", "divsqrt_folded", "cmp", "i2f", "f2i")
UNITS += ("sincos", "sincos_overlapped")
RUNS = {f"fp_{unit}": Run(f"fp_{unit}", unit_tb, f"^fp_{unit}__|unit={unit}$") for unit in UNITS}

test_scenario = one_test_each(RUNS)
