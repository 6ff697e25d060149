# SPDX-License-Identifier: Apache-2.0
"""scripts/lint_registers.py finds literal bit positions, and none stands in the tree."""

from pathlib import Path

import pytest

from scripts.lint_registers import main, python_findings, text_findings

PLANTED = {
    "shift.py": 'rtl.write("CONTROL", 1 << 8)\n',
    "number.py": 'dut.write(CSR["IRQ_ENABLE"], 3)\n',
    "name.py": 'START = 1\ndut.write(CSR["CONTROL"], START)\n',
    "pair.py": 'writes = [(CSR["IRQ_ENABLE"], 3)]\n',
    "compare.py": 'assert rtl.read("CONFIG") == 5 | 8 << 4\n',
    "mask.py": 'def f(rtl):\n    word = rtl.read("STATUS")\n    return word & 4\n',
    "select.sv": "assign a = writedata_i[3:0] & asip_regmap_pkg::REG_ID;\n",
    "bit.sv": "assign a = writedata_i[8] & asip_regmap_pkg::REG_ID;\n",
    "filled.sv": "assign readdata_q = {16'd0, asip_regmap_pkg::REG_ID};\n",
    "nios.sv": "assign rdata_o = {31'd0, n2_io_regmap_pkg::REG_CYCLE};\n",
    "write.c": "write32(core, ASIP_WORD(csr.CONTROL), 2);\n",
    "read.c": "int busy = read32(core, CSR(STATUS)) & 1;\n",
    "nios.c": "io_write(REG_TIMER_CONTROL, 5);\n",
    "held.c": "return status & 0x4;\n",
}
GOOD = {
    "fields.py": 'rtl.write("CONTROL", REGMAP.registers["CONTROL"].word(path=1))\n',
    "zero.py": 'rtl.write("CONTROL", 0)\n',
    "number_register.py": 'dut.write(CSR["WATCHDOG"], 500)\n',
    "field.sv": "assign a = writedata_i[asip_regmap_pkg::CONTROL_START_LSB];\n",
    "field.c": "write32(core, CSR(CONTROL), MASK(CONTROL, START));\n",
}


def findings(folder: Path, name: str, text: str) -> int:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    look = python_findings if path.suffix == ".py" else text_findings
    return len(look(path)[1])


@pytest.mark.parametrize("name", PLANTED)
def test_lint__literal_position__is_found(name: str, tmp_path: Path) -> None:
    assert findings(tmp_path, name, PLANTED[name]) == 1


@pytest.mark.parametrize("name", GOOD)
def test_lint__named_field_or_number__is_left_alone(name: str, tmp_path: Path) -> None:
    assert findings(tmp_path, name, GOOD[name]) == 0


def test_lint__the_tree__has_none(capsys) -> None:
    assert main() == 0
    assert "0 literal bit positions" in capsys.readouterr().out
