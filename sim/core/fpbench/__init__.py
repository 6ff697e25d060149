# SPDX-License-Identifier: Apache-2.0
"""Fast bench of the arithmetic units: millions of checked operations per second and core.

`quick(op, rtl_folder)` is the short set of one operation against RTL in any folder; `Unit` runs
chosen cases; `python -m sim.core.fpbench --help` lists the commands.
"""

from sim.core.fpbench.native import BenchError, Mismatch, Report, Unit, operations
from sim.core.fpbench.quick import quick

__all__ = ["BenchError", "Mismatch", "Report", "Unit", "operations", "quick"]
