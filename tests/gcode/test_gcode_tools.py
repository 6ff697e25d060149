# SPDX-License-Identifier: Apache-2.0
"""Tool tables: what is read and refused, and the option --tools of the command lines."""

import pytest

from sim.motion.gcode.interpreter import GcodeErrors
from sim.motion.gcode.tools import Tool, tool_table
from sim.motion.lookahead import __main__ as lookahead_cli
from sim.motion.trajectory import __main__ as trajectory_cli

COMMANDS = [trajectory_cli.main, lookahead_cli.main]


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("T1 M6\nG43 G1 X3 Y0 F6000\nM2\n")
    return path


@pytest.fixture
def tools(tmp_path):
    path = tmp_path / "tool.tbl"
    path.write_text("T1 X2 ; probe\n")
    return path


def test_tool_table__lines_of_linuxcnc__are_tools_by_number():
    lines = ["T1 P1 D0.125 Z+0.5 ;T9", "", "; note", "t23 P4 X1 Y-2 A3 C4\n"]
    assert tool_table(lines, unit=25.4) == {
        1: Tool((0.0, 0.0, 12.7, 0.0, 0.0), 3.175),
        23: Tool((25.4, -50.8, 0.0, 3.0, 4.0)),
    }


@pytest.mark.parametrize(
    ("line", "column", "offending", "what"),
    [
        ("P1 Z1", 1, "P1 Z1", "has no tool"),
        ("T1.5 Z1", 1, "T1.5 Z1", "has no tool"),
        ("T0", 1, "T0", "has no tool"),
        ("T1 Z2", 1, "T1 Z2", "there already"),
        ("T2 Zx", 4, "Zx", "not a word"),
        ("T2 Z1 drill", 7, "drill", "not a word"),
        ("T2 Z-1" + "0" * 8, 4, "Z-1" + "0" * 8, "out of range"),
    ],
)
def test_tool_table__line_that_is_none__is_told_with_its_place(line, column, offending, what):
    with pytest.raises(GcodeErrors) as caught:
        tool_table(["T1", line], "tool.tbl")
    (error,) = caught.value.errors
    assert (error.file, error.line, error.column) == ("tool.tbl", 2, column)
    assert error.text == offending
    assert what in error.what


@pytest.mark.parametrize(
    ("main", "option"),
    [*zip(COMMANDS, ["--csv", "--json"], strict=True)],
    ids=["path", "look-ahead"],
)
def test_tools__of_the_command_line__move_the_program_by_the_offset(
    main, option, program, tools, tmp_path
):
    written = tmp_path / "written" / program.name
    written.parent.mkdir()
    written.write_text("M6\nG1 X5 Y0 F6000\nM2\n")
    results = []
    for arguments in ([program, "--tools", tools], [written]):
        result = tmp_path / "result"
        assert main([*map(str, arguments), option, str(result)]) == 0
        results.append(result.read_text().replace(str(arguments[0]), "the program"))
    assert results[0] == results[1]


@pytest.mark.parametrize("main", COMMANDS)
def test_tools__broken_table__is_told_with_its_place(main, program, tools, capsys):
    tools.write_text("T1 Z1\nT2 Zx\nT1\n")
    assert main([str(program), "--tools", str(tools)]) == 1
    told = capsys.readouterr().err
    assert told.startswith(f"{tools}:2:4: error: not a word of a tool table; got 'Zx'")
    assert f"{tools}:3:1: error: the tool is there already; got 'T1'" in told


@pytest.mark.parametrize("main", COMMANDS)
def test_tools__no_such_table__is_told(main, program, tmp_path, capsys):
    assert main([str(program), "--tools", str(tmp_path / "none.tbl")]) == 1
    told = capsys.readouterr().err
    assert told.startswith("python -m sim.")
    assert told.endswith(f": error: {tmp_path / 'none.tbl'}: No such file or directory\n")


@pytest.mark.parametrize("main", COMMANDS)
def test_tools__not_given__leave_the_program_without_tools(main, program, capsys):
    assert main([str(program)]) == 1
    assert capsys.readouterr().err.startswith(f"{program}:1:1: error: there is no tool 1")
