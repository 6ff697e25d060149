# SPDX-License-Identifier: Apache-2.0
"""Goals of the RTL for other tools: our subset of SystemVerilog, and plain Verilog in Icarus."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from asip_asm.project import ROOT
from scripts.plain_verilog import CORES, FOLDER, write_plain
from scripts.rtl_subset import check
from sim.goals import Goal, at_least, at_most, exactly, not_measured
from sim.harness.sources import RTL

# Targets that nothing measures yet: they are listed, so that the file does not pass for complete.
MISSING = (
    ("tops whose plain Verilog equals the RTL", "20", "tops"),
    ("optimised tick on ECP5-85-8, median of five seeds", "<= 0.8", "us"),
)
BENCHES = [f"tests/cocotb/test_{kind}.py" for kind in ("units", "custom", "asip", "systems")]
LOST = ("failures", "errors", "skipped")
PARSED = "tops whose plain Verilog-2001 Icarus parses"


def cocotb_tests(full: bool) -> Iterator[Goal]:
    """Scenarios of tests/cocotb that pass, and that fail."""
    name, most = "cocotb tests against the golden model", 60
    if not full:
        yield not_measured(name, f">= {most}", "tests", "make goals T=hardware RUN=full")
        return
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        command = [sys.executable, "-m", "pytest", "-q", "-n", "2", *BENCHES]
        subprocess.run([*command, f"--junitxml={report}"], cwd=ROOT, check=False)
        suite = ElementTree.parse(report).getroot()[0]
    total, lost = int(suite.attrib["tests"]), sum(int(suite.attrib[k]) for k in LOST)
    yield at_least(name, total - lost, most, "tests")
    yield exactly("cocotb tests that fail or do not run", lost, 0, "tests")


def parsed(top: str) -> bool:
    """Whether Icarus parses the plain Verilog of a top without a message. Raises PlainError."""
    file = FOLDER / f"{top}.v"
    write_plain(top, file)
    command = ["iverilog", "-g2001", "-Wall", "-i", "-t", "null", "-s", top, file]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode == 0 and not done.stdout + done.stderr


def rows(full: bool) -> Iterator[Goal]:
    """The goals; all tops only with `full`, since Yosys takes minutes."""
    found = sum(len(check(path.read_text(), path)) for path in sorted(RTL.rglob("*.sv")))
    yield at_most("constructs that the subset checker refuses", found, 0, "constructs")
    yield from cocotb_tests(full)
    for name, target, unit in MISSING:
        yield not_measured(name, target, unit, "no command measures it yet")
    if shutil.which("iverilog") is None or not full:
        cure = "install iverilog, then make goals T=hardware RUN=full"
        yield not_measured(PARSED, f"{len(CORES)}", "tops", cure)
        return
    yield exactly(PARSED, sum(map(parsed, CORES)), len(CORES), "tops")
