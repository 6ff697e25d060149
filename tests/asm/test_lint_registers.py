# SPDX-License-Identifier: Apache-2.0
"""scripts/lint_registers.py finds literal bit positions, and none is in the tree."""

from pathlib import Path

import pytest

from scripts.lint_registers import main, python_findings, text_findings

ESC = "from sim.bus.gen import esc_regmap\n"
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
    "esc.py": f"{ESC}line.write(esc_regmap.PDI_CONFIG, 1)\n",
    "esc_bytes.py": f'{ESC}single(2, 0, esc_regmap.AL_CONTROL.address, b"\\x12\\0")\n',
    "esc_mask.py": f"{ESC}assert line.read(esc_regmap.SM_STATUS, 0) & 8 == 0\n",
    "esc_part.py": f"{ESC}assert line.read(esc_regmap.DL_STATUS) & MASK == 0x600\n",
    "esc_call.py": f"{ESC}state = register(esc_regmap.AL_STATUS) & 0x1F\n",
    "read_word.py": 'def f(a):\n    w = a.read_word(B + M.address("STATUS"))\n    return w >> 3\n',
    "int.py": 'def f(rtl):\n    word = int(rtl.read("STATUS"))\n    return word & 3\n',
    "keyword.py": 'a.write(CSR["CONTROL"], word=5)\n',
    "local.py": 'def f(a):\n    x = 1 << 3\n    a.write("CONTROL", x)\n',
    "address.py": 'def f(a):\n    at = B + M.address("HEAD")\n    a.write_words(at, [2 << 4])\n',
    "subfield.py": 'host.write(10, "MODE", axis0=1 | 1 << 2)\n',
    "subword.py": 'MAP.registers["MODE"].word(axes=2 << 2)\n',
    "taken.sv": "  else control_q <= register_i.data;\nassign a = control_q[2];\n",
    "access.sv": "assign a = register_i.data[0];\n",
    "multiple.sv": "assign a = writedata_i[4*Axes-1:0];\n",
    "lane.sv": "assign status_o[8*n+:8] = {2'b00, last, esc_regmap_pkg::REG_SM_STATUS};\n",
    "alone.sv": "assign a = writedata_i[3];\n",
    "bus.c": "uint32_t busy = bus.read(csr.STATUS) & 1;\n",
    "host.c": "host.write(csr.CONTROL, 5);\n",
    "variable.c": "uint32_t word = io_read(REG_TICK_STATUS);\nreturn word & 1;\n",
    "pointer.cpp": "read(host.status, &word);\nlast = word;\nreturn last >> host.cause_low & 15;\n",
    "esc_value.c": "esc_write8(ESC_SM_PDI(1), 3);\n",
    "esc_word.c": "uint32_t event = esc_read32(ESC_AL_EVENT);\nif (event & (1u << 10)) act();\n",
    "esc_memory.c": "return memory[ESC_SM_CONTROL(n)] & 4;\n",
    "esc_set.c": "memory[ESC_SM_PDI(n)] = 1;\n",
}
GOOD = {
    "fields.py": 'rtl.write("CONTROL", REGMAP.registers["CONTROL"].word(path=1))\n',
    "zero.py": 'rtl.write("CONTROL", 0)\n',
    "number_register.py": 'dut.write(CSR["WATCHDOG"], 500)\n',
    "field.sv": "assign a = writedata_i[asip_regmap_pkg::CONTROL_START_LSB];\n",
    "field.c": "write32(core, CSR(CONTROL), MASK(CONTROL, START));\n",
    "esc.py": f"{ESC}line.write(esc_regmap.PDI_CONFIG, esc_regmap.PDI_CONFIG.word(emulation=1))\n",
    "esc_number.py": f"{ESC}line.write(esc_regmap.PULSE_LENGTH, 5)\n",
    "place.py": f"{ESC}assert not line.read(esc_regmap.SM_STATUS, 1) & MASK\n",
    "power.py": 'MAP.registers["STEP_TIMING"].word(length=1 << 9)\n',
    "bytes.sv": "assign a[8*i+:8] = strobe_i[i] ? writedata_i[8*i+:8] : b;\n",
    "fields.sv": "assign a = writedata_i[p_regmap_pkg::A_LSB+:4*p_regmap_pkg::A_WIDTH];\n",
    "block.c": "esc_read(ESC_SM_ACTIVATE(1), bytes, 8);\n",
    "esc.c": "esc_write8(ESC_SM_PDI(1), 1u << ESC_SM_PDI_DISABLE_LSB);\n",
    "esc_mask.c": "uint8_t on = esc_read8(ESC_SM_PDI(1));\nreturn on & ESC_SM_PDI_DISABLE_MASK;\n",
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
