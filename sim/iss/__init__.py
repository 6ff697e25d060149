# SPDX-License-Identifier: Apache-2.0
"""Instruction-set model of the ASIP: `Iss(image)` executes a program image without timing."""

from sim.iss.core import TABLE_1, Iss, RunResult
from sim.iss.isa import Fault
from sim.iss.path import EXPORT_OF_ROW, PathFault, PathRun, run_path

__all__ = [
    "EXPORT_OF_ROW",
    "TABLE_1",
    "Fault",
    "Iss",
    "PathFault",
    "PathRun",
    "RunResult",
    "run_path",
]
