# SPDX-License-Identifier: Apache-2.0
"""Generated packages and tables: the committed ones are current, and a stale one is refused."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.isa import default_isa
from tests.bench.commands import output

ROOT = Path(__file__).parents[2]
GENERATOR = (sys.executable, ROOT / "scripts/gen_isa.py")


def localparams(name: str) -> dict[str, int]:
    """Values of the localparams of a generated package."""
    text = (ROOT / "rtl" / "gen" / name).read_text(encoding="utf-8")
    found = re.findall(r"localparam [^=]*?(\w+) = (?:\d+'([bh])([0-9a-f]+)|(\d+));", text)
    bases = {"b": 2, "h": 16}
    return {
        name: int(digits, bases[base]) if base else int(decimal)
        for name, base, digits, decimal in found
    }


@pytest.mark.parametrize("script", ["gen_isa.py", "gen_regmap.py"])
def test_check__committed_files__are_current(script: str) -> None:
    output(sys.executable, ROOT / "scripts" / script, "--check")


def test_check__changed_file__fails_with_a_diff_and_writes_nothing(tmp_path: Path) -> None:
    output(*GENERATOR, "--root", tmp_path)
    stale = tmp_path / "rtl" / "gen" / "asip_isa_pkg.sv"
    text = stale.read_text(encoding="utf-8").replace("OP_FADD = 6'b011000", "OP_FADD = 6'b011001")
    stale.write_text(text, encoding="utf-8")
    command = [*GENERATOR, "--check", "--root", tmp_path]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "-  localparam logic [5:0] OP_FADD = 6'b011001;" in result.stdout
    assert "generated files are stale" in result.stderr
    assert stale.read_text(encoding="utf-8") == text


def test_isa_package__holds_every_opcode_and_limit() -> None:
    values = localparams("asip_isa_pkg.sv")
    isa = default_isa()
    for record in isa.operations.values():
        assert values[f"OP_{record.name.upper()}"] == record.opcode
    for bank in isa.banks.values():
        assert values[f"BANK_{bank.name.upper()}"] == bank.code
    assert values["FAST_BUNDLE_WIDTH"] == 128
    assert values["PROGRAM_BUNDLES"] == isa.program_bundles
    assert values["FIELD_A_LSB"] == 18


def test_register_map_package__holds_every_address_and_fault() -> None:
    values = localparams("asip_regmap_pkg.sv")
    for register in REGMAP.registers.values():
        assert values[f"REG_{register.name}"] == register.offset
    for block in REGMAP.blocks.values():
        assert values[f"BASE_{block.name.upper()}"] == block.base
        assert values[f"WORDS_{block.name.upper()}"] == block.words
    for fault in REGMAP.faults.values():
        assert values[f"FAULT_{fault.name}"] == fault.code


def test_documents__list_every_operation_and_register() -> None:
    isa_text = (ROOT / "docs" / "isa.md").read_text(encoding="utf-8")
    regmap_text = (ROOT / "docs" / "regmap.md").read_text(encoding="utf-8")
    for record in default_isa().operations.values():
        assert f"| {record.opcode:06b} | `{record.name}" in isa_text
    for name in REGMAP.registers:
        assert f"| `{name}` |" in regmap_text
