# SPDX-License-Identifier: Apache-2.0
"""Goals of the RTL for other tools: our subset of SystemVerilog, and the cocotb tests."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from asip_asm.project import ROOT
from scripts.rtl_subset import check
from sim.report.goals import Goal, at_least, at_most, exactly, not_measured
from sim.rtl.sources import RTL

BENCHES = [f"tests/cocotb/test_{kind}.py" for kind in ("units", "custom", "asip", "systems")]
LOST = ("failures", "errors", "skipped")


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


def rows(full: bool) -> Iterator[Goal]:
    """The goals; the cocotb tests only with `full`."""
    found = sum(len(check(path.read_text(), path)) for path in sorted(RTL.rglob("*.sv")))
    yield at_most("constructs that the subset checker refuses", found, 0, "constructs")
    yield from cocotb_tests(full)
