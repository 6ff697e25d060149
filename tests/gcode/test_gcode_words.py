# SPDX-License-Identifier: Apache-2.0
"""Interpreter: what rs274 cannot be asked, streams, the table frame, mistakes."""

import dataclasses
import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.gcode import table_frame
from sim.motion.gcode.interpreter import GcodeErrors, parse, parse_file, stream, stream_file
from sim.motion.gcode.tools import Tool
from sim.motion.geometry.moves import Dwell, Motion, Move
from sim.motion.geometry.workspace import default_robot, pivot_of
from sim.robot.parameters import Robot
from tests.gcode.mistakes import ZERO, check_error, errors_of

PIVOT = (0.0, 0.0, 520.0)  # mm: the start height 600 less h = 80 of the default robot


def to_machine(pose):
    return table_frame.to_machine(pose, PIVOT)


def from_machine(pose):
    return table_frame.from_machine(pose, PIVOT)


def ends(text: str):
    return [move.end for move in parse(text, start=ZERO).moves]


def test_home__set_by_parameters__is_the_end_of_g28():
    text = "#5161=10 #5162=20 #5163=30 #5164=4 #5166=5\nG0 X1\nG28\nM2"
    assert ends(text)[-1] == (10, 20, 30, 4, 5)


def test_home__at_first__is_the_start():
    assert parse("G0 X5 A3\nG28\nM2").moves[-1].end == (0.0, 0.0, 600.0, 0.0, 0.0)


def test_coordinate_system__set_by_parameters__acts_when_selected():
    assert ends("#5241=3 #5242=4\nG0 X1\nG55 X1 Y1\nM2") == [(1, 0, 0, 0, 0), (4, 5, 0, 0, 0)]


def test_path_control__words__set_tolerance_and_merging_of_the_moves():
    text = "G1 X1 F9\nG64 X2\nG64 P0.1 Q0.02\nX3\nG20 G64 P.01\nX4\nG61 X5\nM2"
    assert [(m.tolerance, m.merge) for m in parse(text, start=ZERO).moves] == [
        (0, 0), (math.inf, 0), (0.1, 0.02), (pytest.approx(0.254),) * 2, (0, 0),
    ]  # fmt: skip


def test_dwells__in_a_program__stand_before_their_moves():
    program = parse("G4 P1\nG0 X1\nG4 P2\nM2")
    assert [(k, dwell.seconds) for k, dwell in program.dwells] == [(0, 1.0), (1, 2.0)]


@pytest.mark.parametrize("word", ["M0", "M1", "M60", "M6"])
def test_pause__of_each_kind__is_a_stop_of_the_path(word):
    program = parse(f"G0 X1 {word}\nG0 X2\nM2")
    (dwell,) = program.dwells
    assert dwell[0] == (0 if word == "M6" else 1)
    assert (dwell[1].line, dwell[1].seconds) == (1, 0.0)


def test_tools__offset__moves_the_point_of_the_program():
    tools = {4: Tool((1.0, 2.0, 3.0, 0.0, 5.0))}
    program = parse("T4 M6\nG43 G0 X10 Y0 Z0 C0\nG49 X0 Y0\nM2", start=ZERO, tools=tools)
    assert [move.end for move in program.moves] == [(11, 2, 3, 0, 5), (0, 0, 3, 0, 5)]


def test_percent__at_the_end_alone__ends_the_text():
    assert ends("G0 X1\nM2\n%\nG0 X2 !") == [(1, 0, 0, 0, 0)]


def test_percent__at_both_ends__needs_no_m2():
    assert ends("%\nG0 X1\n%\nG0 X2 !") == [(1, 0, 0, 0, 0)]


def test_stream__endless_text__yields_moves_as_it_reads():
    lines = (f"G1 X{k % 100} F100" for k in itertools.count())
    moves = list(itertools.islice(stream(lines), 10))
    assert [move.line for move in moves] == list(range(1, 11))


