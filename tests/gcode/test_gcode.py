# SPDX-License-Identifier: Apache-2.0
"""G-code reader: units, distance modes, modal state, and the place and text of every error."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.gcode.errors import MAX_ERRORS
from sim.motion.gcode.interpreter import GcodeErrors, parse, parse_file
from sim.motion.geometry.moves import GcodeProgram, Motion, Plane
from tests.gcode.mistakes import check_error, errors_of, refused


def ends(program: GcodeProgram) -> list[tuple[float, ...]]:
    return [move.end for move in program.moves]


def test_parse__inches__are_converted_and_degrees_are_not():
    program = parse("G20\nG1 X1 Y-0.5 Z20 A10 F10\nG21\nX1 F100\nM2")
    first, second = ends(program)
    assert first == pytest.approx((25.4, -12.7, 508.0, 10.0, 0.0))
    assert second == pytest.approx((1.0, -12.7, 508.0, 10.0, 0.0))
    assert [move.feed for move in program.moves] == pytest.approx([254.0, 100.0])


def test_parse__feed_in_inches__keeps_its_value_after_a_change_of_unit():
    program = parse("G20\nG1 X1 F10\nG21 X1\nM2")
    assert [move.feed for move in program.moves] == pytest.approx([254.0, 254.0])


def test_parse__incremental_distance__adds_to_the_position_of_every_axis():
    program = parse("G91 G1 X1 Z-10 C5 F100\nX2 C5\nG90 X1\nM2")
    assert ends(program) == [(1, 0, 590, 0, 5), (3, 0, 590, 0, 10), (1, 0, 590, 0, 10)]


def test_parse__axis_left_out__keeps_its_position():
    program = parse("G0 X1\nY2\nA3\nM2")
    assert ends(program) == [(1, 0, 600, 0, 0), (1, 2, 600, 0, 0), (1, 2, 600, 3, 0)]


def test_parse__motion_mode__stays_until_the_next_motion_word():
    program = parse("G1 X1 F100\nX2\nG0 X3\nX4\nG3 X2 I-1\nX4 I1\nM2")
    assert [move.motion.value for move in program.moves] == ["G1", "G1", "G0", "G0", "G3", "G3"]


def test_parse__words_of_different_groups__share_a_block():
    (move,) = parse("N7 G18 G21 G90 G2 X10 Z600 I5 F100\nM30").moves
    assert (move.motion, move.plane, move.line) == (Motion.ARC_CW, Plane.ZX, 1)
    assert move.centre == pytest.approx((600.0, 5.0))


def test_parse__comments_blanks_and_lower_case__do_not_change_the_meaning():
    text = "%\n( title )\n\nn10 g01 x 1.50 (in) y+.5 f100 ; to the end ( of line\n\tM02\n%\nunread"
    (move,) = parse(text).moves
    assert move.end == (1.5, 0.5, 600, 0, 0)
    assert (move.motion, move.line) == (Motion.LINEAR, 4)


def test_parse__words_of_one_block__act_in_any_order():
    assert (
        parse("F100 X1 G1 G91 Y1\nM2").moves[0].end == parse("G91 G1 Y1 X1 F100\nM2").moves[0].end
    )


def test_parse__end_of_program_on_the_last_block__keeps_the_move():
    assert ends(parse("G0 X1 M2")) == [(1, 0, 600, 0, 0)]


def test_arc__end_off_the_circle__is_accepted_as_in_rs274():
    assert len(parse("G3 X-20.0282 I-10 F100\nM2").moves) == 1
    (error,) = errors_of("G3 X-20.0284 I-10 F100\nM2")
    assert "not on its circle: radius 10.0000 mm at the start, 10.0284 mm at" in error.what
    assert "at most 0.0100 mm" in errors_of("G3 X-0.22 I-.1 F100\nM2")[0].expected


def test_arc__programmed_in_inches__has_the_tolerance_of_inches():
    assert len(parse("G20 G3 X-2.0028 I-1 F100\nM2").moves) == 1
    assert "at most 0.0718 mm" in errors_of("G20 G3 X-2.0029 I-1 F100\nM2")[0].expected


# Text, line, column, offending text, and parts of what, expected and help.
MISTAKES = {
    "unknown G": ("G77 X1\nM2", 1, 1, "G77", "G77 is not a known", "a G word", "remove"),
    "G of others": ("G76 X1\nM2", 1, 1, "G76", "G76, a lathe cycle", "a G word", "no lathe"),
    "G near a known one": ("G59.4\nM2", 1, 1, "G59.4", "G59.4 is not", "a G word", "mean G59"),
    "fractional G": ("G1.5 X1\nM2", 1, 1, "G1.5", "G1.5 is not", "a G word", "did you mean G1?"),
    "unknown M": ("M31\nM2", 1, 1, "M31", "M31 is not a known word", "an M word", "remove"),
    "unknown letter": ("U1\nM2", 1, 1, "U1", "U, an axis along X", "G M N F S T X", "this machine"),
    "loop of Fanuc": (
        "WHILE [#1 GT 0] DO1\nM2", 1, 1, "WHILE", "statement of Fanuc's", "O words", "O100 while"
    ),
    "end of a loop of Fanuc": ("END1\nM2", 1, 1, "END", "statement of Fan", "O words", "endwhile"),
    "branch of Fanuc": (
        "N7 IF[#1 EQ 0]GOTO9\nM2", 1, 4, "IF", "IF, a statement of", "O words", "O100 if"
    ),
    "jump of Fanuc": ("N3 goto 5\nM2", 1, 4, "goto", "GOTO, a statement", "O words", "branches"),
    "decimal comma": ("G0 X2,5\nM2", 1, 6, ",5", "unexpected", "a word such", "decimal point"),
    "program number with a colon": (":0100\nM2", 1, 1, ":0100", "unexpected", "a word", "as O100"),
    "block delete with a number": ("/1 G0 X5\nM2", 1, 2, "1", "unexpected", "a word", "without a"),
    "call of Fanuc": ("M97 P1\nM2", 1, 1, "M97", "M97, a call of lines", "an M word", "O100 call"),
    "thread at rest": ("G33 Z1 K1\nM2", 1, 1, "G33", "does not turn", "M3 or M4", "S400 M3"),
    "thread without K": ("S9 M3 G33 Z1\nM2", 1, 7, "G33", "without a pitch", "K greater", "K1.25"),
    "thread backwards": ("S9 M3 G33 Z1 K-1\nM2", 1, 14, "K-1", "a pitch", "K greater", "K1.25"),
    "thread of the table": ("S9 M3 G33 A1 K1\nM2", 1, 7, "G33", "without a way", "X, Y or", "G1"),
    "thread with F": ("S9 M3 G33 X1 K1 F5\nM2", 1, 17, "F5", "F with G33", "K and S", "of its own"),
    "thread in time": ("S9 M3 G93\nG33 X1 K1\nM2", 2, 1, "G33", "G33 with G93", "G94", "G94"),
    "thread beside": (
        "S9 M3 G41.1 D3 G1 X5 F9\nG33 X9 K1\nM2", 2, 1, "G33", "during cutter", "G0 G1", "G40",
    ),
    "probe in time": ("G93 G38.2 X1 F9\nM2", 1, 5, "G38.2", "with G93", "G94", "G94 before"),
    "probe without a feed": ("G38.2 Z1\nM2", 1, 1, "G38.2", "no feed is set", "an F word", "F2000"),
    "probe of Fanuc": ("G31 Z1\nM2", 1, 1, "G31", "G31, a move up to a", "a G word", "G38.2"),
    "unknown letter of none": ("\\1\nM2", 1, 1, "\\1", "unexpected", "a word", "comment"),
    "negative spindle": ("S-5\nM2", 1, 1, "S-5", "spindle is negative", "S of 0", "M4"),
    "letter without number": ("G0 X Y1\nM2", 1, 4, "X", "no number", "after X", "comment"),
    "malformed number": ("G0 X1.2.3\nM2", 1, 4, "X1.2.3", "malformed", "one decimal", "-12.5"),
    "sign alone": ("G0 X-\nM2", 1, 4, "X-", "malformed", "digits", "-12.5"),
    "huge number": ("G0 X10000001\nM2", 1, 4, "X10000001", "out of", "1e+07", "decimal point"),
    "parameter": ("G0 #1\nM2", 1, 4, "#1", "without a letter", "#n = value", "after a letter"),
    "stray character": ("G0 X1 !\nM2", 1, 7, "!", "unexpected character", "a word", "remove"),
    "letter outside ASCII": ("G0 \u0425\nM2", 1, 4, "\u0425", "unexpected", "a word", "remove"),
    "open comment": ("G0 X1 (a\nM2", 1, 7, "(a", "not closed", "`)`", "close it"),
    "nested comment": ("(a (b) G0 X1\nM2", 1, 4, "(", "inside a comment", "before", "not nest"),
    "two motions": ("G0 G1 X1\nM2", 1, 4, "G1", "word of the motion", "G0 G1 G2 G3", "keep G0"),
    "two planes": ("G17 G19\nM2", 1, 5, "G19", "second word of the plane", "G17 G18 G19", "G17"),
    "two units": ("G20 G21\nM2", 1, 5, "G21", "second word of the unit", "G20 G21", "keep G20"),
    "two distances": ("G90 G91\nM2", 1, 5, "G91", "word of the distance", "G90 G91", "keep G90"),
    "two ends": ("M2 M30", 1, 4, "M30", "second word of the stop", "M2 M30", "keep M2"),
    "axis twice": ("G0 X1 X2\nM2", 1, 7, "X2", "second X word", "at most one X", "X1 and X2"),
    "line number late": ("G0 N5 X1\nM2", 1, 4, "N5", "not at the start", "first word", "front"),
    "line number wrong": ("N-1 G0 X1\nM2", 1, 1, "N-1", "not valid", "0 to 99999", "optional"),
    "feed zero": ("G1 X1 F0\nM2", 1, 1, "G1", "no feed", "an F word", "F2000"),
    "feed missing": ("G0 X2\n G1 X1\nM2", 2, 2, "G1", "no feed is set", "an F word", "F2000"),
    "arc feed missing": ("G2 X2 I1\nM2", 1, 1, "G2", "no feed is set for G2", "F word", "F2000"),
    "no motion": ("X1 F5\nM2", 1, 1, "X1", "no motion is selected", "G0, G1, G2", "before X1"),
    "no position": ("G0 X1\nG2 F100\nM2", 2, 1, "G2", "without a position", "X Y Z A C", "G2"),
    "offset of a line": ("G0 X1 I2\nM2", 1, 7, "I2", "I does not belong", "X Y Z A C", "G2 G3"),
    "arc without centre": ("G2 X1 F5\nM2", 1, 1, "G2", "no centre", "I or J different", "distance"),
    "modal arc without centre": ("G2 X1 R1 F5\nX3\nM2", 2, 1, "X3", "no centre", "J", "start"),
    "offset outside the plane": ("G2 X1 K1 F5\nM2", 1, 7, "K1", "K is not in", "I and J", "K1"),
    "offset and radius": ("G2 X1 I1 R1 F5\nM2", 1, 7, "I1", "I together with R", "R", "I1 or R1"),
    "radius of a full turn": ("G2 X0 R1 F5\nM2", 1, 7, "R1", "where it starts", "point", "I, J"),
    "radius too small": ("G2 X3 R1 F5\nM2", 1, 7, "R1", "3.0000 mm", "at least 1.5000 mm", "R"),
    "end off the circle": (
        "G2 X3 I1 F5\nM2", 1, 1, "G2",
        "radius 1.0000 mm at the start, 2.0000 mm at the end", "at most 0.0283 mm", "offsets",
    ),
    "no end": ("G0 X1\nG0 X2", 2, 6, "", "has no end", "M2 or M30", "truncated"),
    "empty file": ("", 1, 1, "", "has no end", "M2 or M30", "truncated"),
    "late percent": ("G0 X1\n%\nM2\n%", 2, 1, "%", "inside the program", "opening", "first line"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_parse__one_mistake__is_the_only_error_with_its_place_and_text(name):
    text, *told = MISTAKES[name]
    (error,) = errors_of(text, file="letter.ngc")
    assert error.file == "letter.ngc"
    check_error(error, *told)


def test_error__printed__shows_place_line_and_caret():
    (error,) = errors_of("G21\n  G1 X10 Y20\nM2", file="letter.ngc")
    assert str(error) == (
        "letter.ngc:2:3: error: no feed is set for G1; got 'G1'; "
        "expected an F word in this block or before\n"
        "    2 |     G1 X10 Y20\n"
        "      |     ^^  help: add for instance F2000 to the block"
    )


def test_error__behind_a_tab__is_at_the_column_of_its_character():
    (error,) = errors_of("\tG0\tT1 X1\nM2")
    assert error.column == 5
    assert str(error).splitlines()[1] == "    1 |    G0 T1 X1"


def test_parse__several_mistakes__are_reported_together_in_order():
    errors = errors_of("G0 X\nG1 Y1\nG17 G18\nG2 X5 I1 F10\nT5\n")
    assert [(error.line, error.column) for error in errors] == [
        (1, 4), (2, 1), (3, 5), (4, 1), (5, 1), (5, 3),
    ]  # fmt: skip


def test_parse__missing_feed_in_many_blocks__is_reported_once():
    assert len(errors_of("G1 X1\nX2\nX3\nM2")) == 1


def test_parse__block_with_a_mistake__still_moves_the_position_of_the_next():
    (error,) = errors_of("G0 X10 T1\nG2 X20 I5 F100\nM2")
    assert error.text == "T1"


def test_parse__more_mistakes_than_the_limit__stops_and_says_so():
    error = refused("T1\n" * 50)
    assert len(error.errors) == MAX_ERRORS == 20
    assert str(error).endswith("stopped after 20 errors, the rest of the file was not read")


@given(st.text(alphabet="GMXYZACIJKRFNTPQLSINATO0123456789.+-*/[]=<>%();# \t\n", max_size=120))
def test_parse__any_text__gives_a_program_or_located_errors(text):
    lines = text.splitlines() or [""]
    try:
        program = parse(text)
    except GcodeErrors as caught:
        for error in caught.errors:
            assert 1 <= error.line <= len(lines)
            source = lines[error.line - 1]
            assert source[error.column - 1 :].expandtabs(1).startswith(error.text)
    else:
        assert all(1 <= move.line <= len(lines) for move in program.moves)


@given(
    xs=st.lists(st.decimals(-100, 100, places=4), min_size=1, max_size=8),
    feed=st.integers(1, 5000),
)
def test_parse__absolute_and_incremental__describe_the_same_path(xs, feed):
    absolute = parse("\n".join([f"G90 F{feed}", *(f"G1 X{x}" for x in xs), "M2"]))
    steps = [x - before for before, x in zip([0, *xs], xs, strict=False)]
    incremental = parse("\n".join([f"G91 F{feed}", *(f"G1 X{x}" for x in steps), "M2"]))
    # One rounding of a value below 200 mm for each sum and each decimal read.
    assert [p[0] for p in ends(incremental)] == pytest.approx(
        [p[0] for p in ends(absolute)], abs=8 * 2 * 2.9e-14
    )


def test_parse_file__not_text__is_an_error_with_a_place(tmp_path):
    path = tmp_path / "bad.ngc"
    path.write_bytes(b"G0 \xff\nM2\n")
    with pytest.raises(GcodeErrors) as caught:
        parse_file(path)
    (error,) = caught.value.errors
    assert (error.file, error.line, error.column) == (str(path), 1, 4)
