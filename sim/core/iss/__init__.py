# SPDX-License-Identifier: Apache-2.0
"""Instruction-set model of the ASIP: `Iss(image)` executes a program image without timing."""

from sim.core.iss.core import Iss, RunResult
from sim.core.iss.isa import Fault
from sim.core.iss.path import run_path

__all__ = ["Fault", "Iss", "RunResult", "run_path"]
