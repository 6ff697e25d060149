# SPDX-License-Identifier: Apache-2.0
"""Rows of `make workbench` on the Nios systems under GDB, measured by the tests of tests/gdb."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator

from asip_asm.project import ROOT
from sim.debug.row import Row

QUICK, FULL = 40, 1000  # runs with random halts in the two tests
SESSION = "test_gdb.py::test_session_of_forty_commands_on_a_program_of_the_project"
HALTS = {
    False: "test_undisturbed.py::test_random_halts__the_program_ends_as_it_does_alone",
    True: "test_undisturbed.py::test_a_thousand_runs_with_random_halts",
}
CYCLES = "test_undisturbed.py::test_debug_module_costs_no_cycle_and_no_bit"


def passes(test: str) -> tuple[bool, str]:
    """Whether a test of tests/gdb passes, and why it was skipped if it was."""
    command = [sys.executable, "-m", "pytest", "-q", "-rs", f"tests/gdb/{test}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    skipped = re.search(r"^SKIPPED .*?: (.*)$", done.stdout, re.MULTILINE)
    return done.returncode == 0 and skipped is None, skipped[1] if skipped else ""


def rows(full: bool) -> Iterator[Row]:
    """GDB's session, random halts, cycles with the debug module."""
    met, why = passes(SESSION)
    name = "GDB: a scripted session of 40 commands on a C program, output checked"
    yield Row(name, int(met), "sessions", "1", met, why)
    runs = FULL if full else QUICK
    met, why = passes(HALTS[full])
    name = "Nios: random breakpoints and steps, equal to an undisturbed run"
    yield Row(name, runs if met else None, "runs", f">= {FULL}", met and runs >= FULL, why)
    met, why = passes(CYCLES)
    name = "Nios: cycles that an idle debug module costs"
    yield Row(name, 0 if met else None, "cycles", "0", met, why)