def test_stream__mistake__comes_behind_the_good_blocks(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("G0 X1\nG0 X2 T1\nG0 X3\nG0 Z\nM2\n")
    moves = []
    with pytest.raises(GcodeErrors) as caught:
        for item in stream_file(path):
            moves.append(item)
    assert [move.end[0] for move in moves] == [1.0]
    assert [(e.line, e.column) for e in caught.value.errors] == [(2, 7), (4, 4)]


def test_stream_file__and_parse_file__read_the_same(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("%\nG64 P.1\nG0 X1\nG4 P1\nG1 Y2 F5\nM2\n%\n")
    items = list(stream_file(path))
    program = parse_file(path)
    assert tuple(item for item in items if isinstance(item, Move)) == program.moves
    assert [item for item in items if isinstance(item, Dwell)] == [d for _, d in program.dwells]


# Table frame


@given(st.tuples(*[st.floats(-200, 200)] * 3, st.floats(-90, 90), st.floats(-720, 720)))
def test_table_frame__there_and_back__is_the_same_pose(pose):
    assert from_machine(to_machine(pose)) == pytest.approx(pose, abs=1e-9)


def test_table_frame__pivot__is_that_of_the_robot():
    assert pivot_of(default_robot()) == PIVOT
    text = "G43.4\nG0 A90\nM2"
    low = dataclasses.replace(Robot.load(), z_min=0.2, z_max=0.4, z_start=0.3, h=0.05)
    for robot, start, h in ((default_robot(), 600, 80), (low, 300, 50)):
        moves = parse(text, robot=robot).moves
        assert moves[0].start == (0, 0, start, 0, 0)
        assert moves[-1].end == pytest.approx((0, -h, start - h, 90, 0), abs=1e-9)


def test_table_frame__turned_table__carries_the_point_with_it():
    # By hand: C90 takes +X to +Y, then A90 takes +Y to +Z, about the pivot.
    x, y, z = PIVOT
    assert to_machine((x + 10, y, z, 0, 90))[:3] == pytest.approx((x, y + 10, z))
    assert to_machine((x + 10, y, z, 90, 90))[:3] == pytest.approx((x, y, z + 10))
    assert to_machine((x, y, z + 80, 90, 0))[:3] == pytest.approx((x, y - 80, z))


def test_table_frame__point_held_while_the_table_turns__keeps_its_place_on_the_work_piece():
    moves = parse("G43.4\nG0 X30 Y5 Z605\nG1 A20 C90 F600\nM2").moves
    for move in moves[1:]:
        assert from_machine(move.end)[:3] == pytest.approx((30, 5, 605), abs=1e-9)
    assert all(move.inner for move in moves[2:])
    assert moves[-1].end[3:] == (20, 90)


def test_table_frame__feed__is_that_of_the_tool_on_the_work_piece():
    moves = parse("G43.4\nG1 X30 Y5 A20 C90 F600\nM2").moves
    minutes = 0.0
    for move in moves:
        tool = math.dist(move.start[:3], move.end[:3])
        minutes += tool / move.feed
    assert minutes * 600 == pytest.approx(math.hypot(30, 5), rel=1e-9)


def test_table_frame__chords__miss_the_curve_by_less_than_they_may():
    moves = parse("G43.4\nG1 X40 Y5 A30 C170 F600\nM2").moves
    count = len(moves)
    for k, move in enumerate(moves):
        share = (k + 0.5) / count
        true = to_machine((40 * share, 5 * share, 600, 30 * share, 170 * share))
        middle = [(a + b) / 2 for a, b in zip(move.start, move.end, strict=True)]
        assert math.dist(middle[:3], true[:3]) <= 0.0005


def test_table_frame__ended_by_g49__counts_in_the_machine_again():
    moves = parse("G43.4\nG0 A30\nG49\nG0 X5 Y0 Z600\nM2").moves
    assert moves[-1].end == (5, 0, 600, 30, 0)
    assert all(move.motion is Motion.RAPID for move in moves)


# Text, column, offending text, part of what, part of expected.
MISTAKES = {
    "expression open": ("G0 X[1+2\nM2", 5, "[1+2", "not closed", "operator or ]"),
    "value missing": ("G0 X[1+]\nM2", 8, "]", "a value is missing", "a number"),
    "unknown function": ("G0 X[SINH[1]]\nM2", 6, "SINH", "unknown function", "SIN"),
    "function without bracket": ("G0 X[SIN 3]\nM2", 10, "3", "opening bracket", "[ after"),
    "arc tangent": ("G0 X[ATAN[1]]\nM2", 6, "ATAN[1]", "two values", "ATAN[y]/[x]"),
    "division": ("G0 X[1/[2-2]]\nM2", 7, "/", "no value for these numbers", "finite"),
    "root": ("G0 X[SQRT[0-1]]\nM2", 6, "SQRT", "SQRT has no value", "finite"),
    "power": ("G0 X[[0-8] ** .5]\nM2", 12, "**", "no value", "finite"),
    "name without value": ("G0 X#<a>\nM2", 5, "#<a>", "#<a> has no value", "line before"),
    "bad parameter": ("#0=3\nM2", 2, "0", "not the number of a parameter", "1 to 5999"),
    "read only": ("#5220=3\nM2", 1, "#5220=3", "read only", "another"),
    "result too large": ("G0 X[9000*2000]\nM2", 4, "X[9000*2000]", "out of range", "1e+07"),
    "nested": ("G0 X" + "[" * 60 + "1" + "]" * 60 + "\nM2", 55, "[", "nested too deeply", "50"),
    "block delete": ("G0 X1 /Y2\nM2", 7, "/Y2", "unexpected character", "a word"),
    "blanks in a number": ("G0 X1 2 Y1 . .2\nM2", 9, "Y1 . .2", "malformed", "one decimal"),
    "turns": ("G2 I1 P1.5 F9\nM2", 7, "P1.5", "number of turns", "from 1 to 1000"),
    "P of two": ("G64 P1 G2 I1 F9\nM2", 5, "P1", "belongs to G64 and to G2", "one word with P"),
    "machine coordinates of nothing": ("G53 G0\nM2", 1, "G53", "without a position", "X Y Z A C"),
    "inverse time of a rapid": ("G93 G0 X1 F2\nM2", 11, "F2", "no move of the block", "G1, G2"),
    "inverse time of nothing": ("G93 F2\nM2", 5, "F2", "no move of the block", "G1, G2"),
    "inverse time ended": ("G93 G1 X2 F2\nG94 X3\nM2", 1, "G94", "no feed is set", "F word in"),
    "subprogram shared": ("M98 P1 X2\nM2", 8, "X2", "M98 shares its block", "M98 alone"),
    "subprogram in part": ("M98 P1.5\nM2", 5, "P1.5", "M98 with P1.5", "whole numbers"),
    "subprogram without P": ("M98 L2\nM2", 1, "M98", "M98 without P", "the number of the sub"),
    "subprogram before its call": (
        "o1 if [0]\nO7\nM99\no1 endif\nM98 P7\nM2", 1, "M98", "no subprogram 7 after", "O7",
    ),
    "subprogram without end": ("M98 P7\nM2\nO7\nG0 X1", 1, "M98", "O7 has no end", "M99 after"),
    "subprograms without end": (
        "M98 P7\nM2\nO7\nG0 X1\nO8\nM99", 1, "O8", "O8 inside the subprogram O7", "M99 at the end",
    ),
    "subprogram of itself": ("M98 P7\nM2\nO7\nM98 P7\nM99", 1, "M98", "deeper than 9", "at most 9"),
    "subprogram without moves": (
        "M98 P7 L1000000\nM2\nO7\nM99", 1, "M99", "runs 1000000 characters", "a loop or",
    ),
    "end of no subprogram": ("G0 X1\nM99\nM2", 1, "M99", "outside of a subprogram", "M98 calls"),
    "O word inside": ("G0 X1 O100\nM2", 7, "O100", "O word after other words", "first in"),
    "feed per turn of no spindle": (
        "G95 G1 X1 F1\nM2", 5, "G1", "spindle that does not turn", "M3 or M4",
    ),
    "probing per turn": (
        "G95 M3 S9 F1\nG38.2 X1\nM2", 1, "G38.2", "G38.2 with G95", "feed per minute",
    ),
    "tool without a number": ("M61\nM2", 1, "M61", "M61 without a tool", "Q with its number"),
    "data of no tool": ("G10 L1 P7 Z1\nM2", 8, "P7", "without a tool", "tool of the table"),
    "data of no kind": ("G10 L3 P1 Z1\nM2", 5, "L3", "without a known L", "L1, L10, L11"),
    "orientation out of range": ("M19 R400\nM2", 5, "R400", "M19 with R400", "from 0 to 360"),
    "orientation without time": ("M19 Q0\nM2", 5, "Q0", "M19 with Q0", "greater than 0"),
    "wait for a signal": ("M66 P1 L3 Q5\nM2", 8, "L3", "never comes", "L0"),
    "input without a number": ("M66\nM2", 1, "M66", "reads one input", "P (digital) or E"),
    "input that has no number": ("M66 P-1\nM2", 5, "P-1", "M66 with P-1", "whole one"),
    "output in part": ("M62 P1.5\nM2", 5, "P1.5", "M62 with P1.5", "whole one"),
    "two inputs": ("M66 P1 E1\nM2", 1, "M66", "reads one input", "P (digital) or E"),
    "output without a number": ("M62\nM2", 1, "M62", "number of its output", "P"),
    "analog output without a number": ("M68 Q2\nM2", 1, "M68", "number of its output", "E"),
    "parameter of an INI file": (
        "#<_ini[a]b> = 3\nM2", 2, "<_ini[a]b>", "a machine's configuration", "the program sets",
    ),
    "home of an absent axis": ("G28 B0\nM2", 5, "B0", "machine lacks", "X Y Z A C"),
    "place of an absent axis": ("G0 X1 B2\nM2", 7, "B2", "an axis about Y", "one of"),
    "value that shows the state": (
        "#<_metric> = 3\nM2", 1, "#<_metric> = 3", "read only", "another parameter",
    ),
    "value that shows the tool": ("#5403 = 3\nM2", 1, "#5403 = 3", "read only", "another"),
    "rotated compensation": (
        "G10 L2 P1 R9\nG18 G41.1 D1\nM2", 5, "G41.1", "in G18 of a rotated", "G17",
    ),
    "abort": ("G0 X1 (ABORT, no tool)\nM2", 7, "(ABORT, no tool)", "stops: no tool", "not reach"),
    "dwell without time": ("G4\nM2", 1, "G4", "G4 needs a time", "P in seconds"),
    "tolerance negative": ("G64 P-1\nM2", 5, "P-1", "negative", "at least 0"),
    "P of nothing": ("G0 X1 P2\nM2", 7, "P2", "P does not belong to G0", "X Y Z A C @ ^"),
    "cycle without R": ("G81 X1 Z1 F5\nM2", 1, "G81", "without R", "R in the first"),
    "cycle from below": ("G81 Z3 R1 F5\nM2", 8, "R1", "below the bottom", "at least Z"),
    "peck of nothing": ("G83 Z3 R4 Q0 F5\nM2", 11, "Q0", "too small", "Q greater"),
    "cycle with table": ("G81 A3 Z3 R4 F5\nM2", 5, "A3", "A does not belong to G81", "X Y Z"),
    "cycle cancelled": ("G80 X5\nM2", 5, "X5", "no motion is selected", "G0, G1"),
    "repeats": ("G81 Z3 R4 L.5 F5\nM2", 11, "L.5", "number of repeats", "integer"),
    "offset kind": ("G10 L3 P1 X1\nM2", 5, "L3", "without a known L", "L2"),
    "offset number": ("G10 L2 P12 X1\nM2", 8, "P12", "without a coordinate system", "P1 to P9"),
    "shift of nothing": ("G92\nM2", 1, "G92", "without axis words", "coordinates"),
    "machine arc": ("G53 G2 X5 R3 F5\nM2", 1, "G53", "origin of the machine", "G0 or G1"),
    "machine in the table frame": ("G43.4 G53 G0 X5\nM2", 7, "G53", "machine", "outside G43.4"),
    "inverse time without F": ("G93 G1 X1 F2\nX2\nM2", 1, "X2", "no feed is set", "F word in this"),
    "polar and Cartesian": ("G0 @2 Y1\nM2", 7, "Y1", "Y together with @", "either @ and ^"),
    "polar at the origin": ("G0 @2\nM2", 4, "@2", "at the origin", "with G90"),
    "polar, by steps, at the origin": ("G91 G0 ^2\nM2", 8, "^2", "at the origin", "with G90"),
    "polar home": ("G28 @2\nM2", 5, "@2", "@ does not belong to G28", "X Y Z"),
    "polar machine": ("G53 G0 @2 ^1\nM2", 1, "G53", "origin of the machine", "G0 or G1 with X"),
    "no state": ("M72\nM2", 1, "M72", "no saved state", "M70 or M73"),
    "state and more": ("M70\nM72 G0\nM2", 5, "G0", "M72 shares its block", "M72 alone"),
    "two stops": ("M0 M70\nM2", 4, "M70", "second word of the stop", "M0 M1"),
    "no such tool": ("T5 M6\nM2", 1, "T5", "there is no tool 5", "0 or a tool of the table"),
    "no such offset": ("G43 H5\nM2", 5, "H5", "there is no tool 5", "0 or a tool of the table"),
    "H of nothing": ("G0 X1 H1\nM2", 7, "H1", "H does not belong to G0", "X Y Z A C @ ^"),
    "diameter and radius": ("G7 G8\nM2", 4, "G8", "second word of the lathe", "G7 G8"),
    "shift with a motion": ("G92 G1 X1 F5\nM2", 5, "G1", "both take the axis words", "one of"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake__alone__is_told_with_column_and_reason(name):
    text, *told = MISTAKES[name]
    (error,) = errors_of(text)
    check_error(error, error.line, *told)


@pytest.mark.parametrize(
    "text",
    [
        "O0001 (PART)\nG0 X1\nM2", "%\n(x)\no7\nG0 X1\nM2", "G0 X1\nM30\nG0 Q what (",
        "%\nG0 X1\nM2", "F0 G0 X1\nM2", "G0 G80 X1\nM2", "G80 G0 X1\nM2", "N10.5 G0 X1\nM2",
        "o1 if [0]\n(abort, no)\no1 endif\nG0 X1\nM2\n(abort, later)",
    ],
)  # fmt: skip
def test_text__that_linuxcnc_runs__is_run(text):
    assert ends(text) == [(1, 0, 0, 0, 0)]


def test_rotation__move_of_the_table_alone__does_not_move_the_tool():
    text = "G10 L2 P1 X.3 R30\nG0 X1 Y2\nG1 C90 F360\nG28\nG1 C80\nM2"
    turns = [move for move in parse(text).moves if move.motion is Motion.LINEAR]
    assert [move.turns_only_the_table for move in turns] == [True, True]


def test_cycle__under_g64__stops_at_its_corners_and_leaves_the_mode():
    text = "G64 P1 Q0.5\nG1 X1 F100\nG99 G81 X5 Z-3 R2\nG80\nG1 X9\nM2"
    moves = parse(text, start=ZERO).moves
    kept = {(move.line == 3, move.tolerance, move.merge) for move in moves}
    assert kept == {(False, 1.0, 0.5), (True, 0.0, 0.0)}
    assert len(moves) == 7
