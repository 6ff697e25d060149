# SPDX-License-Identifier: Apache-2.0
"""Layouts of waves: groups by stage, operands as numbers, source lines of both processors."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
from pathlib import Path

from asip_asm.cli_as import main as assemble
from sim.rtl.nios_image import IMAGES
from sim.rtl.wave_layout import (
    FLOAT_FILTER,
    Wave,
    filter_text,
    groups,
    gtkwave,
    main,
    mapping_text,
    source_lines,
    surfer,
)

WAVES = [
    Wave("TOP.asip.pc_d", 16),
    Wave("TOP.asip.opa_e1_q", 32),
    Wave("TOP.asip.opb_e1_q", 32),
    Wave("TOP.asip.valid_e2_q", 1),
    Wave("TOP.asip.cycles_q", 32),
    Wave("TOP.n2_core.result_m_q", 32),
]
SOURCE = """\
.input x, y
.output p, safe = 0.0
  fmul t, x, y
  fadd q, t, x
  mov p, q
  halt
"""


def test_signals_stand_in_groups_of_their_stage():
    found = {title: [w.leaf for w in members] for title, members in groups(WAVES) if members}
    assert found == {
        "program counters": ["pc_d"],
        "asip": ["cycles_q"],
        "asip, stage E1": ["opa_e1_q", "opb_e1_q"],
        "asip, stage E2": ["valid_e2_q"],
        "n2_core, stage M": ["result_m_q"],
    }


def test_operands_are_numbers_and_counters_source_lines_in_gtkwave(tmp_path):
    text = gtkwave(tmp_path / "x.fst", WAVES, tmp_path / "x.source.txt")
    assert f"@4022\n^>1 {FLOAT_FILTER}\nTOP.asip.opa_e1_q[31:0]\n" in text
    assert f"@2022\n^1 {tmp_path / 'x.source.txt'}\nTOP.asip.pc_d[15:0]\n" in text
    assert "@22\nTOP.asip.cycles_q[31:0]\n@" in text and "@22\nTOP.asip.valid_e2_q\n" in text


def test_operands_are_numbers_and_counters_source_lines_in_surfer():
    """Formats go to the item in focus, which is what was added last once an item has it."""
    lines = surfer([*WAVES, Wave("TOP.asip.alu.sum_e2_q", 32)], "asip-1 source").splitlines()
    assert lines[:4] == [
        "divider_add program_counters",
        "item_focus a",
        "variable_add TOP.asip.pc_d",
        "item_set_format asip-1 source",
    ]
    behind = dict(zip(lines, lines[1:], strict=False))
    for name in ("asip.opa_e1_q", "asip.opb_e1_q", "n2_core.result_m_q", "asip.alu.sum_e2_q"):
        assert behind[f"variable_add TOP.{name}"] == "item_set_format FP: 32-bit IEEE 754"
    assert lines.count("item_set_format FP: 32-bit IEEE 754") == 4
    dividers = [line.split(" ", 1)[1] for line in lines if line.startswith("divider_add")]
    assert "asip_alu_stage_E2" in dividers
    assert all(re.fullmatch(r"\w+", name) for name in dividers)  # Surfer drops any other
    assert lines[-2:] == ["item_unfocus", "zoom_fit"]
    assert "source" not in surfer(WAVES)


def test_mapping_of_surfer_has_its_name_width_and_a_line_per_value():
    lines = {0: "law.s:3  fmul  t, x, y | law.s:5 # mov p, q", 26: "law.s:4 halt"}
    assert mapping_text("x source", 16, lines).splitlines() == [
        "Name = x source",
        "Bits = 16",
        "0x0 law.s:3 fmul t, x, y | law.s:5 mov p, q",  # Surfer takes the rest after a # away
        "0x1a law.s:4 halt",
    ]


def test_float_filter_answers_each_line_with_the_number():
    words = [struct.pack(">f", value).hex() for value in (2.5, -0.1, float("inf"), 1e-40)]
    text = "\n".join([*words, "xxxxxxxx", ""])
    done = subprocess.run(
        [sys.executable, FLOAT_FILTER], input=text, capture_output=True, text=True, check=True
    )
    *numbers, other = done.stdout.split()
    assert [struct.pack(">f", float(n)).hex() for n in numbers] == words and other == "xxxxxxxx"


def test_source_lines_of_a_program_of_the_asip(tmp_path):
    source, image = tmp_path / "law.s", tmp_path / "law.asip.json"
    source.write_text(SOURCE)
    assert assemble([str(source), "-o", str(image)]) == 0
    bits, lines = source_lines(image)
    shown = "\n".join(lines.values())
    assert all(f"law.s:{n} {text}" in shown for n, text in ((3, "fmul t, x, y"), (5, "mov p, q")))
    assert filter_text(bits, lines).startswith("0000 law.s:3 ")


def test_source_lines_of_a_program_of_the_nios_systems():
    bits, lines = source_lines(IMAGES / "run/demo_hello_fpga2.elf")
    assert bits == 32 and lines[0x1000_0000].startswith("(start-up): orhi r27")


def test_file_that_is_not_there_is_an_error_with_its_cure(capsys):
    assert main(["/nowhere/x.fst"]) == 1
    assert "no such file; WAVES=1 writes waves" in capsys.readouterr().err
    assert main([__file__]) == 1
    assert Path(__file__).name in capsys.readouterr().err
