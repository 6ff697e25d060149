# SPDX-License-Identifier: Apache-2.0
"""The files of docs/cocotb.md, as a user saves them, with pytest and with cocotb's Makefile."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks, write_files
from sim.cocotb.runner import outcomes
from tests.bench.commands import output
from tests.bench.needs import needs

PAGE = ROOT / "docs/cocotb.md"
SIMULATORS = ["verilator", pytest.param("icarus", marks=needs("iverilog", "yosys"))]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_files(PAGE, tmp_path)
    (makefile,) = (block.text for block in code_blocks(PAGE) if block.language == "make")
    (tmp_path / "Makefile").write_text(makefile, encoding="utf-8")
    return tmp_path


def environment() -> dict[str, str]:
    """As after activating the environment; a run of pytest in pytest is one of its own."""
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    own = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "MAKE", "WAVES"))}
    return own | {"PATH": path, "PYTHONPATH": str(ROOT)}


def test_page__test_of_a_tick__is_short():
    (block,) = (b for b in code_blocks(PAGE) if b.title == "test_sum.py")
    assert len(block.text.strip().splitlines()) <= 30


@pytest.mark.parametrize("sim", SIMULATORS)
def test_page__with_pytest(folder, sim):
    command = [sys.executable, "-m", "pytest", "-q", "test_sum.py", "-k", sim]
    said = output(*command, cwd=folder, env=environment(), timeout=600)
    assert "1 passed" in said


@pytest.mark.parametrize("sim", SIMULATORS)
def test_page__with_its_makefile(folder, sim):
    output("make", f"SIM={sim}", cwd=folder, env=environment(), timeout=600)
    assert outcomes(folder / "results.xml") == {"every_tick_is_right": ""}
