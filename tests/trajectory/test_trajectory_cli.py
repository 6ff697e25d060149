# SPDX-License-Identifier: Apache-2.0
"""What `python -m sim.motion.trajectory` prints: text as it is, whole tables, a unit a number."""

import os

import pytest

from sim.motion.command import output
from sim.motion.lookahead.__main__ import main as lookahead
from sim.motion.trajectory.__main__ import main

LINE = "G1 X[#1] Y[#2 + 10] Z[600 + #1] A[ABS[#1] * 3] C12.345678 F1234.5678"


@pytest.fixture
def program(tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text(f"#1=3 #2=1\n{LINE}\nM2\n")
    return file


def test_tables__into_a_file__are_neither_wrapped_nor_cut_nor_read_as_markup(program, capsys):
    assert main([str(program)]) == 0
    shown = capsys.readouterr().out
    assert LINE in shown
    assert "…" not in shown
    (row,) = [line for line in shown.splitlines() if "F1234" in line]
    for unit in (" mm ", " m/min "):
        assert unit in row
    assert "motion" in shown and "time [s]" in shown


def test_tables__of_the_axes__have_units(program, capsys):
    main([str(program)])
    rows = capsys.readouterr().out.split("axes")[1].splitlines()
    for name, unit in (("x", "mm"), ("alpha", "deg")):
        (row,) = [line for line in rows if f" {name} " in line]
        assert row.count(f" {unit} ") == 2 and f" {unit}/s " in row and f" {unit}/s2 " in row


def test_output__on_a_terminal__keeps_its_width(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    assert output().width == 120


def test_motion__too_long_to_be_held__is_told_with_the_command_that_can(tmp_path, capsys):
    file = tmp_path / "slow.ngc"
    file.write_text("G1 X3 F0.5\nM2\n")
    assert main([str(file)]) == 1
    shown = capsys.readouterr().err
    assert "slow.ngc:1: error: the motion is too long to be held" in shown
    assert "python -m sim.motion.lookahead" in shown


@pytest.mark.parametrize(
    ("command", "option"), [(main, "--csv"), (lookahead, "--json")], ids=["trajectory", "lookahead"]
)
def test_output_file__pipe_or_input__refused(program, tmp_path, capsys, command, option):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert command([str(program), option, str(pipe)]) == 1
    assert "pipe: is a pipe that nothing reads" in capsys.readouterr().err
    text = program.read_text()
    assert command([str(program), option, str(program)]) == 1
    assert "would overwrite the input" in capsys.readouterr().err
    assert program.read_text() == text
