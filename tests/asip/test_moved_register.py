# SPDX-License-Identifier: Apache-2.0
"""A register that moves in its source moves everywhere: RTL, simulation, C driver and page follow.

In a copy of the tree CONTROL.start, two fields of STATUS and STATUS itself get other places in
regmap.rdl; the generated files are made again, the core is built and runs a program twice.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from asip_asm.gen.asip_regmap import REGMAP
from tests.bench.commands import output
from tests.bench.copies import share_models

ROOT = Path(__file__).parents[2]
MOVES = {
    "} start[0:0]": "} start[9:9]",
    "} done[1:1];\n      field {} fault[2:2];": "} done[30:30];\n      field {} fault[17:17];",
    "} STATUS @ 0x0C": "} STATUS @ 0x3C",
    "} STREAM @ 0x3C": "} STREAM @ 0x0C",
}
ADDRESS_BITS = (len(REGMAP.registers) - 1).bit_length()
FOLLOWED = {
    "rtl/gen/asip_regmap_pkg.sv": ("CONTROL_START_LSB = 9;", f"REG_STATUS = {ADDRESS_BITS}'hf;"),
    "asip_asm/gen/asip_regmap.py": ("done=30",),
    "sim/core/host/gen/asip_regs.h": ("ASIP__CSR__STATUS__FAULT_bp 17",),
    "docs/regmap.md": ("| 0x000f | `STATUS` |", "| 30 | `done` |", "| 9 | `start` |"),
}


@pytest.fixture(scope="module")
def moved(tmp_path_factory) -> Path:
    """The copy, its generated files made again."""
    copy = tmp_path_factory.mktemp("moved")
    for folder in ("asip_asm", "sim", "rtl", "scripts", "docs", "nios_sw"):
        ignored = shutil.ignore_patterns("__pycache__", "data", "images")
        shutil.copytree(ROOT / folder, copy / folder, ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", copy)
    source = copy / "asip_asm/regmap.rdl"
    text = source.read_text(encoding="utf-8")
    for old, new in MOVES.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    source.write_text(text, encoding="utf-8")
    share_models(copy / "build", "verilated-*")
    run(copy, "scripts/gen_regmap.py")
    return copy


def run(copy: Path, *arguments: object) -> str:
    """Output of the copy's Python."""
    environment = os.environ | {"PYTHONPATH": str(copy)}
    return output(sys.executable, *arguments, cwd=copy, env=environment, timeout=900)


@pytest.mark.parametrize("name", FOLLOWED)
def test_move__generated_file__follows(name: str, moved: Path) -> None:
    text = (moved / name).read_text(encoding="utf-8")
    assert all(piece in text for piece in FOLLOWED[name])
    assert not any(piece in (ROOT / name).read_text(encoding="utf-8") for piece in FOLLOWED[name])


def test_move__hardware_harness_and_driver__follow(moved: Path, tmp_path: Path) -> None:
    here = Path(__file__).parent
    found = json.loads(run(moved, here / "moved_register.py", tmp_path, here / "moved_register.c"))
    assert found["address"] == 15 and found["masks"]["done"] == 1 << 30
    assert found["masks"]["fault"] == 1 << 17
    assert found["harness"]["fault"] == "NONE"
    assert found["harness"]["words"] == found["wanted"]
    assert found["harness"]["status"] & (1 << 30 | 1 << 17) == 1 << 30, "done, no fault"
    assert found["driver"] == {"result": 0, "words": found["wanted"], "done": 1}
    assert found["status"] >> 30 == 1 and found["old_status"] == 0, "nothing stands where it was"
