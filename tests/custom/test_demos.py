# SPDX-License-Identifier: Apache-2.0
"""The demos on both simulated systems: hardware runs, and gives the same results as software.

The cycles that a demo prints include moves of the compiler: at least those of the instruction.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sim.rtl.build import ROOT
from sim.rtl.custom_table import load
from sim.rtl.nios_image import read_elf
from sim.rtl.nios_rtl import NiosRtl
from tests.bench.commands import output
from tests.bench.needs import needs

LIMIT = 200_000  # cycles of a demo, an order above the longest
LINE = re.compile(r"^(\w+): hardware, (\d+) cycles \(software: (\d+)\), same result$", re.M)


@needs("nios-gcc")
@pytest.mark.parametrize("platform", ["fpga1", "fpga2"])
def test_demos__on_the_system__every_instruction_runs_and_agrees_with_software(platform, tmp_path):
    instructions = load()[platform].instructions
    names = sorted(path.stem for path in (ROOT / "nios_sw/demo").glob("ci_*.c"))
    programs = [tmp_path / f"demo_{name}_{platform}.elf" for name in names]
    output("make", "-s", "-C", ROOT / "nios_sw", f"BUILD={tmp_path}", *programs)
    measured = {}
    for program in programs:
        text = run(platform, program)
        assert "other result" not in text
        found = {name: (int(hard), int(soft)) for name, hard, soft in LINE.findall(text)}
        told = set(re.findall(r"^(\w+): software, \d+ cycles; no instruction", text, re.M))
        assert told.isdisjoint(instructions), text
        measured |= found
        if program.stem.startswith("demo_ci_fph1"):
            assert ("subnormal result: zero" in text) == (platform == "fpga1")
    assert set(measured) == set(instructions) - {"fsat_set"}
    short = {n: hard for n, (hard, _) in measured.items() if hard < instructions[n].cycles}
    assert short == {}, "faster than the table allows"


def run(platform: str, program: Path) -> str:
    """Console of a program that must end with status 0."""
    system = NiosRtl(platform)  # a model runs one program
    system.load(read_elf(program))
    system.start()
    assert system.execute(LIMIT) == 0, f"{program.stem}: {system.console}"
    return system.console
