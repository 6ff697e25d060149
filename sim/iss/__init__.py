# SPDX-License-Identifier: Apache-2.0
"""Instruction-set model of the ASIP: `Iss(image)` executes a program image without timing."""

from sim.iss.core import TABLE_1, Iss, RunResult
from sim.iss.isa import Fault

__all__ = ["TABLE_1", "Fault", "Iss", "RunResult"]
