# SPDX-License-Identifier: Apache-2.0
"""Goals of the workbench on the Nios systems under GDB, measured by the tests of tests/gdb."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator

from asip_asm.project import ROOT
from sim.report.goals import Goal, depth, exactly, not_measured

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


def failed(name: str, target: str, unit: str) -> Goal:
    """The goal of a test that fails."""
    return Goal(name, None, unit, target, False, "the test fails")


def rows(full: bool) -> Iterator[Goal]:
    """GDB's session, random halts, cycles with the debug module."""
    met, why = passes(SESSION)
    name = "GDB: a scripted session of 40 commands on a C program, output checked"
    yield not_measured(name, "1", "sessions", why) if why else exactly(name, met, 1, "sessions")
    runs = FULL if full else QUICK
    met, why = passes(HALTS[full])
    name = "Nios: random breakpoints and steps, equal to an undisturbed run"
    target, cure = f">= {FULL}", "RUN=full makes them all"
    if why:
        yield not_measured(name, target, "runs", why)
    else:
        yield depth(name, runs, FULL, "runs", cure) if met else failed(name, target, "runs")
    met, why = passes(CYCLES)
    name = "Nios: cycles that an idle debug module costs"
    if why:
        yield not_measured(name, "0", "cycles", why)
    else:
        yield exactly(name, 0, 0, "cycles") if met else failed(name, "0", "cycles")
