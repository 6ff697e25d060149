# SPDX-License-Identifier: Apache-2.0
"""Systems under cocotb: the tests of nios_tb.py, motion_tb.py, drive_tb.py."""

from tests.cocotb import drive_tb, motion_tb, nios_tb
from tests.cocotb.bench import Run, one_test_each

test_scenario = one_test_each(
    {f"n2_system-{n}": Run("n2_system", nios_tb, f"^fpga{n}__", {"Platform": n}) for n in (1, 2)}
    | {"motion": Run("motion_front_end", motion_tb), "drive": Run("drive_front_end", drive_tb)},
    quick=("n2_system-2-*", "motion-*", "drive-*"),
)
